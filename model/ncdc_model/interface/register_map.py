"""The registers, declared once: gateware, host software and documentation read this table."""

from dataclasses import dataclass

from ncdc_model.geometry import MAX_SIZE, MIN_SIZE, SCAN, STRIP_UNIT
from ncdc_model.interface.frames import ADDRESS_BITS

__all__ = ["ADDRESS_WORDS_BITS", "Bits", "CONSTANTS", "COUNTERS", "CTRL_ABORT", "CTRL_COMMIT",
           "CTRL_START", "Flag", "ID", "NODES", "Register", "SKIP", "STATUS_ABORTED", "STATUS_BANK",
           "STATUS_BUSY", "STATUS_COMMITTED", "STATUS_DONE", "STATUS_PENDING", "STATUS_REFUSED",
           "TABLE", "counters", "network_registers", "registers"]

ADDRESS_WORDS_BITS = 14
TABLE = 1 << 13           # word address of the window on the table of valid rows
ID = 0x4E434443           # "NCDC"

CONSTANTS = ("ID", "DIGEST", "NEURONS", "NODES")     # of an instance

CTRL_START, CTRL_COMMIT, CTRL_ABORT = 1, 2, 4
STATUS_BUSY, STATUS_DONE, STATUS_PENDING = 1, 2, 4
STATUS_COMMITTED, STATUS_REFUSED, STATUS_BANK, STATUS_ABORTED = 8, 16, 32, 64

# Counted while a frame runs; FRAMES beside them counts frames.
COUNTERS = ("CLOCKS", "PIXELS", "FETCHES", "FRONT_END_STALLS", "SINK_STALLS", "DATA_STALLS",
            "INTERLOCK_STALLS", "CREDIT_STALLS", "PENDING_STALLS")


@dataclass(frozen=True)
class Bits:
    """A number of ``width`` bits, a two's complement one if ``signed``."""
    width: int
    signed: bool = False


_SIZE = Bits(MAX_SIZE.bit_length())


@dataclass(frozen=True)
class Flag:
    """One bit of an "action" register.

    Parameters
    ----------
    name : str
    mask : int
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
        """Number of the bit."""
        return self.mask.bit_length() - 1


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
        Bits that are kept; a signed value is sign-extended on reading.
    text : str
    flags : tuple of Flag
        Of an "action" register.
    parameter : tuple
        Of a register of the network, where its value stands in it: layer ("hidden", "output"),
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


def _action(name, address, text, *flags):
    return Register(name, address, "action", Bits(max(flag.bit for flag in flags) + 1), text,
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
                 "a write was ignored that would have changed a committed set or valid rows in "
                 "use"),
            Flag("BANK", STATUS_BANK, "ro", "bank of the valid rows in use"),
            Flag("ABORTED", STATUS_ABORTED, "ro",
                 "the last frame lacks pixels: it was aborted, or its width or height is 0")),
    Register("IRQ_ENABLE", 0x05, "rw", Bits(1), "irq follows STATUS.DONE."),
    Register("VALID_WINDOW", 0x06, "rw", Bits(1),
             "Bank of the valid rows that the table window reads and writes."),
    Register("VALID_BANK", 0x07, "shadow", Bits(1), "Bank of the valid rows that frames use."),
    Register("SOURCE_BASE", 0x08, "shadow", Bits(ADDRESS_BITS),
             "Byte address of the raw frame, a multiple of the memory word."),
    Register("SOURCE_PITCH", 0x09, "shadow", _SIZE,
             "Bytes from row to row of the raw frame, a multiple of the memory word, below 8192."),
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
    Register("BAYER_PHASE", 0x14, "shadow", Bits(2),
             "Parity of the column (bit 0) and the row (bit 1) of the red samples."),
    Register("FILL", 0x15, "shadow", Bits(24),
             "Colour of pixels without a source, 0xRRGGBB."),
    Register("CACHE_SPLIT", 0x16, "shadow", Bits(4),
             "Cache fetcher: log2 of the tile pairs along a row that have sets of their own."),
    Register("STRIP_WIDTH", 0x17, "shadow", _SIZE,
             f"Columns of a strip, a multiple of {STRIP_UNIT}; 0: raster. "
             "A stream is always a raster."),
    Register("CLOCKS", 0x18, "ro", Bits(32), "Clocks of the last frame, start to last pixel."),
    Register("PIXELS", 0x19, "ro", Bits(32), "Pixels of the last frame."),
    Register("FETCHES", 0x1A, "ro", Bits(32), "Windows (multiport), or tiles of 16x4 (cache), "
             "that the last frame read from memory."),
    Register("FRONT_END_STALLS", 0x1B, "ro", Bits(32),
             "Clocks in which the last frame's front end waited for room behind it."),
    Register("FRAMES", 0x1C, "ro", Bits(32), "Frames completed since reset."),
    Register("SINK_STALLS", 0x1D, "ro", Bits(32),
             "Clocks in which a corrected pixel of the last frame waited for writer or stream."),
    Register("DATA_STALLS", 0x1E, "ro", Bits(32),
             "Clocks in which the last frame's oldest window waited for the memory."),
    Register("INTERLOCK_STALLS", 0x1F, "ro", Bits(32),
             "Cache fetcher: clocks in which a missing tile waited for the place of one in use."),
    Register("CREDIT_STALLS", 0x20, "ro", Bits(32),
             "Cache fetcher: clocks in which a missing tile waited because as many as allowed were "
             "under way."),
    Register("PENDING_STALLS", 0x21, "ro", Bits(32),
             "Cache fetcher: clocks in which a window waited because as many as allowed were "
             "pending."),
)
NODES = 0x30
_NODES = Register("NODES", NODES, "ro", Bits(6),
                  "Pixels from node to node; an instance whose network is evaluated at every pixel "
                  "has no such register and reads 0.")
_HIDDEN, _OUTPUT, _OUTPUT_BIAS, SKIP = 0x100, 0x200, 0x280, 0x284


def network_registers(hidden_neurons, formats):
    """The registers of the network's weights and biases, by ascending address."""
    hidden = (("WEIGHT_X", ("weights", 0), formats.hidden_weight),
              ("WEIGHT_Y", ("weights", 1), formats.hidden_weight),
              ("BIAS", ("bias",), formats.hidden_bias))
    rows = [_numbered("HIDDEN{}_" + name, "Hidden neuron {}, " + f"{q}.", j, _HIDDEN + 4 * j + k, q,
                      ("hidden", j, *place))
            for j in range(hidden_neurons) for k, (name, place, q) in enumerate(hidden)]
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
    """The register of the hidden neuron ``j`` whose ``name`` and ``text`` leave a place for it."""
    return Register(name.format(j), address, "shadow", Bits(q.width, signed=True), text.format(j),
                    parameter=parameter, family=(name.format("j"), text.format("j")))


def registers(hidden_neurons, formats, nodes=1):
    """All registers of an instance, by ascending address."""
    return (*_FIXED, *([_NODES] if nodes > 1 else []), *network_registers(hidden_neurons, formats))


def counters(table):
    """The registers of ``table`` that count, as opposed to read-only constants."""
    return tuple(r for r in table if r.access == "ro" and r.name not in CONSTANTS)
