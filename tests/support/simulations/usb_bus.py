"""Words both ways through a UsbFifo and the model of its chip."""

from dataclasses import dataclass

from ncdc_hdl.export.verilog import module_verilog
from ncdc_sim.runner import HDL, build_bench, results_of
from ncdc_sim.tools import SimulationError
from simulations import HDL as OWN

__all__ = ["TIMINGS", "BusRun", "Timing", "simulate_bus"]


@dataclass(frozen=True)
class Timing:
    """Times at the pins of a chip, in ps.

    Parameters
    ----------
    out_min, out_max : int
        From the clock to the chip's pins.
    setup, hold : int
        The chip's requirements on the FPGA's outputs.
    fpga_out : int
        From the clock to the FPGA's pins, as late as the setup time allows.
    """
    out_min: int
    out_max: int
    setup: int
    hold: int
    fpga_out: int


TIMINGS = {
    # FTDI, "FT232H", FT_000288 version 2.1, table 4.1: t4, t5, t11; t7, t9, t12, t14; t8, t10.
    "FT232H": Timing(0, 9000, 7500, 0, 9100),
    # Lime Microsystems' constraints for LimeSDR Mini (FT601_timing.sdc): outputs 4 to 7 ns after
    # the clock. Their setup time of 0.5 ns is doubled here.
    "FT601": Timing(4000, 7000, 1000, 0, 8900),
}


@dataclass(frozen=True)
class BusRun:
    """Results of a run.

    Parameters
    ----------
    results : dict
        Counters of the bench.
    lines : list of str
        Errors that the chip's model printed.
    """
    results: dict
    lines: list

    def rate(self, direction):
        """Words per clock of the chip from the first word "up" or "down" to the last."""
        return self.results[direction] / self.results[f"{direction}_clocks"]

    def rate_unpaused(self, direction):
        """The same, of the clocks in which the chip did not pause."""
        return self.results[direction] / (self.results[f"{direction}_clocks"]
                                          - self.results[f"{direction}_paused"])


def simulate_bus(fifo, *, up, down, simulator="verilator", timed=False, verilog=None, **options):
    """Send ``up`` words to the host and ``down`` words from it, through ``fifo``, a UsbFifo.

    Parameters
    ----------
    timed : bool
        Whether the pins change as late as :data:`TIMINGS` has it (Icarus only).
    verilog : str, optional
        Text of a module ``dut`` with the same ports, instead of the fifo's own.
    options : int
        Plusargs of ``usb_bench.v``: pauses, in clocks of 256, and clock periods in ps.

    Raises
    ------
    SimulationError
        If a word is lost, doubled or changed, or a rule of the chip is broken.
    """
    chip = fifo.chip
    defines = {"NCDC_LANES": chip.lanes}
    if timed:
        timing = TIMINGS[chip.name]
        defines |= {"NCDC_TIMED": None, **{f"NCDC_{name.upper()}": value
                                           for name, value in vars(timing).items()}}
    files = [HDL / "ft245_chip.v", OWN / "usb_bench.v"]
    text = verilog or module_verilog(fifo, "dut")
    sources = [("dut.v", "`timescale 1ps/1ps\n" + text)]
    sources += [(path.name, path.read_text()) for path in files]
    program = build_bench("usb", "usb_bench", sources, defines=defines, simulator=simulator)
    plusargs = {"up": up, "down": down, "extclk_period": round(1e12 / chip.clock_hz), **options}
    lines = []

    def hear(*words):
        if words[0] in ("USB-ERROR", "DIFFERENT"):
            lines.append(" ".join(words))

    results = results_of(program, plusargs, hear)
    outcome = BusRun(results, lines)
    wrong = {name: results.get(name) for name, right in (
        ("up", up), ("down", down), ("different", 0), ("errors", 0)) if results.get(name) != right}
    if wrong:
        raise SimulationError(f"the USB bus went wrong: {wrong}; {'; '.join(lines[:5])}")
    return outcome
