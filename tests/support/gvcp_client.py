"""A client of GVCP that talks to a device in the test's own process, or to the firmware."""

import struct
from ipaddress import IPv4Address

from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.features import feature

__all__ = ["PEER", "Client"]

PEER = ("10.77.0.1", 5000)


class Client:
    """Commands to a device; ``answers(datagram)`` gives its answers."""

    def __init__(self, answers):
        self._answers, self._number = answers, 0

    def command(self, code, payload):
        self._number += 1
        *_, last = self._answers(gvcp.command_packet(code, self._number, payload))
        status, _, number, rest = gvcp.parse_acknowledge(last)
        assert number == self._number
        return status, rest

    def get(self, name):
        status, rest = self.command(gvcp.READREG, struct.pack(">I", feature(name).address))
        assert status == gvcp.SUCCESS, name
        return int.from_bytes(rest, "big")

    def write(self, address, value):
        return self.command(gvcp.WRITEREG, struct.pack(">II", address, value))[0]

    def set(self, **values):
        """Write features; the status of each."""
        return [self.write(feature(name).address, value) for name, value in values.items()]

    def control(self):
        """Take control, and choose this machine as the receiver."""
        for name, value in (("ControlPrivilege", 2), ("StreamPort", 6000),
                            ("StreamAddress", int(IPv4Address(PEER[0])))):
            assert self.write(gvcp.register(name).address, value) == gvcp.SUCCESS

    def exposure(self):
        return self.get("ExposureTime"), self.get("Gain")
