"""GVCP's commands and statuses with what their payloads hold, for the documentation."""

from dataclasses import dataclass

from ncdc_spec.protocols import gvcp

__all__ = ["COMMANDS", "STATUSES", "Message", "Status"]


@dataclass(frozen=True)
class Message:
    """A command: its code, and the fields of its payload and of its answer's.

    A field is (bytes, text); the bytes are 0 where the field fills the rest.
    """
    name: str
    code: int
    request: tuple
    answer: tuple | None


@dataclass(frozen=True)
class Status:
    """A status of an acknowledge or of a packet of a stream."""
    name: str
    code: int
    text: str


_NOTHING = (2, "0")

COMMANDS = (
    Message("DISCOVERY", gvcp.DISCOVERY, (), (
        (gvcp.DISCOVERY_BYTES, "the memory from address 0 on"),)),
    Message("FORCEIP", gvcp.FORCEIP, (
        _NOTHING, (6, "MAC"), (12, "0"), (4, "IPv4 address"), (12, "0"), (4, "mask"),
        (12, "0"), (4, "gateway")), ()),
    Message("PACKETRESEND", gvcp.PACKETRESEND, (
        _NOTHING, (2, "block"), (4, "first packet, bits 23..0"), (4, "last packet, bits 23..0")),
        None),
    Message("READREG", gvcp.READREG, ((0, "addresses of 4 bytes"),), ((0, "words of 4 bytes"),)),
    Message("WRITEREG", gvcp.WRITEREG, ((0, "pairs of address and word, 4 bytes each"),), (
        _NOTHING, (2, "number of words that were written"))),
    Message("READMEM", gvcp.READMEM, ((4, "address"), _NOTHING, (2, "number of bytes")), (
        (4, "address"), (0, "the bytes"))),
    Message("WRITEMEM", gvcp.WRITEMEM, ((4, "address"), (0, "the bytes")), (
        _NOTHING, (2, "number of bytes that were written"))),
)

STATUSES = (
    Status("SUCCESS", gvcp.SUCCESS, ""),
    Status("NOT_IMPLEMENTED", gvcp.NOT_IMPLEMENTED, "no such command"),
    Status("INVALID_PARAMETER", gvcp.INVALID_PARAMETER, "a value outside the limits"),
    Status("INVALID_ADDRESS", gvcp.INVALID_ADDRESS, "nothing is at the address"),
    Status("WRITE_PROTECT", gvcp.WRITE_PROTECT, "the register is read-only"),
    Status("BAD_ALIGNMENT", gvcp.BAD_ALIGNMENT, "address or count is no multiple of 4"),
    Status("ACCESS_DENIED", gvcp.ACCESS_DENIED, "the sender has no control; a feature is locked; "
           "no receiver that is allowed"),
    Status("BUSY", gvcp.BUSY, "the sensor's bus works for another command"),
    Status("INVALID_HEADER", gvcp.INVALID_HEADER, "the payload's length does not fit the command"),
    Status("DEVICE_ERROR", gvcp.DEVICE_ERROR, "the sensor does not answer"),
)
