"""The whole camera system under Verilator: sensor's pins to corrected pictures, and its faults."""

from itertools import takewhile

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_bench.system.readers import simulate_readers
from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_hdl.system import System
from ncdc_sim.sensor.verilog import Fault, Light
from ncdc_sim.system.camera import simulate_camera
from ncdc_sim.system.live import Clocks
from ncdc_sim.waves import FORMATS, Waves
from ncdc_spec.hardware import Hardware
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.sensor import Settings
from simulations.metastability import Metastability, metastable_verilog

regress = pytest.mark.regress

WIDTH, HEIGHT = 64, 24
FAULTS = {
    "short_line": ({"frame": 1, "row": 7}, "LINE_FAULTS"),
    "long_line": ({"frame": 1, "row": 7}, "LINE_FAULTS"),
    "glitch": ({"frame": 1, "row": 7}, "LINE_FAULTS"),
    "cut_frame": ({"frame": 1, "row": 15}, "FRAMES_CUT"),
    "clock_stop": ({"frame": 1, "row": 9, "clocks": 60_000}, "CLOCK_STOPS"),
}


@pytest.fixture(scope="module")
def system():
    return System(barrel_descriptor((WIDTH, HEIGHT), (WIDTH, HEIGHT), hidden_neurons=2,
                                    strength=.4), Hardware(data_width=64))


@pytest.fixture(scope="module")
def verilog(system):
    return system_verilog(system)


@pytest.fixture(scope="module")
def light():
    noise = np.random.default_rng(1).integers(0, 4096, (6, HEIGHT, WIDTH), dtype=np.uint16)
    return Light(noise)


def asked(name="mt9p031"):
    """The sensor sends frames of 64x24, without a PLL."""
    sensor = sensor_named(name)
    return setup(sensor, Settings(width=WIDTH, height=HEIGHT, exposure_us=100,
                                  clock_hz=sensor.pixel_clock_hz))


@pytest.mark.parametrize("follow", [pytest.param(False, marks=pytest.mark.longer), True])
def test_every_frame_is_its_own_raw_frame_corrected(system, verilog, light, follow):
    run = simulate_camera(system, asked(), light, count=3, verilog=verilog, follow=follow)
    assert [frame.different for frame in run.frames] == [0, 0, 0]
    assert [frame.number for frame in run.frames] == [1, 2, 3]
    assert run.counters["RAW_BEGUN"] - run.counters["CORRECTED_BEGUN"] in (0, 1)
    assert not any(run.counters[name] for name in (
        "LINE_FAULTS", "FRAMES_CUT", "OVERFLOWS", "FRAMES_MISSED", "CLOCK_STOPS", "RAW_ENDED_BAD",
        "CORRECTED_ENDED_BAD", "RAW_SKIPPED"))
    assert not any(value for name, value in run.bench.items() if name.endswith("_errors"))
    assert run.i2c_errors == []


@pytest.mark.many_clocks
@regress
def test_a_second_simulator_agrees(system, verilog, light):
    run = simulate_camera(system, asked(), light, count=1, verilog=verilog, simulator="icarus")
    assert [(frame.number, frame.different) for frame in run.frames] == [(1, 0)]


@regress
@pytest.mark.parametrize("kind", FORMATS)
def test_waveforms_of_a_camera(system, verilog, light, tmp_path, kind):
    path = tmp_path / f"waves.{kind}"
    run = simulate_camera(system, asked(), light, count=1, verilog=verilog,
                          waves=Waves(path, kind))
    assert run.frames[0].different == 0
    if kind == "fst":
        assert path.read_bytes()[:9] == bytes([0]) + (329).to_bytes(8, "big")
        return
    with path.open() as lines:
        variables = [line.split() for line in takewhile(
            lambda line: "$enddefinitions" not in line, lines) if "$var" in line]
        codes = {words[3]: words[4] for words in variables}
        moved = {codes.get(line[1:].strip()) for line in lines if line[0] in "01"}
    assert {"frame_valid", "line_valid", "scl", "sda", "irq", "write_write"} <= moved


@pytest.mark.many_clocks
@regress
@pytest.mark.parametrize("period,counters", [
    (9_990, ("produce_cdc", "consume_cdc")), (30_010, ("produce_cdc", "consume_cdc")),
    # An entry is taken some clocks after the sensor's edge, never near the next one.
    (79_990, ("produce_cdc",))])
def test_every_synchroniser_of_a_system_may_be_metastable(system, light, period, counters):
    verilog = metastable_verilog(system_verilog(system, Metastability()))
    run = simulate_camera(
        system, asked(), light, count=3, verilog=verilog, clocks=Clocks(extclk_period=period),
        more=["+metastable_ps=4490"])
    assert [(frame.number, frame.different) for frame in run.frames] == [(1, 0), (2, 0), (3, 0)]
    assert not any(run.counters[name] for name in (
        "LINE_FAULTS", "FRAMES_CUT", "OVERFLOWS", "FRAMES_MISSED", "CLOCK_STOPS", "RAW_ENDED_BAD"))
    paths = " ".join(run.bench)
    assert all(name in paths for name in (*counters, "scl_cdc", "sda_cdc"))


@pytest.mark.longer
@pytest.mark.parametrize("kind,follow", [
    ("short_line", False), ("cut_frame", True), ("clock_stop", True),
    *(pytest.param(kind, follow, marks=regress) for kind, follow in (
        ("short_line", True), ("long_line", False), ("long_line", True), ("glitch", False),
        ("glitch", True), ("cut_frame", False), ("clock_stop", False)))])
def test_a_fault_is_counted_and_the_next_frame_is_right(system, verilog, light, kind, follow):
    options, counter = FAULTS[kind]
    run = simulate_camera(system, asked(), light, count=3, verilog=verilog, follow=follow,
                          fault=Fault(kind, **options))
    assert run.counters[counter] > 0
    assert run.counters["RAW_ENDED_BAD"] > 0
    # One that is followed has been begun; it is not handed on.
    assert run.counters["CORRECTED_ENDED_BAD"] == (run.counters["RAW_ENDED_BAD"] if follow else 0)
    assert [frame.different for frame in run.frames] == [0, 0, 0]
    assert [frame.number for frame in run.frames][0] == 1
    assert [frame.number for frame in run.frames][1] > 2


@pytest.mark.longer
@pytest.mark.parametrize("kind,flag", [("nack", "NACK"), ("stuck_sda", "LOST")])
def test_a_sensor_that_does_not_answer_is_asked_again(system, verilog, light, kind, flag):
    run = simulate_camera(system, asked(), light, count=1, verilog=verilog,
                          fault=Fault(kind, start=9))
    assert flag in run.i2c_errors
    assert run.frames[0].different == 0


@pytest.mark.longer
def test_a_memory_that_stalls_loses_frames_and_says_so(system, verilog, light):
    run = simulate_camera(system, asked(), light, count=3, verilog=verilog,
                          disturb=lambda host: host.live.stall(200_000))
    assert run.counters["OVERFLOWS"] > 0
    assert [frame.different for frame in run.frames] == [0, 0, 0]


@pytest.mark.longer
@pytest.mark.many_clocks
@pytest.mark.parametrize("frames,limit,period", [
    (25, 40_000, 6_000), pytest.param(25, 0, 10_000, marks=regress),
    pytest.param(500, 0, 7_000, marks=regress), pytest.param(500, 50_000, 23_000, marks=regress)])
def test_readers_never_see_a_torn_frame_unmarked(system, verilog, light, frames, limit, period):
    """With a limit buffers are taken away: each time the reader, or a counter, says so."""
    run = simulate_readers(system, asked(), light, count=frames, seed=frames + limit, limit=limit,
                           verilog=verilog, clocks=Clocks(extclk_period=period))
    assert run.torn == 0
    assert run.raw > 2 and run.corrected > 2
    assert (run.lost > 0) == (limit > 0)
    assert run.taken >= run.lost
    assert run.bad == 0
