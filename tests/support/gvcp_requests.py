"""Requests that every GVCP device of ours answers alike, in the order in which they are sent.

A request is (name, peer, datagram, what is compared). Peers: 0 and 1 are two programs of one
machine, 2 is another machine. Of most answers all is compared; of those that hold the device's own
address, texts or pictures the status and the length.
"""

import struct
from dataclasses import dataclass
from ipaddress import IPv4Address

from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.features import (
    AUTO_FEATURES,
    FEATURES,
    VIEW_FEATURES,
    VIEWS_FEATURES,
)

__all__ = ["PEERS", "Request", "requests"]

PEERS = (("10.77.0.1", 5000), ("10.77.0.1", 5001), ("10.77.0.2", 5000))
_CCP, _HEARTBEAT, _PORT, _ADDRESS, _SIZE, _DELAY = (gvcp.register(name).address for name in (
    "ControlPrivilege", "HeartbeatTimeout", "StreamPort", "StreamAddress", "StreamPacketSize",
    "StreamPacketDelay"))
# They differ from device to device, or with time.
_OWN = {row.address for row in gvcp.BOOTSTRAP if row.length > 4} | {
    gvcp.register(name).address for name in (
        "MacHigh", "MacLow", "IpAddress", "SubnetMask", "IpConfiguration", "TimestampHigh",
        "TimestampLow", "StreamSourcePort")}
_STATE = {"AcquisitionMode", "TriggerMode", "TriggerSelector", "TriggerSource", "TLParamsLocked",
          "SensorRegisterAddress", *AUTO_FEATURES, "BalanceRatioSelector", "BalanceRatio",
          *(one.name for one in VIEW_FEATURES)}
# The firmware's test has a sensor whose bus is always at work.
_BUS = {"SensorRegisterValue"}


@dataclass(frozen=True)
class Request:
    """What is sent by which peer, and whether the whole answer is compared."""
    name: str
    peer: int
    data: bytes
    whole: bool = True


class _List:
    """Requests, numbered as they are added."""
    def __init__(self):
        self.made = []

    def command(self, name, code, payload=b"", peer=0, whole=True, answered=True):
        number = len(self.made) % 65535 + 1
        self.made.append(Request(name, peer, gvcp.command_packet(code, number, payload, answered),
                                 whole))

    def raw(self, name, data, peer=0):
        self.made.append(Request(name, peer, data))

    def read(self, name, address, peer=0, whole=True):
        self.command(f"read {name}", gvcp.READREG, struct.pack(">I", address), peer, whole)

    def write(self, name, address, *values, peer=0):
        for value in values:
            self.command(f"write {name} {value:#x}", gvcp.WRITEREG,
                         struct.pack(">II", address, value), peer)


def requests():
    """The list of :class:`Request`."""
    made = _List()
    _nonsense(made)
    for peer in (0, 2):                         # no user has control
        _reads(made, peer)
        _writes(made, peer)
    _control(made)
    _headers(made)
    _limits(made)
    _views(made)
    _automatic(made)
    _acquisition(made)
    return made.made


def _addresses():
    """(name, address, whether its content is the same for all) of every register there is, and of
    some that are none."""
    rows = [(row.name, row.address, row.address not in _OWN) for row in gvcp.BOOTSTRAP]
    features = [(one.name, one.address, one.name in _STATE)
                for one in (*FEATURES, *VIEW_FEATURES)
                if one.address >= gvcp.FEATURE_BASE and one.name not in _BUS]
    after = max(one.address for one in VIEWS_FEATURES) + 4
    corrector = gvcp.CORRECTOR_BASE, gvcp.CORRECTOR_BYTES
    other = {
        "reserved word of discovery": (0x18, True), "word after discovery": (0xF8, True),
        "word before the URL": (0x1FC, True), "nothing": (0x700, True),
        "end of bootstrap": (0xFFFC, True), "before the features": (gvcp.FEATURE_BASE - 4, True),
        "after the features": (after, True), "before the XML": (gvcp.XML_BASE - 4, True),
        "XML": (gvcp.XML_BASE, False), "far after the XML": (gvcp.XML_BASE + 0xF_0000 // 2, True),
        "corrector": (corrector[0], False), "corrector's end": (sum(corrector) - 4, False),
        "after the corrector": (sum(corrector), True), "last word": (0xFFFF_FFFC, True)}
    return [*rows, *features, *((name, *rest) for name, rest in other.items())]


def _nonsense(made):
    """Datagrams that are no commands of ours."""
    good = gvcp.command_packet(gvcp.READREG, 9, bytes(4))
    made.raw("empty", b"")
    made.raw("half a header", good[:5])
    made.raw("foreign key", b"\x41" + good[1:])
    made.raw("too long", good + bytes(4))
    made.raw("too short", good[:-1])
    made.command("discovery", gvcp.DISCOVERY, whole=False)
    made.command("discovery with a payload", gvcp.DISCOVERY, bytes(4), whole=False)
    made.raw("read, number 0", gvcp.command_packet(gvcp.READREG, 0, bytes(8)))
    for code in (0, 1, 3, 5, 0x41, 0x42, 0x81, 0x83, 0x88, 0x89, 0x8A, 0xC0, 0x1234, 0xFFFE):
        made.command(f"code {code:#x}", code, bytes(4))
    made.command("read, no answer wanted", gvcp.READREG, bytes(4), answered=False)
    made.command("code 0xC0, no answer wanted", 0xC0, answered=False)


def _reads(made, peer):
    for name, address, whole in _addresses():
        made.read(name, address, peer, whole)
    for offset in (1, 2, 3):
        made.read(f"bootstrap + {offset}", offset, peer)
        made.read(f"features + {offset}", gvcp.FEATURE_BASE + offset, peer)
        made.read(f"nothing + {offset}", 0x700 + offset, peer)


def _writes(made, peer):
    """Without control: nothing may be learned of what is there."""
    for name, address, _ in _addresses():
        if name != "ControlPrivilege":
            made.write(name, address, 1, peer=peer)
    for offset in (1, 2, 3):
        made.write(f"bootstrap + {offset}", offset, 1, peer=peer)
        made.write(f"nothing + {offset}", 0x700 + offset, 1, peer=peer)


def _control(made):
    """Who has control, and how it is given back."""
    made.write("ControlPrivilege", _CCP, 4, 0x8000_0000, 0, 2)
    for peer in (1, 2):
        made.write("ControlPrivilege of another", _CCP, 0, 1, 2, 3, 4, peer=peer)
        made.write("HeartbeatTimeout of another", _HEARTBEAT, 1000, peer=peer)
        made.read("ControlPrivilege", _CCP, peer)
    made.write("ControlPrivilege", _CCP, 1, 3, 2, 7)
    made.read("ControlPrivilege", _CCP)
    made.command("FORCEIP while controlled, another MAC", gvcp.FORCEIP, bytes(56), peer=2)
    for size in (0, 4, 55, 57, 60):
        made.command(f"FORCEIP of {size} bytes", gvcp.FORCEIP, bytes(size), peer=2)
    made.write("ControlPrivilege", _CCP, 0)
    made.write("ControlPrivilege of another", _CCP, 2, peer=2)
    made.write("ControlPrivilege", _CCP, 2)
    made.write("ControlPrivilege of another", _CCP, 0, peer=2)
    made.write("ControlPrivilege", _CCP, 2)


def _headers(made):
    """Lengths, counts and alignments, with control."""
    words = struct.pack(">I", _HEARTBEAT)
    for count in (0, 1, 2, gvcp.REGISTERS_MAX, gvcp.REGISTERS_MAX + 1):
        made.command(f"read {count} registers", gvcp.READREG, words * count)
    for size in (1, 3, 5, 6):
        made.command(f"read of {size} bytes", gvcp.READREG, bytes(size))
    made.command("read two, the second is none", gvcp.READREG, words + struct.pack(">I", 0x700))
    pair = struct.pack(">II", _HEARTBEAT, 4000)
    most = gvcp.REGISTERS_MAX // 2
    for count in (0, 1, 2, most, most + 1):
        made.command(f"write {count} registers", gvcp.WRITEREG, pair * count)
    for size in (4, 12, 9):
        made.command(f"write of {size} bytes", gvcp.WRITEREG, bytes(size))
    made.command("write two, the second is none", gvcp.WRITEREG,
                 struct.pack(">IIII", _HEARTBEAT, 5000, 0x700, 1))
    made.read("HeartbeatTimeout", _HEARTBEAT)   # the first one is written
    last = gvcp.MEMORY_BYTES_MAX
    for address in (0, 0x48, 0x200, 0x900, gvcp.FEATURE_BASE, gvcp.XML_BASE, 0x700, 2):
        for count in (0, 1, 2, 3, 4, 5, 8, last - 4, last - 2, last, last + 1, last + 4, 0xFFFF):
            made.command(f"read {count} bytes at {address:#x}", gvcp.READMEM,
                         struct.pack(">IHH", address, 0, count), whole=False)
    for size in (0, 4, 7, 9, 12):
        made.command(f"memory read of {size} bytes", gvcp.READMEM, bytes(size))
    for size in (0, 3, 4, 6, 8, 12):
        payload = (struct.pack(">II", _HEARTBEAT, 6000) + bytes(4))[:size]
        made.command(f"memory write of {size} bytes", gvcp.WRITEMEM, payload)
        made.read("HeartbeatTimeout", _HEARTBEAT)
    made.command("memory write, too long", gvcp.WRITEMEM, words + bytes(gvcp.MEMORY_BYTES_MAX + 4))
    made.command("memory write, misaligned", gvcp.WRITEMEM, struct.pack(">II", 2, 6000))


def _limits(made):
    """Values of every register that is written, at its limits and beyond."""
    for value in (0, 499, 500, 501, 29_999, 30_000, 30_001, 0xFFFF_FFFF):
        made.write("HeartbeatTimeout", _HEARTBEAT, value)
        made.read("HeartbeatTimeout", _HEARTBEAT)
    for name, values in {
            "StreamPort": (0, 1, 0xFFFF, 0x10000, 0xFFFF_FFFF, 0),
            "StreamPacketDelay": (0, 1, 1_000_000, 1_000_001, 0xFFFF_FFFF, 0),
            "StreamPacketSize": (0, 575, 576, 1500, 0x4000_0000 | 1500, 8000, 16380, 16384, 0xFFFF),
            "StreamAddress": (0, 1, 0xFFFF_FFFF, 0),
            "Configuration": (0, 1, 2, 3, 4, 0xFFFF_FFFF, 0),
            "TimestampControl": (0, 1, 3, 0xFFFF_FFFF)}.items():
        address = gvcp.register(name).address
        for value in values:
            made.write(name, address, value)
            made.read(name, address)
    for row in gvcp.BOOTSTRAP:
        if row.access == "ro":
            made.write(row.name, row.address, 0)
    for one in FEATURES:
        if one.address < gvcp.FEATURE_BASE or one.table or one.name in _BUS or (
                one.name.startswith("Acquisition") and one.kind == "command"):
            continue
        for value in sorted({0, 1, 2, one.low, one.high, one.high + 1, 0xFFFF_FFFF}):
            made.write(one.name, one.address, value & 0xFFFF_FFFF)
        made.read(one.name, one.address, whole=one.name in _STATE)
    for name, address, _ in _addresses():
        if name in ("word after discovery", "word before the URL", "nothing", "end of bootstrap",
                    "before the features", "after the features", "XML", "last word",
                    "reserved word of discovery", "after the corrector"):
            made.write(name, address, 0)


def _views(made):
    """Numbers of a view, at their limits and beyond, and the widest together."""
    for one in VIEW_FEATURES:
        for value in (one.low - 1, one.low, one.high, one.high + 1, -1, 0, 0x7FFF_FFFF):
            made.write(one.name, one.address, value & 0xFFFF_FFFF)
            made.read(one.name, one.address)
    for one in VIEW_FEATURES:
        made.read(one.name, one.address)
    at = {one.name: one.address for one in VIEW_FEATURES}
    for name, value in (("Zoom", 1000), ("Pan", 0), ("Tilt", 0), ("Roll", 0)):
        made.write(name, at[name], value)


def _automatic(made):
    """Modes, and what each one locks; balance ratios of the colours."""
    at = {one.name: one.address for one in FEATURES}
    for name in AUTO_FEATURES:
        made.write(name, at[name], 0)
    # Values that all devices have from here on.
    made.write("ExposureTime", at["ExposureTime"], 100, 101)
    made.write("Gain", at["Gain"], 16, 17)
    for auto, name, values in (("ExposureAuto", "ExposureTime", (101, 102, 0, 0x10_0000)),
                               ("GainAuto", "Gain", (17, 18, 7, 64)),
                               ("BalanceWhiteAuto", "BalanceRatio", (256, 257, 0, 1024))):
        for mode in (0, 1, 2, 3, 0xFFFF_FFFF):
            made.write(auto, at[auto], mode)
            made.read(auto, at[auto])
        for value in values:
            made.write(f"{name}, {auto} is Continuous", at[name], value)
            made.read(name, at[name])
        made.write(auto, at[auto], 0)
        made.write(f"{name}, {auto} is Off", at[name], *values)
        made.read(name, at[name])
    for selected in (0, 1, 2, 3):
        made.write("BalanceRatioSelector", at["BalanceRatioSelector"], selected)
        made.write("BalanceRatio", at["BalanceRatio"], 300 + selected)
        made.read("BalanceRatio", at["BalanceRatio"])
    for selected in (0, 1, 2):
        made.write("BalanceRatioSelector", at["BalanceRatioSelector"], selected)
        made.read("BalanceRatio", at["BalanceRatio"])
    for name in AUTO_FEATURES:
        made.write(name, at[name], 2)


def _acquisition(made):
    """Start and stop, and what is locked meanwhile."""
    at = {one.name: one.address for one in FEATURES}
    made.write("TLParamsLocked", at["TLParamsLocked"], 0)
    made.write("TriggerMode", at["TriggerMode"], 1)     # no picture leaves by itself
    made.write("AcquisitionMode", at["AcquisitionMode"], 0)
    made.write("AcquisitionStop", at["AcquisitionStop"], 1)
    made.write("AcquisitionStart, no receiver", at["AcquisitionStart"], 0, 1)
    made.write("StreamPort", _PORT, 6000)
    made.write("AcquisitionStart, no address", at["AcquisitionStart"], 1)
    made.write("StreamAddress of another", _ADDRESS, int(IPv4Address(PEERS[2][0])))
    made.write("AcquisitionStart, another's address", at["AcquisitionStart"], 1)
    made.write("StreamAddress", _ADDRESS, int(IPv4Address(PEERS[0][0])))
    made.write("AcquisitionStart", at["AcquisitionStart"], 1, 1)
    for name, address, values in (
            ("StreamPort", _PORT, (6000, 6001, 0x10000)),
            ("StreamAddress", _ADDRESS, (int(IPv4Address(PEERS[0][0])), 0)),
            ("StreamPacketDelay", _DELAY, (10,)),
            ("AcquisitionMode", at["AcquisitionMode"], (0, 1)),
            ("TriggerMode", at["TriggerMode"], (0, 1)),
            ("TLParamsLocked", at["TLParamsLocked"], (1, 0))):
        for value in values:
            made.write(f"{name} while it streams", address, value)
        made.read(name, address)
    made.write("AcquisitionStop", at["AcquisitionStop"], 0, 1, 1)
    made.write("StreamPort", _PORT, 6001)
    made.write("ControlPrivilege", _CCP, 0)
    for name in ("HeartbeatTimeout", "Configuration", "StreamPort", "StreamPacketDelay",
                 "StreamAddress", "StreamPacketSize", "ControlPrivilege"):
        made.read(f"{name} after control", gvcp.register(name).address)
    for name in ("AcquisitionMode", "TriggerMode", "TLParamsLocked", *AUTO_FEATURES,
                 "BalanceRatioSelector", "ExposureTime", "Gain"):
        made.read(f"{name} after control", at[name])
