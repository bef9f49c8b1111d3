"""Which part of a sensor raw frames show: sizes, positions, colours, what is rejected."""

import numpy as np
import pytest

from ncdc_boards.camera_board.design import sensor_for
from ncdc_sim.sensor.photo import still_raw
from ncdc_sim.sensor.reference import raw_frames
from ncdc_sim.sensor.verilog import Light
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import BAYER_PHASE, GRADIENT, MONO, Geometry
from ncdc_spec.sensors.catalogue import SENSORS
from ncdc_spec.sensors.framing import grid_row, setup_around, shown

EACH = pytest.mark.parametrize("name", [sensor.name for sensor in SENSORS])


def geometry(width=640, height=480, bayer="GRBG"):
    interpolation = {"interpolation": GRADIENT} if bayer == MONO else {}
    return Geometry(width, height, width, height, bayer=bayer, **interpolation)


def shares(name, size, **more):
    """Share of the sensor's width and height that raw frames show by default on a board."""
    g = geometry(*size, **more)
    plan, crop = sensor_for(name, g, field="full")
    _, _, width, height = shown(plan, crop, g)
    return width / plan.sensor.columns, height / plan.sensor.rows


@pytest.mark.parametrize("bayer", [*BAYER_PHASE, MONO])
def test_vga_shows_the_whole_field(bayer):
    for name in ("mt9p031", "ov5640", "ov5647"):
        assert min(shares(name, (640, 480), bayer=bayer)) > 0.98, name
    assert shares("mt9d111", (640, 480), bayer=bayer) == (0.8, 0.8)


def test_without_a_field_the_window_is_in_the_middle():
    """Not in the top left corner of the sensor, where a wide lens shows nothing of what it does."""
    plan, crop = sensor_for("mt9p031", geometry())
    assert (plan.settings.left, plan.settings.top) == (976, 732)
    assert shown(plan, crop, geometry()) == (976, 732, 640, 480)
    assert not crop.grid and grid_row(plan, crop) is None


@pytest.mark.parametrize("name,size,skip,bins,binning,rate", [
    ("mt9p031", (640, 480), 4, 2, 0, 23.1),         # 4 bins would send 14.3
    ("mt9p031", (320, 240), 7, 4, 0, 30.5),
    ("mt9p031", (800, 600), 3, 2, 0, 17.3),
    ("mt9p031", (1280, 720), 2, 1, 0, 15.6), ("mt9p031", (1920, 1080), 1, 1, 0, 8.1),
    ("mt9p031", (1280, 960), 2, 1, 0, 11.8),        # fewer than 15 anyway: the most
    ("ov5640", (640, 480), 2, 2, 1, 6.7),           # binning costs it nothing
    ("imx219", (640, 480), 2, 2, 1, 52.9), ("ov5647", (640, 480), 2, 2, 1, 40.2),
    ("mt9d111", (640, 480), 2, 1, 0, 43.5), ("mt9d111", (1280, 960), 1, 1, 0, 14.3)])
def test_the_way_to_reduce(name, size, skip, bins, binning, rate):
    plan, crop = sensor_for(name, geometry(*size), field="full")
    assert (plan.settings.skip, plan.settings.bins, crop.binning) == (skip, bins, binning)
    assert round(plan.timing.frames_per_second, 1) == rate
    assert grid_row(plan, crop) == (plan.timing.width if skip > 1 else None)


def test_the_ov5640_is_slow_at_25_mhz():
    """5,000 clocks a line whatever its width, 3,792 of every other pair."""
    plan, _ = sensor_for("ov5640", geometry(), field="640x480")
    assert plan.timing.line_clocks == 5000 and round(plan.timing.frames_per_second, 1) == 9.9
    plan, _ = sensor_for("ov5640", geometry(), field="full")
    assert plan.timing.line_clocks == 3792


def test_a_fast_clock_leaves_time_for_more_bins():
    plan, _ = sensor_for("mt9p031", geometry(), field="full", pixel_clock_hz=75_000_000)
    assert plan.settings.bins == 4 and plan.timing.frames_per_second > 15


RAMP = 1.5, 2.0         # per active pixel, to the right and down


@EACH
@pytest.mark.parametrize("bayer", BAYER_PHASE)
@pytest.mark.parametrize("field", ["full", "128x96+41+30", None])
def test_raw_frames_show_what_is_said(name, bayer, field):
    """A ramp over the sensor comes out as the ramp over the field, whatever pixels make it."""
    g = geometry(64, 48, bayer)
    plan, crop = setup_around(name, g, field=field)
    left, top, width, height = shown(plan, crop, g)
    sensor, reduction = plan.sensor, width // 64
    light = (RAMP[0] * (np.arange(sensor.columns) - left)
             + RAMP[1] * (np.arange(sensor.rows) - top)[:, None] + 200)
    frames = raw_frames(plan, Light(np.rint(np.clip(light, 0, 3500)).astype(np.uint16)[None]))
    raw, = crop.raw(frames, g.distorted)
    x, y = (reduction * (np.arange(size) + .5) - .5 for size in (64, 48))
    wanted = RAMP[0] * x + RAMP[1] * y[:, None] + 200 + plan.sensor.black
    lost = (1 << 12 - sensor.bits) - 1              # bits that the sensor does not have
    # Weights are whole sixteenths: a reduction of 7 is off by a fifth of an active pixel.
    error = (raw - wanted)[2:, 2:]
    rounded = 1 + (reduction == 7)
    assert -lost - rounded <= error.min() and error.max() <= rounded


@EACH
@pytest.mark.parametrize("bayer", BAYER_PHASE)
def test_colours_are_those_of_the_geometry(name, bayer):
    """Light of one colour only, by the sensor's own filter, lies where the geometry has it."""
    for field in ("full", "128x96", None):
        g = geometry(64, 48, bayer)
        plan, crop = setup_around(name, g, field=field)
        red = plan.sensor.bayer.index("R")
        light = np.zeros((plan.sensor.rows, plan.sensor.columns), np.uint16)
        light[red // 2::2, red % 2::2] = 1000
        raw, = crop.raw(raw_frames(plan, Light(light[None])), g.distorted)
        column, row = BAYER_PHASE[bayer]
        # Evening takes a share of each slope from other colours, at most 3 / 4 of it.
        dark = np.ones((48, 64), bool)
        dark[row::2, column::2] = False
        bright = raw[~dark].astype(int)
        assert bright.min() > raw[dark].max(), field


@EACH
def test_a_raw_frame_on_the_sensor_comes_back(name):
    """Where it changes slowly; else reduced pixels lack the detail."""
    y, x = np.indices((48, 64))
    wanted = (40 + 2 * x + y + 30 * (x % 2)).astype(np.uint8)
    for field in ("full", "128x96", None):
        g = geometry(64, 48)
        plan, crop = setup_around(name, g, field=field)
        raw, = crop.raw(raw_frames(plan, still_raw(plan, crop, wanted)), g.distorted)
        bytes_ = (raw.astype(int) - plan.sensor.black) * 255 / (4095 - plan.sensor.black)
        assert np.abs(bytes_ - wanted)[2:-2, 2:-2].max() < 3, field


@pytest.mark.parametrize("field,sentence", [
    ("1300x960", "the field is 1300x960, raw frames of 640x480 show 640x480, 1280x960, 1920x1440, "
     "2560x1920 of the mt9p031's 2592x1944 pixels"),
    ("640x480+1960+0", "left of the field is 1960, one of 640x480 of the mt9p031's 2592x1944 "
     "pixels has 0 to 1952"),
    ("640x480+0+1500", "top of the field is 1500, one of 640x480 of the mt9p031's 2592x1944 "
     "pixels has 0 to 1464"),
    ("whole", "the field is 'whole', full, WIDTHxHEIGHT or WIDTHxHEIGHT+LEFT+TOP"),
    ("640x480+-2+0", "the field is '640x480+-2+0', full"), ("640x480+7", "'640x480+7', full"),
    ("", "the field is '', full")])
def test_bad_fields(field, sentence):
    with pytest.raises(InputError) as error:
        setup_around("mt9p031", geometry(), field=field)
    assert sentence in str(error.value)


def test_a_raw_frame_larger_than_the_sensor():
    with pytest.raises(InputError, match="raw frames of 1600x1200 take 1602x1202 pixels of a "
                                         "sensor, the mt9d111 has 1600x1200"):
        setup_around("mt9d111", geometry(1600, 1200), field="full")


def test_a_corner_goes_to_the_nearest_position_of_its_colours():
    for bayer, corner in (("GRBG", (974, 730)), ("BGGR", (974, 731)), ("RGGB", (975, 730))):
        g = geometry(bayer=bayer)
        plan, crop = setup_around("mt9p031", g, field="640x480+975+731")
        assert shown(plan, crop, g)[:2] == corner, bayer
        assert plan.settings.left % 2 == plan.settings.top % 2 == 0
