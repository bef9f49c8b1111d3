"""The IMX219 of Sony: 8 million pixels, 10 bits, CSI-2; the Raspberry Pi camera module 2.

Sources: L, drivers/media/i2c/imx219.c of Linux (6.x): addresses, window, limits, clock tree,
gains, mirrors, test patterns, power-up; in parentheses its names. What Sony does not describe has
the values of L and is named "undocumented". C, libcamera's tuning file imx219.json of the
Raspberry Pi: black level. M, the module's own oscillator: 24 MHz, as L demands.

Less certain, to be checked with the first module: which pixels a binned sample is the mean of
(ours: those of the same colour in a square of 4, as L's windows imply); multipliers of the PLLs
between those of L; bars of the test pattern when mirrored.
"""

from fractions import Fraction

from ncdc_spec.errors import InputError
from ncdc_spec.sensors.checks import exposure_lines, factor_of, frame_lines, pattern_mode, resolved
from ncdc_spec.sensors.controls import Controls, Gain, Mirror, Part
from ncdc_spec.sensors.csi2 import DataType
from ncdc_spec.sensors.sensor import Limits, Link, Sensor, Setup, Timing, UserRegister, Write, wide
from ncdc_spec.sensors.waking import Waking

__all__ = ["SENSOR", "TEST_COLOURS", "line_of", "setup", "window"]

_MODE_SELECT = 0x0100                   # 1: streaming
_ANALOG_GAIN, _EXPOSURE = 0x0157, 0x015A
_MIRRORS = 0x0172                       # bit 0 columns, bit 1 rows
_PATTERN = 0x0600
_USUAL_LANE_HZ = 912_000_000            # 2 * IMX219_DEFAULT_LINK_FREQ
_PREDIVIDER = 3                         # of both PLLs, PREPLLCK_VT_DIV and PREPLLCK_OP_DIV
_PIXEL_MULTIPLIERS = range(57, 89)      # PLL_VT_MPY of 2 and of 4 lanes
_LANE_MULTIPLIERS = range(57, 115)      # PLL_OP_MPY is 91 and 114; PLL_VT_MPY goes down to 57
_PIXEL_DIVIDER = 5                      # VTPXCK_DIV; two pixels a clock
_BITS = 10                              # OPPXCK_DIV, CSI_DATA_FORMAT_A
_MIN_LINE = 3448                        # IMX219_LLP_MIN
_EXPOSURE_MARGIN = 4                    # lines of a frame beyond the exposure
_MAX_LINES = 0xFFFE                     # IMX219_FLL_MAX
_MAX_ANALOG = 232                       # IMX219_ANA_GAIN_MAX; the gain is 256 / (256 - word)
_DIGITAL = (0x0100, 0x0FFF)             # IMX219_DGTL_GAIN_MIN and _MAX, 256ths
_EMBEDDED_ROWS = 2                      # L, frame descriptor: two lines of embedded data

# To write 0x3000 to 0x5FFF, and what L then writes there.
_UNLOCK = ((0x30EB, 0x05), (0x30EB, 0x0C), (0x300A, 0xFF), (0x300B, 0xFF), (0x30EB, 0x05),
           (0x30EB, 0x09))
_UNDOCUMENTED = ((0x455E, 0x00), (0x471E, 0x4B), (0x4767, 0x0F), (0x4750, 0x14), (0x4540, 0x00),
                 (0x47B4, 0x14), (0x4713, 0x30), (0x478B, 0x10), (0x478F, 0x10), (0x4793, 0x10),
                 (0x4797, 0x0E), (0x479B, 0x0E))

TEST_COLOURS = {"R": (0x0602, 0x294), "Gr": (0x0604, 0x168), "B": (0x0606, 0x2A8),
                "Gb": (0x0608, 0x168)}
"""Register (TESTP_RED and so on) and value, of 10 bits, of each colour of ColorField. The values
are those of the MT9P031."""

_TEST_PATTERNS = {"ColorField": 1, "ColorBar": 2}       # SOLID_COLOR, COLOR_BARS

SENSOR = Sensor(
    name="imx219", title="Sony IMX219, Raspberry Pi camera module 2", i2c_address=0x10,
    pointer_bits=16, value_bits=8, chip_id=((0x0000, 0x02), (0x0001, 0x19)), columns=3280,
    rows=2464, bits=_BITS,
    bayer="RGGB", mirror_keeps_bayer=False,     # imx219_mbus_formats
    black=64 << 2,                              # C: 4096 of 65536
    clock_hz=24_000_000, pixel_clock_hz=182_400_000,
    # Rows of 4 samples are whole bytes in RAW10; L has windows of multiples of 4.
    limits=Limits(step=4, corner_step=2, smallest=(16, 16),
                  lines=(4, _MAX_LINES - _EXPOSURE_MARGIN),     # IMX219_EXPOSURE_MIN
                  vertical=(32, _MAX_LINES),                    # IMX219_VBLANK_MIN
                  gain_256=(256, (256 * _DIGITAL[1] + 12) // 24), pixel_clock_hz=281_600_000,
                  frame_lines=_MAX_LINES, reductions=((2, 2),)),
    test_patterns=_TEST_PATTERNS,
    # Gains, exposure, pattern.
    user_registers=(
        UserRegister(_ANALOG_GAIN, mask=0xFF, ranges=((0, _MAX_ANALOG),)),
        UserRegister(0x0158, mask=0xFF, ranges=((_DIGITAL[0] >> 8, _DIGITAL[1] >> 8),)),
        *map(UserRegister, (0x0159, _EXPOSURE, _EXPOSURE + 1)),
        UserRegister(_PATTERN, mask=0xFF, ranges=((0, 0),)),
        UserRegister(_PATTERN + 1, mask=0xFF, ranges=((0, max(_TEST_PATTERNS.values())),))),
    controls=Controls(
        exposure=(Part(_EXPOSURE, width=8, low=8), Part(_EXPOSURE + 1, width=8)),
        margin=_EXPOSURE_MARGIN, stretches=False,
        gain=Gain((Part(_ANALOG_GAIN, width=8),), 0, 256, -1, 256, _MAX_ANALOG),
        mirror_columns=Mirror((Part(_MIRRORS, 0, 1),)), mirror_rows=Mirror((Part(_MIRRORS, 1, 1),)),
        pattern=(Part(_PATTERN, width=8, low=8), Part(_PATTERN + 1, width=8)),
        patterns=_TEST_PATTERNS),
    waking=Waking(reset_us=1000, rest_us=6200, rest_clocks=0,
                  source="L, IMX219_XCLR_MIN_DELAY_US; the reset is taken for that of the OV5640"),
    lanes=2)


def setup(settings):
    """The :class:`Setup` for ``settings``; raises :class:`InputError` at a limit."""
    asked = resolved(SENSOR, settings)
    line = line_of(asked)
    lines = exposure_lines(SENSOR, asked, line, 0)
    total = frame_lines(SENSOR, asked, line, lines + _EXPOSURE_MARGIN)
    analog, digital, gain_256 = _gain(factor_of(SENSOR, asked))
    writes = (
        Write(_MODE_SELECT, 0, "standby"),
        *(Write(*pair, "access to 0x3000 to 0x5FFF") for pair in _UNLOCK),
        *_clocks(asked), *(Write(*pair, "undocumented") for pair in _UNDOCUMENTED),
        *window(asked), *_picture(asked),
        Write(_ANALOG_GAIN, analog, f"analog gain, 256 / {256 - analog}"),
        *wide(0x0158, digital, "digital gain, 256ths"),
        *wide(_EXPOSURE, lines, "exposure in lines"),
        *wide(0x0160, total, "lines of a frame"), *wide(0x0162, line, "pixels of a line"),
        Write(_MODE_SELECT, 1, "start"))
    return Setup(SENSOR, asked, writes,
                 Timing(asked.width, asked.height, line, total, asked.pixel_clock_hz),
                 lines * line, gain_256, _link(asked))


def line_of(asked):
    """Pixel clocks of a line for :class:`Settings`."""
    # A row that takes longer makes the lines longer. Capture evens reduced ones sample by sample.
    row = _link(asked).row_seconds(asked.width, serial=asked.skip > 1)
    return max(_MIN_LINE, 2 * round(asked.pixel_clock_hz * row / 2))


def _link(asked):
    return Link(SENSOR.lanes, asked.lane_hz or _USUAL_LANE_HZ, DataType.RAW10, _EMBEDDED_ROWS)


def _gain(factor):
    """Words of the analog and of the digital gain nearest to ``factor``, and their gain, of which
    256 is 1: the analog one first, which adds less noise."""
    analog = min(_MAX_ANALOG, round(256 - 256 / factor))
    digital = _DIGITAL[0]
    if analog == _MAX_ANALOG:
        digital = min(_DIGITAL[1], max(_DIGITAL[0], round(factor * (256 - analog))))
    return analog, digital, (256 * digital + (256 - analog) // 2) // (256 - analog)


def window(asked):
    """Writes of the window, binning and format that :class:`Settings` ask for."""
    right, bottom = (begin + asked.skip * size - 1 for begin, size in (
        (asked.left, asked.width), (asked.top, asked.height)))
    bins = int(asked.bins > 1)
    return [write for register, value, meaning in (
        (0x0164, asked.left, "first column"), (0x0166, right, "last column"),
        (0x0168, asked.top, "first row"), (0x016A, bottom, "last row"),
        (0x016C, asked.width, "columns sent"), (0x016E, asked.height, "rows sent"),
        (0x018C, _BITS << 8 | _BITS, "RAW10")) for write in wide(register, value, meaning)] + [
        Write(0x0170, 1, "every column"), Write(0x0171, 1, "every row"),
        Write(0x0174, bins, "columns binned by 2: 1"), Write(0x0175, bins, "rows binned by 2: 1")]


def _picture(asked):
    """Mirrors, and the test pattern in a window of the frame's size: users may choose one later."""
    mirrors = asked.mirror_columns | asked.mirror_rows << 1
    return [Write(_MIRRORS, mirrors, "mirrored: bit 0 columns, bit 1 rows")] + [
        part for write in (
            (_PATTERN, pattern_mode(SENSOR, asked) or 0, "test pattern"),
            (0x0624, asked.width, "test pattern's columns"),
            (0x0626, asked.height, "test pattern's rows"),
            *((*pair, f"test pattern's {colour}") for colour, pair in TEST_COLOURS.items()))
        for part in wide(*write)]


def _clocks(asked):
    """Writes that make pixel clock and lane rate of the external clock: external / 3 * multiplier
    is the lane rate, or five halves of the pixel clock."""
    pixel = _multiplier("the pixel clock is", Fraction(_PIXEL_DIVIDER, 2) * asked.pixel_clock_hz,
                        asked, _PIXEL_MULTIPLIERS, Fraction(2, _PIXEL_DIVIDER))
    lane = _multiplier("the lanes have", _link(asked).lane_hz, asked, _LANE_MULTIPLIERS, 1)
    megahertz = round(256 * Fraction(asked.clock_hz, 10**6))
    return [
        Write(0x0114, SENSOR.lanes - 1, "lanes less one"), Write(0x0128, 0, "D-PHY timing: auto"),
        *wide(0x012A, megahertz, "external clock in 256ths of a MHz"),
        Write(0x0301, _PIXEL_DIVIDER, "pixel clock: two pixels of PLL / 5"),
        Write(0x0303, 1, "pixel clock: PLL / 1"),
        Write(0x0304, _PREDIVIDER, "PLL of the pixels / 3"),
        Write(0x0305, _PREDIVIDER, "PLL of the lanes / 3"),
        *wide(0x0306, pixel, f"PLL of the pixels * {pixel}"),
        Write(0x0309, _BITS, "bits of a sample"), Write(0x030B, 1, "lane rate: PLL / 1"),
        *wide(0x030C, lane, f"PLL of the lanes * {lane}")]


def _multiplier(what, wanted, asked, known, scale):
    """The multiplier of a PLL that makes ``wanted`` of the external clock; InputError if none of
    ``known`` does. ``scale`` is the rate that is named in the message, of that of the PLL."""
    multiplier = Fraction(wanted * _PREDIVIDER, asked.clock_hz)
    if multiplier not in known:
        low, high = (float(scale * asked.clock_hz * end / _PREDIVIDER)
                     for end in (known[0], known[-1]))
        step = float(Fraction(asked.clock_hz, _PREDIVIDER) * scale)
        raise InputError(f"{what} {float(scale * wanted):.0f} Hz, the {SENSOR.name} makes "
                         f"{low:.0f} to {high:.0f} in steps of {step:.0f} of its clock of "
                         f"{asked.clock_hz} Hz")
    return int(multiplier)
