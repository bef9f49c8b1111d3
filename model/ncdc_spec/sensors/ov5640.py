"""The OV5640 of OmniVision: 5 million pixels, 10 bits; on most camera modules in today's shops.

Chosen as the third sensor because a module costs little and is sold for nearly every FPGA kit,
with a parallel port of 8 or 10 bits; the AR0135 has more documented registers and a global shutter,
but few sell it. Raw Bayer frames are read without scaling, so that its own processor, which would
change colours and edges, is not used. It is not documented whether the scaler works on raw frames.
So it reduces by 2 only.

Sources: L, drivers/media/i2c/ov5640.c of Linux: register names, window margins, line lengths, clock
tree, exposure, gain, mirrors, test patterns. DS, the data sheet OV5640 (2011), names of registers.
What OmniVision does not describe is written with the values of L and named "analog". The formula
of the clocks gives the 30 frames per second of OmniVision's VGA mode (24 MHz, 0x3036 = 70,
1896 clocks by 984 lines), a mode that reads every other pair, binned: from it are line, blanking,
increments and analog registers of reduced frames. Less certain: its margins are 16 and 6 samples,
which leave 98.8 % of the columns; ours are half of those of the whole array. The Bayer phase of
binned frames is to be looked at with the first board.
"""

from fractions import Fraction

from ncdc_spec.errors import InputError
from ncdc_spec.sensors.checks import exposure_lines, factor_of, frame_lines, pattern_mode, resolved
from ncdc_spec.sensors.sensor import Limits, Sensor, Setup, Timing, UserRegister, Write, wide
from ncdc_spec.sensors.waking import Waking

__all__ = ["SENSOR", "setup"]

_SYSTEM, _SYSTEM_RESET, _SYSTEM_OFF, _SYSTEM_ON = 0x3008, 0x82, 0x42, 0x02
_MARGIN_LEFT, _MARGIN_TOP = 16, 4       # of the window inside what is read; L, every full mode
_LONG_LINE, _LINE = 2844, 2500          # halves of a line's pixel clocks; L, 2592 and 1920 columns
_LINE_COLUMNS = 1920                    # the most of the shorter line
_REDUCED_LINE = 1896                    # L, of all modes that read every other pair
_MIN_VERTICAL = {1: 24, 2: 12}          # lines, by skip; L
_MAX_LINES = 3375                       # of a frame; L
_EXPOSURE_MARGIN = 4                    # lines of a frame beyond the exposure; L
_PREDIVIDER = 3                         # L: as vendors have it
_OSCILLATOR = (500_000_000, 1_000_000_000)      # L
_MIRROR = 0b110                         # L: bit 2 of the processor, bit 1 of the sensor
_BIN = 0b001                            # L: in both registers of the mirrors
_INCREMENTS = {1: 0x11, 2: 0x31}        # of even pixels, upper four bits, and of odd ones; by skip

# L, start of its initial settings.
_ANALOG = ((0x3630, 0x36), (0x3631, 0x0E), (0x3632, 0xE2), (0x3633, 0x12), (0x3621, 0xE0),
           (0x3704, 0xA0), (0x3703, 0x5A), (0x3715, 0x78), (0x3717, 0x01), (0x370B, 0x60),
           (0x3705, 0x1A), (0x3905, 0x02), (0x3906, 0x10), (0x3901, 0x0A), (0x3731, 0x12),
           (0x3600, 0x08), (0x3601, 0x33), (0x302D, 0x60), (0x3620, 0x52), (0x371B, 0x20),
           (0x471C, 0x50), (0x3635, 0x13), (0x3636, 0x03), (0x3634, 0x40), (0x3622, 0x01))
# L, of its mode of all pixels, and of its VGA mode; by skip.
_ANALOG_OF = {
    1: ((0x3618, 0x04), (0x3612, 0x29), (0x3708, 0x21), (0x3709, 0x12), (0x370C, 0x00)),
    2: ((0x3618, 0x00), (0x3612, 0x29), (0x3708, 0x64), (0x3709, 0x52), (0x370C, 0x03))}

SENSOR = Sensor(
    name="ov5640", title="OmniVision OV5640, most camera modules", i2c_address=0x3C,
    pointer_bits=16, value_bits=8, chip_id=((0x300A, 0x56), (0x300B, 0x40)), columns=2592,
    rows=1944, bits=10,
    # L: its raw format for 0x4300 = 0, which it keeps with every mirror.
    bayer="BGGR", mirror_keeps_bayer=True,
    black=16 << 2,                      # DS, black level target 0x4009 after reset: 16 of 1023
    clock_hz=24_000_000, pixel_clock_hz=96_000_000,
    limits=Limits(step=2, corner_step=2, smallest=(16, 16),
                  lines=(1, _MAX_LINES - _EXPOSURE_MARGIN),
                  vertical=(min(_MIN_VERTICAL.values()), _MAX_LINES),
                  gain_256=(256, 1023 * 16), pixel_clock_hz=96_000_000, frame_lines=_MAX_LINES,
                  reductions=((2, 1), (2, 2))),
    # L, 0x503D: bit 7 on, bits 3..2 kind of bars, bits 1..0 bars or squares.
    test_patterns={"ColorBar": 0x80},
    # Exposure, gain, pattern.
    user_registers=tuple(map(UserRegister, (0x3500, 0x3501, 0x3502, 0x350A, 0x350B, 0x503D))),
    waking=Waking(reset_us=1000, rest_us=20_000, rest_clocks=0,
                  source="DS, section 2.7, power up sequence, t3 and t4, as L repeats them"))


def setup(settings):
    """The :class:`Setup` for ``settings``; raises :class:`InputError` at a limit."""
    asked = resolved(SENSOR, settings)
    half_line = _half_line(asked)
    line = 2 * half_line
    lines = exposure_lines(SENSOR, asked, line, 0)
    total = frame_lines(SENSOR, asked, line, max(lines + _EXPOSURE_MARGIN,
                                                 asked.height + _MIN_VERTICAL[asked.skip]))
    gain = round(16 * factor_of(SENSOR, asked))
    mode = pattern_mode(SENSOR, asked)
    bins = _BIN if asked.bins > 1 else 0
    writes = (
        Write(0x3103, 0x11, "clock from the pad"),
        Write(_SYSTEM, _SYSTEM_RESET, "reset", 5000), Write(_SYSTEM, _SYSTEM_OFF, "standby"),
        Write(0x3103, 0x03, "clock from the PLL"),
        Write(0x300E, 0x18, "parallel port, no MIPI"),
        Write(0x3017, 0x7F, "pins are outputs"), Write(0x3018, 0xFC, "pins are outputs"),
        Write(0x3000, 0x00, "out of reset"), Write(0x3002, 0x1C, "no JPEG"),
        Write(0x3004, 0xFF, "clocks on"), Write(0x3006, 0xC3, "clocks on, no JPEG"),
        *_clock(asked), *(Write(*pair, "analog") for pair in (*_ANALOG, *_ANALOG_OF[asked.skip])),
        *_increments(asked.skip),
        *_window(asked, half_line, total),
        # The sensor sees through its back: with the bits set, the picture is not mirrored.
        Write(0x3821, bins | (0 if asked.mirror_columns else _MIRROR),
              "columns mirrored: bits 2, 1 clear; bit 0: binned"),
        Write(0x3820, bins | (_MIRROR if asked.mirror_rows else 0),
              "rows mirrored: bits 2, 1 set; bit 0: binned"),
        Write(0x3503, 0b11, "exposure and gain by hand"),
        *wide(0x350C, 0, "no lines for long exposures"),
        Write(0x3500, lines >> 12, "exposure, sixteenths of lines"),
        Write(0x3501, lines >> 4 & 0xFF, "exposure"), Write(0x3502, lines << 4 & 0xFF, "exposure"),
        *wide(0x350A, gain, "gain, sixteenths"),
        Write(0x4300, 0x00, "raw"), Write(0x501F, 0x03, "raw, of the defect correction"),
        Write(0x5000, 0x06, "no lens correction, no gamma; defects are corrected"),
        Write(0x5001, 0x00, "no white balance, no colour matrix, no scaling"),
        Write(0x503D, mode or 0, "test pattern"),
        Write(0x4740, 0x21, "PCLK rises within a sample; HREF high in rows, VSYNC in frames"),
        Write(_SYSTEM, _SYSTEM_ON, "start"))
    return Setup(SENSOR, asked, writes,
                 Timing(asked.width, asked.height, line, total, asked.pixel_clock_hz),
                 lines * line, 16 * gain)


def _half_line(asked):
    """Half of a line's pixel clocks."""
    if asked.skip > 1:
        return _REDUCED_LINE
    return _LINE if asked.width <= _LINE_COLUMNS else _LONG_LINE


def _increments(skip):
    """From pixel to pixel, of columns and of rows."""
    which = "every" if skip == 1 else "every other pair of"
    return (Write(0x3814, _INCREMENTS[skip], f"{which} column" + "s" * (skip > 1)),
            Write(0x3815, _INCREMENTS[skip], f"{which} row" + "s" * (skip > 1)))


def _window(asked, half_line, total):
    """Window, line and frame; what is read has a margin of 16 columns and 4 rows on each side."""
    skip = asked.skip
    right = asked.left + skip * asked.width + 2 * _MARGIN_LEFT - 1
    bottom = asked.top + skip * asked.height + 2 * _MARGIN_TOP - 1
    return [write for register, value, meaning in (
        (0x3800, asked.left, "first column"), (0x3802, asked.top, "first row"),
        (0x3804, right, "last column"), (0x3806, bottom, "last row"),
        (0x3808, asked.width, "columns sent"), (0x380A, asked.height, "rows sent"),
        (0x380C, half_line, "clocks of a line"), (0x380E, total, "lines of a frame"),
        (0x3810, _MARGIN_LEFT // skip, "margin, samples"),
        (0x3812, _MARGIN_TOP // skip, "margin, samples"))
        for write in wide(register, value, meaning)]


def _clock(asked):
    """PLL: pixel clock = external / 3 * multiplier / divider / 2 / 2.5; lines count half of it."""
    for divider in range(1, 16):
        multiplier = Fraction(asked.pixel_clock_hz * _PREDIVIDER * 5 * divider, asked.clock_hz)
        oscillator = asked.clock_hz * multiplier / _PREDIVIDER
        whole = multiplier.denominator == 1 and (multiplier <= 127 or multiplier % 2 == 0)
        if whole and 4 <= multiplier <= 252 and _OSCILLATOR[0] <= oscillator <= _OSCILLATOR[1]:
            return [Write(0x3034, 0x1A, "10 bits"),
                    Write(0x3035, divider << 4 | 1, f"PLL / {divider}"),
                    Write(0x3036, int(multiplier), f"PLL * {multiplier}"),
                    Write(0x3037, 0x10 | _PREDIVIDER, f"PLL / {_PREDIVIDER} / 2"),
                    Write(0x3108, 0x01, "lines count half of the pixel clock", 1000)]
    raise InputError(f"the pixel clock is {asked.pixel_clock_hz} Hz, the PLL of the {SENSOR.name} "
                     f"cannot make it of {asked.clock_hz} Hz")
