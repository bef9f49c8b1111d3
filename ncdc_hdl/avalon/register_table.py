"""The registers, declared once: gateware, host software and documentation read this table."""

from dataclasses import dataclass

from amaranth import signed, unsigned

from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.backend.packer import PIXEL_BYTES
from ncdc_model.fetch.cache_options import CacheOptions
from ncdc_model.geometry import MAX_SIZE, MIN_SIZE, SCAN, STRIP_UNIT

__all__ = ["ADDRESS_WORDS_BITS", "CONSTANTS", "CTRL_ABORT", "CTRL_COMMIT", "CTRL_START", "Flag",
           "ID", "Register", "SKIP", "STATUS_ABORTED", "STATUS_BANK", "STATUS_BUSY",
           "STATUS_COMMITTED", "STATUS_DONE", "STATUS_PENDING", "STATUS_REFUSED",
           "TABLE", "counters", "frame_bytes", "host_values", "network_values",
           "registers", "table_words"]

ADDRESS_WORDS_BITS = 14
TABLE = 1 << 13           # word address of the window on the table of valid rows
ID = 0x4E434443           # "NCDC"

CONSTANTS = ("ID", "DIGEST", "NEURONS")      # of an instance

CTRL_START, CTRL_COMMIT, CTRL_ABORT = 1, 2, 4
STATUS_BUSY, STATUS_DONE, STATUS_PENDING = 1, 2, 4
STATUS_COMMITTED, STATUS_REFUSED, STATUS_BANK, STATUS_ABORTED = 8, 16, 32, 64

_SIZE = unsigned(MAX_SIZE.bit_length())


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
    shape : Shape
        Bits that are kept; a signed value is sign-extended on reading.
    text : str
    flags : tuple of Flag
        Of an "action" register.
    """
    name: str
    address: int
    access: str
    shape: object
    text: str
    flags: tuple = ()


def _action(name, address, text, *flags):
    return Register(name, address, "action", unsigned(max(flag.bit for flag in flags) + 1), text,
                    flags)


_FIXED = (
    Register("ID", 0x00, "ro", unsigned(32), "Constant 0x4E434443, \"NCDC\"."),
    Register("DIGEST", 0x01, "ro", unsigned(32),
             "First 32 bits of the hash of the descriptor that the reset values are from."),
    Register("NEURONS", 0x02, "ro", unsigned(6), "Hidden neurons of this instance."),
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
                 "a write was ignored that would have changed a committed set or valid rows in use"),
            Flag("BANK", STATUS_BANK, "ro", "bank of the valid rows in use"),
            Flag("ABORTED", STATUS_ABORTED, "ro",
                 "the last frame lacks pixels: it was aborted, or its width or height is 0")),
    Register("IRQ_ENABLE", 0x05, "rw", unsigned(1), "irq follows STATUS.DONE."),
    Register("VALID_WINDOW", 0x06, "rw", unsigned(1),
             "Bank of the valid rows that the table window reads and writes."),
    Register("VALID_BANK", 0x07, "shadow", unsigned(1), "Bank of the valid rows that frames use."),
    Register("SOURCE_BASE", 0x08, "shadow", unsigned(ADDRESS_BITS),
             "Byte address of the raw frame, a multiple of the memory word."),
    Register("SOURCE_PITCH", 0x09, "shadow", _SIZE,
             "Bytes from row to row of the raw frame, a multiple of the memory word, below 8192."),
    Register("TARGET_BASE", 0x0A, "shadow", unsigned(ADDRESS_BITS),
             "Byte address of the corrected frame, a multiple of the memory word."),
    Register("CORRECTED_WIDTH", 0x0B, "shadow", _SIZE, f"Corrected image, pixels per row, {MIN_SIZE}..{MAX_SIZE}."),
    Register("CORRECTED_HEIGHT", 0x0C, "shadow", _SIZE, f"Corrected image, rows, {MIN_SIZE}..{MAX_SIZE}."),
    Register("DISTORTED_WIDTH", 0x0D, "shadow", _SIZE, f"Raw frame, samples per row, {MIN_SIZE}..{MAX_SIZE}."),
    Register("DISTORTED_HEIGHT", 0x0E, "shadow", _SIZE, f"Raw frame, rows, {MIN_SIZE}..{MAX_SIZE}."),
    Register("FOLLOW", 0x0F, "shadow", unsigned(1),
             "1: a pixel waits until `camera_rows` says that its raw rows are in memory; 0: the raw "
             "frame is complete when a frame begins."),
    Register("SCAN_ORIGIN_X", 0x10, "shadow", signed(SCAN.width),
             f"Normalised x of the first column, {SCAN}."),
    Register("SCAN_STEP_X", 0x11, "shadow", signed(SCAN.width),
             f"Normalised distance of two columns, {SCAN}."),
    Register("SCAN_ORIGIN_Y", 0x12, "shadow", signed(SCAN.width),
             f"Normalised y of the first row, {SCAN}."),
    Register("SCAN_STEP_Y", 0x13, "shadow", signed(SCAN.width),
             f"Normalised distance of two rows, {SCAN}."),
    Register("BAYER_PHASE", 0x14, "shadow", unsigned(2),
             "Parity of the column (bit 0) and the row (bit 1) of the red samples."),
    Register("FILL", 0x15, "shadow", unsigned(24),
             "Colour of pixels without a source, 0xRRGGBB."),
    Register("CACHE_SPLIT", 0x16, "shadow", unsigned(4),
             "Cache fetcher: log2 of the tile pairs along a row that have sets of their own."),
    Register("STRIP_WIDTH", 0x17, "shadow", _SIZE,
             f"Columns of a strip, a multiple of {STRIP_UNIT}; 0: raster. "
             "A stream is always a raster."),
    Register("CLOCKS", 0x18, "ro", unsigned(32), "Clocks of the last frame, start to last pixel."),
    Register("PIXELS", 0x19, "ro", unsigned(32), "Pixels of the last frame."),
    Register("FETCHES", 0x1A, "ro", unsigned(32), "Windows (multiport), or tiles of 16x4 (cache), "
             "that the last frame read from memory."),
    Register("FRONT_END_STALLS", 0x1B, "ro", unsigned(32),
             "Clocks in which the last frame's front end waited for room behind it."),
    Register("FRAMES", 0x1C, "ro", unsigned(32), "Frames completed since reset."),
    Register("SINK_STALLS", 0x1D, "ro", unsigned(32),
             "Clocks in which a corrected pixel of the last frame waited for writer or stream."),
    Register("DATA_STALLS", 0x1E, "ro", unsigned(32),
             "Clocks in which the last frame's oldest window waited for the memory."),
    Register("INTERLOCK_STALLS", 0x1F, "ro", unsigned(32),
             "Cache fetcher: clocks in which a missing tile waited for the place of one in use."),
    Register("CREDIT_STALLS", 0x20, "ro", unsigned(32),
             "Cache fetcher: clocks in which a missing tile waited because as many as allowed were "
             "under way."),
    Register("PENDING_STALLS", 0x21, "ro", unsigned(32),
             "Cache fetcher: clocks in which a window waited because as many as allowed were "
             "pending."),
)
_HIDDEN, _OUTPUT, _OUTPUT_BIAS, SKIP = 0x100, 0x200, 0x280, 0x284


def registers(hidden_neurons, formats):
    """All registers of an instance, by ascending address."""
    rows = list(_FIXED)
    for j in range(hidden_neurons):
        for k, (part, q) in enumerate((("WEIGHT_X", formats.hidden_weight),
                                       ("WEIGHT_Y", formats.hidden_weight),
                                       ("BIAS", formats.hidden_bias))):
            rows.append(Register(f"HIDDEN{j}_{part}", _HIDDEN + 4 * j + k, "shadow",
                                 signed(q.width), f"Hidden neuron {j}, {q}."))
    for j in range(hidden_neurons):
        for k, axis in enumerate("XY"):
            rows.append(Register(f"OUTPUT_{axis}_WEIGHT{j}", _OUTPUT + 4 * j + k, "shadow",
                                 signed(formats.output_weight.width),
                                 f"Weight of hidden neuron {j} in output {axis.lower()}', "
                                 f"pixels, {formats.output_weight}."))
    for k, axis in enumerate("XY"):
        rows.append(Register(f"OUTPUT_{axis}_BIAS", _OUTPUT_BIAS + k, "shadow",
                             signed(formats.output_bias.width),
                             f"Bias of output {axis.lower()}', pixels, {formats.output_bias}."))
    if formats.skip_weight is not None:
        rows += [Register(f"SKIP_{axis}_WEIGHT_{name}", SKIP + 2 * k + j, "shadow",
                          signed(formats.skip_weight.width),
                          f"Weight of input {name.lower()} in output {axis.lower()}', pixels, "
                          f"{formats.skip_weight}; only with a skip path.")
                 for k, axis in enumerate("XY") for j, name in enumerate("XY")]
    return tuple(rows)


def counters(table):
    """The registers of ``table`` that count, as opposed to read-only constants."""
    return tuple(r for r in table if r.access == "ro" and r.name not in CONSTANTS)


def network_values(descriptor):
    """Register values, by name, of the network of ``descriptor``."""
    values = {}
    for j in range(descriptor.hidden_neurons):
        values[f"HIDDEN{j}_WEIGHT_X"], values[f"HIDDEN{j}_WEIGHT_Y"] = (
            int(w) for w in descriptor.hidden_weights[j])
        values[f"HIDDEN{j}_BIAS"] = int(descriptor.hidden_biases[j])
        for k, axis in enumerate("XY"):
            values[f"OUTPUT_{axis}_WEIGHT{j}"] = int(descriptor.output_weights[k, j])
    for k, axis in enumerate("XY"):
        values[f"OUTPUT_{axis}_BIAS"] = int(descriptor.output_biases[k])
        if descriptor.skip_weights is not None:
            for j, name in enumerate("XY"):
                values[f"SKIP_{axis}_WEIGHT_{name}"] = int(descriptor.skip_weights[k, j])
    return values


def host_values(descriptor, data_width, split=None, strip=0, follow=False):
    """Register values, by name, that a host writes to correct frames of ``descriptor``'s camera:
    network, geometry, and a raw frame at address 0 with the corrected frame behind it.

    ``split``: of the cache; that of :meth:`CacheOptions.for_width` if absent. ``strip``: columns
    of a strip, 0 for a raster. ``follow``: begin before the raw frame is complete."""
    g = descriptor.geometry
    if split is None:
        split = CacheOptions.for_width(g.distorted_width).split_for(g.distorted_width)
    word = data_width // 8
    pitch = -(-g.distorted_width // word) * word
    origin_x, step_x, origin_y, step_y = g.scan()
    red, green, blue = g.fill
    return {
        **network_values(descriptor),
        "VALID_BANK": 0,
        "SOURCE_BASE": 0, "SOURCE_PITCH": pitch,
        "TARGET_BASE": -(-pitch * g.distorted_height // 4096) * 4096,
        "CORRECTED_WIDTH": g.corrected_width, "CORRECTED_HEIGHT": g.corrected_height,
        "DISTORTED_WIDTH": g.distorted_width, "DISTORTED_HEIGHT": g.distorted_height,
        "SCAN_ORIGIN_X": origin_x, "SCAN_STEP_X": step_x,
        "SCAN_ORIGIN_Y": origin_y, "SCAN_STEP_Y": step_y,
        "BAYER_PHASE": g.phase[0] | g.phase[1] << 1,
        "FILL": red << 16 | green << 8 | blue,
        "CACHE_SPLIT": split, "STRIP_WIDTH": strip, "FOLLOW": int(follow),
    }


def frame_bytes(geometry):
    """Bytes of a corrected frame in memory."""
    return geometry.corrected_width * geometry.corrected_height * PIXEL_BYTES


def table_words(valid):
    """(word address, value) of every entry of the table of valid rows."""
    return [(TABLE + 2 * row + k, spans[2 * k] | spans[2 * k + 1] << 16)
            for row, spans in enumerate(valid.spans.tolist()) for k in range(2)]
