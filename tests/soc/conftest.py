"""The whole system, compiled once for all tests with clients."""

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_sim.system.soc import SocModel
from peers import need
from soc_clients import SIZE


@pytest.fixture(scope="session")
def model():
    """A system whose sensor sees noise, at an exposure of 100 us."""
    need("riscv64-unknown-elf-gcc", "unshare", "ip", "aravis")
    noise = np.random.default_rng(1).integers(0, 256, SIZE[::-1], dtype=np.uint8)
    descriptor = barrel_descriptor(corrected=SIZE, distorted=SIZE)
    return SocModel(descriptor, cv2.GaussianBlur(noise, (0, 0), 1.0), exposure_us=100.0)
