"""Whatever a host writes: nothing outside the buffers, no unaligned address, no hang."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.avalon.read_fence import ReadFence
from ncdc_hdl.backend.packer import Packer
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import verilog_of
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import (
    FAULT_ALIGNMENT,
    FAULT_FORMAT,
    FAULT_SIZE,
    FAULT_SOURCE,
    FAULT_TARGET,
)
from simulations.register_fuzz import simulate_register_fuzz

CACHE = CacheOptions(64, pending=32, outstanding=8)
BUILDS = {
    "multiport, memory": Hardware(fetcher="multiport"),
    "2 pixels, memory": Hardware(cache=CACHE, lanes=2, data_width=64, format="BGR8"),
    "1 pixel, memory": Hardware(cache=CACHE),
    "4 pixels, memory": Hardware(cache=CACHE, lanes=4, data_width=128),
    "multiport, stream": Hardware(fetcher="multiport", output="stream", data_width=128),
    "1 pixel, stream": Hardware(cache=CACHE, output="stream", data_width=64, share=2),
    "2 pixels, stream": Hardware(cache=CACHE, output="stream", lanes=2),
    "4 pixels, stream": Hardware(cache=CACHE, output="stream", lanes=4, data_width=64),
    "view, memory": Hardware(cache=CACHE, view=True, view_rows=4),
    "views, memory": Hardware(cache=CACHE, view=True, views=2, lanes=2, data_width=64),
}


def descriptor(view=False):
    if view:
        return replace(barrel_descriptor((36, 14), (42, 18), hidden_neurons=2), nodes=8)
    return barrel_descriptor((20, 14), (42, 18), hidden_neurons=2)


@cache
def built(name):
    corrector = Corrector(descriptor(BUILDS[name].view), BUILDS[name])
    return corrector, verilog_of(corrector)


def fuzz(corrector, verilog, frames, seed=1):
    raw = np.random.default_rng(6).integers(0, 256, (18, 42), np.uint8)
    return simulate_register_fuzz(corrector, verilog, raw, frames, seed=seed, memory="fixed:9:4",
                                  clock_limit=200_000 * frames)


@pytest.mark.longer
@pytest.mark.parametrize("name", [
    name if name == "2 pixels, memory" else pytest.param(name, marks=pytest.mark.regress)
    for name in BUILDS])
def test_nothing_happens_outside(name):
    result = fuzz(*built(name), 125)
    assert result.differing == (0,) * 125
    assert result.outside == 0
    faults = np.array(result.faults)
    for bit in (FAULT_SOURCE, FAULT_ALIGNMENT, FAULT_SIZE):
        assert (faults & bit != 0).sum() > 10
    assert ((faults & FAULT_TARGET != 0).sum() > 2) == (not BUILDS[name].stream)
    assert (faults & FAULT_FORMAT).any() == (not BUILDS[name].stream)
    assert (faults == 0).sum() > 3


@pytest.mark.longer
@pytest.mark.parametrize("owner", [
    ReadFence, pytest.param(Packer, marks=pytest.mark.regress)])
def test_each_fence_is_needed(owner, monkeypatch):
    monkeypatch.setattr(owner, "_inside", staticmethod(lambda number, first, end: number >= first))
    corrector = Corrector(descriptor(), BUILDS["1 pixel, memory"])
    assert fuzz(corrector, verilog_of(corrector), 60).outside > 0
