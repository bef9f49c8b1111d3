"""A whole corrector on block RAM: a word read in the clock of its own write is undefined."""

import numpy as np
import pytest

from block_ram import undefined_collisions
from cameras import barrel_descriptor
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.hardware import Hardware

# Few sets and few look-ups under way: tiles are evicted, and entries read as they are written.
HARDWARE = Hardware(data_width=64, output="stream",
                    cache=CacheOptions(64, pending=16, outstanding=4), split=0)


@pytest.fixture(scope="module")
def made():
    """A descriptor and the Verilog of its corrector."""
    d = barrel_descriptor((160, 60), (160, 64), hidden_neurons=2, strength=.5)
    with undefined_collisions() as memories:
        verilog = corrector_verilog(d, HARDWARE)
    # Tags, tiles, valid rows, queues.
    assert len(memories) > 4 + 8 + 2
    return d, verilog


@pytest.mark.longer
@pytest.mark.parametrize("memory", ["ideal", "hostile"])
def test_no_word_is_used_that_was_read_in_the_clock_of_its_write(made, memory):
    d, verilog = made
    raw = np.random.default_rng(3).integers(0, 256, (64, 160), np.uint8)
    result = simulate_correction(d, raw, HARDWARE, verilog=verilog, memory=memory)
    assert result.differing == []
    assert result.blank.any() and not result.blank.all()
