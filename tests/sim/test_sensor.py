"""The Verilog model of each sensor against its twin: random set-ups, test patterns, faults, I2C."""

import numpy as np
import pytest

from ncdc_model.sensors.catalogue import SENSORS, sensor_named
from sensors import random_light, run_sensor

NAMES = [sensor.name for sensor in SENSORS]


def random_settings(name, seed):
    """Fields of Settings of a small window anywhere, and light that covers most of it."""
    sensor, chance = sensor_named(name), np.random.default_rng(seed)
    step, corner = sensor.limits.step, sensor.limits.corner_step
    width, height = (int(least + step * chance.integers(1, 6))
                     for least in (max(16, sensor.limits.smallest[0]), sensor.limits.smallest[1]))
    left, top = (int(corner * chance.integers(0, (size - part) // corner + 1))
                 for size, part in ((sensor.columns, width), (sensor.rows, height)))
    # MT9D111: the last column and row have no neighbour to begin with when mirrored.
    asked = {"width": width, "height": height, "left": max(0, left - 2), "top": max(0, top - 2),
             "exposure_us": float(chance.uniform(60, 400)), "gain_db": float(chance.uniform(0, 30)),
             "mirror_columns": bool(chance.integers(2)), "mirror_rows": bool(chance.integers(2))}
    return asked, random_light((2, height, width - 2), seed, asked["left"] + 1, asked["top"],
                               int(chance.integers(10_000, 400_000)))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.regress)
                                       for k in range(2, 12))])
def test_frames_equal_the_twins(name, seed):
    asked, light = random_settings(name, seed)
    run_sensor(name, "verilator", asked, light)
