"""The MT9D111 of Micron: 2 million pixels, 10 bits; on cheap camera boards, as Arducam's B0009.

Its image processor and microcontroller are switched off: the sensor core's samples go to the pins.

Sources: DS, the data sheet MT9D111 of Micron (Rev. B, 2/06; by table and page); D, the open driver
mgm8/mt9d111-driver, which repeats its register list (mt9d111_reg.h) and values after reset
(mt9d111_config.h); C, the data sheet MT9D011 of Micron, page 47, of the same sensor core.
"""

from ncdc_spec.errors import InputError
from ncdc_spec.sensors.checks import exposure_lines, factor_of, frame_lines, pattern_mode, resolved
from ncdc_spec.sensors.sensor import Limits, Sensor, Setup, Timing, UserRegister, Write
from ncdc_spec.sensors.waking import Waking

__all__ = ["SENSOR", "setup"]

# DS, table 5; pages: DS, page register, page 182.
_PAGE = 0xF0
_CHIP_VERSION, _CHIP_VERSION_VALUE = 0x00, 0x1519
_ROW_START, _COLUMN_START, _ROW_WIDTH, _COLUMN_WIDTH = 0x01, 0x02, 0x03, 0x04
_HORIZONTAL_BLANKING_B, _VERTICAL_BLANKING_B = 0x05, 0x06
_SHUTTER_WIDTH, _SHUTTER_DELAY = 0x09, 0x0C
_RESET = 0x0D
_STANDBY = 1 << 2
_READ_MODE_B = 0x20             # bit 0: rows, bit 1: columns mirrored; no border, both converters
_SKIP_2 = 1 << 7 | 1 << 4       # of READ_MODE_B: columns and rows skipped, both by 2; DS, R0x20
_COLOUR_GAINS = (0x2B, 0x2C, 0x2D, 0x2E)
_GLOBAL_GAIN = 0x2F
_CLOCK_CONTROL, _NO_PLL = 0x65, 0xE000          # as after reset: bypassed, and off
_CONTEXT_CONTROL, _CONTEXT_B = 0xF2, 0b1011     # blanking and read mode of context B
# DS, IFP registers, page 1.
_BOOT_MODE = 0xC3               # bit 0: the microcontroller stays in reset
_FACTORY_BYPASS = 0x09          # bits 1..0: 0: the core's 10 bits go to the pins

_FIRST_COLUMN, _FIRST_ROW = 60, 28      # D, values after reset
_BLANKING = 0x204                       # columns; D, after reset of context B: what surely works
_MIN_VERTICAL = 4 + 7                   # lines; DS, R0x06: 4 + R0x22[2:0], which is 7 after reset
_OVERHEAD = 260                         # clocks; DS, page 130, and C, integration time

SENSOR = Sensor(
    name="mt9d111", title="Micron MT9D111, Arducam B0009",
    i2c_address=0x48,                   # of S_ADDR low, as on that board; high: 0x5D; DS, page 181
    pointer_bits=8, value_bits=16, chip_id=((_CHIP_VERSION, _CHIP_VERSION_VALUE),),
    columns=1600, rows=1200, bits=10,
    # DS, R0x20: mirrored, reading begins one column or row further, so that the first colour stays.
    bayer="GRBG", mirror_keeps_bayer=True,
    black=42 << 2,                      # D, R0x30: 42 of 1023 after reset
    clock_hz=36_000_000, pixel_clock_hz=36_000_000,     # C
    limits=Limits(step=1, corner_step=1, smallest=(17, 2),      # DS, R0x03, R0x04
                  lines=(1, 0xFFFF), vertical=(_MIN_VERTICAL, 0x7FFF),
                  gain_256=(256, 127 * 256), pixel_clock_hz=36_000_000,    # C
                  frame_lines=1200 + 0x7FFF, reductions=((2, 1),)),
    user_registers=tuple(map(UserRegister, (_SHUTTER_WIDTH, *_COLOUR_GAINS, _GLOBAL_GAIN))),
    first=(_FIRST_COLUMN, _FIRST_ROW),
    waking=Waking(reset_us=1000, rest_us=20_000, rest_clocks=0,
                  source="not found in DS; taken for those of the OV5640"))


def setup(settings):
    """The :class:`Setup` for ``settings``; raises :class:`InputError` at a limit."""
    asked = resolved(SENSOR, settings)
    if asked.clock_hz != asked.pixel_clock_hz:
        raise InputError(f"the pixel clock is {asked.pixel_clock_hz} Hz, of the {SENSOR.name} it "
                         f"is the external clock of {asked.clock_hz} Hz, as its PLL is not used")
    pattern_mode(SENSOR, asked)
    line = asked.width + _BLANKING
    lines = exposure_lines(SENSOR, asked, line, _OVERHEAD)
    total = frame_lines(SENSOR, asked, line, lines)
    gain, gain_256 = _gain(factor_of(SENSOR, asked))
    mode = (_SKIP_2 if asked.skip == 2 else 0) | asked.mirror_columns << 1 | asked.mirror_rows
    writes = (
        Write(_PAGE, 1, "registers of the image processor"),
        Write(_BOOT_MODE, 1, "the microcontroller stays in reset"),
        Write(_FACTORY_BYPASS, 0, "the core's samples to the pins"),
        Write(_PAGE, 0, "registers of the core"), Write(_RESET, 1, "reset"),
        Write(_RESET, _STANDBY, "out of reset, standby"),
        Write(_CLOCK_CONTROL, _NO_PLL, "the external clock is the pixel clock"),
        Write(_CONTEXT_CONTROL, _CONTEXT_B, "blanking and read mode of context B"),
        Write(_ROW_START, _FIRST_ROW + asked.top, "first row"),
        Write(_COLUMN_START, _FIRST_COLUMN + asked.left, "first column"),
        Write(_ROW_WIDTH, asked.skip * asked.height, "rows"),
        Write(_COLUMN_WIDTH, asked.skip * asked.width, "columns"),
        Write(_HORIZONTAL_BLANKING_B, _BLANKING, "horizontal blanking"),
        # A longer exposure makes the frame longer by itself.
        Write(_VERTICAL_BLANKING_B, min(total - asked.height, SENSOR.limits.vertical[1]),
              "vertical blanking, lines"),
        Write(_SHUTTER_WIDTH, lines, "exposure in lines"), Write(_SHUTTER_DELAY, 0, "no delay"),
        Write(_READ_MODE_B, mode, "mirrors, skipping; no border"),
        Write(_GLOBAL_GAIN, gain, "gain"),
        Write(_RESET, 0, "start"))
    return Setup(SENSOR, asked, writes,
                 Timing(asked.width, asked.height, line, total, asked.pixel_clock_hz),
                 lines * line - _OVERHEAD, gain_256)


def _gain(factor):
    """Global gain nearest to ``factor``, and its gain, of which 256 is 1.

    Bits 6..0 in parts of 32, doubled by each of the bits 7, 8 (analog) and 9, 10, 11 (digital);
    DS, page 37. As few doublings as keep the first part below 2, analog ones first.
    """
    doublings = min(5, int(factor).bit_length() - 1)
    part = min(127, round(32 * factor / (1 << doublings)))
    if part == 64 and doublings < 5:
        part, doublings = 32, doublings + 1
    return ((1 << doublings) - 1 << 7 | part), part * 8 << doublings
