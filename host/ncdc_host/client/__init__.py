"""The client of devices: one interface, whatever the transport.

>>> from ncdc_host.client import discover, open_device
>>> for found in discover(): print(found.url, found.model)
>>> with open_device("tcp://127.0.0.2") as device:
...     device.set("ExposureTime", 5000.0)
...     with device.stream() as frames:
...         frame = frames.next()
...         picture = frame.picture()
"""

import warnings

from ncdc_host.client.device import Device, FeatureInfo, FrameStream, Statistics
from ncdc_host.client.devices import discover, open_device
from ncdc_host.client.errors import (
    BadUrl,
    BadValue,
    DeviceError,
    DeviceGone,
    NoFrame,
    Rejected,
)
from ncdc_host.client.found import Found
from ncdc_host.client.frame import Frame
from ncdc_host.client.record import record

__all__ = ["BadUrl", "BadValue", "Device", "DeviceError", "DeviceGone", "FeatureInfo", "Found",
           "Frame", "FrameStream", "NoFrame", "Rejected", "Statistics", "discover", "open_device",
           "record"]


def __getattr__(name):
    if name == "Refused":
        warnings.warn("Refused is called Rejected now; the old name goes with the next release",
                      DeprecationWarning, stacklevel=2)
        return Rejected
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
