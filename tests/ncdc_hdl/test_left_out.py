"""Cores that leave something out: the same pixels, and registers that are not there."""

from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.hardware import Hardware


@pytest.mark.parametrize("hardware", [
    Hardware(fixed_lens=True, follow=False, counters=False, strip=32)])
def test_pixels_are_the_same(hardware):
    d = barrel_descriptor((72, 21), (76, 24), hidden_neurons=3, bayer="GBRG", fill=(200, 100, 50))
    d = replace(d, nodes=8)
    raw = np.random.default_rng(1).integers(0, 256, d.geometry.distorted[::-1], np.uint8)
    result = simulate_correction(d, raw, hardware, memory="hostile", simulator="icarus")
    print(result.counters, result.clocks_outside)
    assert result.differing == []
