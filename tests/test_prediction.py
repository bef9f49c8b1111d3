"""The planner's prediction against the Verilog: misses exactly, clocks within 1 %."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.avalon.register_table import host_values
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_hdl.options import FetchOptions, FrontEndOptions
from ncdc_model.fetch.cache_options import CacheOptions
from ncdc_model.fetch.lookups import frame_windows, lookups
from ncdc_model.fetch.tags import accesses, misses
from ncdc_model.fetch.timing import predict_clocks
from ncdc_model.fetch.writes import frame_writes
from ncdc_model.memory_timing import memory_timing
from ncdc_sim.corrector import simulate_correction

OPTIONS = CacheOptions(64, pending=64, outstanding=8)


@pytest.fixture(scope="module", params=[("stream", 1, 0), ("memory", 1, 64), ("stream", 2, 0)],
                ids=["stream", "memory", "two pixels"])
def prepared(request):
    """Where pixels go, how many per clock, in which strips; a descriptor, its corrector's Verilog,
    and a raw frame."""
    output, lanes, strip = request.param
    descriptor = barrel_descriptor((160, 120), (160, 120), hidden_neurons=4, strength=.5)
    verilog = corrector_verilog(descriptor, data_width=64, output=output,
                                front_end=FrontEndOptions(lanes=lanes),
                                fetch=FetchOptions("cache", OPTIONS, 0))
    raw = np.random.default_rng(2).integers(0, 256, (120, 160), dtype=np.uint8)
    return output, lanes, strip, descriptor, verilog, raw


@pytest.mark.parametrize("memory,split", [
    ("ideal", 3), ("ddr3", 3), ("ddr3@200", 1), ("sdram", 2), ("sdram", 0), ("fixed:100:4", 3),
    ("fixed:20:1.5", 0)])
def test_misses_are_equal_and_clocks_within_a_hundredth(prepared, memory, split):
    """A cache that is too small and splits that do not suit make tiles be evicted all the time;
    output to memory takes turns with the reads, and saturates the slow ones."""
    output, lanes, strip, descriptor, verilog, raw = prepared
    simulation = simulate_correction(descriptor, raw, verilog=verilog, data_width=64,
                                     output=output, memory=memory,
                                     front_end=FrontEndOptions(lanes=lanes),
                                     fetch=FetchOptions("cache", OPTIONS, split, strip))
    boxes = lookups(frame_windows(descriptor), strip, lanes)
    missed = misses(accesses(boxes), OPTIONS, split)
    values, timing = host_values(descriptor, 64, split), memory_timing(memory)
    writes = None if output == "stream" else frame_writes(
        160, 120, strip, 64, getattr(timing, "access_bytes", 1), values["TARGET_BASE"])
    predicted = predict_clocks(missed, boxes, OPTIONS, timing, 64, base=values["SOURCE_BASE"],
                               pitch=values["SOURCE_PITCH"], writes=writes)
    assert simulation.differing == []
    assert simulation.counters["FETCHES"] == len(missed)
    assert simulation.bytes_read == 64 * len(missed)
    assert simulation.counters["CLOCKS"] == pytest.approx(predicted.clocks, rel=.01)
