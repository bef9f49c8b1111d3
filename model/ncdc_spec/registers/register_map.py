"""The registers, declared once: gateware, host software and documentation read this table."""

from dataclasses import dataclass

from ncdc_spec.frames import ADDRESS_BITS, MONO8, OUTPUT_FORMATS
from ncdc_spec.geometry import MAX_SIZE, MIN_SIZE, SCAN, STRIP_UNIT
from ncdc_spec.interpolation import CRESTS, DIRECTIONAL, FAST, GRADIENT
from ncdc_spec.tone import NODE_BITS, NODE_POSITIONS
from ncdc_spec.view import CAMERA_FORMATS, FORMATS, NAMES, PLANE_HEIGHT, VIEW_REGISTERS
from ncdc_spec.view_list import (
    ENTRY_WORDS,
    MAX_VIEWS,
    OFFSET,
    PITCH,
    PITCH_BITS,
    entry_register,
)
from ncdc_spec.view_rows import (
    MAX_MATRICES,
    ROWS_BANK,
    ROWS_COUNT,
    ROWS_REGISTERS,
    ROWS_STATUS,
    ROWS_STEP,
    STEPS,
)
from ncdc_spec.white_balance import GAIN_BITS

__all__ = ["ADDRESS_WORDS_BITS", "BAYER_MONO", "Bits", "CAPABILITIES", "capabilities",
           "absent", "COLOUR_COUNTERS", "COLOUR_SETTINGS", "CONSTANTS", "COUNTERS", "counters",
           "CTRL_ABORT", "CTRL_COMMIT", "CTRL_START", "FAULT_ALIGNMENT", "FAULT_FORMAT",
           "FAULT_MEMORY", "FAULT_SIZE", "FAULT_SOURCE", "FAULT_TARGET", "FIXED_LENS_BIT", "Flag",
           "ID", "NO_COUNTERS_BIT", "NO_FOLLOW_BIT",
           "INTERPOLATION_BITS", "network_registers", "NODES", "OUTSIDE_DIGEST", "RAW_GAINS",
           "Register", "registers", "SKIP", "STATUS_ABORTED", "STATUS_BANK",
           "STATUS_BUSY", "STATUS_COMMITTED", "STATUS_DONE", "STATUS_FAULT",
           "STATUS_PENDING", "STATUS_REFUSED", "TABLE", "VERSION", "VIEW_BIT", "VIEW_LIST",
           "listed"]

ADDRESS_WORDS_BITS = 14
TABLE = 1 << 13           # word address of the window on the table of valid rows
ID = 0x4E434443           # "NCDC"

VERSION = 3               # of this map; one more whenever a host must know of a change

# Of an instance.
CONSTANTS = ("ID", "DIGEST", "NEURONS", "NODES", "CAPABILITIES", "LARGEST")

# Shadow registers of colour, where there are any.
COLOUR_SETTINGS = ("GAIN_RED", "GAIN_GREEN", "GAIN_BLUE",
                   *(f"TONE{k}" for k in range(len(NODE_POSITIONS))))

# Shadow registers of the gains before interpolation, where there are any.
RAW_GAINS = ("RAW_GAIN_RED", "RAW_GAIN_GREEN", "RAW_GAIN_BLUE")

# Registers of the set that do not depend on the lens: DIGEST does not include them.
OUTSIDE_DIGEST = ("VALID_BANK", "SOURCE_BASE", "SOURCE_LIMIT", "SOURCE_PITCH", "TARGET_BASE",
                  "TARGET_LIMIT", "OUTPUT_FORMAT", "CREST", "FOLLOW", "CACHE_SPLIT", "STRIP_WIDTH",
                  *COLOUR_SETTINGS, *RAW_GAINS, *VIEW_REGISTERS, *CAMERA_FORMATS, "VIEWS",
                  *ROWS_REGISTERS)

# Registers of the set that hardware with a fixed lens has.
_WITH_FIXED_LENS = ("SOURCE_BASE", "SOURCE_LIMIT", "TARGET_BASE", "TARGET_LIMIT", "FOLLOW",
                    *COLOUR_SETTINGS, *RAW_GAINS)

CTRL_START, CTRL_COMMIT, CTRL_ABORT = 1, 2, 4
STATUS_BUSY, STATUS_DONE, STATUS_PENDING = 1, 2, 4
STATUS_COMMITTED, STATUS_REFUSED, STATUS_BANK, STATUS_ABORTED = 8, 16, 32, 64
STATUS_FAULT = 128
CAPABILITIES = 0x25
BAYER_MONO = 4            # of BAYER_PHASE
# Of CAPABILITIES.
INTERPOLATION_BITS = {FAST.name: 0x400, GRADIENT.name: 0x800, DIRECTIONAL.name: 0x200000}
VIEW_BIT = 1 << 28
FIXED_LENS_BIT, NO_FOLLOW_BIT, NO_COUNTERS_BIT = 1 << 29, 1 << 30, 1 << 31
FAULT_SOURCE, FAULT_TARGET, FAULT_ALIGNMENT, FAULT_SIZE, FAULT_FORMAT = 1, 2, 4, 8, 16
FAULT_MEMORY = 32

# Counted while a frame runs; FRAMES counts frames.
COUNTERS = ("CLOCKS", "PIXELS", "FETCHES", "FRONT_END_STALLS", "SINK_STALLS", "DATA_STALLS",
            "INTERLOCK_STALLS", "CREDIT_STALLS", "PENDING_STALLS")

# Counted as well where there are registers of colour.
COLOUR_COUNTERS = ("RED_SUM", "GREEN_SUM", "BLUE_SUM", "VALID_PIXELS")


@dataclass(frozen=True)
class Bits:
    """A number of ``width`` bits, a two's complement one if ``signed``."""
    width: int
    signed: bool = False


_SIZE = Bits(MAX_SIZE.bit_length())


@dataclass(frozen=True)
class Flag:
    """One bit of an "action" register, or some bits of a constant.

    Parameters
    ----------
    name : str
    mask : int
        Adjacent ones.
    access : str
        "w1": writing 1 acts, reads 0; "ro"; "w1c": writing 1 clears.
    text : str
    """
    name: str
    mask: int
    access: str
    text: str

    @property
    def bit(self):
        """Number of the highest bit."""
        return self.mask.bit_length() - 1

    @property
    def low(self):
        """Number of the lowest bit."""
        return (self.mask & -self.mask).bit_length() - 1

    @property
    def position(self):
        """The bits, for people."""
        return f"bit {self.bit}" if self.bit == self.low else f"bits {self.bit}:{self.low}"


@dataclass(frozen=True)
class Register:
    """One 32-bit register.

    Parameters
    ----------
    name : str
    address : int
        In words.
    access : str
        "rw"; "shadow": rw, of the set that a commit makes active; "ro"; "action": flags, each
        with its own access.
    shape : Bits
        Stored bits; a signed value is sign-extended on reading.
    text : str
    flags : tuple of Flag
        Flags of an "action" register, or of a constant with several parts.
    parameter : tuple
        Position in the network of a register's value: layer ("hidden", "output"),
        number of the neuron, "weights", "bias" or "skip", and number of the weight; else empty.
    family : (str, str)
        Name and text with ``j`` for the number of the hidden neuron: those that all hidden
        neurons' registers of one kind have in common.
    """
    name: str
    address: int
    access: str
    shape: Bits
    text: str
    flags: tuple = ()
    parameter: tuple = ()
    family: tuple = ()

    def __post_init__(self):
        if not self.family:
            object.__setattr__(self, "family", (self.name, self.text))


def _action(name, address, text, *flags, access="action"):
    return Register(name, address, access, Bits(max(flag.bit for flag in flags) + 1), text,
                    flags)


_FIXED = (
    Register("ID", 0x00, "ro", Bits(32), "Constant 0x4E434443, \"NCDC\"."),
    Register("DIGEST", 0x01, "ro", Bits(32),
             "First 32 bits of the hash of the descriptor that the reset values are from."),
    Register("NEURONS", 0x02, "ro", Bits(6), "Hidden neurons of this instance."),
    _action("CTRL", 0x03, "Several bits may be written at once.",
            Flag("START", CTRL_START, "w1",
                 "correct one frame; while a frame runs, one more waits its turn"),
            Flag("COMMIT", CTRL_COMMIT, "w1",
                 "make the whole set of shadow registers active at the next frame boundary"),
            Flag("ABORT", CTRL_ABORT, "w1",
                 "end the frame that runs with a blank pixel; what is under way drains first")),
    _action("STATUS", 0x04, "",
            Flag("BUSY", STATUS_BUSY, "ro", "a frame runs"),
            Flag("DONE", STATUS_DONE, "w1c",
                 "a frame is complete: the memory has taken its last word"),
            Flag("PENDING", STATUS_PENDING, "ro", "another frame waits"),
            Flag("COMMITTED", STATUS_COMMITTED, "ro", "a commit waits for the frame boundary"),
            Flag("REFUSED", STATUS_REFUSED, "w1c",
                 "a write to a committed set or to valid rows in use was ignored. Or a start was "
                 "ignored while the corrector runs by itself"),
            Flag("BANK", STATUS_BANK, "ro", "bank of the valid rows in use"),
            Flag("ABORTED", STATUS_ABORTED, "ro",
                 "the last frame lacks pixels: it was aborted, or rejected, see `FAULT`"),
            Flag("FAULT", STATUS_FAULT, "ro", "a bit of `FAULT` is set")),
    Register("IRQ_ENABLE", 0x05, "rw", Bits(1), "irq follows STATUS.DONE."),
    Register("VALID_WINDOW", 0x06, "rw", Bits(1),
             "Bank of the valid rows that the table window reads and writes."),
    Register("VALID_BANK", 0x07, "shadow", Bits(1), "Bank of the valid rows that frames use."),
    Register("SOURCE_BASE", 0x08, "shadow", Bits(ADDRESS_BITS),
             "Byte address of the raw frame, a multiple of the memory word."),
    Register("SOURCE_PITCH", 0x09, "shadow", _SIZE,
             "Bytes from row to row of the raw frame, a multiple of the memory word, from "
             "DISTORTED_WIDTH to 8191."),
    Register("TARGET_BASE", 0x0A, "shadow", Bits(ADDRESS_BITS),
             "Byte address of the corrected frame, a multiple of the memory word."),
    Register("CORRECTED_WIDTH", 0x0B, "shadow", _SIZE,
             f"Corrected image, pixels per row, {MIN_SIZE}..{MAX_SIZE}."),
    Register("CORRECTED_HEIGHT", 0x0C, "shadow", _SIZE,
             f"Corrected image, rows, {MIN_SIZE}..{MAX_SIZE}."),
    Register("DISTORTED_WIDTH", 0x0D, "shadow", _SIZE,
             f"Raw frame, samples per row, {MIN_SIZE}..{MAX_SIZE}."),
    Register("DISTORTED_HEIGHT", 0x0E, "shadow", _SIZE,
             f"Raw frame, rows, {MIN_SIZE}..{MAX_SIZE}."),
    Register("FOLLOW", 0x0F, "shadow", Bits(1),
             "1: a pixel waits until `camera_rows` says that its raw rows are in memory; 0: the "
             "raw frame is complete when a frame begins."),
    Register("SCAN_ORIGIN_X", 0x10, "shadow", Bits(SCAN.width, signed=True),
             f"Normalised x of the first column, {SCAN}."),
    Register("SCAN_STEP_X", 0x11, "shadow", Bits(SCAN.width, signed=True),
             f"Normalised distance of two columns, {SCAN}."),
    Register("SCAN_ORIGIN_Y", 0x12, "shadow", Bits(SCAN.width, signed=True),
             f"Normalised y of the first row, {SCAN}."),
    Register("SCAN_STEP_Y", 0x13, "shadow", Bits(SCAN.width, signed=True),
             f"Normalised distance of two rows, {SCAN}."),
    Register("BAYER_PHASE", 0x14, "shadow", Bits(3),
             "Parity of the column (bit 0) and the row (bit 1) of the red samples. Bit 2: the "
             "sensor is grey, without a colour filter (gradient-corrected interpolation only)."),
    Register("FILL", 0x15, "shadow", Bits(24),
             "Colour of pixels without a source, 0xRRGGBB."),
    Register("CACHE_SPLIT", 0x16, "shadow", Bits(4),
             "Cache fetcher: log2 of the tile pairs along a row that have sets of their own."),
    Register("STRIP_WIDTH", 0x17, "shadow", _SIZE,
             f"Columns of a strip, a multiple of {STRIP_UNIT}; 0: raster. "
             "A stream is always a raster."),
    Register("CLOCKS", 0x18, "ro", Bits(32), "Clocks of the last frame, start to last pixel."),
    Register("PIXELS", 0x19, "ro", Bits(32), "Pixels of the last frame."),
    Register("FETCHES", 0x1A, "ro", Bits(32), "Windows (multiport), or tiles (cache; of 16x2 "
             "samples, with the fast interpolation 16x4), that the last frame read from memory."),
    Register("FRONT_END_STALLS", 0x1B, "ro", Bits(32),
             "Clocks in which the last frame's front end waited for space downstream."),
    Register("FRAMES", 0x1C, "ro", Bits(32), "Frames completed since reset."),
    Register("SINK_STALLS", 0x1D, "ro", Bits(32),
             "Clocks in which a corrected pixel of the last frame waited for writer or stream."),
    Register("DATA_STALLS", 0x1E, "ro", Bits(32),
             "Clocks in which the last frame's oldest window waited for the memory."),
    Register("INTERLOCK_STALLS", 0x1F, "ro", Bits(32),
             "Cache fetcher: clocks in which a missing tile waited for the slot of one in use."),
    Register("CREDIT_STALLS", 0x20, "ro", Bits(32),
             "Cache fetcher: clocks in which a window that misses tiles waited, as those before it "
             "were not all asked for. As many as allowed were under way."),
    Register("PENDING_STALLS", 0x21, "ro", Bits(32),
             "Cache fetcher: clocks in which a window waited because as many as allowed were "
             "pending."),
    Register("SOURCE_LIMIT", 0x22, "shadow", Bits(ADDRESS_BITS),
             "Byte address after the raw frame's buffer: nothing from there on is read."),
    Register("TARGET_LIMIT", 0x23, "shadow", Bits(ADDRESS_BITS),
             "Byte address after the corrected frame's buffer: nothing from there on is written."),
    _action("FAULT", 0x24, "",
            Flag("SOURCE", FAULT_SOURCE, "w1c",
                 "a sample of the raw frame was not read, because it is not between `SOURCE_BASE` "
                 "and `SOURCE_LIMIT`. Pixels are wrong, or the frame was rejected"),
            Flag("TARGET", FAULT_TARGET, "w1c",
                 "pixels were not written, because they are not between `TARGET_BASE` and "
                 "`TARGET_LIMIT`"),
            Flag("ALIGNMENT", FAULT_ALIGNMENT, "w1c",
                 "a frame was rejected: a base, an offset or a pitch is no multiple of the memory "
                 "word"),
            Flag("SIZE", FAULT_SIZE, "w1c",
                 "a frame was rejected. A size, a pitch, the strip, the split, or the number of "
                 "views or matrices is beyond its limits. Or the width is no multiple of the "
                 "pixels per clock"),
            Flag("FORMAT", FAULT_FORMAT, "w1c",
                 "a frame was rejected: `OUTPUT_FORMAT` is none of its values, or "
                 f"{MONO8.name} and `BAYER_PHASE` names no grey sensor"),
            Flag("MEMORY", FAULT_MEMORY, "w1c",
                 "the memory answered a read or a write with an error, which only AXI reports: "
                 "pixels are wrong. Or it was reset in a frame without the corrector: pixels are "
                 "wrong, or the frame does not end until a reset")),
    _action("CAPABILITIES", CAPABILITIES, "What this instance is.",
            Flag("VERSION", 0xFF, "ro", "version of this register map"),
            Flag("STREAM", 0x100, "ro", "1: pixels leave as a video stream, 0: to memory"),
            Flag("CACHE", 0x200, "ro", "1: cache fetcher, 0: multiport"),
            Flag("FAST", INTERPOLATION_BITS[FAST.name], "ro", "1: it has the fast interpolation"),
            Flag("GRADIENT", INTERPOLATION_BITS[GRADIENT.name], "ro",
                 "1: it has the gradient-corrected interpolation, and that of grey sensors"),
            Flag("LANES", 0x7000, "ro", "pixels per clock"),
            Flag("COLOUR", 0x8000, "ro", "1: it has gains after interpolation, a tone curve and "
                 "sums of the colours"),
            Flag("WORD", 0x1F0000, "ro", "bytes of a memory word"),
            Flag("DIRECTIONAL", INTERPOLATION_BITS[DIRECTIONAL.name], "ro",
                 "1: it has the directional interpolation, and that of grey sensors"),
            Flag("RAW_GAINS", 0x400000, "ro", "1: it has gains before interpolation, of raw "
                 "frames as they are read: `RAW_GAIN_RED` and so on"),
            Flag("CAPTURE_GAINS", 0x800000, "ro", "1: it has gains before interpolation, of "
                 "samples as the camera captures them: `CAPTURE_GAINS`"),
            Flag("MAX_SPLIT", 0xF000000, "ro", "largest `CACHE_SPLIT`"),
            Flag("VIEW", VIEW_BIT, "ro", "1: it has a view: `VIEW_X_U` and so on"),
            Flag("FIXED_LENS", FIXED_LENS_BIT, "ro", "1: lens, sizes, format and strips are "
                 "constants; of the set only addresses and colour can be written"),
            Flag("NO_FOLLOW", NO_FOLLOW_BIT, "ro", "1: there is no `FOLLOW`"),
            Flag("NO_COUNTERS", NO_COUNTERS_BIT, "ro", "1: `FRAMES` alone counts, and the sums "
                 "of colours"), access="ro"),
    _action("LARGEST", 0x26, "Largest corrected image that this instance makes.",
            Flag("WIDTH", 0x1FFF, "ro", "pixels per row"),
            Flag("HEIGHT", 0x1FFF0000, "ro", "rows"), access="ro"),
    Register("ALTERED", 0x27, "ro", Bits(1),
             "1: the lens may be another one than DIGEST says. A register of it was written since "
             "the reset, or a valid row of the bank in use since configuration."),
    Register("OUTPUT_FORMAT", 0x28, "shadow", Bits(2),
             "Bytes of a pixel in memory, pixels without a gap, and rows too unless a view has a "
             "pitch. "
             + "; ".join(f"{one.code} {one.name}: {one.text}" for one in OUTPUT_FORMATS.values())
             + ". A stream takes no notice."),
    Register("CREST", 0x29, "shadow", Bits(2),
             "Directional interpolation: what is added where bilinear blending cuts off crests; "
             + ", ".join(f"{value} {name}" for name, value in CRESTS.items()) + "."),
)
NODES = 0x30
_NODES = Register("NODES", NODES, "ro", Bits(6),
                  "Pixels from node to node; an instance whose network is evaluated at every pixel "
                  "has no such register and reads 0.")
_COLOURS, _TONE = ("RED", "GREEN", "BLUE"), 0x50
_COLOUR = (
    *(Register(f"GAIN_{name}", 0x40 + k, "shadow", Bits(GAIN_BITS),
               f"White balance after interpolation: gain of {name.lower()} in 256ths, 256 is "
               "1.0.")
      for k, name in enumerate(_COLOURS)),
    *(Register(f"{name}_SUM", 0x44 + k, "ro", Bits(32),
               f"Sum of {name.lower()} over the pixels of the last frame that have a source, "
               "before `GAIN_RED` and so on; gains before interpolation are in it.")
      for k, name in enumerate(_COLOURS)),
    Register("VALID_PIXELS", 0x47, "ro", Bits(25), "Pixels that these sums are of."),
    *(Register(f"TONE{k}", _TONE + k, "shadow", Bits(NODE_BITS),
               f"Tone curve: what the value {value} becomes, 0..256.",
               family=("TONEj", "Tone curve: what the value at node j becomes, 0..256; "
                       "j = 0..16."))
      for k, value in enumerate(NODE_POSITIONS)))
_RAW_GAINS = tuple(
    Register(name, 0x48 + k, "shadow", Bits(GAIN_BITS),
             f"White balance before interpolation, of the raw frame as it is read: gain of its "
             f"{colour.lower()} samples in 256ths, 256 is 1.0. A grey sensor's have that of green.")
    for k, (name, colour) in enumerate(zip(RAW_GAINS, _COLOURS)))
_VIEW, _HOMOGENEOUS = 0x70, (
    "x of a pixel in the trained picture, times its depth",
    "y of a pixel in the trained picture, times its depth", "depth of a pixel")
_VIEWS = (
    *(Register(NAMES[row][column], _VIEW + 3 * row + column, "shadow", Bits(q.width, signed=True),
               f"View: {quantity}, {q}; " + ("that of the first pixel." if column == 2 else
               f"its growth from {'column to column' if column == 0 else 'row to row'}."))
      for row, quantity in enumerate(_HOMOGENEOUS) for column, q in enumerate(FORMATS[row])),
    Register(PLANE_HEIGHT, _VIEW + 9, "shadow", _SIZE,
             "View: rows of the trained picture, those of the table of valid rows."),
    *(Register(name, _VIEW + 10 + k, "shadow", Bits(q.width, signed=True),
               f"View, for hosts only: {text}, {q}.")
      for k, ((name, q), text) in enumerate(zip(CAMERA_FORMATS.items(), (
          "focal length of the trained picture along a row, in pixels; 0: not known",
          "column of its camera's axis", "row of its camera's axis",
          "its focal length along a column over that along a row")))))
VIEW_LIST = 0x400         # word address of entry 0 of the list of views; each has 16 words
_COUNT_BITS = MAX_VIEWS.bit_length()
_LIST_CONTROL = (
    Register("VIEWS", 0x80, "shadow", Bits(_COUNT_BITS),
             "Views that a start makes, of one raw frame, from 1 on."),
    _action("VIEWS_STATE", 0x81, "",
            Flag("MAX", 0xF, "ro", "most views that a start makes; 0: there is no list of views"),
            Flag("DONE", 0xF00, "ro", "views that have ended, one that was aborted too, of the "
                 "start that runs, or of the last one"), access="ro"))
_POSITION = (
    Register(OFFSET, 0, "shadow", Bits(ADDRESS_BITS), "bytes from `TARGET_BASE` to its first "
             "pixel, a multiple of the memory word"),
    Register(PITCH, 0, "shadow", Bits(PITCH_BITS), "bytes from row to row, a multiple of the "
             "memory word and no less than a row; 0: rows follow without a gap"))
_ROWS = 0x88              # word address of what controls the table of matrices
_VIEW_ROWS = (
    Register(ROWS_COUNT, _ROWS, "shadow", Bits(MAX_MATRICES.bit_length()),
             "Rolling shutter: matrices of the table that are in use, at most `LIMIT`. "
             "0: none, the view's matrix is that of all rows."),
    Register(ROWS_STEP, _ROWS + 1, "shadow", Bits((len(STEPS) - 1).bit_length()),
             "Rolling shutter: raw rows from matrix to matrix; "
             + ", ".join(f"{k}: {step}" for k, step in enumerate(STEPS)) + "."),
    Register(ROWS_BANK, _ROWS + 2, "shadow", Bits(1),
             "Rolling shutter: bank of the table that frames use."),
    _action(ROWS_STATUS, _ROWS + 3, "",
            Flag("LIMIT", 0x7F, "ro", "matrices that this instance has space for"),
            Flag("BANK", 0x80, "ro", "bank of the table in use"), access="ro"))
_HIDDEN, _OUTPUT, _OUTPUT_BIAS, SKIP = 0x100, 0x200, 0x280, 0x284


def network_registers(hidden_neurons, formats):
    """The registers of the network's weights and biases, by ascending address."""
    hidden = (("WEIGHT_X", ("weights", 0), formats.hidden_weight),
              ("WEIGHT_Y", ("weights", 1), formats.hidden_weight),
              ("BIAS", ("bias",), formats.hidden_bias))
    rows = [_numbered("HIDDEN{}_" + name, "Hidden neuron {}, " + f"{q}.", j, _HIDDEN + 4 * j + k, q,
                      ("hidden", j, *position))
            for j in range(hidden_neurons) for k, (name, position, q) in enumerate(hidden)]
    q = formats.output_weight
    rows += [_numbered(f"OUTPUT_{axis}_WEIGHT" + "{}", "Weight of hidden neuron {} in output "
                       f"{axis.lower()}', pixels, {q}.", j, _OUTPUT + 4 * j + k, q,
                       ("output", k, "weights", j))
             for j in range(hidden_neurons) for k, axis in enumerate("XY")]
    q = formats.output_bias
    rows += [Register(f"OUTPUT_{axis}_BIAS", _OUTPUT_BIAS + k, "shadow", Bits(q.width, signed=True),
                      f"Bias of output {axis.lower()}', pixels, {q}.",
                      parameter=("output", k, "bias"))
             for k, axis in enumerate("XY")]
    if (q := formats.skip_weight) is not None:
        rows += [Register(f"SKIP_{axis}_WEIGHT_{name}", SKIP + 2 * k + j, "shadow",
                          Bits(q.width, signed=True),
                          f"Weight of input {name.lower()} in output {axis.lower()}', pixels, "
                          f"{q}; only with a skip path.", parameter=("output", k, "skip", j))
                 for k, axis in enumerate("XY") for j, name in enumerate("XY")]
    return tuple(rows)


def _numbered(name, text, j, address, q, parameter):
    """The register of the hidden neuron ``j``, which is filled in ``name`` and ``text``."""
    return Register(name.format(j), address, "shadow", Bits(q.width, signed=True), text.format(j),
                    parameter=parameter, family=(name.format("j"), text.format("j")))


def _list_registers(views):
    """The number of ``views``, and the registers of as many entries."""
    rows = {row.name: row for row in (*_FIXED, *_VIEWS, *_POSITION)}
    for k in range(views):
        for number, (word, name) in enumerate(ENTRY_WORDS.items()):
            text = "View {}: " + (rows[name].text if name in (OFFSET, PITCH) else f"its `{name}`")
            yield Register(entry_register(k, word), VIEW_LIST + 16 * k + number, "shadow",
                           rows[name].shape, text.format(k) + ".",
                           family=(entry_register("j", word), text.format("j") + "."))


def listed(table):
    """The registers of ``table`` that the list of views holds: those of its entries, and those of
    the set that are entry 0. None without a list."""
    entries = [row for row in table if VIEW_LIST <= row.address < VIEW_LIST + 16 * MAX_VIEWS]
    return [row for row in table if row.name in ENTRY_WORDS.values()] + entries if entries else []


def registers(hidden_neurons, formats, nodes=1, colour=False, raw_balance=False, view=False,
              views=0, view_rows=0):
    """All registers of an instance, by ascending address."""
    optional = (*(_COLOUR if colour else ()), *(_RAW_GAINS if raw_balance else ()),
                *(_VIEWS if view else ()), *(_LIST_CONTROL if views else ()),
                *(_VIEW_ROWS if view_rows else ()))
    return (*_FIXED, *([_NODES] if nodes > 1 else []),
            *sorted(optional, key=lambda row: row.address),
            *network_registers(hidden_neurons, formats), *_list_registers(views))


def absent(table, hardware):
    """Names of the registers of ``table`` that ``hardware`` leaves out: constants of its
    configuration, or counters. They read 0, and writes to them are ignored."""
    names = set() if hardware.counters else set(COUNTERS)
    if hardware.fixed_lens:
        names |= {"VALID_WINDOW"} | {row.name for row in table if row.access == "shadow"
                                     and row.name not in _WITH_FIXED_LENS}
    return frozenset(names if hardware.follow else names | {"FOLLOW"})


def counters(table):
    """The registers of ``table`` that count, as opposed to read-only constants."""
    return tuple(r for r in table if r.name in (*COUNTERS, *COLOUR_COUNTERS, "FRAMES"))


def capabilities(hardware, width, height, capture=False):
    """Values of CAPABILITIES and LARGEST, and of VIEW_ROWS_STATUS if there is such, by name.

    Parameters
    ----------
    hardware : ncdc_spec.hardware.Hardware
        Made for a camera.
    width, height : int
        Size of the largest corrected image.
    capture : bool
        Whether it belongs to a system with a camera's capture.
    """
    split = hardware.cache.max_split if hardware.cached else 0
    interpolation = hardware.cache.interpolation if hardware.cached else FAST
    return {"CAPABILITIES": VERSION | hardware.stream << 8 | hardware.cached << 9
            | INTERPOLATION_BITS[interpolation.name] | hardware.lanes << 12
            | hardware.colour << 15 | hardware.data_width // 8 << 16
            | hardware.raw_balance << 22 | capture << 23 | split << 24
            | (VIEW_BIT if hardware.view else 0)
            | (FIXED_LENS_BIT if hardware.fixed_lens else 0)
            | (0 if hardware.follow else NO_FOLLOW_BIT)
            | (0 if hardware.counters else NO_COUNTERS_BIT),
            "LARGEST": width | height << 16,
            **({ROWS_STATUS: hardware.view_rows} if hardware.view_rows else {})}
