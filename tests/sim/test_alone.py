"""A component with a reset of its own: what it resets, and what of its outputs means something."""

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.entry_packer import EntryPacker
from ncdc_hdl.camera.level import Level
from ncdc_hdl.camera.moved import Moved
from ncdc_hdl.export.verilog import module_verilog
from ncdc_hdl.lib.gains import BALANCE, NO_BALANCE
from ncdc_hdl.lib.relay import Relay
from ncdc_hdl.lib.word_crossing import WordCrossing
from ncdc_sim.tools import SimulationError
from pipelines import run_bench
from simulations.traces import Alone, Units, replay, trace
from units.crossings import check_queue, check_relay, check_word_crossing, queue_of
from units.levels import check_level, check_moved
from units.sensor_entries import check_entry_packer


class Counter(wiring.Component):
    """Counts clocks; ``even`` says that the count is."""
    i: In(1)
    even: Out(1)
    o: Out(8)

    def elaborate(self, platform):
        m = Module()
        with m.If(self.i):
            m.d.sync += self.o.eq(self.o + 1)
        m.d.comb += self.even.eq(~self.o[0])
        return m


def count(dut):
    """Count, with a reset after seven clocks."""
    async def bench(ctx):
        ctx.set(dut.i, 1)
        for clock in range(20):
            ctx.set(dut.reset, int(clock == 7))
            await ctx.tick()

    run_bench(dut, bench)


def outputs(**means):
    """``o`` in each clock."""
    return [row[1] >> 1 for row in trace(Alone(Counter(), means=means), count)]


def test_its_reset_is_its_own():
    assert outputs() == [*range(8), *range(12)]


def test_an_output_that_means_nothing_is_zero():
    assert outputs(o=lambda part: part.even)[:6] == [0, 0, 2, 0, 4, 0]
    assert outputs(o=lambda part: Const(6, 8))[:6] == [0, 0, 2, 2, 4, 4]


def test_an_output_that_it_lacks():
    with pytest.raises(ValueError, match="Counter has no output other"):
        outputs(other=lambda part: part.even)


class Late(Counter):
    """The same, with the reset a clock late."""

    def elaborate(self, platform):
        m = super().elaborate(platform)
        late = Signal(reset_less=True)
        m.d.sync += late.eq(ResetSignal())
        with m.If(late):
            m.d.sync += self.o.eq(0)
        return m


def test_a_reset_that_acts_otherwise_is_found():
    right, wrong = ({"counter": Alone(part)} for part in (Counter(), Late()))
    traces = {"counter": trace(Alone(Counter()), count)}
    replay(right, traces, module_verilog(Units(right), "alone"), [], top="alone")
    with pytest.raises(SimulationError, match="FAILED clock 9:"):
        replay(right, traces, module_verilog(Units(wrong), "alone"), [], top="alone")


class Bright(Level):
    """A level whose gained samples are all odd."""

    def _gained(self, m):
        return super()._gained(m) | 1


class Forgetful(EntryPacker):
    """An entry whose first byte has a wrong bit."""

    def elaborate(self, platform):
        m = super().elaborate(platform)
        m.d.comb += self.o[0].eq(1)
        return m


def test_checks_of_parts_find_what_is_wrong():
    with pytest.raises(AssertionError):
        check_level(Alone(Bright()), settings=6)
    wrong = Moved()
    wrong.latency = Moved.latency + 1
    with pytest.raises(AssertionError):
        check_moved(Alone(wrong), count=200)
    with pytest.raises(AssertionError):
        check_entry_packer(Alone(Forgetful(1)), clocks=400)


def test_checks_of_parts_pass():
    check_level(Alone(Level()), settings=6)
    check_moved(Alone(Moved()), count=200)
    check_entry_packer(Alone(EntryPacker(1)), clocks=900)


def test_another_clock_and_crossings():
    check_relay(Alone(Relay(8), name="relay"), clocks=400)
    balance = DomainRenamer({"there": "camera"})(WordCrossing(BALANCE, init=NO_BALANCE))
    check_word_crossing(Alone(balance, name="balance", other="camera"), clocks=1500)
    queue = queue_of(9, 16, "sync", "pins")
    check_queue(Alone(queue, name="queue", other="pins", reset_less=True))


class Forgetting(Relay):
    """A relay that is always ready: what it cannot hold is lost."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.relay = relay = Relay(self.shape)
        m.d.comb += [relay.i.valid.eq(self.i.valid), relay.i.payload.eq(self.i.payload),
                     self.i.ready.eq(1), self.o.valid.eq(relay.o.valid),
                     self.o.payload.eq(relay.o.payload), relay.o.ready.eq(self.o.ready)]
        return m


def test_an_item_that_is_lost_is_found():
    with pytest.raises(AssertionError):
        check_relay(Alone(Forgetting(8)), clocks=400)
