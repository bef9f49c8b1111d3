"""A board's core on its SDRAM, between a sensor's pins and a gigabit line, as a program that runs.

A host in Python replaces its processor, and reads and writes its registers in simulated time.
"""

import subprocess
import tempfile
from collections import deque
from contextlib import suppress
from pathlib import Path

import numpy as np

from ncdc_boards.camera_board.core import BoardCore
from ncdc_boards.camera_board.design import design_of, hardware_for, sensor_for
from ncdc_boards.camera_board.programs import register_addresses
from ncdc_hdl.export.verilog import module_verilog
from ncdc_hdl.link.processor import LINK_BASE
from ncdc_hdl.video.modes import VideoMode
from ncdc_sim.link.mac import mac_verilog
from ncdc_sim.runner import HDL, build_bench, command_of
from ncdc_sim.sdram import chip_parameters
from ncdc_sim.sensor.reference import raw_frames
from ncdc_sim.sensor.verilog import Light, sensor_sources
from ncdc_sim.tools import SimulationError, environment
from ncdc_spec.registers.link_map import LINK, TEMPLATES
from ncdc_spec.sensors.level import levelled

__all__ = ["CORE_MHZ", "HEADERS", "LINE_HZ", "NetworkModel", "NetworkRun"]

CORE_MHZ = 100                          # of the core and its SDRAM, if nothing else is asked for
LINE_HZ = 125_000_000
HEADERS = LINK_BASE + TEMPLATES         # word address of the packetiser's headers
_SENSOR = "mt9p031"
_PIXEL_CLOCK_HZ = 80_000_000            # of the sensor; its PLL makes it of the boards' 25 MHz
_EXPOSURE_US = 1000
# The firmware's: 4,300 clocks for a picture, in which it makes some 84 accesses; and its loop.
_PACE, _POLL = 50, 1000
_TIMEOUT = 20_000_000                  # clocks for which nothing may come
_END, _WRITE, _READ, _WAIT, _UNTIL, _COUNTS = range(6)


class NetworkModel:
    """A board's design with its processor's ports and its network, compiled.

    Parameters
    ----------
    board : Board
        With Ethernet at RGMII, its device one of Altera's.
    descriptor : Descriptor
    frames_per_second : float
        Frame rate of the sensor.
    hardware : Hardware, optional
        That of :func:`hardware_for` if absent.
    core_mhz : number
        Clock of the core and its SDRAM.
    frames : int
        Different ones that the sensor sees, of noise, in turn.
    optimise : str, optional
        As of :func:`ncdc_sim.runner.build`.

    Attributes
    ----------
    design : Design
    setup : Setup
        Configuration of the sensor.
    raw : ndarray of uint8, shape (frames, height, width)
        The raw frames that are captured.
    at : dict
        Word address of each register, by name.
    """

    def __init__(self, board, descriptor, frames_per_second=0.0, *, hardware=None,
                 core_mhz=CORE_MHZ, frames=4, optimise=None):
        geometry = descriptor.geometry
        sensor = sensor_for(_SENSOR, geometry, pixel_clock_hz=_PIXEL_CLOCK_HZ,
                            exposure_us=_EXPOSURE_US, frames_per_second=frames_per_second)
        self.setup, crop = sensor
        self.descriptor = descriptor
        self.design = design_of(
            board, [("lens", descriptor)], sensor, _slow(geometry.corrected),
            hardware=hardware or hardware_for(board), core_mhz=core_mhz, processor=True,
            time_scale=1000, waits=False, i2c_hz=400_000)
        asked = self.setup.settings
        sent = (frames, asked.height, asked.width)
        self.light = Light(np.random.default_rng(1).integers(0, 4096, sent, dtype=np.uint16),
                           asked.left, asked.top)
        self.raw = levelled(crop.raw(raw_frames(self.setup, self.light), geometry.distorted),
                            self.setup.sensor.black)
        self.at = register_addresses(self.design.system) | {
            register.name: LINK_BASE + register.address for register in LINK}
        self.program = self._build(optimise)

    def _build(self, optimise):
        chip = self.design.board.chip
        parameters = chip_parameters(chip, self.design.core_hz)
        defines = {"NCDC_SENSOR": f'"{_SENSOR}"', "NCDC_DQ": chip.data_bits,
                   "NCDC_MASKS": chip.data_bits // 8,
                   "NCDC_CHIP": ", ".join(f".{name}({value})" for name, value
                                          in parameters.items())}
        header = "".join(f"`define {key} {value}\n" for key, value in defines.items())
        sources = [("network_bench.v", header + (HDL / "network_bench.v").read_text()),
                   ("board_core.v", module_verilog(BoardCore(self.design), "board_core")),
                   ("mac.v", mac_verilog(self.design.board.device)),
                   ("sdram_chip.v", (HDL / "sdram_chip.v").read_text()), *sensor_sources()]
        # LiteX's Verilog is others': its warnings are not ours to mend. Cells with delays are
        # among those that are not used.
        return build_bench("network", "network_bench", sources, optimise=optimise, options=(
            "--no-timing", "-Wno-fatal", "-CFLAGS", "-fno-tree-slp-vectorize"))


def _slow(size):
    """A video mode of that size whose lines come as slowly as a monitor's clock allows."""
    width, height = size
    return VideoMode((width, 48, 32, 340), (height, 3, 5, 6), True, (101, 200), "@slow")


class NetworkRun:
    """A :class:`NetworkModel` that runs, as a context.

    Parameters
    ----------
    model : NetworkModel
    screen : bool
        Whether the screen reads frames from the memory too.

    Attributes
    ----------
    results : dict
        Numbers of the bench, once :meth:`end` was called.
    record : bytes
        Record of the line, in the format of ``hdl/network_bench.v``.

    Raises
    ------
    SimulationError
        From every method, if the program has ended, or what was waited for does not come.
    """

    def __init__(self, model, screen=False):
        self.model, self.results, self.record = model, {}, b""
        self._screen = screen
        self._last = deque(maxlen=20)

    def __enter__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="ncdc-")
        folder, model = Path(self._folder.name), self.model
        (folder / "sensor.bin").write_bytes(model.light.data())
        periods = {
            "clk": 10**12 // model.design.core_hz, "line": 10**12 // LINE_HZ,
            "extclk": 10**12 // _PIXEL_CLOCK_HZ,
            "pixel": round(1e6 / model.design.clocks.pixel_mhz) if self._screen else 0}
        settings = {f"{name}_period": period for name, period in periods.items()}
        # The first edges of no two clocks come together.
        settings |= {f"{name}_phase": period // 2 + 500 * k
                     for k, (name, period) in enumerate(periods.items())}
        settings |= {
            "pace": _PACE, "poll": _POLL, "timeout": _TIMEOUT}
        self._process = subprocess.Popen(
            [*command_of(model.program), *(f"+{key}={value}" for key, value in settings.items()),
             *model.light.plusargs("sensor.bin", model.design.time_scale)], cwd=folder,
            env=environment(), text=True, errors="replace", stdin=subprocess.PIPE,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        return self

    def __exit__(self, *failure):
        self._process.kill()
        self._process.communicate()
        self._folder.cleanup()

    def write(self, name, value):
        """Write a register, given by its name or its word address."""
        self._ask(_WRITE, self.model.at.get(name, name), value)

    def read(self, name):
        """The value of a register."""
        return int(self._ask(_READ, self.model.at[name])[0])

    def until(self, name, mask, value):
        """Read a register until its bits of ``mask`` are ``value``; the whole value."""
        return int(self._ask(_UNTIL, self.model.at[name], mask, value)[0])

    def wait(self, clocks):
        """Let so many clocks go by."""
        self._ask(_WAIT, clocks)

    def counts(self):
        """Clocks since the start; those in which the SDRAM read, and was written."""
        return tuple(map(int, self._ask(_COUNTS)))

    def end(self):
        """End the run; see ``results`` and ``record``."""
        self._ask(_END)
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(60)
        self.record = (Path(self._folder.name) / "wire.bin").read_bytes()

    def _ask(self, operation, a=0, b=0, c=0):
        """Send a command; the words of its answer but for the first."""
        with suppress(BrokenPipeError):         # what it printed before it ended says why
            self._process.stdin.write(f"{operation:x} {a:x} {b:x} {c:x}\n")
            self._process.stdin.flush()
        for line in self._process.stdout:
            kind, *values = line.split() or [""]
            if kind in ("DONE", "READ", "COUNTS", "END"):
                return values
            self._last.append(line.strip())
            if kind == "RESULT":
                self.results[values[0]] = int(values[1])
            elif kind == "LATE":
                raise SimulationError(f"register {a:#x} stays {int(values[0]):#x}")
            elif kind in ("FAILED", "SENSOR-ERROR", "SDRAM-VIOLATION"):
                raise SimulationError(f"simulation failed: {line.strip()}")
        raise SimulationError(f"the simulation has ended with status {self._process.wait()}:\n"
                              + "\n".join(self._last))
