"""No signal goes from one clock to the other but by the ways that are named here.

Found in the netlist: a register that reads one of the other clock is a row of the table below, or
the test fails. How the synchronisers behave is tested in ``tests/sim/test_crossing.py``.
"""

import pytest
from amaranth import *
from amaranth.back import rtlil
from amaranth.lib import data
from amaranth.lib.cdc import FFSynchronizer

from cameras import barrel_descriptor
from crossings import Clocks, Wire
from ncdc_hdl.camera import capture
from ncdc_hdl.system import System
from ncdc_spec.camera_port import camera_port
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.system_map import LOCKED

QUEUE = "capture.queue.unbuffered"
SENSOR = ("sensor_clock", "sensor_frame_valid", "sensor_line_valid", "sensor_data")

# Source, first flop, its second one, bits. Of more than one bit only a Gray counter may be.
SYNCHRONISERS = (
    ("scl", "i2c.scl_cdc.stage0", "i2c.scl_cdc.stage1", 1),
    ("sda", "i2c.sda_cdc.stage0", "i2c.sda_cdc.stage1", 1),
    ("page.values", "capture.enable.stage0", "capture.enable.stage1", 1),
    ("capture.balance.asked", "capture.balance.asked_cdc.stage0",
     "capture.balance.asked_cdc.stage1", 1),
    ("capture.balance.taken", "capture.balance.taken_cdc.stage0",
     "capture.balance.taken_cdc.stage1", 1),
    ("capture.$signal", "capture.active.stage0", "capture.active.stage1", 1),
    (f"{QUEUE}.produce_w_gry", f"{QUEUE}.produce_cdc.stage0", f"{QUEUE}.produce_cdc.stage1", 10),
    (f"{QUEUE}.consume_r_gry", f"{QUEUE}.consume_cdc.stage0", f"{QUEUE}.consume_cdc.stage1", 10),
)
# At once, not with an edge: a reset, whose end goes through both flops.
RESETS = {("rst", "capture.reset.stage0"), ("rst", "capture.reset.stage1")}
# An entry of the queue is read when the counter that has passed it has crossed, gains when the bit
# has that says that they are to be taken.
WORDS = {(f"{QUEUE}.storage", f"{QUEUE}.r_data"), ("capture.balance.offered", "capture.balance.o")}
# Amaranth's queue has a level for its writer, with logic before a synchroniser. We do not use it.
UNUSED = "capture.queue.consume_buffered_cdc"
# Constant while the capture is active: registers that are locked then.
SETTINGS = {name for name in LOCKED if name.startswith(("SENT_", "WINDOW_", "BLACK_", "CURVE"))}


@pytest.fixture(scope="module")
def system():
    return System(barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, strength=.4),
                  Hardware(data_width=64))


@pytest.fixture(scope="module")
def clocks(system):
    return Clocks(rtlil.convert(system, name="ncdc_system", emit_src=False), {
        "scl": "", "sda": "", **dict.fromkeys(SENSOR, "sensor_clock")})


def registers_in(system, bits):
    """Names of the page's registers that some bits of their values are of."""
    layout = data.StructLayout({r.name: r.shape.width for r in system.table if r.access == "rw"})
    return {name for name, field in layout
            if not bits.isdisjoint(range(field.offset, field.offset + field.width))}


def unknown(crossings, prefix):
    """Those whose sink is no synchroniser, reset or word of the tables above."""
    known = {sink for _, sink, *_ in SYNCHRONISERS} | {sink for _, sink in RESETS | WORDS}
    known |= {f"{UNUSED}.stage0"}
    return {c for c in crossings if prefix + c.sink not in known}


@pytest.mark.longer
def test_every_crossing_is_a_known_one(system, clocks):
    crossings = clocks.crossings()
    pairs = {(c.source, c.sink) for c in crossings}
    assert {(source, sink) for source, sink, *_ in SYNCHRONISERS} | RESETS | WORDS <= pairs
    settings = unknown(crossings, "")
    assert {c.source for c in settings} == {"page.values"}
    assert all(c.sink.startswith("capture.side.port.") for c in settings)
    assert set().union(*(registers_in(system, c.bits) for c in settings)) == SETTINGS


@pytest.mark.longer
def test_nothing_but_wires_leads_to_a_synchroniser(system, clocks):
    crossings = clocks.crossings()
    for source, first, _, width in SYNCHRONISERS:
        found, = (c for c in crossings if c.sink == first)
        assert (found.source, len(found.bits), found.direct) == (source, width, True)
        if source == "page.values":
            assert registers_in(system, found.bits) == {"CAMERA_ENABLE"}


@pytest.mark.longer
def test_only_the_second_flop_reads_the_first(clocks):
    for _, first, second, _ in SYNCHRONISERS:
        assert clocks.readers(first) == {second: True}
    assert clocks.readers("capture.reset.stage0") == {"capture.reset.stage1": True}


@pytest.mark.longer
def test_nothing_reads_what_has_logic_before_its_synchroniser(clocks):
    assert clocks.readers(f"{UNUSED}.stage0") == {f"{UNUSED}.stage1": True}
    assert clocks.readers(f"{UNUSED}.stage3") == {}


def crossings_of_capture():
    alone = capture.Capture(32, burst=4, depth=512)
    pins = ("clock", *(f"camera__pins__{name}" for name in ("frame_valid", "line_valid", "data")))
    netlist = rtlil.convert(alone, name="capture", emit_src=False)
    return Clocks(netlist, dict.fromkeys(pins, "clock")).crossings()


def test_a_crossing_without_a_synchroniser_is_found(monkeypatch):
    assert {c.source for c in unknown(crossings_of_capture(), "capture.")} == {"settings"}
    monkeypatch.setattr(capture, "FFSynchronizer", Wire)
    found = {(c.source, c.sink) for c in unknown(crossings_of_capture(), "capture.")}
    assert ("enable", "side.port.enabled_begins") in found
    assert "active" in {sink for _, sink in found}


def test_logic_before_a_synchroniser_is_found(monkeypatch):
    class Gated(Elaboratable):
        """A planted error: a gate before a synchroniser."""

        def __init__(self, i, o, **options):
            self.i, self.gated = i, Signal()
            self.inner = FFSynchronizer(self.gated, o, **options)

        def elaborate(self, platform):
            m = Module()
            m.d.comb += self.gated.eq(self.i & ResetSignal())
            m.submodules.inner = self.inner
            return m

    monkeypatch.setattr(capture, "FFSynchronizer", Gated)
    found = {c.sink: c.direct for c in crossings_of_capture() if "inner" in c.sink}
    assert found == {"active.inner.stage0": False, "enable.inner.stage0": False}


@pytest.mark.longer
@pytest.mark.parametrize("kind,settings", [("axis", {"SENT_HEIGHT"}),
                                           ("csi2:2", {"CSI_CHANNEL", "CSI_TYPE"})])
def test_a_source_reads_locked_settings_and_its_faults_cross_one_by_one(kind, settings):
    camera = camera_port(kind)
    system = System(barrel_descriptor((64, 24), (64, 24), hidden_neurons=2), Hardware(
        data_width=64), camera=camera)
    pins = [name for name in system.signature.members if name.startswith("sensor_")]
    clocks = Clocks(rtlil.convert(system, name="ncdc_system", emit_src=False), {
        "scl": "", "sda": "", **dict.fromkeys(pins, "sensor_clock")})
    found = unknown(clocks.crossings(), "")
    # Outputs of the module count as those of its clock.
    counted = {c for c in found if c.sink.startswith("capture.faults.")}
    read = {c for c in found - counted if c.source == "page.values"}
    assert {c.sink for c in found - counted - read} <= {"sensor_tready"}
    assert {(c.source, c.sink, len(c.bits), c.direct) for c in counted} == {
        (f"capture.faults.{name}_changes", f"capture.faults.{name}.stage0", 1, True)
        for name in camera.faults}
    assert set().union(*(registers_in(system, c.bits) for c in read)) == SETTINGS | settings
    assert settings <= set(LOCKED)


@pytest.mark.longer
def test_settings_of_the_grid_stage_are_locked_too():
    system = System(barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, strength=.4),
                    Hardware(data_width=64), grid=80)
    netlist = rtlil.convert(system, name="ncdc_system", emit_src=False)
    found = unknown(Clocks(netlist, {"scl": "", "sda": "", **dict.fromkeys(
        SENSOR, "sensor_clock")}).crossings(), "")
    assert {c.source for c in found} == {"page.values"}
    assert set().union(*(registers_in(system, c.bits) for c in found)) == SETTINGS | {
        "GRID_WEIGHT", "GRID_BIN"} <= set(LOCKED)
