"""Set-ups of image sensors: values worked out by hand from the data sheets, round trips, limits."""

from dataclasses import replace
from math import log10

import numpy as np
import pytest

from ncdc_spec.errors import InputError
from ncdc_spec.sensors.catalogue import SENSORS, sensor_named, setup
from ncdc_spec.sensors.sensor import Settings, bayer_at

BY_NAME = {sensor.name: sensor for sensor in SENSORS}
EACH = pytest.mark.parametrize("sensor", SENSORS, ids=BY_NAME)


def prepared(name, **asked):
    return setup(BY_NAME[name], Settings(**asked))


def last_of(plan):
    """The value that each register is left with."""
    return dict(plan.pairs)


def test_mt9p031_by_hand():
    plan = prepared("mt9p031", width=1280, height=1024, left=640, top=460, gain_db=20 * log10(4))
    assert plan.timing.line_clocks == 2 * (640 + 450)
    # (960,000 + 2 * 213) / 2180 = 440.56
    assert plan.exposure_clocks == 441 * 2180 - 426
    assert plan.timing.frame_lines == 1024 + 9
    expected = {0x01: 54 + 460, 0x02: 16 + 640, 0x03: 1023, 0x04: 1279, 0x05: 449, 0x06: 8,
                0x07: 0x1F82, 0x08: 0, 0x09: 441, 0x0A: 0x8000, 0x0D: 0, 0x20: 0x0040, 0x35: 32,
                # 24 MHz * 16 / 2 / 2
                0x11: 16 << 8 | 1, 0x12: 1, 0x10: 0x53}
    assert expected.items() <= last_of(plan).items()
    assert plan.pairs[:3] == [(0x0D, 1), (0x0D, 0), (0x07, 0x1F80)]
    assert plan.pairs[-1] == (0x07, 0x1F82)


@pytest.mark.parametrize("width,height,rate", [
    (2592, 1944, 14), (2048, 1536, 21), (1600, 1200, 31), (1280, 1024, 42), (1024, 768, 63),
    (800, 600, 90), (1920, 1080, 31)])
def test_mt9p031_frame_rates_are_those_of_the_data_sheet(width, height, rate):
    """Its tables of resolutions have the 26 lines of vertical blanking after reset, not the 9 that
    its equations allow."""
    timing = prepared("mt9p031", width=width, height=height, exposure_us=1000).timing
    assert timing.frame_lines == height + 9
    assert round(96e6 / (timing.line_clocks * (height + 26))) == rate


@pytest.mark.parametrize("factor,word", [
    (1, 8), (1.125, 9), (4, 32), (4.25, 1 << 6 | 17), (8, 1 << 6 | 32), (9, 0x0160),
    (128, 0x7860)])
def test_mt9p031_gain_word(factor, word):
    plan = prepared("mt9p031", gain_db=20 * log10(factor))
    assert last_of(plan)[0x35] == word and plan.gain_256 == 256 * factor


def test_mt9p031_test_pattern_turns_off_black_correction():
    words = last_of(prepared("mt9p031", test_pattern="ColorBar", mirror_rows=True))
    assert words[0xA0] == 8 << 3 | 1 and words[0x20] == 1 << 15 and words[0x4B] == 0


def test_mt9p031_makes_the_frame_longer_for_a_long_exposure():
    plan = prepared("mt9p031", width=640, height=480, exposure_us=1e6)
    lines = plan.timing.frame_lines - 1
    assert last_of(plan)[0x08] << 16 | last_of(plan)[0x09] == lines > 60_000
    assert last_of(plan)[0x06] == 4095


def test_mt9d111_by_hand():
    plan = prepared("mt9d111", width=1600, height=1200, exposure_us=66_660, gain_db=20 * log10(3))
    # The example of the MT9D011: 66.66 ms at 36 MHz; its line is shorter.
    assert plan.timing.line_clocks == 1600 + 516
    assert plan.exposure_clocks == 1134 * 2116 - 260
    expected = {0x01: 28, 0x02: 60, 0x03: 1200, 0x04: 1600, 0x05: 516, 0x06: 11, 0x09: 1134,
                0x20: 0, 0x2F: 1 << 7 | 48, 0xF2: 0b1011, 0x0D: 0, 0xC3: 1}
    assert expected.items() <= last_of(plan).items()
    assert plan.pairs[:4] == [(0xF0, 1), (0xC3, 1), (0x09, 0), (0xF0, 0)]


@pytest.mark.parametrize("factor,word", [(1, 32), (1.5, 48), (2, 1 << 7 | 32), (4, 3 << 7 | 32),
                                         (32, 31 << 7 | 32), (127, 31 << 7 | 127)])
def test_mt9d111_gain_word(factor, word):
    plan = prepared("mt9d111", gain_db=20 * log10(factor))
    assert last_of(plan)[0x2F] == word and plan.gain_256 == 256 * factor


def test_ov5640_by_hand():
    plan = prepared("ov5640", gain_db=20 * log10(2.5))
    # Of the whole array: the values after reset, by the data sheet.
    whole = {0x3800: 0, 0x3801: 0, 0x3804: 0x0A, 0x3805: 0x3F, 0x3806: 0x07, 0x3807: 0x9F,
             0x3808: 0x0A, 0x3809: 0x20, 0x380A: 0x07, 0x380B: 0x98, 0x380C: 0x0B, 0x380D: 0x1C,
             0x380E: 0x07, 0x380F: 0xB0, 0x3811: 16, 0x3813: 4}
    # 10 ms of 96 MHz in lines of 5688: 168.8; 24 MHz / 3 * 120 / 2 / 2 / 2.5 = 96 MHz.
    rest = {0x3500: 0, 0x3501: 0x0A, 0x3502: 0x90, 0x350A: 0, 0x350B: 40, 0x3035: 0x21,
            0x3036: 120, 0x3037: 0x13, 0x4300: 0, 0x501F: 3, 0x3821: 6, 0x3820: 0, 0x3008: 0x02}
    assert (whole | rest).items() <= last_of(plan).items()


def test_imx219_by_hand():
    """Linux's mode of 1920x1080 at 30 frames per second."""
    plan = prepared("imx219", width=1920, height=1080, left=680, top=692, exposure_us=20_000,
                    frames_per_second=30, gain_db=20 * log10(8))
    # 182.4 MHz / (3448 * 30) = 1763.3; 20 ms are 1058 lines.
    expected = {0x0160: 0x06, 0x0161: 0xE3, 0x0162: 0x0D, 0x0163: 0x78, 0x0164: 0x02, 0x0165: 0xA8,
                0x0166: 0x0A, 0x0167: 0x27, 0x0168: 0x02, 0x0169: 0xB4, 0x016A: 0x06, 0x016B: 0xEB,
                0x016C: 0x07, 0x016D: 0x80, 0x016E: 0x04, 0x016F: 0x38, 0x0174: 0, 0x0175: 0,
                0x0306: 0, 0x0307: 57, 0x030C: 0, 0x030D: 114, 0x0309: 10, 0x018C: 10, 0x018D: 10,
                0x0114: 1, 0x012A: 24, 0x012B: 0, 0x0157: 224, 0x0158: 1, 0x0159: 0, 0x015A: 0x04,
                0x015B: 0x22, 0x0172: 0, 0x0601: 0, 0x0100: 1}
    assert expected.items() <= last_of(plan).items()
    assert plan.gain_256 == 8 * 256 and plan.exposure_clocks == 1058 * 3448
    assert (plan.link.lanes, plan.link.lane_hz, plan.link.embedded_rows) == (2, 912_000_000, 2)
    # The whole array, binned: 1640x1232 at 30 frames per second.
    plan = prepared("imx219", skip=2, bins=2, frames_per_second=30)
    expected = {0x0164: 0, 0x0165: 0, 0x0166: 0x0C, 0x0167: 0xCF, 0x016A: 0x09, 0x016B: 0x9F,
                0x016C: 0x06, 0x016D: 0x68, 0x016E: 0x04, 0x016F: 0xD0, 0x0174: 1, 0x0175: 1}
    assert expected.items() <= last_of(plan).items() and plan.timing.frame_lines == 1763


def test_imx219_lines_are_longer_on_slow_lanes():
    """1920 samples on two lanes of 456 Mb/s: 21.05 us and the pause are 4114 clocks of the pixels;
    640 take 7 us, less than the shortest line."""
    slow = prepared("imx219", width=1920, height=1080, lane_hz=456_000_000)
    assert slow.timing.line_clocks == 4114 and last_of(slow)[0x030D] == 57
    assert prepared("imx219", width=640, lane_hz=456_000_000).timing.line_clocks == 3448


@pytest.mark.parametrize("name,asked,rate", [
    ("imx219", {"width": 1920, "height": 1080}, 47.6), ("imx219", {"skip": 2, "bins": 2}, 41.9),
    ("imx219", {"width": 640, "height": 480}, 103.3),
    ("imx219", {"width": 1920, "height": 1080, "lane_hz": 456_000_000}, 39.9),
    ("ov5647", {"width": 1920, "height": 1080}, 32.8), ("ov5647", {"skip": 2, "bins": 2}, 39.9),
    ("ov5647", {"width": 640, "height": 480}, 71.9)])
def test_rates_of_sensors_with_csi2(name, asked, rate):
    """The table of docs/reference/sensors.md."""
    timing = prepared(name, exposure_us=1000, **asked).timing
    assert round(timing.frames_per_second, 1) == rate


@pytest.mark.parametrize("factor,analog,digital", [
    (1, 0, 256), (2, 128, 256), (256 / 24, 232, 256), (16, 232, 384), (160, 232, 3840)])
def test_imx219_gain_words(factor, analog, digital):
    plan = prepared("imx219", gain_db=20 * log10(factor))
    words = last_of(plan)
    assert (words[0x0157], words[0x0158] << 8 | words[0x0159]) == (analog, digital)
    assert plan.gain_256 == round(256 * factor)


def test_ov5647_by_hand():
    """Linux's modes of 2592x1944, and of 1296x972 but for its margins, lines and frames."""
    plan = prepared("ov5647", gain_db=20 * log10(2), exposure_us=20_000)
    expected = {0x3036: 105, 0x3800: 0, 0x3801: 0, 0x3802: 0, 0x3803: 0, 0x3804: 0x0A,
                0x3805: 0x3F, 0x3806: 0x07, 0x3807: 0xA3, 0x3808: 0x0A, 0x3809: 0x20,
                0x380A: 0x07, 0x380B: 0x98, 0x3811: 16, 0x3813: 6, 0x380C: 0x0B, 0x380D: 0x1C,
                0x380E: 0x07, 0x380F: 0xB0, 0x3814: 0x11, 0x3821: 2, 0x3820: 0, 0x350B: 32,
                # 20 ms of 87.5 MHz in lines of 2844: 615.3.
                0x3500: 0, 0x3501: 615 >> 4, 0x3502: (615 & 15) << 4, 0x4800: 4, 0x0100: 1}
    assert expected.items() <= last_of(plan).items()
    plan = prepared("ov5647", skip=2, bins=2)
    # The first row that is read: 6 - 2 * 2. 1296 samples, one each 18.29 ns, and 1.5 us: 2204.
    expected = {0x3801: 0, 0x3803: 2, 0x3805: 0x3F, 0x3808: 0x05, 0x3809: 0x10, 0x380A: 0x03,
                0x380B: 0xCC, 0x380C: 0x08, 0x380D: 0x9C, 0x3814: 0x31, 0x3815: 0x31,
                0x3821: 3, 0x3820: 0x41, 0x3612: 0x59, 0x3618: 0}
    assert expected.items() <= last_of(plan).items()
    # 25 MHz / 3 * 72 / 2 on each lane.
    plan = prepared("ov5647", lane_hz=300_000_000)
    assert last_of(plan)[0x3036] == 72 and plan.timing.pixel_clock_hz == 60_000_000
    assert plan.link.lane_hz == 300_000_000


@EACH
def test_exposure_and_gain_are_the_nearest(sensor):
    rng = np.random.default_rng(5)
    for _ in range(200):
        exposure, gain = float(rng.uniform(200, 50_000)), float(rng.uniform(0, 35.5))
        plan = setup(sensor, Settings(width=640, height=480, exposure_us=exposure, gain_db=gain))
        assert abs(plan.exposure_us - exposure) <= plan.timing.line_us / 2 * (1 + 1e-9)
        again = setup(sensor, Settings(width=640, height=480, exposure_us=plan.exposure_us,
                                       gain_db=plan.gain_db))
        assert again.pairs == plan.pairs
        assert abs(plan.gain_256 / 256 / 10 ** (gain / 20) - 1) < 1 / 15


@EACH
def test_a_frame_rate_is_met(sensor):
    for rate in (15, 20.25, 30):
        plan = setup(sensor, Settings(width=640, height=480, exposure_us=500,
                                      frames_per_second=rate))
        timing = plan.timing
        assert abs(timing.pixel_clock_hz / rate - timing.frame_clocks) <= timing.line_clocks / 2


@pytest.mark.parametrize("bins,mode,blanking,line,rates", [
    (1, 0x03, 449, 1542, (33.0, 84.5, 126.8)), (2, 0x13, 775, 2194, (23.2, 59.4, 89.1)),
    (4, 0x33, 1457, 3558, (14.3, 36.6, 55.0))])
def test_mt9p031_reduced_by_hand(bins, mode, blanking, line, rates):
    """Modes, blanking and lines by the equations of the data sheet and of Linux."""
    for rate, clock in zip(rates, (25_000_000, 64_000_000, 96_000_000)):
        plan = prepared("mt9p031", width=642, height=482, left=16, top=10, skip=4, bins=bins,
                        exposure_us=1000, pixel_clock_hz=clock, clock_hz=clock)
        assert abs(plan.timing.frames_per_second - rate) < 0.05
    expected = {0x01: 64, 0x02: 32, 0x03: 1927, 0x04: 2567, 0x05: blanking, 0x22: mode, 0x23: mode}
    assert expected.items() <= last_of(plan).items()
    assert plan.timing.line_clocks == line and plan.bayer == "GRBG"
    # 96 MHz: (96,000 + overhead) / line; the overhead counts each of the rows.
    overhead = 2 * (208 * bins + 5)
    assert plan.exposure_clocks == round((96_000 + overhead) / line) * line - overhead
    assert list(plan.columns[:4]) == [15 + bins + one for one in (0, 1, 8, 9)]
    assert plan.rows[-2] == plan.rows[0] + 480 * 4 and plan.rows[-1] == plan.rows[-2] + 1


@pytest.mark.parametrize("width,height,skip,bins,rate", [
    (1024, 768, 2, 1, 63), (1024, 768, 2, 2, 47), (800, 600, 2, 1, 90), (800, 600, 2, 2, 65),
    (640, 480, 4, 4, 53)])
def test_mt9p031_reduced_rates_are_those_of_the_data_sheet(width, height, skip, bins, rate):
    """Its table of resolutions, with 26 lines of vertical blanking."""
    timing = prepared("mt9p031", width=width, height=height, skip=skip, bins=bins, top=2,
                      exposure_us=1000).timing
    assert round(96e6 / (timing.line_clocks * (height + 26))) == rate


def test_ov5640_reduced_by_hand():
    plan = prepared("ov5640", skip=2, bins=2, exposure_us=1000, clock_hz=25_000_000,
                    pixel_clock_hz=25_000_000)
    # All that is read unreduced, of which half is sent: by Linux's VGA mode 1896 by 984.
    expected = {0x3800: 0, 0x3801: 0, 0x3803: 0, 0x3804: 0x0A, 0x3805: 0x3F, 0x3806: 0x07,
                0x3807: 0x9F, 0x3808: 1296 >> 8, 0x3809: 1296 & 255, 0x380A: 972 >> 8,
                0x380B: 972 & 255, 0x380C: 0x07, 0x380D: 0x68, 0x380E: 0x03, 0x380F: 0xD8,
                0x3811: 8, 0x3813: 2, 0x3814: 0x31, 0x3815: 0x31, 0x3820: 0x01, 0x3821: 0x07,
                0x3708: 0x64, 0x370C: 0x03, 0x5001: 0}
    assert expected.items() <= last_of(plan).items()
    assert abs(plan.timing.frames_per_second - 6.70) < 0.005 and plan.bayer == "BGGR"
    skipped = last_of(prepared("ov5640", skip=2))
    assert skipped[0x3820] == 0 and skipped[0x3821] == 6 and skipped[0x3814] == 0x31


def test_mt9d111_reduced_by_hand():
    plan = prepared("mt9d111", width=642, height=482, left=158, top=118, skip=2, exposure_us=1000,
                    clock_hz=25_000_000, pixel_clock_hz=25_000_000)
    expected = {0x01: 146, 0x02: 218, 0x03: 964, 0x04: 1284, 0x05: 516, 0x20: 0x90}
    assert expected.items() <= last_of(plan).items()
    assert plan.timing.line_clocks == 642 + 516 and abs(plan.timing.frames_per_second - 43.8) < .05


LIMITS = [
    ("mt9p031", {"skip": 8}, "skip is 8 and bins 1, the mt9p031 has 1 and 1, 2 and 1, 2 and 2, 3"),
    ("mt9p031", {"skip": 4, "bins": 3}, "skip is 4 and bins 3, the mt9p031 has 1 and 1, 2 and 1"),
    ("mt9p031", {"bins": 2}, "skip is 1 and bins 2, the mt9p031 has 1 and 1, 2 and 1"),
    ("ov5640", {"skip": 4}, "skip is 4 and bins 1, the ov5640 has 1 and 1, 2 and 1, 2 and 2"),
    ("mt9d111", {"skip": 2, "bins": 2}, "the mt9d111 has 1 and 1, 2 and 1"),
    ("mt9p031", {"skip": 2, "mirror_rows": True}, "the mt9p031 mirrors unreduced frames only"),
    ("mt9p031", {"skip": 4, "width": 650}, "width is 650, the mt9p031 needs a multiple of 2 from 2 "
     "to 648"),
    ("mt9p031", {"skip": 4, "width": 648, "left": 2},
     "the window has the columns 2 to 2593, the mt9p031 has 2592"),
    ("mt9p031", {"skip": 4, "bins": 2, "top": 8},
     "top is 8, the mt9p031 bins from a multiple of 4 on: 6 or 10 fits"),
    ("mt9d111", {"skip": 2, "width": 321, "height": 240}, "width is 321, the mt9d111 needs a mult"),
    ("mt9p031", {"width": 641}, "width is 641, the mt9p031 needs a multiple of 2 from 2 to 2592"),
    ("mt9p031", {"left": 3}, "left is 3, the mt9p031 needs a multiple of 2 from 0 to 2592"),
    ("mt9p031", {"width": 640, "left": 2000},
     "the window has the columns 2000 to 2639, the mt9p031 has 2592"),
    ("mt9p031", {"exposure_us": 10}, "the exposure is 10 us, the mt9p031 exposes 31.9 to"),
    ("mt9p031", {"exposure_us": 1e9}, "the exposure is 1e+09 us, the mt9p031 exposes"),
    ("mt9p031", {"gain_db": -1}, "the gain is -1 dB, the mt9p031 has 0.0 to 42.1 dB"),
    ("mt9p031", {"gain_db": 43}, "the gain is 43 dB, the mt9p031 has 0.0 to 42.1 dB"),
    ("mt9p031", {"frames_per_second": 15},
     "15 frames per second are asked for, the mt9p031 sends 4.552 to 14.077 of 2592x1944"),
    ("mt9p031", {"gain_db": 1e9}, "the gain is 1e+09 dB"),
    ("mt9p031", {"gain_db": float("nan")}, "the gain is nan dB"),
    ("mt9p031", {"exposure_us": float("inf")}, "the exposure is inf us"),
    ("mt9p031", {"frames_per_second": float("inf")}, "inf frames per second are asked for"),
    ("mt9p031", {"frames_per_second": 1e-9}, "1e-09 frames per second are asked for"),
    ("mt9p031", {"left": -2}, "left is -2, the mt9p031 needs"),
    ("mt9p031", {"width": -2}, "width is -2, the mt9p031 needs"),
    ("mt9p031", {"clock_hz": -24_000_000}, "cannot make it of -24000000 Hz"),
    ("ov5640", {"clock_hz": -24_000_000}, "cannot make it of -24000000 Hz"),
    ("mt9p031", {"frames_per_second": -1}, "-1 frames per second are asked for"),
    ("mt9p031", {"test_pattern": "Cat"}, "the test pattern is 'Cat', the mt9p031 has Off, Color"),
    ("mt9p031", {"pixel_clock_hz": 100_000_000},
     "the pixel clock is 100000000 Hz, the mt9p031 has at most 96000000 Hz"),
    ("mt9p031", {"clock_hz": 1_000_000}, "cannot make it of 1000000 Hz"),
    ("mt9d111", {"width": 8}, "width is 8, the mt9d111 needs an integer from 17 to 1600"),
    ("mt9d111", {"test_pattern": "ColorBar"}, "the mt9d111 has Off in its raw frames"),
    ("mt9d111", {"pixel_clock_hz": 24_000_000}, "as its PLL is not used"),
    ("ov5640", {"exposure_us": 300_000}, "the exposure is 300000 us, the ov5640 exposes 59.2 to"),
    ("ov5640", {"width": 640, "height": 480, "frames_per_second": 5},
     "5 frames per second are asked for, the ov5640 sends 5.689 to 38.095 of 640x480"),
    ("ov5640", {"pixel_clock_hz": 95_000_001}, "the PLL of the ov5640 cannot make it"),
    ("ov5640", {"lane_hz": 400_000_000}, "the lanes have 400000000 bits per second, the ov5640 has "
     "a parallel port"),
    ("imx219", {"width": 642}, "width is 642, the imx219 needs a multiple of 4 from 16 to 3280"),
    ("imx219", {"skip": 2}, "skip is 2 and bins 1, the imx219 has 1 and 1, 2 and 2"),
    ("imx219", {"lane_hz": 400_000_000}, "the lanes have 400000000 Hz, the imx219 makes 456000000 "
     "to 912000000 in steps of 8000000"),
    ("imx219", {"pixel_clock_hz": 182_000_000}, "the pixel clock is 182000000 Hz, the imx219 makes "
     "182400000 to 281600000 in steps of 3200000"),
    ("imx219", {"gain_db": 45}, "the gain is 45 dB, the imx219 has 0.0 to 44.6 dB"),
    ("imx219", {"clock_hz": -24_000_000}, "of its clock of -24000000 Hz"),
    ("ov5647", {"pixel_clock_hz": 50_000_000}, "the pixel clock is 50000000 Hz, the ov5647 makes "
     "58333333 to 87500000 in steps of 833333"),
    ("ov5647", {"pixel_clock_hz": 60_000_000, "lane_hz": 299_000_000},
     "the lanes have 299000000 Hz and the pixel clock 60000000 Hz"),
    ("ov5647", {"clock_hz": -25_000_000}, "of its clock of -25000000 Hz"),
]


@pytest.mark.parametrize("name,asked,sentence", LIMITS)
def test_a_limit_is_reported(name, asked, sentence):
    with pytest.raises(InputError) as error:
        prepared(name, **asked)
    assert sentence in str(error.value)


def test_an_unknown_sensor():
    known = "'ov2640', known are mt9p031, mt9d111, ov5640, imx219, ov5647"
    with pytest.raises(InputError, match=known):
        sensor_named("ov2640")


def test_bayer_phase():
    assert [bayer_at("GRBG", left, top) for top in (0, 1) for left in (0, 1)] == [
        "GRBG", "RGGB", "BGGR", "GBRG"]
    # Some read the same pixels backwards, the others begin one further.
    small = {"width": 64, "height": 48}
    for name, expected in (("mt9p031", ["GRBG", "RGGB", "BGGR", "GBRG"]),
                           ("imx219", ["RGGB", "GRBG", "GBRG", "BGGR"]),    # both as Linux has it
                           ("ov5647", ["GBRG", "BGGR", "RGGB", "GRBG"])):
        assert [prepared(name, mirror_columns=x, mirror_rows=y, **small).bayer
                for y in (False, True) for x in (False, True)] == expected
    for name, bayer in (("mt9d111", "GRBG"), ("ov5640", "BGGR")):
        assert {prepared(name, mirror_columns=x, mirror_rows=y, **small).bayer
                for y in (False, True) for x in (False, True)} == {bayer}
    assert prepared("mt9d111", left=1, **small).bayer == "RGGB"
    assert prepared("mt9d111", width=65, height=48, mirror_columns=True).bayer == "RGGB"


@EACH
def test_columns_and_rows_stay_on_the_sensor(sensor):
    asked = {"left": 32, "top": 16, "width": 64, "height": 48}
    plain = setup(sensor, Settings(**asked))
    assert list(plain.columns) == list(range(32, 96)) and list(plain.rows) == list(range(16, 64))
    moved = int(sensor.mirror_keeps_bayer)
    mirrored = setup(sensor, Settings(mirror_columns=True, mirror_rows=True, **asked))
    assert list(mirrored.columns) == [k + moved for k in range(95, 31, -1)]
    assert list(mirrored.rows) == [k + moved for k in range(63, 15, -1)]


@EACH
def test_reduced_columns_and_rows_keep_their_colours(sensor):
    """Which pixels are read, counted one by one, and the phase that they give a frame."""
    for skip, bins in sensor.limits.reductions:
        left, top = ((8 - first) % (2 * bins) + 8 for first in sensor.first)
        plan = setup(sensor, Settings(left=left, top=top, width=20, height=16, skip=skip,
                                      bins=bins))
        for positions, begin in ((plan.columns, left), (plan.rows, top)):
            read = [begin + 2 * skip * group + column for group in range(len(positions) // 2)
                    for column in (0, 1)]
            means = [np.mean([first + 2 * k for k in range(bins)]) for first in read]
            assert list(positions) == means, (skip, bins)
        assert plan.bayer == bayer_at(sensor.bayer, left, top)


@EACH
def test_values_fit_their_registers(sensor):
    for asked in ({}, {"mirror_columns": True}, {"gain_db": 36, "exposure_us": 150_000},
                  *({"skip": skip, "bins": bins, "top": 2 * bins - sensor.first[1] % (2 * bins),
                     "left": 2 * bins - sensor.first[0] % (2 * bins)}
                    for skip, bins in sensor.limits.reductions)):
        plan = setup(sensor, Settings(**asked))
        for write in plan.writes:
            assert 0 <= write.register < 1 << sensor.pointer_bits, write
            assert 0 <= write.value < 1 << sensor.value_bits and write.meaning, write


@EACH
def test_users_write_what_no_frame_depends_on(sensor):
    """Window, mirrors, rate and clock set none of the registers that users may write."""
    first = Settings(width=640, height=480, exposure_us=1000.0)
    plain = dict(setup(sensor, first).pairs)
    free = {one.address for one in sensor.user_registers}
    for change in ({"width": 320}, {"height": 240}, {"left": 64, "top": 32},
                   {"frames_per_second": 20.0}, {"mirror_columns": True, "mirror_rows": True},
                   dict(zip(("skip", "bins"), sensor.limits.reductions[0]))):
        other = dict(setup(sensor, replace(first, **change)).pairs)
        changed = {register for register in other if other[register] != plain.get(register)}
        assert changed, change
        # The exposure counts lines, whose length follows width and skipping.
        longer = "width" in change or "skip" in change
        assert longer or not changed & free, (change, changed & free)
    for change in ({"exposure_us": 500.0}, {"gain_db": 6.0}):
        other = dict(setup(sensor, replace(first, **change)).pairs)
        changed = {register for register in other if other[register] != plain.get(register)}
        assert changed and changed <= free, (change, changed - free)
    assert not free & {register for register, _ in sensor.chip_id}
