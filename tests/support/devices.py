"""Emulated devices in the test's own process, at addresses of this machine that are theirs."""

import itertools
import os
from dataclasses import replace

from cameras import barrel_descriptor
from ncdc_host.device.emulated import DeviceOptions, EmulatedDevice, lens_corrections
from ncdc_model.example import noise_picture

__all__ = ["NARROW", "SIZE", "device", "loopback_address", "small_lens", "view_lens"]

SIZE = (64, 48)
NARROW = 2000.0         # focal length at which a few views do not fit the registers
_numbers = itertools.count(1)


def loopback_address():
    """An address 127.X.Y.Z that is given out once, whichever process asks."""
    pid = os.getpid() & 0xFFFF
    return f"127.{16 + (pid >> 8) % 200}.{pid & 255}.{next(_numbers) % 250 + 1}"


def small_lens(seed=1, **geometry):
    """A descriptor of 64x48 pixels."""
    return barrel_descriptor(SIZE, SIZE, seed=seed, **geometry)


def view_lens(seed=1, focal=41.257):
    """The same at nodes, with a focal length: a lens of a device with a view."""
    return replace(small_lens(seed), nodes=8, provenance={"frame": [focal, 31.0, 24.5]})


def device(descriptors=None, image=None, **options):
    """An :class:`EmulatedDevice` without noise, looking at a noise picture, at a free TCP port."""
    options = {"address": loopback_address(), "noise": 0.0, "tcp_port": 0, "fps": 100.0, **options}
    image = noise_picture(*SIZE) if image is None else image
    return EmulatedDevice(lens_corrections(descriptors or [small_lens()]),
                          DeviceOptions(**options), image)
