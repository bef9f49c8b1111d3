"""Hosts of the registers in a board: a serial line, JTAG, a bus and programs at one agent."""

import random
from functools import cache

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.avalon.bus import Agent
from ncdc_hdl.registers.access import RegisterAccess
from ncdc_hdl.registers.agent_access import AgentAccess
from ncdc_hdl.registers.jtag_bridge import DOMAIN, JtagBridge, Scan
from ncdc_hdl.registers.program import Op, ProgramRunner
from ncdc_hdl.registers.serial_bridge import SerialBridge
from ncdc_sim.runner import build_bench, command_of, hdl_text
from ncdc_sim.tools import SimulationError
from ncdc_sim.transcript import transcribed
from ncdc_spec.protocols import jtag_link, serial_link
from ncdc_spec.registers.system_map import SYSTEM_WORDS_BITS
from simulations import HDL

__all__ = ["DESIGN", "RegisterHosts"]

_TOP = "register_hosts"
_BITS = SYSTEM_WORDS_BITS
_DIVISOR, _RETRY = 9, 300           # clocks of a bit; before a program begins anew
_GAP = 100 * 10 * _DIVISOR          # clocks after which a request on the line is dropped
_SPECIAL = 31 << _BITS - 5          # from here on a register changes as it is read
# Their low bytes begin with 7, 3, 32 and 255.
_COUNTS, _GUARDED, _AGAIN, _LONG = (_SPECIAL + (low ^ 0xA5) for low in (7, 3, 32, 255))
_QUARTER = 1 << _BITS - 2           # registers of each host
_PROGRAMS = (
    [(Op.WRITE, 7, 0x89ABCDEF), (Op.PAUSE, 0, 300), (Op.LOOK, 9, 1 << 3), (Op.WRITE_NOT, 10, 0),
     (Op.LOOK, 9, 1 << 2), (Op.WRITE_NOT, 11, 0), (Op.UNTIL_ZERO, _COUNTS, 0x06),
     (Op.WRITE, 8, 0x01234567), (Op.GUARD, _GUARDED, 0xFF), (Op.WRITE, 12, 0xFFFFFFFF)],
    [(Op.WRITE, 40 + k, 0x5A << k) for k in range(20)] + [(Op.GUARD, _AGAIN, 0xFF)],
    [],
    [step for k in range(32) for step in ((Op.LOOK, 900 + 37 * k, 1 << k),
                                          (Op.WRITE_NOT, 2000 + k, 0))],
    [(Op.GUARD, _LONG, 0xFF)],
    [(Op.PAUSE, 0, 0), (Op.LOOK, 1000, 0xFFFFFFFF), (Op.WRITE_NOT, 1001, 0)])
_STARTS = 1, 2, 3, 1, 5, 4, 0


class RegisterHosts(wiring.Component):
    """The hosts of the registers in a board, at one agent.

    Members
    -------
    receive, send, scan, start, which, busy, failures
        As of :class:`SerialBridge`, :class:`JtagBridge` and :class:`ProgramRunner`.
    tck : ``In(1)``
        The JTAG chain's clock.
    agent : ``In(Agent(address_bits))``
        Another host, as of :class:`AgentAccess`.
    bus : ``Out(Agent(address_bits))``
    """

    def __init__(self):
        super().__init__({
            "receive": In(1), "send": Out(1, init=1), "scan": In(Scan()), "tck": In(1),
            "start": In(1),
            "which": In(range(len(_PROGRAMS))), "busy": Out(1, init=1), "failures": Out(8),
            "agent": In(Agent(_BITS)), "bus": Out(Agent(_BITS))})

    def elaborate(self, platform):
        m = Module()
        m.domains += ClockDomain(DOMAIN, reset_less=True, local=True)
        m.d.comb += ClockSignal(DOMAIN).eq(self.tck)
        m.submodules.access = access = RegisterAccess(_BITS, 4)
        m.submodules.programs = programs = ProgramRunner(_PROGRAMS, _BITS, retry_clocks=_RETRY)
        m.submodules.serial = serial = SerialBridge(_DIVISOR, _BITS)
        m.submodules.jtag = jtag = JtagBridge(_BITS)
        m.submodules.agent = agent = AgentAccess(_BITS)
        for k, host in enumerate((programs, serial, jtag, agent)):
            connect(m, host.access, access.hosts[k])
        connect(m, access.bus, flipped(self.bus))
        connect(m, flipped(self.agent), agent.bus)
        connect(m, flipped(self.scan), jtag.scan)
        m.d.comb += [serial.receive.eq(self.receive), self.send.eq(serial.send),
                     programs.start.eq(self.start), programs.which.eq(self.which),
                     self.busy.eq(programs.busy), self.failures.eq(programs.failures)]
        return m


class Words:
    """The register file, as a host that is alone sees it; its accesses are recorded."""

    def __init__(self):
        self.words, self.accesses = {}, []

    def read(self, address):
        """The word of a register, which may change it."""
        word = self.words.get(address, address * 0x10001 ^ 0xA5A5A5A5)
        self.accesses.append((0, address, word))
        if address >= _SPECIAL and word & 0xFF:
            self.words[address] = word - 1
        return word

    def write(self, address, word):
        """Write a register."""
        self.words[address] = word
        self.accesses.append((1, address, word))


class Expected:
    """Scripts of all hosts, and what must come of them.

    Attributes
    ----------
    files : dict
        Texts of the scripts by name.
    uart, scans, words : list
        Bytes on the line; numbers scanned out that are not 0; words read by the bus host.
    accesses : dict
        Accesses of each host as (write, address, word); programs are host 0.
    """

    def __init__(self, seed):
        self.rng = random.Random(seed)
        self.files, self.accesses = {}, {}
        self.uart = self._serial()
        self.scans = self._jtag()
        self.words = self._bus()
        self.accesses[0] = programs_accesses()
        self.files["program.txt"] = "".join(f"0 {which:x} 0\n" for which in _STARTS)

    def _serial(self):
        """Requests on the line, right ones and wrong ones."""
        rng, lines, answers, words = self.rng, [], b"", Words()

        def send(data, bit=16 * _DIVISOR):
            lines.extend(f"0 {byte:x} {bit:x}" for byte in data)

        def checked(data):
            return data + bytes([serial_link.crc8(data)])

        def wait(clocks):
            lines.append(f"1 {clocks:x} 0")

        answered = 30 * 10 * _DIVISOR       # clocks, with an access that waits
        for k in range(16):
            address, word = _QUARTER + rng.randrange(_QUARTER), rng.getrandbits(32)
            # The host's clock is off by up to 2 %, its bytes have pauses, or there is noise.
            bit = 16 * _DIVISOR + rng.choice((-2, 0, 0, 2))
            if k % 4 == 1:              # no letters: one bit of theirs is another
                send(bytes(letter ^ 1 << bit for letter in b"RW" for bit in (k // 4, k // 4 + 4)))
                wait(rng.randrange(1, 200))
            if k % 4 == 2:
                lines.append(f"2 {_DIVISOR // 2 - 2:x} 0")
                wait(3 * _DIVISOR)
            if k % 4 == 3:              # no stop bit, which is no byte
                lines.append(f"2 {14 * _DIVISOR:x} 0")
                wait(3 * _DIVISOR)
            request = serial_link.write_request(address, word)
            if k in (4, 9, 13):
                wrong = bytearray(request)
                wrong[1 + k % 7] ^= 1 << k % 8
                send(wrong, bit)
                answers += checked(bytes([serial_link.BAD]))
                wait(answered)
            if k in (5, 11):            # a request that stops for too long is dropped
                send(request[:k % 6], bit)
                wait(_GAP - 10 * _DIVISOR + 8)      # a byte takes ten bits
            send(request[:3], bit)
            if k == 7:                  # no stop bit within a request
                lines.append(f"2 {14 * _DIVISOR:x} 0")
                wait(3 * _DIVISOR)
            wait(_GAP - 10 * _DIVISOR - 8 if k == 8 else 1 + 37 * (k % 2))
            send(request[3:], bit)
            words.write(address, word)
            answers += checked(b"w")
            wait(answered)
            if k % 3 == 0:
                address = _QUARTER + rng.randrange(_QUARTER)
            send(serial_link.read_request(address), bit)
            answers += checked(b"r" + words.read(address).to_bytes(4, "big"))
            wait(answered)
        self.files["serial.txt"] = "\n".join([*lines, ""])
        self.accesses[1] = words.accesses
        return answers

    def _jtag(self):
        """Scans: requests, those that come too early, and no requests."""
        rng, lines, answers, words = self.rng, [], [], Words()

        def scan(value):
            lines.append(f"0 {value >> 32:x} {value & 0xFFFFFFFF:x}")

        for k in range(24):
            address, word = 2 * _QUARTER + rng.randrange(8) * 0x155, rng.getrandbits(32)
            kind = rng.choice((jtag_link.READ, jtag_link.WRITE))
            message = jtag_link.jtag_message(kind, k + 0x5A & 0xFF, address, word)
            if k % 5 == 3:              # the second request is dropped
                lines.append("2 300 0")
                scan(message)
                scan(jtag_link.jtag_message(jtag_link.WRITE, 0xEE, address, ~word & 0xFFFFFFFF))
                lines.append("1 1000 0")
            else:
                scan(message)
            if kind == jtag_link.WRITE:
                words.write(address, word)
                answer = word
            else:
                answer = words.read(address)
            lines.append(f"1 {rng.randrange(200):x} 0")
            if k % 6 == 5:
                lines.append("3 b 2ff")     # a short scan requests nothing
            answers.append(jtag_link.jtag_message(kind, k + 0x5A & 0xFF, address, answer))
            for _ in range(3):
                lines.append("1 60 0")
                # One bit more than a request has, or both of theirs.
                kind = rng.choice((jtag_link.READ, jtag_link.WRITE)) | 1 << rng.randrange(2, 8)
                scan(rng.choice((0, 3 << 56, kind << 56)) | rng.getrandbits(56))
        self.files["jtag.txt"] = "\n".join([*lines, ""])
        self.accesses[2] = words.accesses
        return answers

    def _bus(self):
        """Accesses of the bus host."""
        rng, lines, answers, words = self.rng, [], [], Words()
        for _ in range(150):
            address, word = 3 * _QUARTER + rng.randrange(16) * 0x33, rng.getrandbits(32)
            if rng.randrange(2):
                lines.append(f"0 {address:x} {word:x}")
                words.write(address, word)
            else:
                lines.append(f"1 {address:x} 0")
                answers.append(words.read(address))
            if rng.randrange(2):
                lines.append(f"2 {rng.randrange(300):x} 0")
        self.files["bus.txt"] = "\n".join([*lines, ""])
        self.accesses[3] = words.accesses
        return answers


def programs_accesses():
    """Accesses of the programs: number 0, then those that are started."""
    words = Words()
    for which in (0, *_STARTS):
        found, at = False, 0
        while at < len(_PROGRAMS[which]):
            op, address, word = _PROGRAMS[which][at]
            at += 1
            if op in (Op.WRITE, Op.WRITE_NOT):
                words.write(address, word if op == Op.WRITE else int(not found))
            elif op != Op.PAUSE:
                some = words.read(address) & word
                found = bool(some) if op == Op.LOOK else found
                at -= op == Op.UNTIL_ZERO and bool(some)
                if op == Op.GUARD and some:
                    at = 0
    return words.accesses


@cache
def expected(seed):
    """Scripts and results of a seed, made once for all mutants."""
    return Expected(seed)


def make():
    """The hosts, anew."""
    return RegisterHosts()


def program_of(verilog):
    """The compiled bench."""
    return build_bench("hosts", "hosts_bench", [
        ("register_hosts.v", verilog), ("digest.v", hdl_text("digest.v")),
        ("hosts_bench.v", (HDL / "hosts_bench.v").read_text())], defines={
            "NCDC_ADDRESS_BITS": _BITS, "NCDC_DIVISOR": _DIVISOR})


def all_hosts(seed, wait, latency, late, noise=0):
    """The bench of all hosts at once, at a register file of these times.

    ``late``: most clocks by which it delays the programs. ``noise``: clocks with resets before.
    """
    def bench(verilog, transcripts):
        wanted, found = expected(seed), {"UART": [], "JTAG": [], "BUS": [], "ACCESS": []}
        results = {}

        def take(line):
            kind, *values = line.split() or [""]
            if kind == "FAILED":
                raise SimulationError(line)
            if kind == "RESULT":
                results[values[0]] = int(values[1])
            elif kind in found:
                found[kind].append(values)

        transcribed([*command_of(program_of(verilog)), f"+wait={wait}", f"+latency={latency}",
                     f"+noise={noise}", "+clock_limit=400000"], take, transcripts,
                    files={name: text.encode() for name, text in wanted.files.items()})
        assert results, "the simulation ended without a result"
        check(wanted, found, results, late)
    return bench


def check(wanted, found, results, late):
    """What came is what must come, of each host in its order."""
    assert bytes(int(byte, 16) for byte, in found["UART"]) == wanted.uart
    scans = [int(value, 16) for value, in found["JTAG"]]
    assert [value for value in scans if value] == wanted.scans
    assert [int(word) for word, in found["BUS"]] == wanted.words
    accesses = [tuple(map(int, values)) for values in found["ACCESS"]]

    def host_of(address):
        return 0 if address >= _SPECIAL else address // _QUARTER

    for host in range(4):
        assert [one[1:] for one in accesses if host_of(one[2]) == host] == wanted.accesses[host]
    failures = sum(address in (_GUARDED, _AGAIN, _LONG) and word & 0xFF != 0
                   for _, address, word in wanted.accesses[0])
    assert failures > 255 == results["failures"]
    # A pause of a program, and that before it begins anew.
    own = [one for one in accesses if host_of(one[2]) == 0]
    for before, after in zip(own, own[1:]):
        clocks = after[0] - before[0]
        if before[2] == 7:
            assert 300 < clocks < 300 + late, clocks
        if before[2] == _GUARDED and after[2] == 7 and before[3] & 0xFF:
            assert _RETRY < clocks < _RETRY + late, clocks


DESIGN = Design("bridges", _TOP, make, (
    PlayedBench("hosts at a quick agent", all_hosts(1, 0, 1, 200)),
    PlayedBench("hosts at a slow agent", all_hosts(2, 150, 20, 1500)),
    PlayedBench("hosts after resets", all_hosts(3, 60, 12, 600, noise=40_000))))
