"""A packetiser's Verilog between a memory, a host with a script and a line, all in Verilog."""

from dataclasses import dataclass, field

from ncdc_sim.runner import build_bench, command_of, hdl_text
from ncdc_sim.tools import SimulationError
from ncdc_sim.transcript import transcribed
from ncdc_spec.registers.link_map import LINK, TEMPLATE_WORDS, TEMPLATES
from simulations import HDL

__all__ = ["PACKETISER", "PacketRun", "Script", "simulate_packets"]

PACKETISER = "packetiser"
"""Name of its module."""

_AT = {register.name: register.address for register in LINK}
_END, _WRITE, _READ, _UNTIL, _WAIT, _RESET, _IRQ = range(7)


class Script:
    """What the host does, line by line; registers are called without LINK_."""

    def __init__(self):
        self._lines = []

    @property
    def text(self):
        """The text of the file."""
        return "\n".join([*self._lines, "0 0 0", ""])

    def _add(self, operation, a=0, b=0):
        self._lines.append(f"{operation:x} {a:x} {b:x}")

    def put(self, **values):
        """Write registers."""
        for name, value in values.items():
            self._add(_WRITE, _AT[f"LINK_{name}"], value)

    def write(self, address, value):
        """Write to a word address."""
        self._add(_WRITE, address, value)

    def get(self, name):
        """Read a register."""
        self._add(_READ, _AT[f"LINK_{name}"])

    def read(self, address):
        """Read from a word address."""
        self._add(_READ, address)

    def settled(self, busy):
        """Read the status until its bits of ``busy`` are 0; clear it."""
        self._add(_UNTIL, busy, _AT["LINK_STATUS"])
        self.put(STATUS=0xFFFFFFFF)

    def wait(self, clocks):
        """Let so many clocks go by."""
        self._add(_WAIT, clocks)

    def reset(self, clocks, memory=False):
        """Reset the packetiser, and the memory with it."""
        self._add(_RESET, clocks, int(memory))

    def interrupt(self):
        """Wait for the interrupt."""
        self._add(_IRQ)

    def prepare(self, rng, headers, base, delay=0):
        """Write all that a frame needs; bytes after a header's end are random."""
        for number, name in enumerate(("leader", "payload", "last", "trailer")):
            header, at = getattr(headers, name), TEMPLATES + TEMPLATE_WORDS * number
            self.write(at, len(header))
            for word in range(-(-len(header) // 4)):
                four = (header + rng.randbytes(4))[4 * word:4 * word + 4]
                self.write(at + 1 + word, int.from_bytes(four, "little"))
        self.put(BASE=base, PAYLOAD=headers.payload_bytes, PACKETS=headers.packets,
                 LAST=headers.last_bytes, FIRST_NUMBER=headers.first,
                 NUMBER_FIELD=headers.field[0] | headers.field[1] << 8, DELAY=delay)


@dataclass
class PacketRun:
    """Results of a run.

    Parameters
    ----------
    packets : list of bytes
    times : list of (int, int)
        Clocks of the first and the last beat of each.
    reads : list of int
        Words that were read, and the status where the script waited for it.
    results : dict
        Numbers of the bench.
    """
    packets: list = field(default_factory=list)
    times: list = field(default_factory=list)
    reads: list = field(default_factory=list)
    results: dict = field(default_factory=dict)

    def take(self, line):
        """Record a line of the bench; SimulationError if it reports an error."""
        kind, *values = line.split() or [""]
        if kind == "PACKET":
            self.times.append((int(values[0]), int(values[1])))
            self.packets.append(bytes.fromhex(values[2]))
        elif kind in ("READ", "STATUS"):
            self.reads.append(int(values[0]))
        elif kind == "RESULT":
            self.results[values[0]] = int(values[1])
        elif kind in ("FAILED", "AVALON-ERROR"):
            raise SimulationError(f"simulation failed: {line}")


def simulate_packets(verilog, data_width, content, script, *, transcripts=None, **settings):
    """Run a packetiser.

    Parameters
    ----------
    verilog : str
        Text of a module ``packetiser``.
    data_width : int
    content : bytes
        Of the memory, a power of two of them.
    script : Script
    transcripts : list, optional
        The run's transcript is added to it.
    settings
        Plusargs of ``packets_bench.v`` and of the memory.

    Raises
    ------
    SimulationError
        If it does not compile, a rule of a bus or of the line is broken, or the run does not end.
    """
    sources = [("packetiser.v", verilog),
               ("packets_bench.v", (HDL / "packets_bench.v").read_text()),
               *((name, hdl_text(name)) for name in (
                   "avalon_memory.v", "dram_timing.v", "avalon_checker.v", "digest.v"))]
    program = build_bench("packets", "packets_bench", sources, optimise="-O0", defines={
        "NCDC_DATA_WIDTH": data_width, "NCDC_MEMORY_BYTES": len(content)})
    result = PacketRun()
    transcribed([*command_of(program), *(f"+{key}={value}" for key, value in settings.items())],
                result.take, transcripts,
                files={"script.txt": script.text.encode(), "content.bin": content})
    if any(result.results.get(name) != 0 for name in ("bus_errors", "csr_errors", "memory_errors")):
        raise SimulationError(f"a bus went wrong: {result.results}")
    return result
