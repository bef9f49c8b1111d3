"""The MT9P031 of Aptina, now onsemi: 5 million pixels, 12 bits; on the Terasic D5M.

Sources: DS, the data sheet MT9P031/D of onsemi (Rev. 10, 2017; tables and sections by their names);
L, drivers/media/i2c/mt9p031.c of Linux, for limits, PLL and the order of gain stages. Line and
frame times agree with those that PixeLINK publishes for its PL-D775, which has this sensor, those
with skipping and binning with DS, frame rates at common resolutions.
T, drivers/media/i2c/mt9t031.c of Linux, of a sensor of the same family, says that a window that is
binned must begin at a multiple of the group.
"""

from fractions import Fraction

from ncdc_spec.errors import InputError
from ncdc_spec.sensors.checks import exposure_lines, factor_of, frame_lines, pattern_mode, resolved
from ncdc_spec.sensors.controls import Controls, Gain, Mirror, Part
from ncdc_spec.sensors.sensor import Limits, Sensor, Setup, Timing, UserRegister, Write
from ncdc_spec.sensors.waking import Waking

__all__ = ["CHIP_VERSION", "CHIP_VERSION_VALUE", "COLOUR_GAINS", "COLUMN_MODE", "COLUMN_SIZE",
           "COLUMN_START", "FIRST_COLUMN", "FIRST_ROW", "GLOBAL_GAIN", "READ_MODE_2", "ROW_MODE",
           "ROW_SIZE", "ROW_START", "SENSOR", "SHUTTER_LOWER", "SHUTTER_UPPER", "TEST_COLOURS",
           "TEST_PATTERN", "TEST_PATTERN_MODES", "line_clocks", "line_of", "setup", "window"]

# DS, register list and register description.
CHIP_VERSION = 0x00
CHIP_VERSION_VALUE = 0x1801
ROW_START = 0x01
COLUMN_START = 0x02
ROW_SIZE = 0x03             # rows of the window less one
COLUMN_SIZE = 0x04          # columns of the window less one
SHUTTER_UPPER = 0x08        # exposure in lines, bits 19..16
SHUTTER_LOWER = 0x09        # and bits 15..0
READ_MODE_2 = 0x20
_MIRROR_ROW = 15            # bit of READ_MODE_2: the picture upside down
_MIRROR_COLUMN = 14         # bit of READ_MODE_2: the picture left to right
COLOUR_GAINS = (0x2B, 0x2C, 0x2D, 0x2E)     # green of red rows, blue, red, green of blue rows
GLOBAL_GAIN = 0x35
_ANALOG_GAIN = (0, 6)       # lowest bit and width of the analog gain in GLOBAL_GAIN, eighths
TEST_PATTERN = 0xA0         # bit 0 on, bits 6..3 which

_HORIZONTAL_BLANK = 0x05    # pairs of columns less one
_VERTICAL_BLANK = 0x06      # lines less one
_OUTPUT_CONTROL = 0x07
_STOPPED, _RUNNING = 0x1F80, 0x1F82     # bit 1: chip enable; the rest as after reset
ROW_MODE, COLUMN_MODE = 0x22, 0x23    # bits 5..4: bins less one; bits 2..0: skip less one
_PIXEL_CLOCK_CONTROL = 0x0A
_INVERT_PIXEL_CLOCK = 0x8000            # pins change as the clock falls: capture looks as it rises
_RESTART = 0x0B
_RESET = 0x0D
_PLL_CONTROL, _PLL_CONFIG_1, _PLL_CONFIG_2 = 0x10, 0x11, 0x12
_ROW_BLACK = 6                          # bit of READ_MODE_2: black level of each row
_ROW_BLACK_OFFSET = 0x4B
TEST_COLOURS = {"G": (0xA1, 0x5A0), "R": (0xA2, 0xA50), "B": (0xA3, 0xAA0)}
"""Register and value of each colour of the test pattern ColorField; values: L."""

_BAR_WIDTH = 0xA4                       # of the bars of test patterns

TEST_PATTERN_MODES = {"ColorField": 0, "GreyHorizontalRamp": 1, "GreyVerticalRamp": 2,
                      "GreyDiagonalRamp": 3, "WalkingOnes": 5, "HorizontalBars": 6,
                      "VerticalBars": 7, "ColorBar": 8}
"""Bits 6..3 of TEST_PATTERN; DS, test patterns. Mode 4, the classic pattern, is not offered."""


def pattern_word(name):
    """TEST_PATTERN for the test pattern of that name."""
    return TEST_PATTERN_MODES[name] << 3 | 1


# Those that users of a network choose from.
_USER_PATTERNS = {name: pattern_word(name) for name in (
    "GreyHorizontalRamp", "GreyVerticalRamp", "GreyDiagonalRamp", "HorizontalBars", "VerticalBars",
    "ColorBar")}

FIRST_ROW, FIRST_COLUMN = 54, 16    # of the active pixels; DS, pixel array structure
_ROW_OVERHEAD = 346                 # pairs of columns, for each row read; DS, frame time
_DARK_COLUMNS = {1: 80, 2: 40, 4: 20}       # read before a row, by bins; DS, table 7
_PLL_CLOCKS = (6_000_000, 27_000_000)           # external clock; this one and what follows: L
_PLL_INPUT = (2_000_000, 13_500_000)            # external clock / N
_PLL_OSCILLATOR = (180_000_000, 360_000_000)    # external clock * M / N
_PLL_M, _PLL_N, _PLL_P = range(16, 256), range(1, 65), range(1, 129)

SENSOR = Sensor(
    name="mt9p031", title="onsemi MT9P031, Terasic D5M", i2c_address=0x5D, pointer_bits=8,
    value_bits=16, chip_id=((CHIP_VERSION, CHIP_VERSION_VALUE),), columns=2592, rows=1944, bits=12,
    # DS: without mirrors the first row is green and red; mirrored it is row 1997, an odd one.
    bayer="GRBG", mirror_keeps_bayer=False,
    black=168,                      # DS, row black target, R0x49 after reset
    clock_hz=24_000_000, pixel_clock_hz=96_000_000,
    limits=Limits(step=2, corner_step=2,        # DS, window control
                  smallest=(2, 2), lines=(1, (1 << 20) - 1), vertical=(9, 4096),
                  gain_256=(256, 128 * 256), pixel_clock_hz=96_000_000, frame_lines=1944 + 4096,
                  # DS: Column_Skip is up to 6, Column_Bin 0, 1 or 3 and at most as much.
                  reductions=tuple((skip, bins) for skip in range(2, 8) for bins in (1, 2, 4)
                                   if bins <= skip)),
    test_patterns=TEST_PATTERN_MODES,
    user_registers=(
        UserRegister(SHUTTER_UPPER, ranges=((0, 15),)), UserRegister(SHUTTER_LOWER),
        *map(UserRegister, COLOUR_GAINS),
        # Less than 1 would leave what is white grey.
        UserRegister(GLOBAL_GAIN, mask=63, ranges=((8, 63),)),
        UserRegister(TEST_PATTERN, ranges=((0, 0), *(
            (word, word) for word in _USER_PATTERNS.values()))),
        *(UserRegister(address) for address, _ in TEST_COLOURS.values()),
        UserRegister(_BAR_WIDTH)),
    controls=Controls(
        exposure=(Part(SHUTTER_UPPER, width=4, low=16), Part(SHUTTER_LOWER)), margin=1,
        stretches=True, gain=Gain((Part(GLOBAL_GAIN, *_ANALOG_GAIN),), 1, 0, 0, 8, 63),
        mirror_columns=Mirror((Part(READ_MODE_2, _MIRROR_COLUMN, 1),)),
        mirror_rows=Mirror((Part(READ_MODE_2, _MIRROR_ROW, 1),)),
        pattern=(Part(TEST_PATTERN),), patterns=_USER_PATTERNS),
    first=(FIRST_COLUMN, FIRST_ROW),
    waking=Waking(reset_us=1000, rest_us=0, rest_clocks=850_000,
                  source="Linux, drivers/media/i2c/mt9p031.c, mt9p031_power_on"))


def _blanking(bins):
    """The least horizontal blanking, in pairs of columns; DS, frame time, and L."""
    return _ROW_OVERHEAD * bins + 64 + _DARK_COLUMNS[bins] // 2


def line_clocks(columns, bins=1):
    """Pixel clocks of a line of ``columns`` samples, at the least blanking; DS: row time."""
    return 2 * max(columns // 2 + _blanking(bins), 41 + _ROW_OVERHEAD * bins + 99)


def _overhead(bins):
    """Pixel clocks of a line that are not exposed, without shutter delay; DS, exposure."""
    return 2 * (208 * bins + 98 + 1 - 94)


def setup(settings):
    """The :class:`Setup` for ``settings``; raises :class:`InputError` at a limit."""
    asked = resolved(SENSOR, settings)
    line, overhead = line_of(asked), _overhead(asked.bins)
    lines = exposure_lines(SENSOR, asked, line, overhead)
    total = frame_lines(SENSOR, asked, line, lines + 1)
    gain, gain_256 = _gain(factor_of(SENSOR, asked))
    writes = (
        Write(_RESET, 1, "reset"), Write(_RESET, 0, "out of reset"),
        Write(_OUTPUT_CONTROL, _STOPPED, "stop"),
        Write(_PIXEL_CLOCK_CONTROL, _INVERT_PIXEL_CLOCK, "pins change as the pixel clock falls"),
        *_clock(asked),
        *window(asked),
        Write(_HORIZONTAL_BLANK, _blanking(asked.bins) - 1, "horizontal blanking: the least"),
        # A longer exposure makes the frame longer by itself.
        Write(_VERTICAL_BLANK, min(total - asked.height, SENSOR.limits.vertical[1]) - 1,
              "vertical blanking, lines less one"),
        Write(SHUTTER_UPPER, lines >> 16, "exposure in lines, upper bits"),
        Write(SHUTTER_LOWER, lines & 0xFFFF, "exposure in lines"),
        Write(GLOBAL_GAIN, gain, "gain"),
        *_picture(asked),
        Write(_RESTART, 1, "begin anew with these"), Write(_OUTPUT_CONTROL, _RUNNING, "start"))
    return Setup(SENSOR, asked, writes,
                 Timing(asked.width, asked.height, line, total, asked.pixel_clock_hz),
                 lines * line - overhead, gain_256)


def line_of(asked):
    """Pixel clocks of a line for :class:`Settings`."""
    return line_clocks(asked.width, asked.bins)


def window(asked):
    """Writes of the window, skipping and binning that :class:`Settings` ask for."""
    return [Write(COLUMN_START, FIRST_COLUMN + asked.left, "first column"),
            Write(ROW_START, FIRST_ROW + asked.top, "first row"),
            Write(COLUMN_SIZE, asked.skip * asked.width - 1, "columns less one"),
            Write(ROW_SIZE, asked.skip * asked.height - 1, "rows less one"), *_reduction(asked)]


def _reduction(asked):
    """Skipping and binning; nothing where all pixels are read, as after reset."""
    if asked.skip == 1:
        return []
    mode = asked.bins - 1 << 4 | asked.skip - 1
    meaning = f"of {2 * asked.skip} {{}} two are sent"
    if asked.bins > 1:
        meaning += f", each the mean of {asked.bins}"
    return [Write(ROW_MODE, mode, meaning.format("rows")),
            Write(COLUMN_MODE, mode, meaning.format("columns"))]


def _gain(factor):
    """GLOBAL_GAIN nearest to ``factor``, and its gain, of which 256 is 1.

    The analog gain goes to 4 in eighths, doubled to 8 by bit 6; then the digital one, bits 14..8,
    adds to it in ones: L says that this order adds least noise.
    """
    eighths = round(8 * factor)
    if eighths <= 32:
        return eighths, 32 * eighths
    if eighths <= 64:
        half = round(4 * factor)
        return 1 << 6 | half, 64 * half
    whole = round(factor)
    return whole - 8 << 8 | 1 << 6 | 32, 256 * whole


def _picture(asked):
    """Mirrors and test pattern; with one the correction of black is off, as L says."""
    mode = pattern_mode(SENSOR, asked)
    word = (asked.mirror_rows << _MIRROR_ROW | asked.mirror_columns << _MIRROR_COLUMN
            | (mode is None) << _ROW_BLACK)
    writes = [Write(READ_MODE_2, word, "mirrors; black level of rows")]
    if mode is not None:
        writes += [Write(register, value, f"test pattern's {colour}")
                   for colour, (register, value) in TEST_COLOURS.items()]
        writes += [Write(_ROW_BLACK_OFFSET, 0, "no offset on a test pattern"),
                   Write(TEST_PATTERN, pattern_word(asked.test_pattern), "test pattern")]
    return writes


def _clock(asked):
    """Writes that make the pixel clock of the external one: none if they are alike."""
    external, pixel = asked.clock_hz, asked.pixel_clock_hz
    if external == pixel:
        return []
    for n in _PLL_N:
        if not _PLL_INPUT[0] <= Fraction(external, n) <= _PLL_INPUT[1]:
            continue
        for p in _PLL_P:
            m, rest = divmod(pixel * n * p, external)
            if (not rest and m in _PLL_M and _PLL_CLOCKS[0] <= external <= _PLL_CLOCKS[1]
                    and _PLL_OSCILLATOR[0] <= pixel * p <= _PLL_OSCILLATOR[1]):
                return [Write(_PLL_CONTROL, 0x51, "PLL on"),
                        Write(_PLL_CONFIG_1, m << 8 | n - 1, f"M = {m}, N = {n}"),
                        Write(_PLL_CONFIG_2, p - 1, f"P = {p}", 1000),
                        Write(_PLL_CONTROL, 0x53, "pixel clock from the PLL")]
    raise InputError(f"the pixel clock is {pixel} Hz, the PLL of the {SENSOR.name} cannot make it "
                     f"of {external} Hz")
