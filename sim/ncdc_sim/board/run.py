"""The design of a board, whole, between a sensor, an SDRAM chip and a monitor."""

import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from ncdc_boards.board import project_name
from ncdc_boards.ecp5.build import prepared
from ncdc_boards.quartus.project import top_verilog
from ncdc_boards.quartus.user import user_module
from ncdc_sim.board.ethernet import passed
from ncdc_sim.board.screen import Screen, screen_of
from ncdc_sim.runner import HDL, build, command_of, run
from ncdc_sim.sdram import chip_parameters
from ncdc_sim.sensor.verilog import sensor_sources
from ncdc_sim.tools import SimulationError

__all__ = ["BoardRun", "request_at", "scans_at", "simulate_board", "unplugged_at"]

_REFERENCE_MHZ = 25         # of the boards, to the sensor

# The bench comes first.
_ULX3S = ("ulx3s_bench.v", "ecp5_cells.v", "dvi_monitor.v", "csi2_pins.v")
_COLORLIGHT_I9 = ("colorlight_i9_bench.v", "ecp5_cells.v")
_QUARTUS = ("quartus_bench.v", "altera_cells.v", "virtual_jtag.v")
_SHARED = ("sdram_board.v", "board_run.v", "uart_host.v", "sdram_chip.v")
# Warnings of Verilator for the netlist of a whole top: signals of no bits, unused outputs of cells,
# comparisons that are constant for some lens, and delays from plusargs.
_RULES = ("ASCRANGE", "PINMISSING", "UNSIGNED", "ZERODLY")


@dataclass
class BoardRun:
    """Results of a run.

    Parameters
    ----------
    screen : Screen or None
        None if the board has none.
    results : dict
        Numbers of the bench, by name.
    pixel_clock_ps : float
        Period that the monitor measured.
    serial : bytes
        Output of the serial port.
    scans : list of int
        Output of JTAG, a number for each scan.
    sent : list of Passed
        Ethernet frames that were sent, without preamble and check sequence.
    leds : list of (int, int)
        Microsecond of a change, and the LEDs from then on; bit k is LED k.
    sensor_frames : list of int
        Numbers of the frames that the sensor began, counted from its start.
    early : int
        Accesses over I2C before the sensor's time.
    """
    screen: Screen = None
    results: dict = field(default_factory=dict)
    pixel_clock_ps: float = 0.0
    serial: bytes = b""
    scans: list = field(default_factory=list)
    sent: list = field(default_factory=list)
    leds: list = field(default_factory=list)
    sensor_frames: list = field(default_factory=list)
    early: int = 0

    def take(self, line):
        """Record a line of the bench; SimulationError if it reports an error."""
        kind, *values = line.split() or [""]
        if kind == "RESULT":
            self.results[values[0]] = int(values[1])
        elif line.startswith("MONITOR clock"):
            self.pixel_clock_ps = float(values[1])
        elif kind == "UART":
            self.serial += bytes.fromhex(values[0])
        elif kind == "LED":
            self.leds.append((int(values[0]), int(values[1])))
        elif line == "SENSOR early":
            self.early += 1
        elif line.startswith("SENSOR frame"):
            self.sensor_frames.append(int(values[1]))
        elif kind == "JTAG":
            self.scans.append(int(values[0], 16))
        elif kind in ("SENSOR-ERROR", "BOARD-ERROR", "MONITOR-ERROR"):
            raise SimulationError(f"simulation failed: {line}")


def simulate_board(design, sensor, light, *, run_us, events=None, edit=None, optimise=None,
                   ethernet=None):
    """Run a :class:`~ncdc_boards.camera_board.core.Design` for so many microseconds.

    Parameters
    ----------
    design : Design
    sensor, light : str, Light
        Name of the sensor's model, and light on it; None with a test pattern.
    run_us : int
    events : dict, optional
        Plusargs of ``hdl/board_run.v``, buttons that are pressed, of :func:`request_at`, of
        :func:`scans_at` and of :func:`unplugged_at`.
    edit : callable, optional
        Changes the Verilog of the top: to see a test fail.
    optimise : str, optional
        As of :func:`ncdc_sim.runner.build`.
    ethernet : Ethernet, optional
        Cable of a design with a processor.

    Raises
    ------
    SimulationError
        If it does not compile, or the monitor saw no picture. If the sensor or a cell of the device
        was used outside its specification.
    """
    name, verilog, files = _top(design)
    verilog = edit(verilog) if edit else verilog
    processor = ethernet.files.verilog if ethernet else {}
    board, chip = design.board, chip_parameters(design.board.chip, design.core_hz)
    defines = {"NCDC_CHIP": ", ".join(f".{key}({_number(value)})" for key, value in chip.items()),
               **({"NCDC_PATTERN": 1} if design.pattern else {"NCDC_SENSOR": f'"{sensor}"'}),
               **({"NCDC_CSI2": design.link.lanes} if design.link else {}),
               "NCDC_TOP": name, "NCDC_DQ": board.chip.data_bits,
               "NCDC_BAUD": board.baud, **_screen(design),
               **({"NCDC_ETHERNET": 1} if ethernet else {})}
    header = "".join(f"`define {key} {value}\n" for key, value in defines.items())
    files = (*files, *_SHARED, *(["rgmii_chip.v"] if ethernet else []))
    sources = [(f"{name}.v", header + verilog), *processor.items(),
               *((file, (HDL / file).read_text()) for file in files), *sensor_sources()]
    bench = files[0].removesuffix(".v")
    program = build(name, bench, sources, optimise=optimise, options=(
        "--timing", "--main", "-CFLAGS", "-std=c++20 -fcoroutines",
        # LiteX's Verilog and the processor's are others': their warnings are not ours to mend.
        *(["-Wno-fatal"] if ethernet else []), *(f"-Wno-{rule}" for rule in _RULES)))
    result = BoardRun()
    settings = {"run_us": run_us} | _lanes(design) | (events or {})
    plusargs = [f"+{key}={value}" for key, value in settings.items()]
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        if light:
            (folder / "sensor.bin").write_bytes(light.data())
            plusargs += light.plusargs("sensor.bin", design.time_scale)
        if ethernet:
            ethernet.fill(folder)
        run([*command_of(program), *plusargs], folder, result.take)
        if design.mode:
            result.screen = screen_of((folder / "screen.bin").read_bytes())
        if ethernet:
            result.sent = passed((folder / "tx.bin").read_bytes())
    return result


def request_at(microsecond, data):
    """Events: bytes are sent to the board's serial port."""
    return {"uart_at_us": microsecond, "uart_bytes": data.hex(), "uart_count": len(data)}


def scans_at(microsecond, values):
    """Events: numbers of 64 bits are scanned into the chain of a Quartus board, one by one."""
    return {"jtag_at_us": microsecond, "jtag_scans": "".join(f"{value:016x}" for value in values),
            "jtag_count": len(values)}


def unplugged_at(microsecond, microseconds):
    """Events: the sensor has no supply for so many microseconds, its reference being 25 MHz."""
    return {"sensor_fault": "unplug", "sensor_fault_start": _REFERENCE_MHZ * microsecond,
            "sensor_fault_clocks": _REFERENCE_MHZ * microseconds}


def _top(design):
    """Name of the top, its Verilog, the bench's own files."""
    name = project_name(design.board)
    if design.board.tools == "open":
        bench = _ULX3S if design.board.screen else _COLORLIGHT_I9
        return name, prepared(design)[f"{name}.v"], bench
    monitor = "vga_monitor.v" if design.board.dac else "vga_wire_monitor.v"
    return name, top_verilog(design) + user_module(), (*_QUARTUS, monitor)


def _lanes(design):
    """Plusargs of a sensor with CSI-2, whose external clock counts its pixels."""
    if not design.link:
        return {}
    pixel_hz = design.sensor[0].timing.pixel_clock_hz
    return {"csi2_lane_hz": design.link.lane_hz, "csi2_pixel_hz": pixel_hz,
            "sensor_khz": pixel_hz // 1000}


def _screen(design):
    """Macros that configure the bench for the board's screen."""
    if design.board.tools == "open":
        return {}
    if design.board.dac:
        return {"NCDC_DAC": 1}
    mode, parts = design.mode, ("", "_FRONT", "_SYNC", "_BACK")
    values = {f"{axis}{part}": length for axis, lengths in (("H", mode.horizontal),
                                                            ("V", mode.vertical))
              for part, length in zip(parts, lengths)} | {"HIGH": int(mode.high)}
    return {"NCDC_MODE": ", ".join(f".{name}({value})" for name, value in values.items())}


def _number(value):
    """A parameter of more than 32 bits needs its width."""
    return f"64'd{value}" if value >= 1 << 31 else str(value)
