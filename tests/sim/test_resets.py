"""Resets at random clocks: of the corrector alone, and of corrector and memory together."""

from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import verilog_of
from ncdc_sim.tools import SimulationError
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.hardware import Hardware
from simulations.resets import simulate_resets

SIZE = 32, 16
LONGEST = {"hostile": 1500, "sdram": 700}       # clocks, about as many as a frame takes
CACHE = CacheOptions(64, pending=64, outstanding=8)
BUILDS = {
    "cache, memory": Hardware(cache=CACHE),
    "multiport, memory": Hardware(fetcher="multiport", data_width=64),
    "cache, stream, two pixels": Hardware(cache=CACHE, data_width=128, output="stream", lanes=2),
    "cache, memory, four pixels": Hardware(cache=CACHE, data_width=128, lanes=4),
    "cache, memory, shared": Hardware(cache=CACHE, share=2),
}


def descriptor():
    return barrel_descriptor(SIZE, (40, 20), hidden_neurons=2)


@cache
def built(name):
    corrector = Corrector(descriptor(), BUILDS[name])
    return corrector, verilog_of(corrector)


def raws():
    rng = np.random.default_rng(6)
    return [rng.integers(0, 256, (20, 40), np.uint8) for _ in range(2)]


def reset(frames, corrector, verilog, forgets, memory="hostile", seed=1):
    return simulate_resets(corrector, verilog, raws(), frames, forgets=forgets,
                           longest=LONGEST[memory], memory=memory, seed=seed,
                           clock_limit=20_000 * frames)


@pytest.mark.longer
@pytest.mark.parametrize("memory", LONGEST)
@pytest.mark.parametrize("forgets", [True, False], ids=["forgets", "answers"])
@pytest.mark.parametrize("name", [name if name == "cache, memory" else
                                  pytest.param(name, marks=pytest.mark.regress) for name in BUILDS])
def test_the_next_frame_is_right(name, forgets, memory):
    result = reset(125, *built(name), forgets, memory)
    assert result.differing == (0,) * 125
    assert result.under_way > 30


@pytest.mark.longer
@pytest.mark.parametrize("tied_to,forgets", [("1'b0", True), ("rst", False)])
def test_the_corrector_must_know_what_its_memory_does(tied_to, forgets):
    """Without a signal that its memory forgot, it hangs. With one from a memory that answers, it
    breaks a command off, and shows samples of the frame before."""
    corrector, verilog = built("cache, memory")
    wrong = verilog.replace(".memory_rst(memory_rst)", f".memory_rst({tied_to})")
    try:
        assert max(reset(20, corrector, wrong, forgets).differing) > 0
    except SimulationError as error:
        assert "clock-limit" in str(error) if forgets else "held" in str(error)
