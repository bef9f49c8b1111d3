"""A PHY of an ECP5's cells and a receiver, run on the wires of a transmitter."""

from dataclasses import dataclass, field

from amaranth import *
from amaranth.back import verilog
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_boards.ecp5.csi2_phy import Ecp5Csi2Phy
from ncdc_hdl.camera.csi2.burst_start import settle_clocks
from ncdc_hdl.camera.csi2.eye_search import EYE
from ncdc_hdl.camera.csi2.receiver import Receiver
from ncdc_hdl.camera.samples import samples
from ncdc_sim.runner import build, hdl_text, results_of
from ncdc_sim.tools import SimulationError
from ncdc_spec.sensors.csi2 import DataType

__all__ = ["HEIGHT", "LANES", "WIDTH", "PhyRun", "run_phy", "sent_row"]

LANES = 2
WIDTH, HEIGHT = 32, 6           # of a frame of the bench
_SEARCH = {"steps": 16, "bursts": 4, "stride": 8, "timeout": 20_000}
_FILES = ("csi2_phy_bench.v", "csi2_pins.v", "csi2_transmitter.v", "ecp5_cells.v")


class _PhyReceiver(wiring.Component):
    """Both, with the ports of the bench."""

    def __init__(self, lane_hz):
        self.lane_hz = lane_hz
        super().__init__({
            "pair": In(1), "pairs": In(LANES), "low_power": In(LANES), "clock": Out(1),
            "ready": Out(1), "eyes": Out(EYE).array(LANES), "failures": Out(8),
            "o": Out(samples(LANES))})

    def elaborate(self, platform):
        m = Module()
        m.domains.lanes = ClockDomain(local=True, reset_less=True)
        m.submodules.phy = phy = Ecp5Csi2Phy(LANES, **_SEARCH)
        m.submodules.receiver = receiver = DomainRenamer("lanes")(Receiver(LANES))
        for ours, theirs in zip(phy.o, receiver.i):
            connect(m, ours, theirs)
        connect(m, receiver.o, flipped(self.o))
        m.d.comb += [
            ClockSignal("lanes").eq(phy.clock), self.clock.eq(phy.clock), phy.pair.eq(self.pair),
            phy.pairs.eq(self.pairs), phy.low_power.eq(self.low_power),
            phy.settle.eq(settle_clocks(self.lane_hz)), self.ready.eq(phy.ready),
            self.failures.eq(phy.failures), receiver.settings.type.eq(DataType.RAW10)]
        for ours, theirs in zip(self.eyes, phy.eyes):
            m.d.comb += ours.eq(theirs)
        return m


@dataclass
class PhyRun:
    """Results of a run.

    Parameters
    ----------
    results : dict
        Numbers of the bench, by name: ``ready``, ``failures``, ``step0`` and so on.
    frames : list of (list of rows, bool)
        The frames that ended, and whether they were bad.
    """
    results: dict = field(default_factory=dict)
    frames: list = field(default_factory=list)


def sent_row(number, y):
    """Samples, of 12 bits, of a row of frame ``number`` of the bench."""
    return [(37 * x + 91 * y + 17 * number) % 1024 << 2 for x in range(WIDTH)]


def run_phy(frames, *, lane_hz=456_000_000, edit=lambda text: text, **plusargs):
    """A :class:`PhyRun` of so many frames; ``plusargs`` are those of the bench.

    Raises
    ------
    SimulationError
        If the Verilog does not compile or the run fails.
    """
    text = edit(verilog.convert(_PhyReceiver(lane_hz), name="phy_receiver",
                                strip_internal_attrs=True))
    sources = [("phy_receiver.v", text), *((name, hdl_text(name)) for name in _FILES)]
    program = build("phy", "csi2_phy_bench", sources, optimise="-O0", options=(
        "--timing", "--main", "-CFLAGS", "-std=c++20 -fcoroutines", "-Wno-ZERODLY",
        "-Wno-PINMISSING"))
    run, rows, row = PhyRun(), [], []

    def hear(kind, *values):
        nonlocal rows, row
        if kind.endswith("-ERROR"):
            raise SimulationError(f"simulation failed: {kind} {' '.join(values)}")
        if kind != "STREAM":
            return
        valid, first, last, end, bad, *sample = map(int, values)
        if first:
            rows, row = [], []
        row += sample[:valid.bit_count()]
        if last:
            rows, row = [*rows, row], []
        if end:
            run.frames.append((rows, bool(bad)))

    run.results = results_of(program, {"frames": frames, "csi2_lane_hz": lane_hz, **plusargs}, hear)
    return run
