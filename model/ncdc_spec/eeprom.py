"""The image of a camera's EEPROM: its network, geometry and valid rows, with a checksum.

The layout is described here and in docs/reference/eeprom.md only; the C driver's ncdc_eeprom.c
reads it too. Numbers are little-endian.
"""

import struct
import zlib
from dataclasses import dataclass

import numpy as np

from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError, reading
from ncdc_spec.fixed import Q
from ncdc_spec.float_network import FloatNetwork
from ncdc_spec.formats import MAX_NEURONS, Formats
from ncdc_spec.geometry import BAYERS, Geometry, ValidRows
from ncdc_spec.interpolation import INTERPOLATIONS, interpolation_of
from ncdc_spec.registers.host_values import network_values
from ncdc_spec.registers.register_map import network_registers
from ncdc_spec.tansig import VARIANTS

__all__ = ["ERRORS", "EepromError", "Image", "LOADED", "MAGIC", "NO_CHIP", "SERIAL_BYTES",
           "STATES", "VERSION", "check_like", "kind_bytes", "pack", "start", "unpack"]

MAGIC, VERSION = b"NCDE", 1
SERIAL_BYTES = 32       # ASCII, filled up with zeros
# Magic, version, neurons, flags (bit 0: skip path), filter pattern, length of the image,
# corrected width and height, distorted width and height, fill (blue first), a zero, digest,
# serial, kind.
_HEADER = struct.Struct("<4sBBBBHHHHH3sx6s32s22s")
_SKIP = 1
_CHECKSUM = 4           # bytes at the end: CRC-32 of all before, as zlib has it
_SPANS = 4              # numbers of a row: start, stop, start, stop

# Why an image is rejected: name in C, without NCDC_EEPROM_, and what it means.
ERRORS = {
    "EMPTY": "all bytes are equal: it was never written",
    "MAGIC": "it does not begin with NCDE",
    "VERSION": "its layout has another version",
    "LENGTH": "it is shorter or longer than it says",
    "CHECKSUM": "its checksum is wrong",
    "CONTENT": "it holds a value out of range",
    "NEURONS": "it has another number of hidden neurons",
    "SIZE": "it is of another size of picture",
    "KIND": "it has other number formats, grid points, interpolation or tan-sigmoid",
}

# What a device reports of its EEPROM, by position: that the lens is from it, or why it is not.
STATES = ("NoChip", "Loaded", *(name.capitalize() for name in ERRORS))
NO_CHIP, LOADED = 0, 1


class EepromError(InputError):
    """An image that is rejected; ``name`` is one of :data:`ERRORS`, ``state`` its number among
    :data:`STATES`."""

    def __init__(self, name, detail=""):
        super().__init__(f"the image is rejected: {ERRORS[name]}{detail and f' ({detail})'}")
        self.name = name
        self.state = STATES.index(name.capitalize())


@dataclass(frozen=True)
class Image:
    """Content of an EEPROM: the serial number, and the camera's descriptor.

    The descriptor's network before quantisation is that of the integers, and it has no errors.
    """
    serial: str
    descriptor: Descriptor


def kind_bytes(descriptor):
    """22 bytes that must be those of the hardware: what no register can change.

    Interpolation, distance of grid points, tan-sigmoid and its fraction bits, then integer and
    fraction bits of each format in the order of :class:`Formats`, zeros for none.
    """
    head = (list(INTERPOLATIONS).index(descriptor.geometry.interpolation.name), descriptor.nodes,
            list(VARIANTS).index(descriptor.variant), descriptor.tansig.fraction_bits)
    formats = [part for q in vars(descriptor.formats).values()
               for part in ((q.i_bits, q.f_bits) if q else (0, 0))]
    return struct.pack("<4B18b", *head, *formats)


def pack(serial, descriptor, neurons=None):
    """Bytes of the image of a camera.

    Parameters
    ----------
    serial : str
        Serial number, up to 32 printable characters of ASCII.
    descriptor : Descriptor
    neurons : int, optional
        Hidden neurons of the hardware; those that the network lacks have zeros.

    Raises
    ------
    InputError
        If the serial number does not fit, or the network has more neurons than the hardware, or the
        hardware more than there can be.
    """
    if not serial.isascii() or not serial.isprintable() or not 1 <= len(serial) <= SERIAL_BYTES:
        raise InputError(f"the serial number is {serial!r}, 1 up to {SERIAL_BYTES} characters of "
                         f"ASCII are needed")
    if neurons is not None and neurons > MAX_NEURONS:
        raise InputError(f"{neurons} hidden neurons are asked for, the maximum is {MAX_NEURONS}")
    g, values = descriptor.geometry, network_values(descriptor, neurons).values()
    rows = _packed_rows(descriptor.valid.spans)
    length = _HEADER.size + 4 * len(values) + len(rows) + _CHECKSUM
    header = _HEADER.pack(
        MAGIC, VERSION, neurons or descriptor.hidden_neurons,
        _SKIP if descriptor.skip_weights is not None else 0, BAYERS.index(g.bayer), length,
        *g.corrected, *g.distorted, bytes(g.fill[::-1]), bytes.fromhex(descriptor.digest),
        serial.encode(), kind_bytes(descriptor))
    content = header + b"".join(struct.pack("<i", value) for value in values) + rows
    return content + struct.pack("<I", zlib.crc32(content))


def unpack(content):
    """:class:`Image` of the bytes of an EEPROM, which may go on after the image.

    Raises
    ------
    EepromError
        If the image is damaged.
    """
    if not content.strip(content[:1]):
        raise EepromError("EMPTY")
    if content[:4] != MAGIC:
        raise EepromError("MAGIC")
    if content[4:5] != bytes([VERSION]):
        raise EepromError("VERSION", f"{content[4] if len(content) > 4 else 'none'}, {VERSION} is "
                                     f"needed")
    if len(content) < _HEADER.size:
        raise EepromError("LENGTH", f"{len(content)} bytes")
    (_, _, neurons, flags, bayer, length, *sizes, fill, digest, serial,
     kind) = _HEADER.unpack_from(content)
    if not _HEADER.size + _CHECKSUM <= length <= len(content):
        raise EepromError("LENGTH", f"{len(content)} bytes, it says {length}")
    content = content[:length]
    if struct.unpack("<I", content[-_CHECKSUM:])[0] != zlib.crc32(content[:-_CHECKSUM]):
        raise EepromError("CHECKSUM")
    try:
        if not 1 <= neurons <= MAX_NEURONS or flags & ~_SKIP:
            raise InputError(f"{neurons} neurons, flags {flags}")
        with reading("the image"):
            descriptor = _descriptor(content[_HEADER.size:-_CHECKSUM], neurons, kind,
                                     Geometry(*sizes, bayer=BAYERS[bayer], fill=tuple(fill[::-1]),
                                              interpolation=_named(INTERPOLATIONS, kind[0],
                                                                   interpolation_of)))
            if bool(flags) != (descriptor.skip_weights is not None):
                raise InputError("skip path")
            name = serial.rstrip(b"\0").decode("ascii")
            if not name.isprintable():
                raise InputError(f"the serial number {name!r}")
            return Image(name, descriptor)
    except (InputError, IndexError, struct.error) as error:
        raise EepromError("CONTENT", str(error)) from error


def check_like(image, descriptor):
    """Check that hardware made for ``descriptor`` can load an :class:`Image`.

    Raises
    ------
    EepromError
        If neurons, sizes of the pictures, or what :func:`kind_bytes` has differ.
    """
    own, needed = image.descriptor, descriptor
    for name, of in (("KIND", kind_bytes), ("NEURONS", lambda one: one.hidden_neurons),
                     ("SIZE", lambda one: (*one.geometry.corrected, *one.geometry.distorted))):
        if of(own) != of(needed):
            raise EepromError(name, "" if name == "KIND" else f"{of(own)}, {of(needed)} is needed")


def start(content, built_in):
    """What a device does at its start with the bytes of its EEPROM.

    Returns (:class:`Descriptor` that it loads, number among :data:`STATES`, text): the built-in
    one stays if the image is rejected, with the reason as text.
    """
    try:
        image = unpack(content)
        check_like(image, built_in)
    except EepromError as error:
        return built_in, error.state, str(error)
    return image.descriptor, LOADED, f"the lens of {image.serial}"


def _named(table, number, of):
    return of(list(table)[number])


def _descriptor(body, neurons, kind, geometry):
    """The :class:`Descriptor` of parameters and rows, ``body``, and of :func:`kind_bytes`."""
    _, nodes, variant, bits, *formats = struct.unpack("<4B18b", kind)
    names = list(Formats.__dataclass_fields__)
    formats = Formats(**{name: Q(*formats[2 * k:2 * k + 2]) if any(formats[2 * k:2 * k + 2])
                         else None for k, name in enumerate(names)})
    if formats.tansig.f_bits != bits + 1:
        raise InputError(f"{bits} fraction bits of the tan-sigmoid, its format is {formats.tansig}")
    registers = network_registers(neurons, formats)
    raw = {"hidden_weights": np.zeros((neurons, 2), np.int64),
           "hidden_biases": np.zeros(neurons, np.int64),
           "output_weights": np.zeros((2, neurons), np.int64),
           "output_biases": np.zeros(2, np.int64)}
    if formats.skip_weight:
        raw["skip_weights"] = np.zeros((2, 2), np.int64)
    values = struct.unpack_from(f"<{len(registers)}i", body)
    names = {"weights": "weights", "bias": "biases"}
    for register, value in zip(registers, values):
        layer, neuron, part, *weight = register.parameter
        array = raw["skip_weights" if part == "skip" else f"{layer}_{names[part]}"]
        array[(neuron, *weight)] = value
    real = {name: getattr(formats, _FORMAT[name]).real(array) for name, array in raw.items()}
    spans = _unpacked_rows(body[4 * len(registers):], geometry.corrected_height)
    return Descriptor(geometry=geometry, network=FloatNetwork(**real), **raw,
                      valid=ValidRows(spans), formats=formats, nodes=nodes,
                      variant=list(VARIANTS)[variant])


_FORMAT = {"hidden_weights": "hidden_weight", "hidden_biases": "hidden_bias",
           "output_weights": "output_weight", "output_biases": "output_bias",
           "skip_weights": "skip_weight"}


def _packed_rows(spans):
    """Bytes of valid rows (height, 4): of each group of equal rows the changes from the last one.

    A group has a byte, whose lower four bits name the numbers that change, its upper four the
    rows after the first one. Then comes the change of each: zigzag, seven bits a byte, lowest
    first, bit 7 set in all bytes but the last.
    """
    packed, last, row = bytearray(), np.zeros(_SPANS, np.int64), 0
    while row < len(spans):
        more = 0
        while more < 15 and row + more + 1 < len(spans) and (
                spans[row + more + 1] == spans[row]).all():
            more += 1
        changes = spans[row] - last
        packed.append(more << 4 | sum(1 << k for k in range(_SPANS) if changes[k]))
        for change in changes[changes != 0].tolist():
            number = 2 * change if change > 0 else -2 * change - 1
            while number > 0x7F:
                packed.append(0x80 | number & 0x7F)
                number >>= 7
            packed.append(number)
        last, row = spans[row], row + more + 1
    return bytes(packed)


def _unpacked_rows(packed, height):
    spans, last, at = [], [0] * _SPANS, 0
    while len(spans) < height:
        head, at = packed[at], at + 1
        for k in range(_SPANS):
            if head >> k & 1:
                number = shift = 0
                while True:
                    byte, at = packed[at], at + 1
                    number |= (byte & 0x7F) << shift
                    shift += 7
                    if byte < 0x80:
                        break
                    if shift > 14:
                        raise InputError("a valid row changes by more than 21 bits")
                last[k] += -(number + 1 >> 1) if number & 1 else number >> 1
        spans += [list(last)] * ((head >> 4) + 1)
    if len(spans) != height or at != len(packed):
        raise InputError(f"{len(spans)} valid rows and {len(packed) - at} bytes after them, "
                         f"{height} and none are needed")
    return np.array(spans, np.int64)
