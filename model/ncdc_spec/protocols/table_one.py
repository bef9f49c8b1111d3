"""Table I of the paper: the commands between client and device, on TCP or any byte stream.

All numbers are big endian. A request is an operating code and, for two of them, an address and a
value of 16 bits; each answer begins with the code.
"""

import struct
from dataclasses import dataclass

__all__ = ["COMMANDS", "Command", "IDLE_SECONDS", "MAX_USERS", "MIRRORS", "MRAW", "RATE", "READ",
           "REQUEST", "RESERVED", "SYSTEM_PAGE", "SYSTEM_WORDS", "SystemWord", "TCP_PORT",
           "UNKNOWN", "VIEW", "VIEWS", "WINDOW", "WRITE", "server_settings"]

TCP_PORT = 4000
MAX_USERS = 16          # connections at once that a device accepts; at least 8 are promised
IDLE_SECONDS = 30       # if all are taken, a user silent for so long gives its position away

READ, WRITE, RESERVED, MRAW = 0x80, 0x81, 0x82, 0x83
UNKNOWN = 0xFF          # begins the answer to any other code

REQUEST = struct.Struct(">BHH")     # of READ and WRITE, and of their answers


def server_settings():
    """What a ``table_users.TableServer`` has to know of the table, as a dict for JSON."""
    return {"users": MAX_USERS, "idle_seconds": IDLE_SECONDS, "unknown": UNKNOWN,
            "codes": {"READ": READ, "WRITE": WRITE, "RESERVED": RESERVED, "MRAW": MRAW}}


@dataclass(frozen=True)
class Command:
    """A row of Table I, its first three columns as printed, and what the device answers."""
    code: int
    address: str
    data: str
    text: str
    answer: str


COMMANDS = (
    Command(READ, "2 bytes", "2 bytes", "Read setting from CMOS sensor register.",
            "the code, the address, the value; the request's data are ignored"),
    Command(WRITE, "2 bytes", "2 bytes", "Write setting to CMOS sensor register.",
            "the code, the address, the value as read back: another one than sent means rejected"),
    Command(RESERVED, "-", "-", "Reserve.", "none"),
    Command(MRAW, "-", "-", "Receive an MRAW package.", "the package of Table II"),
)

SYSTEM_PAGE = 0xF000    # addresses from here on are the system's, below them the sensor's


@dataclass(frozen=True)
class SystemWord:
    """A 16-bit word of the system's page.

    Parameters
    ----------
    name : str
    address : int
    access : str
        "rw" or "ro".
    text : str
    """
    name: str
    address: int
    access: str
    text: str


SYSTEM_WORDS = (
    SystemWord("SOURCE", 0xF000, "rw", "0 raw frames, 1 corrected ones"),
    SystemWord("WIDTH", 0xF001, "rw", "pixels of a row of the picture"),
    SystemWord("HEIGHT", 0xF002, "rw", "rows of the picture"),
    SystemWord("FORMAT", 0xF003, "rw", "formation byte of Table II"),
    SystemWord("FRAME_RATE", 0xF004, "rw", "frames per second, tenths"),
    SystemWord("LENS", 0xF005, "rw", "number of the lens that is corrected"),
    SystemWord("DROPPED_UPPER", 0xF006, "ro", "frames dropped, bits 31..16"),
    SystemWord("DROPPED_LOWER", 0xF007, "ro", "and bits 15..0"),
    SystemWord("OFFSET_X", 0xF008, "rw", "column of the whole picture that the picture begins at"),
    SystemWord("OFFSET_Y", 0xF009, "rw", "row of the whole picture that it begins at"),
    SystemWord("WIDTH_MAX", 0xF00A, "ro", "pixels of a row of the whole picture"),
    SystemWord("HEIGHT_MAX", 0xF00B, "ro", "rows of the whole picture"),
    SystemWord("LINE_TIME_UPPER", 0xF00C, "ro", "time of a line of the sensor, ns, bits 31..16"),
    SystemWord("LINE_TIME_LOWER", 0xF00D, "ro", "and bits 15..0"),
    SystemWord("LENS_MAX", 0xF00E, "ro", "number of the last lens"),
    SystemWord("TORN_UPPER", 0xF00F, "ro", "frames torn, bits 31..16"),
    SystemWord("TORN_LOWER", 0xF010, "ro", "and bits 15..0"),
    SystemWord("STREAMING", 0xF011, "ro",
               "1 while pictures stream over GVSP: their size and format are locked"),
    SystemWord("NUMBER_UPPER", 0xF012, "ro",
               "number of the frame that this connection received last, bits 31..16"),
    SystemWord("NUMBER_LOWER", 0xF013, "ro", "and bits 15..0"),
    SystemWord("FRAMES", 0xF014, "ro", "system with Ethernet: frames completed, raw or corrected "
               "as `SOURCE` says, modulo 65536; elsewhere 0"),
    SystemWord("SENSOR_WIDTH", 0xF015, "ro", "active pixels of a row of the sensor; of this and "
               "the six after it 0 over USB, where the host sets up the sensor"),
    SystemWord("SENSOR_HEIGHT", 0xF016, "ro", "rows of them"),
    SystemWord("DECIMATION_X", 0xF017, "ro", "active columns for each of a whole raw frame"),
    SystemWord("DECIMATION_Y", 0xF018, "ro", "active rows for each of a whole raw frame"),
    SystemWord("FIELD_LEFT", 0xF019, "ro", "active column where the whole raw frame begins"),
    SystemWord("FIELD_TOP", 0xF01A, "ro", "active row where it begins"),
    SystemWord("SENSOR_ADDRESS", 0xF01B, "ro", "the sensor's I2C address, by which a client knows "
               "its registers"),
    SystemWord("ABILITIES", 0xF01C, "ro", "what this device lets be written. Bit 0: size and "
               "offsets of the picture. Bit 1: the sensor's mirrors. Bit 2: `FRAME_RATE`. Bit 3: "
               "`PAN` to `ZOOM`, a view. Bit 4: `VIEW_LAYOUT`, several views"),
    SystemWord("PAN", 0xF01D, "rw", "direction of the view to the right, hundredths of a degree, "
               "two's complement"),
    SystemWord("TILT", 0xF01E, "rw", "the same, upwards"),
    SystemWord("ROLL", 0xF01F, "rw", "turn of the view, clockwise, likewise"),
    SystemWord("ZOOM", 0xF020, "rw", "its magnification, thousandths"),
    SystemWord("VIEW_FOCAL_UPPER", 0xF021, "ro", "focal length of corrected pictures at a zoom of "
               "1, hundredths of a pixel, bits 31..16"),
    SystemWord("VIEW_FOCAL_LOWER", 0xF022, "ro", "and bits 15..0"),
    SystemWord("VIEW_LAYOUT", 0xF023, "rw", "views of a corrected picture: 0 one, 1 four of equal "
               "size, 2 one with a second one in its corner"),
    SystemWord("VIEW_SELECTED", 0xF024, "rw", "number of the view that `PAN` to `ZOOM` are of"),
)

WINDOW, MIRRORS, RATE, VIEW, VIEWS = 1, 2, 4, 8, 16     # bits of ABILITIES
