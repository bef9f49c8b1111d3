"""Which picture a device sends: reading, changing and putting back what the choice consists of."""

__all__ = ["CORRECTION", "WINDOW", "has_correction", "read_view", "show_whole", "write_view"]

CORRECTION = "CorrectionEnable"
WINDOW = ("Width", "Height", "OffsetX", "OffsetY")
_MIRROR = ("ReverseX", "ReverseY")


def has_correction(device):
    """Whether the device is one of ours, which sends raw or corrected pictures."""
    return CORRECTION in device.names()


def read_view(device):
    """The present choice: values by feature name."""
    names = (CORRECTION, "PixelFormat", *WINDOW, *_MIRROR)
    present = set(device.names())
    return {name: device.get(name) for name in names if name in present}


def write_view(device, view):
    """Make ``view`` of :func:`read_view` the choice, while no pictures stream."""
    for name in (CORRECTION, *_MIRROR, "PixelFormat"):
        if name in view:
            _change(device, name, view[name])
    if any(device.get(name) != view[name] for name in WINDOW):
        # A window moves and grows only inside the whole picture: the corner first.
        for name, value in (("OffsetX", 0), ("OffsetY", 0), *((name, view[name])
                                                              for name in WINDOW)):
            device.set(name, value)


def show_whole(device, corrected, mirrored=True):
    """Make the whole picture the choice: the corrected one, or the raw frame.

    ``mirrored``: as the user has set it; else as the sensor's pixels lie.
    """
    _change(device, CORRECTION, corrected)
    if not mirrored:
        present = set(device.names())
        for name in _MIRROR:
            if name in present:
                _change(device, name, False)
    for name, value in (("OffsetX", 0), ("OffsetY", 0), ("Width", device.get("WidthMax")),
                        ("Height", device.get("HeightMax"))):
        _change(device, name, value)


def _change(device, name, value):
    """Set a feature that is not ``value`` yet: a device may have it read only."""
    if device.get(name) != value:
        device.set(name, value)
