"""Simulation of whole frames: the generated Verilog with a memory model."""

import tempfile
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path

from ncdc_sim.memory.litedram import LiteDram, litedram_sources
from ncdc_sim.memory.timing import memory_settings, simulated_memory
from ncdc_sim.ports import ports_of
from ncdc_sim.runner import HDL, build_bench, command_of, hdl_text
from ncdc_sim.runner import run as run_program
from ncdc_sim.tools import SimulationError
from ncdc_sim.transcript import Transcript
from ncdc_sim.waves import Waves, build_options, recorded
from ncdc_spec.errors import InputError
from ncdc_spec.frames import ADDRESS_BITS

__all__ = ["UNWRITTEN", "Camera", "FrameResult", "Program", "Run", "simulate_frame"]

TOP = "ncdc"
BENCH = ("frame_bench.v", "avalon_checker.v", "stream_checker.v")
MODEL = ("avalon_memory.v", "dram_timing.v")
UNWRITTEN = 0xA5                # bytes of the output that nothing has written
MIN_MEMORY = 1 << 24          # bytes; more frame sizes share one build
MAX_DECODED = 31                # bits of an address in the bench's memory
PROGRAM_LIMIT = 65536           # operations that the bench holds


class Operation(IntEnum):
    """Operations of the bench, with their numbers in ``frame_bench.v``."""
    END = 0
    WRITE = 1
    COMPARE = 2
    WAIT_IRQ = 3
    REPORT = 4
    WAIT = 5
    WAIT_OUTPUT = 6
    RESET = 7
    POLL = 8
    CAMERA = 9
    RESET_ALL = 10
    ALLOW = 11


@dataclass(frozen=True)
class Camera:
    """A camera that writes raw frames while the run goes on, a byte per clock, past the ports.

    Parameters
    ----------
    width, height, pitch : int
        Bytes of a row, rows, bytes from row to row in memory and in the source.
    line : int
        Clocks from row to row, ``width`` or more.
    """
    width: int
    height: int
    pitch: int
    line: int


@dataclass
class Program:
    """Register accesses that the bench plays one after the other; addresses count words."""
    operations: list = field(default_factory=list)

    def write(self, address, value):
        """Write ``value`` (32 bits)."""
        return self._add(Operation.WRITE, address, value & 0xFFFFFFFF)

    def compare(self, address, value):
        """Read, and fail the run unless ``value`` is read."""
        return self._add(Operation.COMPARE, address, value & 0xFFFFFFFF)

    def wait_irq(self):
        """Wait for the interrupt; the frame's clocks count from the write before it."""
        return self._add(Operation.WAIT_IRQ, 0, 0)

    def read(self, address):
        """Read; the value appears in :attr:`FrameResult.registers`."""
        return self._add(Operation.REPORT, address, 0)

    def wait(self, clocks):
        """Let so many clocks go by."""
        return self._add(Operation.WAIT, 0, clocks)

    def wait_output(self, count):
        """Wait until ``count`` bytes of output, counted from the start of the run, are out."""
        return self._add(Operation.WAIT_OUTPUT, 0, count)

    def reset(self, clocks=1):
        """Reset the module, not the memory, for so many clocks, whatever it is doing."""
        return self._add(Operation.RESET, 0, clocks)

    def reset_all(self, clocks=1, trails=0):
        """Reset the module, and the memory, which forgets its reads, for so many clocks each.

        The memory's reset trails the module's by ``trails`` clocks, or leads if negative.
        """
        return self._add(Operation.RESET_ALL, 0, clocks | (trails & 0xFFFF) << 16)

    def poll(self, address, value):
        """Read until ``value`` is read."""
        return self._add(Operation.POLL, address, value & 0xFFFFFFFF)

    def camera(self, address):
        """Let the camera begin its next frame, the next of the source, at the byte address."""
        return self._add(Operation.CAMERA, 0, address)

    def allow(self, source, target):
        """From here on, allow reads and writes in these byte ranges only, (begin, end) each."""
        for k, address in enumerate((*source, *target)):
            self._add(Operation.ALLOW, k, address)
        return self

    def text(self):
        """The program as the bench reads it."""
        return "".join(f"{op:02x}{address:06x}{value:08x}\n"
                       for op, address, value in [*self.operations, (Operation.END, 0, 0)])

    def _add(self, op, address, value):
        self.operations.append((op, address, value))
        return self


@dataclass
class FrameResult:
    """Measurements of a run.

    Parameters
    ----------
    output : bytes
        The output frame: memory content, or 3 bytes (R, G, B) per pixel of a stream.
    clocks : tuple of int
        Clocks of each frame, from the register write before the wait to the interrupt.
    ends : tuple of int
        Clock, counted from the start of the run, in which each interrupt was seen.
    outputs : tuple of int
        Bytes of output that were out when each interrupt was seen.
    resets : tuple of int
        Bytes of output that were out when each reset of the module began.
    total_clocks : int
    bytes_read : tuple of int
        Bytes delivered by each read port.
    bytes_written : int
        Bytes written (enabled lanes only), or 3 per pixel of a stream.
    registers : dict
        Word address: value last read.
    reads : tuple of (int, int)
        Word address and value of every read, in order.
    counters : dict
        Commands, beats and wait clocks of each port: ``read0_commands``, ``output_waits`` ...
        ``outside_bytes``: read or written outside the ranges that the program allows. With a
        camera ``camera_end``: the clock in which its last byte was in memory; ``early_reads``: read
        commands for rows of its frame that were not.
    errors : tuple of str
        Protocol errors and failures, as printed.
    """
    output: bytes = b""
    clocks: tuple = ()
    ends: tuple = ()
    outputs: tuple = ()
    resets: tuple = ()
    total_clocks: int = 0
    bytes_read: tuple = ()
    bytes_written: int = 0
    registers: dict = field(default_factory=dict)
    reads: tuple = ()
    counters: dict = field(default_factory=dict)
    errors: tuple = ()


@dataclass(frozen=True)
class Run:
    """Memory, simulator and options of a simulation.

    Parameters
    ----------
    memory : str, LatencyMemory, DramMemory or LiteDram
        A name that ``ncdc_sim.memory.timing.simulated_memory`` knows, or a memory of your own.
    simulator : str
        ``verilator`` or ``icarus``.
    clock_limit : int, optional
        Clocks after which the run is given up; 100 per output byte and a million if absent.
    seed : int
        Seed of all random behaviour.
    sink_probability : int
        How often, of 256 clocks, the sink of a stream is ready.
    waves : Waves, optional
        Where to write the waveforms.
    more : sequence of str
        Further plusargs.
    decoded : int, optional
        Bits of an address that the memory decodes; it ignores those above. All if absent.
    transcripts : list, optional
        Gets the run's :class:`Transcript`, of a run that fails as well.
    """
    memory: object = "ideal"
    simulator: str = "verilator"
    clock_limit: int | None = None
    seed: int = 1
    sink_probability: int = 256
    waves: Waves | None = None
    more: tuple = ()
    decoded: int = ADDRESS_BITS
    transcripts: list | None = None


def simulate_frame(verilog, source, program, *, source_base, output_base, output_bytes, camera=None,
                   progress=None, **run):
    """Run the module ``ncdc`` of ``verilog`` on one raw frame.

    Its ports give the data width, the number of read ports and the kind of output.

    Parameters
    ----------
    verilog : str
    source : bytes
        Content of the memory from byte address ``source_base`` on; with a camera, what it sends.
    program : Program
        Sets the registers up, starts, waits for the interrupt.
    source_base, output_base : int
        Byte addresses, multiples of 16.
    output_bytes : int
        Size of the output: in memory from ``output_base`` on, or 3 bytes per pixel of a stream.
    camera : Camera, optional
        Sends the source when the program says so; until then the memory holds 0xA5 there.
    progress : callable
        Called with the fraction of the output done, 0..1, now and then.
    run :
        As of :class:`Run`.

    Returns
    -------
    FrameResult

    Raises
    ------
    InputError
        If the simulator is missing, or a base or size does not fit.
    SimulationError
        If the Verilog does not compile, violates a rule of its buses, reads a wrong register value,
        or does not end in time. It holds the result so far.
    """
    run = Run(**run)
    memory = simulated_memory(run.memory)
    module = _Module(verilog)
    mask = (1 << run.decoded) - 1
    source_base, output_base = source_base & mask, output_base & mask
    end = max(source_base + len(source), 0 if module.stream else output_base + output_bytes)
    _check(program, source_base, output_base, min(run.decoded, MAX_DECODED), end)
    binary = _bench(module, memory, run, end)
    settings = {} if isinstance(memory, LiteDram) else memory_settings(
        memory, module.width, module.readers)
    settings |= {
        "source_base": source_base, "source_bytes": len(source), "output_base": output_base,
        "output_bytes": output_bytes, "program_words": len(program.operations) + 1,
        "clock_limit": run.clock_limit or 1000000 + 100 * output_bytes, "seed": run.seed,
        "address_mask": mask, "sink_probability": run.sink_probability,
        "progress_step": max(1, output_bytes // 100)}
    if camera:
        settings |= {f"camera_{name}": value for name, value in vars(camera).items()}
    listener = _Listener(output_bytes, module.width // 8, module.readers, progress)
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name, \
            recorded(run.waves, run.simulator) as waves:
        folder = Path(name)
        files = {"source.bin": source + bytes(-len(source) % (module.width // 8)),
                 "program.hex": program.text().encode()}
        for file, content in files.items():
            (folder / file).write_bytes(content)
        command = [*command_of(binary), *waves,
                   *(f"+{key}={value}" for key, value in settings.items()), *run.more]
        run_program(command, folder, listener.line)
        output = folder / "output.bin"
        written = {output.name: output.read_bytes()} if output.exists() else {}
        listener.result.output = written.get(output.name, b"")[:output_bytes]
        if run.transcripts is not None:
            run.transcripts.append(
                Transcript(tuple(command), files, tuple(listener.lines), written))
        return listener.finish()


def _check(program, source_base, output_base, decoded, end):
    if source_base % 16 or output_base % 16 or end > 1 << decoded:
        raise InputError(f"bases {source_base:#x} and {output_base:#x} with frames up to {end:#x} "
                         f"do not fit: multiples of 16 below {1 << decoded:#x} are needed")
    if len(program.operations) >= PROGRAM_LIMIT:
        raise InputError(f"the program has {len(program.operations)} operations, "
                         f"the limit is {PROGRAM_LIMIT - 1}")


class _Module:
    """The module ``ncdc`` of a Verilog text, as far as the bench depends on it."""

    def __init__(self, verilog):
        self.verilog, self.ports = verilog, ports_of(verilog, TOP)
        self.readers = sum(name.endswith("_readdata") and name.startswith("read")
                           for name in self.ports)
        self.stream = "stream_data" in self.ports
        self.width = self.ports.get("read0_readdata", 0)
        if self.width not in (32, 64, 128) or self.readers not in (1, 3):
            raise InputError(f"the module {TOP} has {self.readers} read ports of {self.width} "
                             "bits, 1 or 3 of 32, 64 or 128 bits are needed")

    def defines(self, end):
        """Macros of the bench around it, with a memory to byte address ``end``."""
        ports = self.ports
        macros = {"NCDC_DATA_WIDTH": self.width, "NCDC_READ_PORTS": self.readers,
                  "NCDC_READ_BURST_WIDTH": ports["read0_burstcount"],
                  "NCDC_WRITE_BURST_WIDTH": ports.get("write_burstcount", 1),
                  "NCDC_CSR_ADDRESS_WIDTH": ports["csr_address"],
                  "NCDC_MEMORY_BYTES": max(MIN_MEMORY, 1 << (end - 1).bit_length())}
        macros |= {"NCDC_THREE_READ_PORTS": None} if self.readers == 3 else {}
        return macros | ({"NCDC_STREAM": ports["stream_data"] // 24} if self.stream else {})


def _bench(module, memory, run, end):
    """The program that simulates ``module`` in the bench, on ``memory`` to byte address ``end``.

    Raises
    ------
    InputError
        If LiteDRAM cannot be the memory of this run.
    """
    simulator = run.simulator
    defines, options = module.defines(end), build_options(run.waves, simulator)
    sources = [(name, hdl_text(name)) for name in BENCH] + [("ncdc.v", module.verilog)]
    if isinstance(memory, LiteDram):
        if simulator != "verilator" or module.width % memory.native or end > memory.bytes:
            raise InputError(
                f"LiteDRAM with ports of {memory.native} bits and {memory.bytes >> 20} MB needs "
                f"the simulator verilator and a data width that is a multiple of them; asked for "
                f"are {simulator}, {module.width} bits and {end >> 20} MB")
        defines |= {"NCDC_LITEDRAM_NATIVE": memory.native,
                    "NCDC_LITEDRAM_ADDRESS": memory.address_bits}
        sources += [("litedram_memory.v", (HDL / "litedram_memory.v").read_text()),
                    *litedram_sources(memory, module.readers + 1)]
        options += ("-Wno-fatal",)
    else:
        sources += [(name, (HDL / name).read_text()) for name in MODEL]
    return build_bench("frame", "frame_bench", sources, defines=defines, simulator=simulator,
                       options=options)


class _Listener:
    """Turns the bench's lines into a :class:`FrameResult`."""

    def __init__(self, output_bytes, word, readers, progress):
        self.result, self.lines = FrameResult(), []
        self.output_bytes, self.word, self.readers = output_bytes, word, readers
        self.progress = progress or (lambda fraction: None)

    def line(self, line):
        self.lines.append(line)
        kind, *values = line.split() or [""]
        result = self.result
        if kind == "PROGRESS":
            self.progress(min(1.0, int(values[0]) / self.output_bytes))
        elif kind == "FRAME":
            result.clocks += (int(values[0]),)
            result.ends += (int(values[1]),)
            result.outputs += (int(values[2]),)
        elif kind == "READ":
            # A register that reads X keeps the text of its digits, so that it equals no number.
            address, value = int(values[0]), int(values[1]) if values[1].isdigit() else values[1]
            result.registers[address] = value
            result.reads += ((address, value),)
        elif kind == "RESET":
            result.resets += (int(values[0]),)
        elif kind == "RESULT":
            result.counters[values[0]] = int(values[1])
        elif kind in ("AVALON-ERROR", "AXI-ERROR", "FAILED"):
            result.errors += (line,)

    def finish(self):
        """The result, if the run was right and complete."""
        result, counters = self.result, self.result.counters
        result.total_clocks = counters.pop("total_clocks", 0)
        result.bytes_written = counters.pop("output_bytes", 0)
        result.bytes_read = tuple(counters.get(f"read{k}_beats", 0) * self.word
                                  for k in range(self.readers))
        if not result.total_clocks:
            result.errors += ("FAILED the simulation ended without a result",)
        if result.errors:
            more = f" and {len(result.errors) - 1} more" if len(result.errors) > 1 else ""
            raise SimulationError(f"simulation failed: {result.errors[0]}{more}", result)
        self.progress(1.0)
        return result
