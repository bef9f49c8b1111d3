"""A client of your own: find the exposure at which a device's pictures are neither dark nor bright.

    ncdc device serve net.toml &
    python examples/own_client.py tcp://127.0.0.1 picture.png

The URL is that of a device as ``ncdc client list`` prints it: over Ethernet, TCP or USB.
"""

import sys

from ncdc_host.client import DeviceError, NoFrame, open_device
from ncdc_model.images import write_image

TARGET = 110            # mean of a picture to reach, 0..255
NEAR = 5                # how far off it may be
STEPS = 12              # exposures to try, at most
SETTLING = 2            # pictures that may still have the exposure before


def picture_at(device, exposure_us):
    """(exposure that the device took, picture): float and uint8 array of shape (height, width, 3).

    Raises
    ------
    NoFrame
        If no picture came.
    """
    taken = device.set("ExposureTime", exposure_us)
    with device.stream() as frames:
        for _ in range(SETTLING):
            frames.next()
        return taken, frames.next().picture()


def exposed(device):
    """(exposure in microseconds, picture) with the mean :data:`TARGET`, or nearest to it."""
    limits = device.info("ExposureTime")
    exposure, best = device.get("ExposureTime"), None
    for _ in range(STEPS):
        exposure, picture = picture_at(device, exposure)
        mean = float(picture.mean())
        print(f"{exposure:9.0f} us: mean {mean:5.1f}")
        if best is None or abs(mean - TARGET) < abs(best[1].mean() - TARGET):
            best = exposure, picture
        # Light is proportional to the exposure; a white picture says only that it was too long.
        wanted = exposure * (TARGET / max(mean, 1) if mean < 250 else 0.25)
        wanted = min(max(wanted, limits.minimum), limits.maximum)
        if abs(mean - TARGET) <= NEAR or wanted == exposure:
            break
        exposure = wanted
    return best


def main(url, output):
    """Run; the exit status is 1 if the device does not do its part."""
    try:
        with open_device(url) as device:
            print(f"{url}: pictures of {device.get('Width')}x{device.get('Height')} pixels")
            exposure, picture = exposed(device)
    except (DeviceError, NoFrame) as error:
        print(f"own_client: {error}", file=sys.stderr)
        return 1
    write_image(output, picture)
    print(f"{output}: exposure {exposure:.0f} us, mean {picture.mean():.1f}")
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: own_client.py URL PICTURE.png")
    sys.exit(main(*sys.argv[1:]))
