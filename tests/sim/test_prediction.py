"""The planner predicts the Verilog: misses exactly, clocks within 1 %, or to a few."""

from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_bench.throughput.cross import CROSS, worst_split
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import verilog_of
from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.memory_timing import memory_timing
from ncdc_model.planner.plan import best_split
from ncdc_model.planner.tags import accesses, misses
from ncdc_model.planner.timing import predict_clocks
from ncdc_model.planner.writes import frame_writes
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.frames import FrameAddresses
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import FAST, GRADIENT, interpolation_of

CACHE = CacheOptions(64, pending=64, outstanding=8)


def noise(descriptor):
    return np.random.default_rng(2).integers(0, 256, descriptor.geometry.distorted[::-1], np.uint8)


def predicted(corrector, hardware, memory):
    """Misses and clocks that the planner promises ``corrector``, registers set as ``hardware``."""
    descriptor, timing = corrector.descriptor, corrector.timing
    geometry, memory = descriptor.geometry, memory_timing(memory)
    hardware = hardware.made_for(descriptor)
    buffers = FrameAddresses.after_reset(geometry, hardware.data_width)
    boxes = lookups(frame_windows(descriptor), hardware.strip, hardware.lanes)
    missed = misses(accesses(boxes), hardware.cache, hardware.split_for(geometry))
    writes = None if hardware.stream else frame_writes(
        geometry, hardware, getattr(memory, "access_bytes", 1), buffers.target, timing)
    return len(missed), predict_clocks(missed, boxes, hardware, memory, timing, buffers,
                                       writes)


@pytest.fixture(scope="module", params=[("stream", 1, 0), ("memory", 1, 64),
                                        pytest.param(("stream", 2, 0), marks=pytest.mark.regress)],
                ids=["stream", "memory", "two pixels"])
def prepared(request):
    """A hardware, its corrector and that one's Verilog."""
    output, lanes, strip = request.param
    descriptor = barrel_descriptor((160, 120), (160, 120), hidden_neurons=4, strength=.5)
    hardware = Hardware(data_width=64, output=output, lanes=lanes, cache=CACHE, split=0)
    corrector = Corrector(descriptor, hardware)
    return replace(hardware, strip=strip), corrector, verilog_of(corrector)


@pytest.mark.parametrize("memory,split", [
    ("ideal", 3), pytest.param("ddr3", 3, marks=pytest.mark.longer),
    pytest.param("ddr3@200", 1, marks=pytest.mark.longer), ("sdram", 2), ("sdram", 0),
    ("fixed:100:4", 3), ("fixed:20:1.5", 0)])
def test_misses_are_equal_and_clocks_within_a_hundredth(prepared, memory, split):
    """A cache that is too small and splits that do not suit make tiles be evicted all the time;
    output to memory takes turns with the reads, and saturates the slow ones."""
    hardware, corrector, verilog = prepared
    hardware = replace(hardware, split=split)
    descriptor = corrector.descriptor
    simulation = simulate_correction(descriptor, noise(descriptor), hardware, verilog=verilog,
                                     memory=memory)
    missed, clocks = predicted(corrector, hardware, memory)
    assert simulation.differing == []
    assert simulation.counters["FETCHES"] == missed
    assert simulation.bytes_read == 64 * missed
    assert simulation.counters["CLOCKS"] == pytest.approx(clocks.clocks, rel=.01)


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("size,neurons,needs,settings,memory", [
    ((1280, 1024), 12, FAST, dict(strip=128), "sdram"),
    ((1280, 1024), 16, GRADIENT, dict(output="stream"), "sdram"),
    ((1920, 1080), 12, GRADIENT, dict(output="stream", data_width=128), "ddr3"),
    ((1920, 1080), 16, FAST, dict(output="stream", data_width=128, lanes=4), "ddr3"),
    ((1920, 1080), 16, GRADIENT, dict(output="stream", data_width=128, lanes=4), "ddr3")])
def test_misses_and_clocks_of_real_size(size, neurons, needs, settings, memory):
    plain = barrel_descriptor(size, size, neurons, strength=.1, interpolation=needs)
    descriptor, hardware = replace(plain, nodes=16), Hardware(**settings)
    simulation = simulate_correction(descriptor, noise(descriptor), hardware, memory=memory)
    missed, clocks = predicted(Corrector(descriptor, hardware), hardware, memory)
    assert simulation.differing == []
    assert simulation.counters["FETCHES"] == missed
    assert simulation.counters["CLOCKS"] == pytest.approx(clocks.clocks, rel=.01)


# Each two choices of two kinds meet in one of these: distance of nodes, lanes, port, interpolation.
PAIRS = [(nodes, lanes, (32, 64, 128)[(n + k) % 3], (FAST, GRADIENT)[(n + k) % 2])
         for n, nodes in enumerate((1, 8, 16, 32)) for k, lanes in enumerate((1, 2, 4))]
SOON = [(32, 4, 128, GRADIENT)]         # what `make longer` sees of them


def test_each_two_choices_meet():
    def met(choices):
        return {pair for each in choices for pair in combinations(each, 2)}
    assert met(PAIRS) == met((each.nodes, each.lanes, each.data_width,
                              interpolation_of(each.interpolation)) for each in CROSS)
    assert set(SOON) <= set(PAIRS)


@pytest.mark.longer
@pytest.mark.parametrize("nodes,lanes,data_width,needs", [
    each if each in SOON else pytest.param(*each, marks=pytest.mark.regress) for each in PAIRS],
    ids=lambda value: str(getattr(value, "name", value)))
def test_any_two_choices_are_planned_within_a_hundredth(nodes, lanes, data_width, needs):
    """Nodes that come too slowly, narrow ports, tiles of two rows, groups that are cut."""
    descriptor = replace(barrel_descriptor((160, 120), (160, 120), hidden_neurons=4, strength=.5,
                                           interpolation=needs), nodes=nodes)
    hardware = Hardware(data_width=data_width, output="stream", lanes=lanes,
                        cache=CacheOptions(128 if needs == FAST else 256, interpolation=needs))
    corrector = Corrector(descriptor, hardware)
    verilog, raw = verilog_of(corrector), noise(descriptor)
    splits = best_split(descriptor, hardware), worst_split(descriptor, hardware)
    assert splits[0] != splits[1]
    for split in splits:
        chosen = replace(hardware, split=split)
        counters = simulate_correction(descriptor, raw, chosen, verilog=verilog,
                                       memory="ddr3").counters
        missed, clocks = predicted(corrector, chosen, "ddr3")
        assert counters["FETCHES"] == missed
        assert counters["CLOCKS"] == pytest.approx(clocks.clocks, rel=.01)


@pytest.mark.parametrize("memories", [
    ("sdram",), pytest.param(("ideal", "ddr3", "fixed:100:4", "fixed:20:1.5"),
                             marks=pytest.mark.longer)], ids=len)
def test_shared_tiles_are_right_and_planned(memories):
    """No window is read in a clock that writes words. The planner does not know that words of
    later windows delay a read before them, which counts if nearly each window misses tiles."""
    descriptor = replace(barrel_descriptor((160, 120), (160, 120), hidden_neurons=4, strength=.5,
                                           interpolation=GRADIENT), nodes=16)
    hardware = Hardware(output="stream", cache=CacheOptions(256, interpolation=GRADIENT),
                        tile_memory="shared")
    corrector = Corrector(descriptor, hardware)
    verilog, raw = verilog_of(corrector), noise(descriptor)
    for (split, within), memory in product(((best_split(descriptor, hardware), .002),
                                            (worst_split(descriptor, hardware), .04)), memories):
        chosen = replace(hardware, split=split)
        simulation = simulate_correction(descriptor, raw, chosen, verilog=verilog, memory=memory)
        missed, clocks = predicted(corrector, chosen, memory)
        assert simulation.differing == []
        assert simulation.counters["FETCHES"] == missed
        assert simulation.counters["CLOCKS"] == pytest.approx(clocks.clocks, rel=within)


def small(variant, neurons, **choices):
    """A corrector of small frames, its hardware, and its Verilog."""
    descriptor = replace(barrel_descriptor((48, 40), (48, 40), hidden_neurons=neurons),
                         variant=variant)
    hardware = Hardware(**{"output": "stream"} | choices)
    corrector = Corrector(descriptor, hardware)
    return hardware, corrector, verilog_of(corrector)


def check_small(prepared, memory):
    """A frame's clocks and waits to within 4."""
    hardware, corrector, verilog = prepared
    counters = simulate_correction(corrector.descriptor, noise(corrector.descriptor), hardware,
                                   memory=memory, verilog=verilog).counters
    _, clocks = predicted(corrector, hardware, memory)
    assert abs(counters["CLOCKS"] - clocks.clocks) <= 4
    assert abs(counters["INTERLOCK_STALLS"] - clocks.interlock) <= 4
    assert abs(counters["CREDIT_STALLS"] - clocks.credit) <= 4


@pytest.mark.longer
@pytest.mark.parametrize("variant,neurons,choices", [
    ("table", 2, {}), pytest.param("mmhbc", 8, {}, marks=pytest.mark.regress),
    ("mmhbc", 4, {"hidden": "raster"}),
    pytest.param("mmhbc", 4, {"lanes": 2}, marks=pytest.mark.regress),
    ("mmhbc", 3, {"output": "memory"})],
    ids=["table", "mmhbc", "raster", "two pixels", "memory"])
def test_the_latency_is_that_of_the_network(variant, neurons, choices):
    """A small frame is mostly latency: networks of other depth, each within a few clocks."""
    check_small(small(variant, neurons, **choices), "ideal")


@pytest.mark.longer
@pytest.mark.parametrize("nodes,neurons,choices", [
    (16, 12, {}),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        (8, 4, {"lanes": 2}),
        (16, 8, {"lanes": 4}), (32, 5, {"share": 5}), (8, 6, {"output": "memory"})))],
    ids=["one unit", "two pixels", "four", "far", "memory"])
def test_the_latency_is_that_of_the_network_at_nodes(nodes, neurons, choices):
    """The first coordinate waits for four nodes; then one follows per clock and lane."""
    descriptor = replace(barrel_descriptor((160, 40), (160, 40), hidden_neurons=neurons),
                         nodes=nodes)
    hardware = Hardware(**{"output": "stream"} | choices)
    assert hardware.keeps_rate(descriptor)
    corrector = Corrector(descriptor, hardware)
    check_small((hardware, corrector, verilog_of(corrector)), "ideal")


@pytest.fixture(scope="module")
def prepared_small():
    return small("mmhbc", 8)


def unrefreshed(memory):
    """A memory without refresh: how far off the next one is when a frame starts is unknown, and
    the clocks of a small frame depend on it, by up to 17."""
    return replace(memory_timing(memory), refresh_interval=1 << 30)


@pytest.mark.parametrize("memory", [
    "ideal", "fixed:20:4", "fixed:20:1.5", "fixed:100:64", unrefreshed("sdram"),
    pytest.param(unrefreshed("ddr3"), marks=pytest.mark.longer)],
    ids=["ideal", "fixed", "slow", "far", "sdram", "ddr3"])
def test_the_latency_is_that_of_the_memory(prepared_small, memory):
    """The first tiles wait for the first look-up to be read, see the interlock: that takes a
    latency of the memory, and so do the windows after them."""
    check_small(prepared_small, memory)
