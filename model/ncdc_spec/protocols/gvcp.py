"""GVCP: the control protocol, UDP port 3956, as far as devices and clients of ours speak it.

Written from what open implementations send and accept. All numbers are big endian.
"""

import struct
from dataclasses import dataclass

__all__ = ["ACCESS_DENIED", "BAD_ALIGNMENT", "BOOTSTRAP", "BUSY", "CAPABILITY", "CCP_CONTROL",
           "CCP_EXCLUSIVE", "CONFIGURATION_PENDING_ACK", "CORRECTOR_BASE", "CORRECTOR_BYTES",
           "DEVICE_ERROR", "Command", "DISCOVERY", "DISCOVERY_BYTES", "FEATURE_BASE", "FORCEIP",
           "FORCE_IP", "HEARTBEAT_MAX_MS", "HEARTBEAT_MIN_MS", "HEARTBEAT_MS", "INVALID_ADDRESS",
           "INVALID_HEADER", "INVALID_PARAMETER", "KEY", "MEMORY_BYTES_MAX", "NOT_IMPLEMENTED",
           "PACKETRESEND", "PENDING_ACK", "PENDING_MS", "PORT", "Register",
           "READMEM", "READREG", "REGISTERS_MAX", "SCPS_DO_NOT_FRAGMENT", "SCPS_FIRE", "SUCCESS",
           "WRITEMEM", "WRITEREG", "WRITE_PROTECT", "XML_BASE", "XML_NAME", "acknowledge",
           "command_packet", "parse_acknowledge", "parse_command", "pending_acknowledge",
           "register"]

PORT = 3956

# Commands; the acknowledge of each has the next code.
DISCOVERY, FORCEIP, PACKETRESEND = 0x0002, 0x0004, 0x0040
READREG, WRITEREG, READMEM, WRITEMEM = 0x0080, 0x0082, 0x0084, 0x0086
PENDING_ACK = 0x0089            # an acknowledge itself: "not yet, wait so many milliseconds"

SUCCESS = 0x0000
NOT_IMPLEMENTED, INVALID_PARAMETER, INVALID_ADDRESS = 0x8001, 0x8002, 0x8003
WRITE_PROTECT, BAD_ALIGNMENT, ACCESS_DENIED, BUSY = 0x8004, 0x8005, 0x8006, 0x8007
INVALID_HEADER, DEVICE_ERROR = 0x800E, 0x8FFE

KEY = 0x42                      # begins each command
_ANSWER = 0x01                  # flag: the sender wants an acknowledge
_COMMAND = struct.Struct(">BBHHH")      # key, flags, command, length, request
_ACKNOWLEDGE = struct.Struct(">HHHH")   # status, acknowledge, length, request

FORCE_IP = struct.Struct(">2xHI12xI12xI12xI")    # of FORCEIP: MAC; address, mask, gateway

MEMORY_BYTES_MAX = 536          # of READMEM and WRITEMEM
REGISTERS_MAX = 135             # of READREG; WRITEREG takes half as many

# Address space: bootstrap registers from 0, features, the XML, the corrector's own registers.
FEATURE_BASE = 0x1_0000
XML_BASE = 0x2_0000
XML_NAME = "ncdc.xml"
CORRECTOR_BASE = 0x10_0000
CORRECTOR_BYTES = 0x1_0000

CCP_EXCLUSIVE, CCP_CONTROL = 1, 2
HEARTBEAT_MS = 3000
HEARTBEAT_MIN_MS = 500
HEARTBEAT_MAX_MS = 30_000       # one datagram locks a device for no longer than this
SCPS_FIRE = 1 << 31             # write: send one test packet of the size in bits 15..0
SCPS_DO_NOT_FRAGMENT = 1 << 30

# A serial number; PENDING_ACK; PACKETRESEND; WRITEMEM.
CAPABILITY = 1 << 30 | 1 << 5 | 1 << 2 | 1 << 1
CONFIGURATION_PENDING_ACK = 1 << 1      # the controller understands PENDING_ACK
PENDING_MS = 1000               # that a device needs for a command at most

DISCOVERY_BYTES = 0xF8          # a discovery acknowledge: the bootstrap registers up to here


@dataclass(frozen=True)
class Register:
    """A bootstrap register.

    Parameters
    ----------
    name : str
    address : int
    length : int
        Bytes; 4, or more for a text, padded with zeros.
    access : str
        "rw" or "ro".
    text : str
    """
    name: str
    address: int
    length: int
    access: str
    text: str


BOOTSTRAP = (
    Register("Version", 0x0000, 4, "ro", "0x00010002: 1.2"),
    Register("DeviceMode", 0x0004, 4, "ro", "0x80000001: big endian, texts in UTF-8"),
    Register("MacHigh", 0x0008, 4, "ro", "MAC address, upper two bytes"),
    Register("MacLow", 0x000C, 4, "ro", "and lower four"),
    Register("IpOptions", 0x0010, 4, "ro", "ways to get an address: link-local, DHCP"),
    Register("IpConfiguration", 0x0014, 4, "ro", "the way in use"),
    Register("IpAddress", 0x0024, 4, "ro", "IPv4 address"),
    Register("SubnetMask", 0x0034, 4, "ro", "and mask of its net"),
    Register("Gateway", 0x0044, 4, "ro", "gateway; 0: none"),
    Register("DeviceVendorName", 0x0048, 32, "ro", "text"),
    Register("DeviceModelName", 0x0068, 32, "ro", "text"),
    Register("DeviceVersion", 0x0088, 32, "ro", "text"),
    Register("DeviceManufacturerInfo", 0x00A8, 48, "ro", "text"),
    Register("DeviceSerialNumber", 0x00D8, 16, "ro", "text"),
    Register("DeviceUserID", 0x00E8, 16, "ro", "text"),
    Register("FirstUrl", 0x0200, 512, "ro", "text: where the XML lies in the device's memory"),
    Register("SecondUrl", 0x0400, 512, "ro", "text: empty"),
    Register("NetworkInterfaces", 0x0600, 4, "ro", "1"),
    Register("MessageChannels", 0x0900, 4, "ro", "0"),
    Register("StreamChannels", 0x0904, 4, "ro", "1"),
    Register("Capability", 0x0934, 4, "ro", "serial number, PENDING_ACK, PACKETRESEND, "
             "WRITEMEM"),
    Register("HeartbeatTimeout", 0x0938, 4, "rw", "milliseconds without a command of the "
             "controller after which control is free again; what is "
             f"written is limited to {HEARTBEAT_MIN_MS} to {HEARTBEAT_MAX_MS}"),
    Register("TickFrequencyHigh", 0x093C, 4, "ro", "time stamp ticks per second, bits 63..32"),
    Register("TickFrequencyLow", 0x0940, 4, "ro", "and bits 31..0: 1,000,000,000"),
    Register("TimestampControl", 0x0944, 4, "rw", "bit 1: latch the time stamp"),
    Register("TimestampHigh", 0x0948, 4, "ro", "time stamp latched, bits 63..32"),
    Register("TimestampLow", 0x094C, 4, "ro", "and bits 31..0"),
    Register("Configuration", 0x0954, 4, "rw", "bit 1: the controller understands PENDING_ACK"),
    Register("PendingTimeout", 0x0958, 4, "ro", "milliseconds that a command needs at most: 1000"),
    Register("ControlPrivilege", 0x0A00, 4, "rw", "0 free, 1 exclusive access, 2 control"),
    Register("StreamPort", 0x0D00, 4, "rw", "UDP port of the receiver; 0: no stream"),
    Register("StreamPacketSize", 0x0D04, 4, "rw", "bytes of a packet with IP and UDP header, bits "
             "15..0; bit 30: do not fragment; writing bit 31 sends a test packet"),
    Register("StreamPacketDelay", 0x0D08, 4, "rw", "nanoseconds between two packets"),
    Register("StreamAddress", 0x0D18, 4, "rw", "IPv4 address of the receiver, or a multicast "
             "group"),
    Register("StreamSourcePort", 0x0D1C, 4, "ro", "UDP port that the stream comes from; of the "
             "emulated device 0 for whoever has no control"),
    Register("EepromStatus", 0xA000, 4, "ro", "feature of that name; the first of the addresses "
             "that are the manufacturer's"),
)
_BY_NAME = {register.name: register for register in BOOTSTRAP}


def register(name):
    """The bootstrap register of that name."""
    return _BY_NAME[name]


@dataclass(frozen=True)
class Command:
    """A command as received: its code, its request number, its payload, whether it is answered."""
    code: int
    request: int
    payload: bytes
    answered: bool = True


def command_packet(code, request, payload=b"", answered=True):
    """The bytes of a command."""
    return _COMMAND.pack(KEY, _ANSWER if answered else 0, code, len(payload), request) + payload


def parse_command(data):
    """The :class:`Command` in a datagram, None if it is none: a foreign key, a wrong length.

    The request number 0, which no client should use, is answered: Aravis asks with it for a device
    at a known address.
    """
    if len(data) < _COMMAND.size:
        return None
    key, flags, code, length, request = _COMMAND.unpack_from(data)
    if key != KEY or length != len(data) - _COMMAND.size:
        return None
    return Command(code, request, data[_COMMAND.size:], bool(flags & _ANSWER))


def acknowledge(command, status, payload=b""):
    """The bytes that answer ``command``."""
    return _ACKNOWLEDGE.pack(status, command.code + 1, len(payload), command.request) + payload


def pending_acknowledge(command):
    """The bytes of PENDING_ACK for ``command``: its answer comes later."""
    return _ACKNOWLEDGE.pack(SUCCESS, PENDING_ACK, 4, command.request) + struct.pack(
        ">I", PENDING_MS)


def parse_acknowledge(data):
    """(status, acknowledge code, request, payload) of a datagram, None if it is none."""
    if len(data) < _ACKNOWLEDGE.size:
        return None
    status, code, length, request = _ACKNOWLEDGE.unpack_from(data)
    if length != len(data) - _ACKNOWLEDGE.size:
        return None
    return status, code, request, data[_ACKNOWLEDGE.size:]
