"""A simulated system that a host in Python talks to: registers, interrupt, memory, resets."""

import subprocess
import tempfile
from collections import deque
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

from ncdc_hdl.export.verilog.system_cover import SYSTEM
from ncdc_sim.memory.timing import memory_settings, simulated_memory
from ncdc_sim.ports import ports_of
from ncdc_sim.runner import build_bench, command_of, hdl_text
from ncdc_sim.sensor.verilog import Fault, sensor_sources
from ncdc_sim.tools import SimulationError, environment
from ncdc_sim.transcript import Transcript
from ncdc_sim.waves import Waves, build_options, recorded
from ncdc_spec.camera_port import AXIS, CameraPort
from ncdc_spec.errors import InputError

__all__ = ["Clocks", "LiveRun", "LiveSystem"]

_BENCH = ("system_bench.v", "digest.v", "avalon_memory.v", "dram_timing.v", "avalon_checker.v",
          "stream_checker.v", "ft245_chip.v")
_END, _WRITE, _READ, _WAIT_IRQ, _WAIT, _SAVE, _RESET, _RESET_ALL, _STALL, _SENSOR, _STREAM, \
    _USB_SEND, _USB_GOT, _COUNT = range(14)
# With -O2 GCC 12 takes some words of 128 bits of the model for aligned ones, which they are not.
_OPTIONS = ("-CFLAGS", "-fno-tree-slp-vectorize")
_TRACE = 1000                  # clocks between two hashes of all outputs, of runs with a transcript
_TIMEOUT_S = 60                # for a run to end by itself, and to close its waveforms
_MIN_MEMORY = 1 << 24         # bytes; more frame sizes share one build


@dataclass(frozen=True)
class Clocks:
    """Periods of the system's and of the sensor's clock, and time of its first edge, in ps; period
    of the bytes of its lanes."""
    clk_period: int = 10000
    extclk_period: int = 10000
    extclk_phase: int = 5000
    lane_period: int = 10000


@dataclass(frozen=True)
class LiveRun:
    """Memory, clocks, simulator and options of a simulation.

    Parameters
    ----------
    memory : str or a memory
        As of :class:`ncdc_sim.system.frame.Run`, but for LiteDRAM.
    clocks : Clocks
    fault : Fault, optional
        Fault of the sensor.
    camera : CameraPort
        The system's. AXI4-Stream video comes from ``axis_camera.v``, which is no sensor.
    simulator : str
    seed : int
        Seed of the memory's random behaviour.
    sink_probability : int
        How often, of 256 clocks, the sink of a stream is ready.
    waves : Waves, optional
        Where to write the waveforms; they are complete after the context.
    clock_limit : int
        Clocks after which the run fails; 0: none.
    transcripts : list, optional
        The run's :class:`Transcript` is added to it when the context is left. USB and streams are
        not supported.
    more : sequence of str
        Further plusargs.
    """
    memory: object = "sdram"
    clocks: Clocks = Clocks()
    fault: Fault | None = None
    camera: CameraPort = CameraPort()
    simulator: str = "verilator"
    seed: int = 1
    sink_probability: int = 256
    waves: Waves | None = None
    clock_limit: int = 0
    transcripts: list | None = None
    more: tuple = ()


class LiveSystem:
    """The module ``ncdc_system`` of a Verilog text, running, as a context.

    Parameters
    ----------
    verilog : str
    sensor : str
        Name of a model that :mod:`ncdc_sim.sensor` has.
    light : Light
        Light on the sensor.
    memory_bytes : int
        From byte address 0 on; at first it holds 0xA5.
    run :
        As of :class:`LiveRun`.

    Attributes
    ----------
    memory_bytes : int
    now : int
        Clocks since the start, at the last answer.
    results : dict
        Counters of the bench, once :meth:`end` was called, and of flops that were metastable.

    Raises
    ------
    SimulationError
        From every method, if the program has ended, or a rule of a bus was broken.
    """

    def __init__(self, verilog, sensor, light, memory_bytes, **run):
        run = LiveRun(**run)
        memory = simulated_memory(run.memory)
        ports = ports_of(verilog, SYSTEM)
        self.width = ports["read0_readdata"]
        self.readers = sum(name.endswith("_readdata") and name.startswith("read")
                           for name in ports)
        self.stream, self.memory_bytes = "stream_data" in ports, memory_bytes
        if not hasattr(memory, "latency") and not hasattr(memory, "banks"):
            raise InputError("LiteDRAM cannot be the memory of a camera's run")
        binary = self._build(verilog, ports, self._camera(ports, sensor, run.camera),
                             run.simulator, memory_bytes, build_options(run.waves, run.simulator))
        settings = memory_settings(memory, self.width, self.readers) | {
            "memory_bytes": memory_bytes, "seed": run.seed, "clock_limit": run.clock_limit,
            "sink_probability": run.sink_probability, **vars(run.clocks),
            "csi2_lane_hz": 8 * 10**12 // run.clocks.lane_period}
        if run.transcripts is not None:
            settings["trace_every"] = _TRACE
        plusargs = [*(f"+{key}={value}" for key, value in settings.items()),
                    *light.plusargs("sensor.bin"), *(run.fault.plusargs() if run.fault else []),
                    *run.more]
        self._stack = ExitStack()
        self.folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="ncdc-")))
        self._records = run.waves is not None
        plusargs = [*self._stack.enter_context(recorded(run.waves, run.simulator)), *plusargs]
        (self.folder / "sensor.bin").write_bytes(light.data())
        self.now, self.results, self._last = 0, {}, deque(maxlen=20)
        self.sensor_lines = []
        self._transcripts, self._asked, self._heard = run.transcripts, [], []
        self._command = [*command_of(binary), *plusargs]
        self._process = subprocess.Popen(
            self._command, cwd=self.folder, env=environment(), text=True,
            errors="replace", stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT)
        self._stack.push(self._stop)

    @staticmethod
    def _camera(ports, sensor, camera):
        """Macros of the bench for a camera: (defines, sources of its model)."""
        if camera.kind == AXIS:
            return ({"NCDC_AXIS": camera.samples, "NCDC_SAMPLE_BITS": camera.bits},
                    [("axis_camera.v", hdl_text("axis_camera.v"))])
        defines = {"NCDC_SENSOR": f'"{sensor}"'}
        if "sensor_lane0_data" in ports:
            defines |= {"NCDC_CSI2": sum(name.startswith("sensor_lane") and name.endswith("_data")
                                         for name in ports)}
        return defines, sensor_sources()

    def _build(self, verilog, ports, camera, simulator, memory_bytes, options):
        camera_defines, camera_sources = camera
        defines = {"NCDC_DATA_WIDTH": self.width, "NCDC_READ_PORTS": self.readers,
                   "NCDC_READ_BURST_WIDTH": ports["read0_burstcount"],
                   "NCDC_MEMORY_BYTES": max(_MIN_MEMORY, 1 << (memory_bytes - 1).bit_length()),
                   **camera_defines}
        if "usb_clock" in ports:
            defines |= {"NCDC_USB": self.readers - 1, "NCDC_USB_LANES": ports["usb_be_o"]}
        readers = self.readers - ("usb_clock" in ports)
        defines |= {"NCDC_THREE_READ_PORTS": None} if readers == 3 else {}
        defines |= {"NCDC_STREAM": ports["stream_data"] // 24} if self.stream else {}
        sources = [*((name, hdl_text(name)) for name in _BENCH), *camera_sources,
                   ("ncdc_system.v", verilog)]
        return build_bench("system", "system_bench", sources, defines=defines,
                           simulator=simulator, options=(*_OPTIONS, *options))

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        return self._stack.__exit__(*failure)

    def _stop(self, kind, *_):
        """End the program; with waveforms it ends by itself at the end of its input."""
        if self._records and (kind is None or issubclass(kind, SimulationError)):
            with suppress(subprocess.TimeoutExpired):
                self._process.communicate(timeout=_TIMEOUT_S)
        if kind is None and self._transcripts is not None:
            self._transcribe()
        self._process.kill()
        self._process.communicate()

    def _transcribe(self):
        """Add the transcript of the run, which ends."""
        if not self._asked or self._asked[-1] != _line(_END):
            self.end()
        self._heard += self._process.stdout.read().splitlines()
        self._transcripts.append(Transcript(
            tuple(self._command), {"sensor.bin": (self.folder / "sensor.bin").read_bytes()},
            tuple(self._heard), {}, "".join(self._asked)))

    def write(self, address, value):
        """Write ``value`` to the register at a word address."""
        self._ask(_WRITE, address, value & 0xFFFFFFFF)

    def read(self, address):
        """The value of the register at a word address."""
        return int(self._ask(_READ, address)[0])

    def wait_irq(self, clocks):
        """Wait for the interrupt for so many clocks at most; whether it came."""
        return self._ask(_WAIT_IRQ, clocks)[0] == "1"

    def wait(self, clocks):
        """Let so many clocks go by."""
        self._ask(_WAIT, clocks)

    def memory(self, address, size):
        """So many bytes of the memory, which take no time; both multiples of a word."""
        self._ask(_SAVE, address, size)
        return (self.folder / "memory.bin").read_bytes()[:size]

    def reset(self, clocks=4, memory=False):
        """Reset the system, and the memory with it."""
        self._ask(_RESET_ALL if memory else _RESET, clocks)

    def stall(self, clocks):
        """Let the memory take nothing for so many clocks from now on."""
        self._ask(_STALL, clocks)

    def sensor_power(self, on):
        """Release the sensor's reset, or hold it."""
        self._ask(_SENSOR, int(on))

    def streamed(self):
        """All pixels that have left as a stream, three bytes each."""
        size = int(self._ask(_STREAM)[0])
        return (self.folder / "stream.bin").read_bytes()[:size]

    def counters(self):
        """The bench's counters so far, by name."""
        self._ask(_COUNT)
        return dict(self.results)

    def usb_send(self, data):
        """Let a host send bytes by USB, 65,536 at most that it has not sent as yet."""
        (self.folder / "usb_send.bin").write_bytes(data)
        self._ask(_USB_SEND, len(data))

    def usb_got(self):
        """File with all bytes that a host has got by USB, and how many."""
        return self.folder / "usb_got.bin", int(self._ask(_USB_GOT)[0])

    def end(self):
        """End the run; the bench's counters."""
        self._ask(_END)
        return self.results

    def _ask(self, operation, a=0, b=0):
        """Send a command; the words of its answer but for the first and the clocks."""
        self._asked.append(_line(operation, a, b))
        try:
            self._process.stdin.write(self._asked[-1])
            self._process.stdin.flush()
        except BrokenPipeError:
            pass                    # what it printed before it ended says why
        for line in self._process.stdout:
            self._last.append(line.rstrip())
            self._heard.append(line.rstrip())
            kind, *values = line.split() or [""]
            if kind in ("DONE", "READ", "IRQ", "STREAM", "END"):
                self.now = int(values[-1])
                return values[:-1]
            if kind in ("RESULT", "METASTABLE"):
                self.results[" ".join(values[:-1])] = int(values[-1])
            elif kind in ("AVALON-ERROR", "AXI-ERROR", "FAILED", "SENSOR-ERROR",
                          "USB-ERROR"):
                raise SimulationError(f"simulation failed: {line.strip()}")
            elif kind == "SENSOR":
                self.sensor_lines.append((self.now, line.strip()))
        raise SimulationError(f"the simulation has ended with status {self._process.wait()}:\n"
                              + "\n".join(self._last))


def _line(operation, a=0, b=0):
    """A command of ``system_bench.v``."""
    return f"{operation:x} {a:x} {b:x}\n"
