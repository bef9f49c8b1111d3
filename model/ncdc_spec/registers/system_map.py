"""Registers of a whole system in addition to its corrector's: camera, frame stores, I2C.

The corrector's registers lie in front of them, see :mod:`ncdc_spec.registers.register_map`.
"""

from dataclasses import dataclass

from ncdc_spec.camera_port import CSI2, FAULTS, PARALLEL, fault_registers
from ncdc_spec.frames import ADDRESS_BITS
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.registers.register_map import ADDRESS_WORDS_BITS, Bits, Flag, Register
from ncdc_spec.sensors.grid import MAX_WEIGHT
from ncdc_spec.sensors.level import CURVE_BITS, PIECES, SAMPLE_BITS
from ncdc_spec.white_balance import GAIN_BITS

__all__ = ["CAMERA", "EVENTS", "GRID_ROW_MIN", "I2C_COMMAND_FLAGS", "LOCKED", "STORES",
           "SYSTEM_WORDS_BITS", "Stores", "system_registers"]

SYSTEM_WORDS_BITS = ADDRESS_WORDS_BITS + 1
CAMERA = 1 << ADDRESS_WORDS_BITS        # word address of the camera's registers
STORES = CAMERA + 0x400                 # word address of the frame stores'

_SIZE = Bits(MAX_SIZE.bit_length())
_COUNT = Bits(32)

EVENTS = (
    ("RAW_FRAME", "a raw frame is complete in memory"),
    ("RAW_BAD", "a raw frame ended as bad"),
    ("CORRECTED_FRAME", "a corrected frame is complete, in memory or in the stream"),
    ("CORRECTED_BAD", "a corrected frame ended as bad"),
    ("TAKEN", "a buffer was taken away from a reader that held it for too long"),
    ("I2C_DONE", "the last I2C command is over"),
    ("REFUSED", "a write was ignored. It was of a setting or a base in use by camera or "
     "corrector, or of an I2C command before the last one was over"),
)
"""What `CAMERA_STATUS` remembers, each with its bit in `CAMERA_IRQ_ENABLE`."""

I2C_COMMAND_FLAGS = (("WRITE", 0x200, "send `DATA`"), ("READ", 0x400, "receive a byte"),
                     ("NACK", 0x800, "do not acknowledge the byte received"),
                     ("STOP", 0x1000, "STOP after it"), ("START", 0x100, "START before it"))

GRID_ROW_MIN = 8        # samples; so small a frame has a middle

LOCKED = ("SENT_WIDTH", "SENT_HEIGHT", "WINDOW_LEFT", "WINDOW_TOP", "WINDOW_WIDTH",
          "WINDOW_HEIGHT", "BLACK_LEVEL", "GRID_WEIGHT", "GRID_BIN", "CSI_CHANNEL", "CSI_TYPE",
          *(f"CURVE{k}" for k in range(PIECES + 1)), "RAW_PITCH", "RAW_BYTES", "CORRECTED_BYTES")
"""Settings that, like the bases of buffers, do not change while the camera is active or the
corrector runs by itself."""


@dataclass(frozen=True)
class Stores:
    """Buffers and readers of a system.

    Parameters
    ----------
    raw, corrected : int
        Buffers of raw frames and of corrected ones; of the latter 0 if they leave as a stream.
    readers : int
        That claim and release by registers.
    screens : int
        Readers of corrected frames in gateware, 0 or 1.
    """
    raw: int
    corrected: int
    readers: int
    screens: int = 0


def system_registers(stores, grid=None, cameras=(PARALLEL,), phy=False):
    """All registers of a system but the corrector's, by ascending address.

    Parameters
    ----------
    stores : Stores
    grid : int, optional
        Samples of the longest row that capture's grid stage takes; absent: there is no such stage.
    cameras : sequence of str
        Kinds of camera whose registers there are.
    phy : bool
        With those of a PHY for CSI-2.
    """
    camera = (*_control(), *_settings(), *_curve(), *_grid(grid), *_gains(), *_counts(cameras),
              *_screen(stores), *_i2c(), *_source(cameras, phy))
    return (*(_moved(r, CAMERA) for r in camera), *_stores(stores))


def _ro(name, address, text, shape=_COUNT):
    return Register(name, address, "ro", shape, text)


def _rw(name, address, shape, text):
    return Register(name, address, "rw", shape, text)


def _control():
    flags = [Flag("ACTIVE", 1, "ro", "the camera is enabled, or a frame of it is under way"),
             Flag("RUNNING", 2, "ro", "the corrector runs by itself, or ends its last such frame"),
             *(Flag(name, 1 << 8 + k, "w1c", text) for k, (name, text) in enumerate(EVENTS))]
    names = ", ".join(f"{k}: {name}" for k, (name, _) in enumerate(EVENTS))
    return (
        _rw("CAMERA_ENABLE", 0x00, Bits(1),
            "1: frames that begin from now on are captured; 0: none after the one under way."),
        _rw("RUN", 0x01, Bits(1),
            "1: the corrector begins by itself with every new raw frame; `START` is rejected."),
        _rw("RUN_FOLLOW", 0x02, Bits(1),
            "1: such a frame begins with the camera's and follows it row by row; 0: when the raw "
            "frame is complete."),
        Register("CAMERA_STATUS", 0x03, "action", Bits(8 + len(EVENTS)), "", tuple(flags)),
        _rw("CAMERA_IRQ_ENABLE", 0x04, Bits(len(EVENTS)),
            f"`irq` follows these events of `CAMERA_STATUS`: {names}."),
    )


def _settings():
    return (
        _rw("SENT_WIDTH", 0x05, _SIZE, "Samples of a row that the sensor sends, exactly."),
        _rw("SENT_HEIGHT", 0x06, _SIZE, "Rows that the sensor sends, exactly."),
        _rw("WINDOW_LEFT", 0x07, _SIZE,
            "First column that is captured; an odd one changes the Bayer phase."),
        _rw("WINDOW_TOP", 0x08, _SIZE,
            "First row that is captured; an odd one changes the Bayer phase."),
        _rw("WINDOW_WIDTH", 0x09, _SIZE, "Columns that are captured."),
        _rw("WINDOW_HEIGHT", 0x0A, _SIZE, "Rows that are captured."),
        _rw("BLACK_LEVEL", 0x0B, Bits(SAMPLE_BITS), "Taken off each sample, of 0..4095."),
        _rw("CLOCK_LIMIT", 0x0C, _COUNT,
            "Clocks without a sample of the window or a row outside of it, after which a frame of "
            "the sensor is given up; 0: never."),
        _rw("RAW_PITCH", 0x0D, _SIZE,
            "Bytes from row to row of a raw frame in memory, a multiple of the memory word."),
        _rw("RAW_BYTES", 0x0E, _COUNT,
            "Bytes of each raw frame's buffer, a multiple of the memory word: rows beyond are "
            "not written, and the frame is bad."),
        _rw("CORRECTED_BYTES", 0x0F, _COUNT,
            "Bytes of each corrected frame's buffer, a multiple of the memory word."),
    )


def _curve():
    return tuple(
        Register(f"CURVE{k}", 0x10 + k, "rw", Bits(CURVE_BITS),
                 f"Byte of a sample that is {256 * k} above black; straight between the nodes.",
                 family=("CURVEj", "Byte of a sample that is 256 j above black; straight between "
                         "the nodes."))
        for k in range(PIECES + 1))


def _grid(row):
    """Registers of a system with a grid stage."""
    if row is None:
        return ()
    return (
        _rw("GRID_WEIGHT", 0x21, Bits(MAX_WEIGHT.bit_length()),
            "By how many sixteenths of the distance to the next sample of its colour each sample "
            "is moved to an even grid. It is 0 if the sensor skips nothing, 2 if it and `GRID_BIN` "
            "reduce by 2, 3 if by 4. The window counts in the moved frame, which lacks the last "
            "two columns and rows. Only where `GRID_ROW` is not 0."),
        _rw("GRID_BIN", 0x22, Bits(1),
            "1: before that, four samples of a colour become one, their mean: half the columns "
            "and rows. Only where `GRID_ROW` is not 0."),
        _ro("GRID_ROW", 0x23, "Samples of the longest row that can be moved or binned: a longer "
            "one is then a fault. 0: the system has no such stage.", _SIZE),
    )


def _gains():
    """The register of the gains at capture: one word, so that no frame has a part of a set."""
    mask = (1 << GAIN_BITS) - 1
    return (Register(
        "CAPTURE_GAINS", 0x24, "rw", Bits(3 * GAIN_BITS),
        "White balance before interpolation: each sample that is captured is multiplied by the "
        "gain of its colour, which `BAYER_PHASE` gives. This is after the black level and "
        "before the curve. A grey sensor's samples have the gain of green. Written at any time; "
        "frames of the sensor that begin afterwards have it.",
        tuple(Flag(name, mask << k * GAIN_BITS, "rw", f"gain of {name.lower()} in 256ths, 256 is "
                   "1.0") for k, name in enumerate(("RED", "GREEN", "BLUE")))),)


def _counts(cameras):
    """Counters of frames and rows; ``SOURCE_FAULTS`` where a source can find faults."""
    source = () if not any(FAULTS[kind] for kind in cameras) else (
        _ro("SOURCE_FAULTS", 0x2E, "Frames that were bad as the camera's source has it: the "
            "counters of its faults give the reasons. Not with a parallel sensor."),)
    return (
        _ro("CAMERA_ROWS", 0x28, "Rows of the frame under way that are in memory.", _SIZE),
        _ro("LINE_FAULTS", 0x29, "Rows of the sensor that were too short or too long."),
        _ro("FRAMES_CUT", 0x2A, "Frames of the sensor with too few or too many rows."),
        _ro("OVERFLOWS", 0x2B, "Frames of which samples were lost, as the memory was too slow."),
        _ro("FRAMES_MISSED", 0x2C, "Frames that were not begun, as the last one still waited."),
        _ro("CLOCK_STOPS", 0x2D, "Frames whose clock stopped for `CLOCK_LIMIT`."),
        *source,
        _ro("RAW_BEGUN", 0x30, "Raw frames begun."),
        _ro("RAW_ENDED_BAD", 0x31, "Raw frames that ended as bad, and were not handed on."),
        _ro("RAW_TAKEN", 0x32, "Raw buffers that were taken away from a reader."),
        _ro("RAW_SKIPPED", 0x33, "Good raw frames that the corrector, running by itself, did not "
            "correct, as a newer one had come."),
        _ro("CORRECTED_BEGUN", 0x34, "Corrected frames begun by itself."),
        _ro("CORRECTED_ENDED_BAD", 0x35, "Corrected frames that ended as bad: cut short, with a "
            "fault, or of a raw frame that was bad or taken away."),
        _ro("CORRECTED_TAKEN", 0x36, "Corrected buffers that were taken away from a reader."),
        _ro("CORRECTED_NUMBER", 0x37, "Number of the raw frame, from 1 on, that the last corrected "
            "frame was made of: a stream carries no number."),
        _ro("TIME_LOW", 0x38, "Clocks since the reset, lower half."),
        _ro("TIME_HIGH", 0x39, "Clocks since the reset, upper half: read it, `TIME_LOW`, and it "
            "once more."),
    )


def _screen(stores):
    """Registers of a system with a screen."""
    if not stores.screens:
        return ()
    return (_ro("SCREEN_SHOWN", 0x3A, "Pictures of the screen that showed a corrected frame, a new "
                "one or once more the last one."),
            _ro("SCREEN_UNDERRUNS", 0x3B, "Those of them whose words came too late from memory: "
                "their rest was black."))


def _i2c():
    return (
        _rw("I2C_QUARTER", 0x40, Bits(16), "Clocks of a quarter of a bit, at least 8."),
        _rw("I2C_LIMIT", 0x41, _COUNT, "Clocks for which a target may hold SCL."),
        Register("I2C_COMMAND", 0x42, "action", Bits(13), "Writing begins a command.",
                 (Flag("DATA", 0xFF, "w1", "byte to send"),
                  *(Flag(name, mask, "w1", text) for name, mask, text in
                    sorted(I2C_COMMAND_FLAGS, key=lambda flag: flag[1])))),
        Register("I2C_RESULT", 0x43, "action", Bits(12), "Of the last command.",
                 (Flag("DATA", 0xFF, "ro", "byte received"),
                  Flag("BUSY", 0x100, "ro", "it is not over"),
                  Flag("NACK", 0x200, "ro", "the target did not acknowledge"),
                  Flag("LOST", 0x400, "ro", "the bus was not free, or another controller took it"),
                  Flag("TIMEOUT", 0x800, "ro", "SCL was held for longer than `I2C_LIMIT`"))),
    )


def _source(cameras, phy):
    """Settings of the camera's source, counters of its faults, its PHY."""
    registers = {}
    for kind in cameras:
        first = 0x4A if kind == CSI2 else 0x52
        where = "`--camera csi2`" if kind == CSI2 else "AXI4-Stream or Avalon-ST video"
        for k, (name, register) in enumerate(fault_registers(kind).items()):
            registers[register] = Register(
                register, first + k, "ro", Bits(16),
                f"{FAULTS[kind][name]} Modulo 65536. Only with {where}.")
    settings = () if CSI2 not in cameras else (
        _rw("CSI_CHANNEL", 0x48, Bits(2), "Virtual channel of the frames. Only with "
            "`--camera csi2`."),
        _rw("CSI_TYPE", 0x49, Bits(6), "Data type of the rows, 0x10 or more: 0x2A RAW8, 0x2B "
            "RAW10, 0x2C RAW12; each byte of any other type is a sample. Only with "
            "`--camera csi2`."))
    return sorted((*settings, *registers.values(), *(_phy() if phy else ())),
                  key=lambda register: register.address)


def _phy():
    where = "Only on a board whose sensor has CSI-2."
    return (
        _rw("CSI_SETTLE", 0x51, Bits(6), "Clocks of the bytes for which Dn of a lane is low before "
            f"the lane is active, less 3. {where}"),
        Register("CSI_PHY", 0x55, "ro", Bits(9), where,
                 (Flag("READY", 1, "ro", "the delays of the lanes are chosen"),
                  Flag("FAILURES", 0x1FE, "ro", "searches without a result, modulo 256"))),
        _ro("CSI_EYES", 0x56, "Steps of delay in the middle of the eye of lane 0 in bits 7:0, of "
            f"lane 1 in bits 23:16. Widths of the eyes in bits 15:8 and 31:24. {where}"))


def _stores(stores):
    first = (_rw("READER_LIMIT", 0x00, _COUNT,
                 "Clocks for which a reader, the corrector too, may hold a buffer; 0: for ever."),)
    control = tuple(
        Register(f"READER{k}", 0x10 + k, "action", Bits(15),
                 f"Reader {k} claims the newest complete frame; what it held it releases.",
                 (Flag("CLAIM_RAW", 1, "w1", "claim the newest raw frame"),
                  Flag("CLAIM_CORRECTED", 2, "w1", "claim the newest corrected frame"),
                  Flag("RELEASE", 4, "w1", "release"),
                  Flag("HELD", 0x100, "ro", "`BUFFER` is this reader's"),
                  Flag("LOST", 0x200, "ro",
                       "it was taken away after `READER_LIMIT`: what was read may be of two "
                       "frames"),
                  Flag("CORRECTED", 0x400, "ro", "it is one of the corrected frames'"),
                  Flag("BUFFER", 0xF << 11, "ro", "number of the buffer")),
                 family=("READERj", "Reader j claims the newest complete frame; what it held it "
                         "releases."))
        for k in range(stores.readers))
    buffers = [*_buffers("RAW", "raw", 0x40, stores.raw),
               *_buffers("CORRECTED", "corrected", 0x80, stores.corrected)]
    return tuple(_moved(r, STORES) for r in (*first, *control, *buffers))


def _buffers(name, what, address, count):
    """Base, number and time of each buffer."""
    for k in range(count):
        for step, (member, shape, text) in enumerate((
                ("BASE", Bits(ADDRESS_BITS), f"Byte address of {what} buffer {{}}, a multiple of "
                 "the memory word: lower bits read as zero."),
                ("NUMBER", _COUNT, f"Number of the raw frame in {what} buffer {{}}, from 1 on."),
                ("TIME_LOW", _COUNT, f"Clocks from the reset to the beginning of the raw frame in "
                 f"{what} buffer {{}}, lower half."),
                ("TIME_HIGH", _COUNT, "The upper half."))):
            yield Register(f"{name}{k}_{member}", address + 4 * k + step,
                           "rw" if member == "BASE" else "ro", shape, text.format(k),
                           family=(f"{name}j_{member}", text.format("j")))


def _moved(register, base):
    """``register``, so many words further."""
    return Register(**{**vars(register), "address": base + register.address})
