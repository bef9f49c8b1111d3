"""One peer's work with devices; runs in the client's namespace as a program of its own.

``python -m ncdc_bench.client.peer JSON`` prints a JSON report; see :func:`main`.
"""

import json
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ncdc_host.client import DeviceError, Rejected, discover, open_device
from ncdc_spec.white_balance import UNITY

__all__ = ["main"]

_PLAIN = 0x2C           # register of the sensor that takes any value: the gain of blue


def main(task):
    """The report on a ``task``: a dict with

    - scheme: of the URLs; "discover": addresses that a discovery finds instead;
    - devices: addresses; frames: of each; settings: features set before, in order;
    - expected: file of a picture that every frame must equal, or null;
    - packet_size: bytes or null; every_feature: whether all features are set and read back;
    - multicast: group or null; monitor: whether to watch only.
    """
    if task["scheme"] == "discover":
        return {back_end: [one.address for one in discover(1.5, back_end=back_end)]
                for back_end in ("gige", "aravis")}
    expected = None if task["expected"] is None else np.load(task["expected"])
    with ThreadPoolExecutor(len(task["devices"])) as pool:
        return list(pool.map(lambda address: _one(task, address, expected), task["devices"]))


def _one(task, address, expected):
    report = {"address": address, "features": 0, "features_read_back": 0, "frames": 0,
              "incomplete": 0, "wrong_pixels": 0, "resent": 0, "skipped": 0}
    with open_device(f"{task['scheme']}://{address}", task["monitor"]) as device:
        if task["every_feature"]:
            report |= _features(device)
        if task["monitor"]:
            report["rejected"] = _write_rejected(device)
        for name, value in task["settings"].items():
            device.set(name, value)
        if task["frames"]:
            report |= _frames(device, task, expected)
    return report


def _write_rejected(device):
    try:
        device.set("Gain", 2)
    except Rejected:
        return True
    return False


def _frames(device, task, expected):
    used = time.process_time()
    with device.stream(task["packet_size"], multicast=task["multicast"]) as frames:
        got = [frames.next(20)]
        print("streaming", file=sys.stderr, flush=True)
        begin = time.monotonic()
        for _ in range(task["frames"] - 1):
            frame = frames.next(20)
            if expected is not None:
                got.append(frame)
        seconds = time.monotonic() - begin
        counted = frames.statistics
    used = time.process_time() - used
    # Compared afterwards: the receiver is measured, not NumPy.
    return {"frames": counted.frames, "incomplete": counted.lost, "skipped": counted.skipped,
            "resent": counted.resent, "wrong_pixels": sum(_wrong(f, expected) for f in got),
            "frames_per_second": (task["frames"] - 1) / seconds if seconds else 0.0,
            "client_cpu_seconds": used}


def _wrong(frame, expected):
    """Pixels that differ; all of them if the size does."""
    if expected is None:
        return 0
    if frame.pixels.shape != expected.shape:
        return frame.pixels.shape[0] * frame.pixels.shape[1]
    different = frame.pixels != expected
    return int((different.any(axis=2) if different.ndim == 3 else different).sum())


def _features(device):
    """Set every feature that can be set to several values, and read each back."""
    features, right = 0, 0
    if "SensorRegisterAddress" in device.names():
        device.set("SensorRegisterAddress", _PLAIN)
    for name, info in device.features().items():
        features += 1
        if info.kind == "command":
            right += 1                  # run by every stream; nothing to read back
            continue
        good = device.get(name) == info.value or name.startswith("Frames")
        if info.writable:
            for value in [*_values(info), info.value]:
                good &= _agrees(info, value, device.set(name, value))
        right += bool(good)
    return {"features": features, "features_read_back": right}


def _values(info):
    if info.name == "TLParamsLocked":
        return (1, 0)
    if info.kind == "boolean":
        return (True, False)
    if info.kind == "enumeration":
        if info.name == "PixelFormat":
            # Raw frames have the one format that the sensor's filter gives.
            return ("BGRa8", "Mono8", "BGR8", "BayerRG8", "BGR8")
        return info.choices
    if info.kind == "float" and info.name == "ExposureTime":
        return (info.minimum, 2000.0, 7500.0)
    low, high, step = info.minimum, info.maximum, info.increment or 1
    if info.kind == "float":
        return (low, (low + high) / 2, high)
    return (low, low + (high - low) // 2 // step * step, high)


def _agrees(info, written, back):
    if info.kind != "float":
        return back == written
    # The device's step: a line of the sensor, an eighth, a tenth, a 256th.
    step = {"ExposureTime": info.minimum, "Gain": 0.125, "AcquisitionFrameRate": 0.1,
            "BalanceRatio": 1 / UNITY}[info.name]
    return abs(back - written) <= step / 2 * (1 + 1e-6)


if __name__ == "__main__":
    try:
        print(json.dumps(main(json.loads(sys.argv[1]))))
    except DeviceError as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        sys.exit(1)
