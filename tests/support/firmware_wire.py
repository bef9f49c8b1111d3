"""The firmware on this machine, its cable in the test's hands; frames made and read by scapy."""

import subprocess
from dataclasses import replace

from scapy.layers.inet import IP, TCP, UDP
from scapy.layers.l2 import ARP, Ether
from scapy.packet import Raw

from firmware_host import host_program
from ncdc_soc.core import SocCore
from ncdc_soc.firmware import Identity, config
from ncdc_soc.soc import soc_verilog
from ncdc_spec.hardware import Hardware
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.table_one import TCP_PORT
from ncdc_spec.registers.register_map import registers
from ncdc_spec.sensors.framing import camera_of, grid_row, setup_around
from ncdc_spec.view_matrix import camera_values

__all__ = ["CLIENT_IP", "TcpUser", "Wire", "wire_config", "wire_program"]

CLIENT_IP, _CLIENT_MAC = "10.77.0.1", "02:00:00:00:00:01"
_DEVICE = Identity()


def wire_config(descriptor, field=None, capacity=None, colour=False, sensor="mt9p031", view=False):
    """``text(clock_hz=None)``: config.h of a system with a ``sensor`` for ``descriptor``, at that
    clock or its own; ``field`` of the sensor, ``capacity`` of a packet if not the packetiser's,
    ``colour``, ``view``: the corrector has gains, a view."""
    setup, crop = setup_around(sensor, descriptor.geometry, field=field)
    hardware = Hardware(bus="axi", format="BGR8", colour=colour, view=view)
    core = SocCore(descriptor, hardware, grid=grid_row(setup, crop),
                   camera=camera_of(setup, crop))
    soc, capacity = soc_verilog(core), capacity or core.packetiser.capacity
    return lambda clock_hz=None: config(
        core.system, capacity, replace(soc, clock_hz=clock_hz) if clock_hz else soc, setup, crop)


def wire_program(folder, *args, **options):
    """The firmware for this machine, for :class:`Wire`; parameters as of :func:`wire_config`."""
    return host_program(wire_config(*args, **options)(), folder, "wire")


class Wire:
    """Runs ``program``, of ``host_program(..., "wire")``, with ``arguments``, as a context.

    Attributes
    ----------
    sent : list of Ether
        Frames of the device so far, ARP apart, which is answered.
    resent : list of int
        Last numbers of the packets that the packetiser was made to send again.
    streamed : int
        Frames that it was made to send.
    commits : list of tuple of int
        The matrix of the corrector at each of its commits.
    """
    def __init__(self, program, *arguments):
        self._command_line = [program, *map(str, arguments)]
        self.sent, self.resent = [], []
        self.streamed, self._values, self.commits = 0, [], []

    def __enter__(self):
        self._process = subprocess.Popen(self._command_line, stdin=subprocess.PIPE,
                                         stdout=subprocess.PIPE, text=True)
        return self

    def __exit__(self, *_):
        self._process.stdin.close()
        self._process.stdout.close()
        assert self._process.wait(10) == 0

    def _command(self, line):
        """Frames that the device sends meanwhile."""
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()
        found = []
        while (text := self._process.stdout.readline()) != ".\n":
            assert text, "the firmware has ended"
            if text.startswith("v "):
                self._values = [int(value) for value in text[2:].split()]
                continue
            if text.startswith("k "):
                self.commits.append(tuple(map(int, text[2:].split())))
                continue
            if text == "s\n":
                self.streamed += 1
                continue
            if text.startswith("r "):
                self.resent.append(int(text[2:], 16))
                continue
            found.append(Ether(bytes.fromhex(text)))
        return [answer for frame in found for answer in self._taken(frame)]

    def _taken(self, frame):
        if ARP in frame:
            if frame[ARP].op != 1 or frame[ARP].pdst == _DEVICE.ip:
                return []
            return self._command("f " + bytes(
                Ether(src=_CLIENT_MAC, dst=_DEVICE.mac) /
                ARP(op=2, hwsrc=_CLIENT_MAC, psrc=frame[ARP].pdst, hwdst=_DEVICE.mac,
                    pdst=_DEVICE.ip)).hex())
        self.sent.append(frame)
        return [frame]

    def frame(self, packet, source=CLIENT_IP):
        """The frames that answer an IP packet's payload from ``source``."""
        return self._command("f " + bytes(
            Ether(src=_CLIENT_MAC, dst=_DEVICE.mac) / IP(src=source, dst=_DEVICE.ip) /
            packet).hex())

    def wait(self, milliseconds):
        """Let the device's time pass; the frames that it sends meanwhile."""
        return self._command(f"t {milliseconds}")

    def set_link(self, status):
        """Have the packetiser's status be that."""
        self._command(f"l {status}")

    def set_light(self, light):
        """Have raw frames show a grey of ``light`` / 65536 for each line and eighth of gain."""
        self._command(f"b {light}")

    def put(self, register, value):
        """Set the corrector's register at a word address."""
        self._command(f"p {4 * register} {value}")

    def take_camera(self, descriptor):
        """Have the corrector's registers hold the camera of a lens's picture."""
        at = {one.name: one.address for one in registers(1, descriptor.formats, view=True)}
        for name, value in camera_values(descriptor).items():
            self.put(at[name], value & 0xFFFFFFFF)

    def peek(self, register):
        """The corrector's register at a word address."""
        self._command(f"q {4 * register}")
        return self._values[0]

    def sensor_register(self, address):
        """The word of a register of the sensor."""
        self._command(f"i {address}")
        return self._values[0]

    def rule(self, kind, *numbers):
        """What a rule of the firmware says of numbers: "e" of the exposure, "w" of the gains."""
        self._command(f"{kind} {' '.join(map(str, map(int, numbers)))}")
        return tuple(self._values)

    def set_clock(self, clocks):
        """Have the device's clock show ``clocks``."""
        self._command(f"c {clocks}")

    def datagram(self, data, port=5000, source=CLIENT_IP):
        """The datagrams that answer one to GVCP's port."""
        return [bytes(one[UDP].payload)[:one[UDP].len - 8] for one in
                self.frame(UDP(sport=port, dport=gvcp.PORT) / Raw(data), source) if UDP in one]


class TcpUser:
    """A user of Table I; ``takes``: it acknowledges what comes, and has space for more."""

    def __init__(self, wire, port, takes=True, source=CLIENT_IP):
        self._wire, self._port, self._source, self.takes = wire, port, source, takes
        self._next, self._awaited = 1000, 0
        self.data, self.ended = b"", False

    def _segment(self, flags, data=b""):
        window = 0xFFFF if self.takes else 600
        packet = TCP(sport=self._port, dport=TCP_PORT, seq=self._next, ack=self._awaited,
                     flags=flags, window=window) / Raw(data)
        self._next += len(data) + ("S" in flags)
        return self._wire.frame(packet, self._source)

    def begin(self):
        """Send the first segment alone; whether it is answered."""
        for frame in self._segment("S"):
            if TCP in frame and frame[TCP].dport == self._port and "S" in frame[TCP].flags:
                self._awaited = frame[TCP].seq + 1
                return True
        return False

    def connect(self):
        """Whether the connection is there."""
        if not self.begin():
            return False
        self.take(self._segment("A"))
        return not self.ended

    def send(self, data):
        """Send bytes, and take what comes at once."""
        self.take(self._segment("PA", data))

    def take(self, frames):
        """Take this user's segments among ``frames``, and what follows their acknowledges."""
        while frames:
            mine = [f[TCP] for f in frames if TCP in f and f[TCP].dport == self._port]
            got = False
            for segment in mine:
                self.ended |= "R" in segment.flags or "F" in segment.flags
                length = segment.underlayer.len - 20 - 4 * segment.dataofs
                if self.takes and segment.seq == self._awaited and length:
                    self.data += bytes(segment.payload)[:length]
                    self._awaited = (self._awaited + length) % (1 << 32)
                    got = True
            frames = self._segment("A") if got and not self.ended else []

    def drip(self, count):
        """Take ``count`` bytes of what has come, and no more."""
        self._awaited = (self._awaited + count) % (1 << 32)
        self._segment("A")

    def wait(self, milliseconds):
        """Let time pass, and take what comes."""
        self.take(self._wire.wait(milliseconds))

    def ask(self, code, address=0, value=0):
        """The value that a command is answered; None if there is no answer."""
        before = len(self.data)
        self.send(code.to_bytes(1, "big") + address.to_bytes(2, "big") + value.to_bytes(2, "big"))
        answer = self.data[before:]
        return int.from_bytes(answer[3:5], "big") if len(answer) == 5 else None
