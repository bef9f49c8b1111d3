"""Registers of the MT9P031 that its users set: those of the client's sensor panel.

Addresses and fields are those of the register list in Aptina's MT9P031 data sheet.
"""

__all__ = ["ANALOG_GAIN", "CHIP_VERSION", "CHIP_VERSION_VALUE", "COLUMN_SIZE", "COLUMN_START",
           "FIRST_COLUMN", "FIRST_ROW", "GLOBAL_GAIN", "MIRROR_COLUMN", "MIRROR_ROW",
           "READ_MODE_2", "ROW_SIZE", "ROW_START", "SHUTTER_LOWER", "SHUTTER_UPPER",
           "TEST_PATTERN", "line_time_ns"]

CHIP_VERSION = 0x00
CHIP_VERSION_VALUE = 0x1801
ROW_START = 0x01
COLUMN_START = 0x02
ROW_SIZE = 0x03             # rows of the window less one
COLUMN_SIZE = 0x04          # columns of the window less one
SHUTTER_UPPER = 0x08        # exposure in lines, bits 19..16
SHUTTER_LOWER = 0x09        # and bits 15..0
READ_MODE_2 = 0x20
MIRROR_ROW = 15             # bit of READ_MODE_2: the picture upside down
MIRROR_COLUMN = 14          # bit of READ_MODE_2: the picture left to right
GLOBAL_GAIN = 0x35
ANALOG_GAIN = (0, 6)        # lowest bit and width of the analog gain in GLOBAL_GAIN, eighths
TEST_PATTERN = 0xA0         # bit 0 on, bits 6..3 which

FIRST_ROW, FIRST_COLUMN = 54, 16    # of the active pixels
_PIXEL_CLOCK_MHZ = 96
_MIN_BLANKING = 450                 # pairs of columns
_MIN_LINE = 41 + 346 + 99           # pairs of columns, whatever the width


def line_time_ns(columns):
    """Nanoseconds of a line of ``columns`` pixels at 96 MHz without binning, rounded to nearest.

    Two pixels a pixel clock pair: 2 * max(columns / 2 + blanking, least) / 96 MHz.
    """
    pairs = max(columns // 2 + _MIN_BLANKING, _MIN_LINE)
    return round(2000 * pairs / _PIXEL_CLOCK_MHZ)
