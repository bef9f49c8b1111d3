"""The OV5647 of OmniVision: 5 million pixels, 10 bits, CSI-2; the Raspberry Pi camera module 1.

Sources: L, drivers/media/i2c/ov5647.c of Linux (6.x): addresses, windows, line lengths, clocks,
exposure, gain, mirrors, test patterns, power-up. What OmniVision does not describe is written with
the values of L and named "analog". Registers of the automatic exposure and of the white balance,
which are switched off, are left out. C, libcamera's tuning file ov5647.json: black level.
M, the module's own oscillator: 25 MHz, as L demands.

Less certain, to be checked with the first module: margins of a binned window (L's begins 8 columns
and 6 rows further; ours, 16 and 4, keep the colours of the whole array), and from which side of the
picture the window's columns count, as the sensor's own picture is mirrored.
"""

from dataclasses import replace
from fractions import Fraction

from ncdc_spec.errors import InputError
from ncdc_spec.sensors.checks import exposure_lines, factor_of, frame_lines, pattern_mode, resolved
from ncdc_spec.sensors.controls import Controls, Gain, Mirror, Part
from ncdc_spec.sensors.csi2 import DataType
from ncdc_spec.sensors.sensor import Limits, Link, Sensor, Setup, Timing, UserRegister, Write, wide
from ncdc_spec.sensors.waking import Waking

__all__ = ["SENSOR", "line_of", "setup", "window"]

_STREAM, _RESET, _LANES_CONTROL = 0x0100, 0x0103, 0x4800
_EXPOSURE = 0x3500                      # three registers: sixteenths of lines, bits 19..0
_GAIN = 0x350A                          # two registers: sixteenths, bits 9..0
_ROWS_MODE, _COLUMNS_MODE = 0x3820, 0x3821
_PATTERN = 0x503D
_FIRST_COLUMN, _FIRST_ROW = 16, 6       # of the active pixels, in what is read
_MARGINS = {1: (16, 6), 2: (8, 2)}      # samples sent too few at each side, by skip
_LONG_LINE, _LINE, _BINNED_LINE = 2844, 2416, 1896      # 2592, 1920 columns, 1296 binned ones
_LINE_COLUMNS = 1920                    # the most of the shorter line
_EXPOSURE_MARGIN = 4                    # lines of a frame beyond the exposure
_MAX_LINES = 32767                      # OV5647_VTS_MAX
_PREDIVIDER = 3                         # after reset; the oscillator is then at 583 and 875 MHz
_LANE_DIVIDER = 2                       # 0x3035, bits 7..4
_LANE_CLOCKS = 5                        # bits of a lane per sample: ten on two lanes
_MULTIPLIERS = range(70, 106)           # 0x3036 is 70 in VGA mode, 105 in the others
_MIRROR, _BIN = 0b10, 0b01              # bits of both modes
_BIN_ROWS = 0x41                        # of _ROWS_MODE, in binned modes
_INCREMENTS = {1: 0x11, 2: 0x31}        # of even pixels, upper four bits, and of odd ones; by skip

_ANALOG = ((0x303C, 0x11), (0x3106, 0xF5), (0x3827, 0xEC), (0x370C, 0x03), (0x5002, 0x41),
           (0x5003, 0x08), (0x5A00, 0x08), (0x3016, 0x08), (0x3017, 0xE0), (0x301C, 0xF8),
           (0x301D, 0xF0), (0x3C01, 0x80), (0x3B07, 0x0C), (0x3630, 0x2E), (0x3632, 0xE2),
           (0x3633, 0x23), (0x3634, 0x44), (0x3636, 0x06), (0x3620, 0x64), (0x3621, 0xE0),
           (0x3600, 0x37), (0x3704, 0xA0), (0x3703, 0x5A), (0x3715, 0x78), (0x3717, 0x01),
           (0x3731, 0x02), (0x370B, 0x60), (0x3705, 0x1A), (0x3F05, 0x02), (0x3F06, 0x10),
           (0x3F01, 0x0A), (0x4001, 0x02), (0x4000, 0x09), (0x4004, 0x04))
# Modes of all pixels, and of 1296x972; by skip.
_ANALOG_OF = {1: ((0x3612, 0x5B), (0x3618, 0x04), (0x3708, 0x64), (0x3709, 0x12), (0x4837, 0x19)),
              2: ((0x3612, 0x59), (0x3618, 0x00), (0x4837, 0x16))}

_TEST_PATTERNS = {"ColorBar": 0x80}

SENSOR = Sensor(
    name="ov5647", title="OmniVision OV5647, Raspberry Pi camera module 1", i2c_address=0x36,
    pointer_bits=16, value_bits=8, chip_id=((0x300A, 0x56), (0x300B, 0x47)), columns=2592,
    rows=1944, bits=10,
    # ov5647_get_mbus_code, without mirrors, and with each of them.
    bayer="GBRG", mirror_keeps_bayer=False,
    black=16 << 2,                      # C: 1024 of 65536
    clock_hz=25_000_000, pixel_clock_hz=87_500_000,
    limits=Limits(step=4, corner_step=2, smallest=(16, 16),
                  lines=(4, _MAX_LINES - _EXPOSURE_MARGIN),     # OV5647_EXPOSURE_MIN
                  vertical=(24, _MAX_LINES),                    # OV5647_VBLANK_MIN
                  gain_256=(256, 1023 * 16), pixel_clock_hz=87_500_000, frame_lines=_MAX_LINES,
                  reductions=((2, 2),)),
    test_patterns=_TEST_PATTERNS,
    # Exposure, gain, pattern.
    user_registers=tuple(map(UserRegister, (
        _EXPOSURE, _EXPOSURE + 1, _EXPOSURE + 2, _GAIN, _GAIN + 1, _PATTERN))),
    controls=Controls(
        exposure=(Part(_EXPOSURE, width=4, low=12), Part(_EXPOSURE + 1, width=8, low=4),
                  Part(_EXPOSURE + 2, shift=4, width=4)),
        margin=_EXPOSURE_MARGIN, stretches=False,
        gain=Gain((Part(_GAIN, width=2, low=8), Part(_GAIN + 1, width=8)), 1, 0, 0, 16, 1023),
        # The sensor mirrors by itself: with the bit set, the picture is not mirrored.
        mirror_columns=Mirror((Part(_COLUMNS_MODE, 1, 1),), plain=1, mirrored=0),
        mirror_rows=Mirror((Part(_ROWS_MODE, 1, 1),)),
        pattern=(Part(_PATTERN, width=8),), patterns=_TEST_PATTERNS),
    waking=Waking(reset_us=1000, rest_us=20_000, rest_clocks=0,
                  source="L, PWDN_ACTIVE_DELAY_MS; the reset is taken for that of the OV5640"),
    lanes=2)


def setup(settings):
    """The :class:`Setup` for ``settings``; raises :class:`InputError` at a limit."""
    if settings.lane_hz and not settings.pixel_clock_hz:
        settings = replace(settings, pixel_clock_hz=settings.lane_hz // _LANE_CLOCKS)
    asked = resolved(SENSOR, settings)
    clocks = _clocks(asked)
    line = line_of(asked)
    lines = exposure_lines(SENSOR, asked, line, 0)
    total = frame_lines(SENSOR, asked, line, lines + _EXPOSURE_MARGIN)
    gain = round(16 * factor_of(SENSOR, asked))
    binned = asked.bins > 1
    writes = (
        Write(_STREAM, 0, "standby"), Write(_RESET, 1, "reset", 5000),
        *clocks, Write(0x3018, 0x44, "two lanes"),
        *(Write(*pair, "analog") for pair in (*_ANALOG, *_ANALOG_OF[asked.skip])),
        Write(0x3000, 0x00, "pins are inputs"), Write(0x3001, 0x00, "pins are inputs"),
        Write(0x3002, 0x00, "pins are inputs"),
        *window(asked),
        *wide(0x380C, line, "clocks of a line"), *wide(0x380E, total, "lines of a frame"),
        Write(_COLUMNS_MODE, binned * _BIN | (0 if asked.mirror_columns else _MIRROR),
              "columns mirrored: bit 1 clear; bit 0: binned"),
        Write(_ROWS_MODE, binned * _BIN_ROWS | asked.mirror_rows * _MIRROR,
              "rows mirrored: bit 1 set; bits 6, 0: binned"),
        Write(0x3503, 0b11, "exposure and gain by hand"),
        Write(_EXPOSURE, lines >> 12, "exposure, sixteenths of lines"),
        Write(_EXPOSURE + 1, lines >> 4 & 0xFF, "exposure"),
        Write(_EXPOSURE + 2, lines << 4 & 0xFF, "exposure"),
        *wide(_GAIN, gain, "gain, sixteenths"),
        Write(0x5000, 0x06, "no lens correction; defects are corrected"),
        Write(0x5001, 0x00, "no white balance"),
        Write(_PATTERN, pattern_mode(SENSOR, asked) or 0, "test pattern"),
        Write(0x4202, 0x00, "all frames are sent"), Write(0x300D, 0x00, "lanes are driven"),
        Write(_LANES_CONTROL, 0x04, "the clock of the lanes always runs"),
        Write(_STREAM, 1, "start"))
    return Setup(SENSOR, asked, writes,
                 Timing(asked.width, asked.height, line, total, asked.pixel_clock_hz),
                 lines * line, 16 * gain, _link(asked))


def _link(asked):
    return Link(SENSOR.lanes, _LANE_CLOCKS * asked.pixel_clock_hz, DataType.RAW10)


def line_of(asked):
    """Pixel clocks of a line for :class:`Settings`."""
    if asked.skip > 1:
        # Capture evens reduced rows sample by sample: they may take longer.
        row = _link(asked).row_seconds(asked.width, serial=True)
        return max(_BINNED_LINE, 2 * round(asked.pixel_clock_hz * row / 2))
    return _LINE if asked.width <= _LINE_COLUMNS else _LONG_LINE


def window(asked):
    """Writes of the window and of skipping that :class:`Settings` ask for."""
    skip, ranges = asked.skip, []
    for begin, size, first, margin in zip(
            (asked.left, asked.top), (asked.width, asked.height), (_FIRST_COLUMN, _FIRST_ROW),
            _MARGINS[skip]):
        begin += first - skip * margin
        ranges.append((begin, begin + skip * (size + 2 * margin) - 1))
    (left, right), (top, bottom) = ranges
    which = "every" if skip == 1 else "every other pair of"
    return [write for register, value, meaning in (
        (0x3800, left, "first column"), (0x3802, top, "first row"),
        (0x3804, right, "last column"), (0x3806, bottom, "last row"),
        (0x3808, asked.width, "columns sent"), (0x380A, asked.height, "rows sent"),
        (0x3810, _MARGINS[skip][0], "margin, samples"),
        (0x3812, _MARGINS[skip][1], "margin, samples"))
        for write in wide(register, value, meaning)] + [
        Write(0x3814, _INCREMENTS[skip], f"{which} column" + "s" * (skip > 1)),
        Write(0x3815, _INCREMENTS[skip], f"{which} row" + "s" * (skip > 1))]


def _clocks(asked):
    """PLL: lane rate = external clock / 3 * multiplier / 2, of which the pixel clock is a fifth."""
    scale = Fraction(asked.clock_hz, _PREDIVIDER * _LANE_DIVIDER * _LANE_CLOCKS)
    multiplier = asked.pixel_clock_hz / scale if scale else 0
    if asked.lane_hz not in (0, _LANE_CLOCKS * asked.pixel_clock_hz):
        raise InputError(f"the lanes have {asked.lane_hz} Hz and the pixel clock "
                         f"{asked.pixel_clock_hz} Hz, that of the {SENSOR.name} is a fifth of the "
                         "lanes'")
    if multiplier not in _MULTIPLIERS:
        low, high = (float(scale * end) for end in (_MULTIPLIERS[0], _MULTIPLIERS[-1]))
        raise InputError(f"the pixel clock is {asked.pixel_clock_hz} Hz, the {SENSOR.name} makes "
                         f"{low:.0f} to {high:.0f} in steps of {float(scale):.0f} of its clock of "
                         f"{asked.clock_hz} Hz")
    return (Write(0x3034, 0x1A, "10 bits"),
            Write(0x3035, _LANE_DIVIDER << 4 | 1, f"PLL / {_LANE_DIVIDER}"),
            Write(0x3036, int(multiplier), f"PLL * {multiplier}", 1000))
