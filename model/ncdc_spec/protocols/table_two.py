"""Table II of the paper: the MRAW package, a picture with a header of 28 bytes, big endian."""

from dataclasses import dataclass
from ipaddress import IPv4Address

from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.pixel_formats import PixelFormat, format_of_mraw
from ncdc_spec.protocols.table_users import mraw_header

__all__ = ["FIELDS", "Field", "HEADER_BYTES", "MRAW_BYTES_MAX", "MrawHeader"]


@dataclass(frozen=True)
class Field:
    """A row of Table II as printed: packet structure, length in bytes, description."""
    name: str
    length: int
    text: str


FIELDS = (
    Field("Width", 4, "Image width."),
    Field("Height", 4, "Image height."),
    Field("Formation", 1, "Image formation."),
    Field("Size", 7, "Image size."),
    Field("Socket IP", 4, "Ethernet IP of verification system."),
    Field("Socket Port", 4, "Ethernet port of verification system."),
    Field("Capture time", 4, "Capture time from camera subsystem."),
)
HEADER_BYTES = sum(field.length for field in FIELDS)
MRAW_BYTES_MAX = MAX_SIZE * MAX_SIZE * 4        # of the largest picture there is


@dataclass(frozen=True)
class MrawHeader:
    """The header of an MRAW package.

    Parameters
    ----------
    width, height : int
        Pixels.
    pixel_format : PixelFormat
    address : str
        IPv4 address of the device.
    port : int
        TCP port of the device.
    time_us : int
        Microseconds from the device's reset to the capture, modulo 2**32.

    Raises
    ------
    InputError
        If a side is outside 1..4096 or the port outside 0..65535.
    """
    width: int
    height: int
    pixel_format: PixelFormat
    address: str
    port: int
    time_us: int

    def __post_init__(self):
        for name in ("width", "height"):
            if not 1 <= getattr(self, name) <= MAX_SIZE:
                raise InputError(f"the MRAW package has the {name} {getattr(self, name)}, the "
                                 f"limits are 1 and {MAX_SIZE}")
        if not 0 <= self.port <= 0xFFFF:
            raise InputError(f"the MRAW package has the port {self.port}, the limits are 0 and "
                             "65535")

    @property
    def size(self):
        """Bytes of the picture that follows."""
        return self.width * self.height * self.pixel_format.pixel_bytes

    def pack(self):
        """The header as :data:`HEADER_BYTES` bytes."""
        return mraw_header((self.width, self.height, self.pixel_format.mraw, self.size,
                            int(IPv4Address(self.address)), self.port,
                            self.time_us & 0xFFFFFFFF))

    @classmethod
    def unpack(cls, data):
        """The header in :data:`HEADER_BYTES` bytes.

        Raises
        ------
        InputError
            If it is cut, the formation is unknown, a limit is broken, or the size is not that of
            the picture: nothing is ever received on the word of a size alone.
        """
        if len(data) != HEADER_BYTES:
            raise InputError(f"the MRAW package's header has {len(data)} bytes, {HEADER_BYTES} "
                             "are needed")
        values, at = [], 0
        for field in FIELDS:
            values.append(int.from_bytes(data[at:at + field.length], "big"))
            at += field.length
        width, height, formation, size, address, port, time_us = values
        header = cls(width, height, format_of_mraw(formation), str(IPv4Address(address)), port,
                     time_us)
        if size != header.size:
            raise InputError(f"the MRAW package says {size} bytes, a picture of {width}x{height} "
                             f"{header.pixel_format.name} has {header.size}")
        return header
