"""A whole system: reads of a screen or a network, rates, and who limits them."""

from dataclasses import replace
from fractions import Fraction
from itertools import islice

import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_model.planner.delay_steps import DelaySteps
from ncdc_model.planner.memory_timing import LatencyMemory, memory_at
from ncdc_model.planner.plan import Fixed, plan
from ncdc_model.planner.ports import memory_port
from ncdc_model.planner.reader_reads import SteadyReads, with_reads
from ncdc_model.planner.system import Readers, capacity, steady_camera, system_plan
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware

WIDTH, HEIGHT = 160, 120
RAW, PICTURE = WIDTH * HEIGHT, 4 * WIDTH * HEIGHT


def test_reads_worked_out_by_hand():
    """Two bytes per clock of a picture of 100 bytes: bursts of 64 and 36 bytes, then again."""
    reader = SteadyReads(base=4096, size=100, rate=Fraction(2))
    assert list(islice(reader.accesses(word=4, block=4), 26))[15:] == [
        (0, 4156, 1), *((32, 4160 + 4 * k, 1) for k in range(9)), (50, 4096, 1)]
    assert list(islice(reader.accesses(word=4, block=32), 5)) == [
        (0, 4096, 8), (0, 4128, 8), (32, 4160, 8), (32, 4192, 1), (50, 4096, 8)]


@pytest.mark.parametrize("words", [0, 4])
def test_a_read_waits_for_an_earlier_one_of_another_port(words):
    """A memory of a word per clock has the first read word at edge 4, or after the words that
    another port has taken from edge 1 on."""
    writes = replace(with_reads(None, [SteadyReads(0, 4, Fraction(1))], 4, 4),
                     reads=lambda: iter([(0, 64, words)] if words else []))
    port = memory_port(LatencyMemory((1, 1), 4.0), 32, writes, DelaySteps(0))
    assert port.read(3, 4096, 4)[1] == (8 if words else 7)


@pytest.fixture(scope="module")
def barrel():
    return barrel_descriptor((WIDTH, HEIGHT), (WIDTH, HEIGHT), hidden_neurons=4)


@pytest.fixture(scope="module")
def system_of(barrel):
    """``system_of(memory, fps, output, screen, network)``: its :class:`SystemPlan`, and the
    corrector's :class:`Plan`."""
    def make(memory, fps, output="memory", *readers):
        def timing(chosen):
            return Corrector(barrel, chosen).timing
        planned = plan(barrel, Hardware(data_width=32, output=output), memory, timing,
                       fixed=Fixed(8192, 4, 0))
        return system_plan(barrel, planned, memory_at(memory, 100), timing(planned.hardware),
                           steady_camera(barrel.geometry, fps), Readers(*readers)), planned
    return make


def test_the_camera_limits_what_memory_carries(system_of):
    found, planned = system_of("ideal", 100, "memory", 60)
    assert found.limited_by == "camera" and found.frames_per_second == 100
    assert found.parts == pytest.approx({
        "camera, writes": 100 * RAW, "corrector, reads": 100 * 32 * planned.misses * 2,
        "corrector, writes": 100 * PICTURE, "screen, reads": 60 * PICTURE})
    assert found.capacity is None
    assert all(part["share"] is None for part in found.report()["parts"])


def test_the_network_limits_a_stream_without_a_trace_in_memory(system_of):
    found, planned = system_of("ideal", 100, "stream", None, 8 * 50 * PICTURE / 1e6)
    assert found.limited_by == "network" and found.frames_per_second == pytest.approx(50)
    assert list(found.parts) == ["camera, writes", "corrector, reads"]
    assert found.parts["corrector, reads"] == pytest.approx(50 * planned.misses * 64)


def test_a_screen_on_the_stream_takes_each_picture_once(system_of):
    found, _ = system_of("ideal", 100, "stream", 60)
    assert found.limited_by == "screen" and found.frames_per_second == 60
    assert list(found.parts) == ["camera, writes", "corrector, reads"]


def test_the_corrector_limits_where_memory_never_waits(system_of):
    found, planned = system_of("ideal", 20_000, "stream")
    assert found.limited_by == "corrector"
    assert found.frames_per_second == pytest.approx(100e6 / planned.unhindered, rel=.02)


def test_memory_limits_and_a_reader_makes_it_slower(system_of):
    """The memory moves 4 bytes per clock: a pixel written and one read take two clocks alone."""
    camera, reader = 4000, 2000
    alone, _ = system_of("fixed:10:4", camera)
    read, _ = system_of("fixed:10:4", camera, "memory", reader)
    assert alone.limited_by == read.limited_by == "memory"
    assert read.capacity == 400e6
    # What the reader takes lengthens a frame by its share.
    left = 400e6 - camera * RAW
    assert alone.clocks / read.clocks == pytest.approx((left - reader * PICTURE) / left, rel=.03)


def test_more_traffic_than_the_memory_moves_is_rejected(system_of):
    with pytest.raises(InputError, match="the traffic of camera and screen is 461 MB/s, the "
                                         "memory sdram moves 400 MB/s at most"):
        system_of("sdram", 2000, "memory", 5500)


def test_what_memories_move():
    assert capacity(memory_at("ddr3", 125), 125) == 1600e6
    assert capacity(memory_at("sdram", 100), 100) == 400e6
    assert capacity(memory_at("fixed:100:4", 75), 75) == 300e6
    assert capacity(memory_at("ideal", 100), 100) is None


@pytest.mark.parametrize("make,message", [
    (lambda: Readers(0), "the screen's rate is 0 frames per second, it must be positive"),
    (lambda: Readers(None, -1), "the network's rate is -1 Mb/s, it must be positive")])
def test_rates_are_positive(make, message):
    with pytest.raises(InputError, match=message):
        make()
