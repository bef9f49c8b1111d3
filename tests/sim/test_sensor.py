"""The Verilog model of each sensor equals its reference model: settings, patterns, faults, I2C."""

import numpy as np
import pytest

import sensors
from cocotb_run import Design, run_cocotb
from ncdc_sim.sensor.verilog import AWAKE, Fault
from ncdc_sim.tools import SimulationError
from ncdc_spec.sensors.catalogue import SENSORS, sensor_named
from sensors import controlled, random_light, run_sensor, with_lines

NAMES = [sensor.name for sensor in SENSORS]


REDUCED = [(sensor.name, *pair) for sensor in SENSORS for pair in sensor.limits.reductions]
CHEAP_REDUCED = [("mt9p031", 4, 2)]
LONG_REDUCED = [("mt9p031", 2, 1), ("mt9p031", 3, 2), ("mt9p031", 4, 4), ("mt9p031", 7, 1),
                *(one for one in REDUCED if one[0] != "mt9p031")]


def random_settings(name, seed):
    """Fields of Settings of a small window anywhere, and light that covers most of it."""
    sensor, rng = sensor_named(name), np.random.default_rng(seed)
    step, corner = sensor.limits.step, sensor.limits.corner_step
    width, height = (int(least + step * rng.integers(1, 6))
                     for least in (max(16, sensor.limits.smallest[0]), sensor.limits.smallest[1]))
    left, top = (int(corner * rng.integers(0, (size - part) // corner + 1))
                 for size, part in ((sensor.columns, width), (sensor.rows, height)))
    # MT9D111: the last column and row have no neighbour to begin with when mirrored.
    asked = {"width": width, "height": height, "left": max(0, left - 2), "top": max(0, top - 2),
             "exposure_us": float(rng.uniform(120, 400)), "gain_db": float(rng.uniform(0, 30)),
             "mirror_columns": bool(rng.integers(2)), "mirror_rows": bool(rng.integers(2))}
    return asked, random_light((2, height, width - 2), seed, asked["left"] + 1, asked["top"],
                               int(rng.integers(10_000, 400_000)))


def random_reduced(name, skip, bins, seed):
    """Fields of Settings of a small window, read reduced, and light of most of its pixels."""
    sensor, rng = sensor_named(name), np.random.default_rng(seed)
    step = sensor.limits.step
    width, height = (-(-2 * int(rng.integers(least, least + 6)) // step) * step
                     for least in (9, 8))
    left, top = (2 * bins * int(rng.integers(2, (size - skip * part) // (2 * bins)))
                 - first % (2 * bins)
                 for size, part, first in zip((sensor.columns, sensor.rows), (width, height),
                                              sensor.first))
    asked = {"width": width, "height": height, "left": left, "top": top, "skip": skip, "bins": bins,
             "exposure_us": float(rng.uniform(120, 400)), "gain_db": float(rng.uniform(0, 30))}
    # Some pixels of a mean lie outside of it, on each side.
    return asked, random_light((2, skip * height - 3, skip * width - 5), seed, left + 1, top + 1,
                               int(rng.integers(10_000, 400_000)))


@pytest.mark.parametrize("name,skip,bins", [
    *CHEAP_REDUCED, *(pytest.param(*each, marks=pytest.mark.regress)
                      for each in LONG_REDUCED)])
@pytest.mark.parametrize("simulator", ["verilator", pytest.param("icarus",
                                                                 marks=pytest.mark.regress)])
def test_reduced_frames_equal_the_reference_models(name, skip, bins, simulator):
    """Which pixels are read, their means, and how long lines take."""
    run_sensor(name, simulator, *random_reduced(name, skip, bins, 10 * skip + bins))


@pytest.mark.longer
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.regress)
                                       for k in range(2, 12))])
def test_frames_equal_the_reference_models(name, seed):
    asked, light = random_settings(name, seed)
    run_sensor(name, "verilator", asked, light)


@pytest.mark.longer
def test_frames_under_the_other_simulator():
    run_sensor("mt9p031", "icarus", *random_settings("mt9p031", 1))


@pytest.mark.longer
def test_mirrored():
    asked, light = random_settings("mt9d111", 4)
    run_sensor("mt9d111", "verilator", asked | {
        "width": 19, "mirror_columns": True, "mirror_rows": True}, light)


SMALL = {"width": 36, "height": 20, "left": 100, "top": 60, "exposure_us": 200}
EVERY = [(sensor.name, pattern) for sensor in SENSORS for pattern in sensor.test_patterns]
CHEAP = [("mt9p031", "ColorField")]


@pytest.mark.longer
@pytest.mark.parametrize("name,pattern", [
    *CHEAP, *(pytest.param(*each, marks=pytest.mark.regress) for each in EVERY
              if each not in CHEAP)])
def test_patterns(name, pattern):
    light = random_light((1, 20, 36), 1, 100, 60)
    run_sensor(name, "verilator", SMALL | {"test_pattern": pattern, "mirror_rows": True}, light)


@pytest.mark.longer
@pytest.mark.parametrize("kind", ["glitch", *(
    pytest.param(kind, marks=pytest.mark.regress) for kind in (
        "clock_stop", "short_line", "long_line", "cut_frame"))])
def test_a_fault_is_in_its_row_and_the_next_frame_is_right(kind):
    light = random_light((3, 20, 36), 2, 100, 60)
    run_sensor("mt9p031", "verilator", SMALL, light, count=3, fault=Fault(kind, 1, 6, clocks=3000))


@pytest.mark.longer
@pytest.mark.parametrize("name,fault", [
    ("mt9p031", "nack"), *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        ("mt9p031", "stuck_sda"), ("ov5640", ""), ("mt9d111", "")))])
def test_our_controller_sets_it_up(name, fault):
    # The chip id takes two STARTs a register.
    plusargs = [f"+sensor_time_scale={AWAKE}"] + (Fault(fault, start=2).plusargs() if fault else [])
    run_cocotb(controlled(name), "sensor_control", "verilator", plusargs=plusargs, sensor=name,
               asked=SMALL, fault=fault)


@pytest.mark.longer
def test_a_sensor_that_does_not_round_is_found(monkeypatch):
    asked, light = random_settings("mt9p031", 1)
    design = with_lines("mt9p031")
    broken = Design(design.top, design.verilog.replace("+ 32768) >> 16", ") >> 16"))
    monkeypatch.setattr(sensors, "with_lines", lambda name: broken)
    with pytest.raises(SimulationError, match="frames"):
        run_sensor("mt9p031", "icarus", asked, light)
