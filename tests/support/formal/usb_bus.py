"""The bus to an FTDI chip."""

from amaranth import *
from amaranth.lib.wiring import In

from formal.properties import always, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_hdl.usb.fifo_bus import FifoBus

__all__ = ["UsbBus"]

_LATE = 2           # words that come after there was space


class UsbBus(Wrapper):
    """``FifoBus`` between a chip and queues that do what they like.

    Asserts that the chip takes the words of the queue in order, none twice and none missing; that
    a word which is read is handed on; and the rules of the bus.
    """

    def __init__(self, bus=FifoBus):
        self.dut = bus(1, turn=2)
        super().__init__({"rxf_n": In(1), "txe_n": In(1), "data": In(8), "valid": In(1),
                          "space": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut, pins = self.dut, self.dut.pins
        fragment = self.design(m, dut)
        there = inner(fragment, "there")
        offered, got = Signal(8), Signal(8)         # words that left the queue; that were taken
        m.d.comb += [
            pins.rxf_n.eq(self.rxf_n), pins.txe_n.eq(self.txe_n), pins.data_i.eq(self.data),
            pins.be_i.eq(1), dut.space.eq(self.space), dut.to_host.valid.eq(self.valid),
            dut.to_host.p.data.eq(offered), dut.to_host.p.enable.eq(1)]
        waits = self._before(m, self.valid & ~dut.to_host.ready, "waits")
        given(m, ~waits | self.valid)
        taken, read = Signal(), Signal()
        m.d.comb += [taken.eq(~pins.wr_n & ~pins.txe_n), read.eq(~pins.rd_n & ~pins.rxf_n)]
        m.d.sync += [offered.eq(offered + (self.valid & dut.to_host.ready)), got.eq(got + taken)]
        always(m, offered == (got + there)[:8], "as_many")
        always(m, ~there | (pins.data_o == got), "in_order")
        always(m, pins.wr_n | there, "a_word")
        always(m, dut.push == self._before(m, read, "read"), "handed_on")
        always(m, ~dut.push | (dut.from_host.data == self._before(m, self.data, "data")), "word")
        self._rules(m, pins)
        # What the pins are in each state: induction has to know.
        state = inner(fragment, "fsm_state")
        # They have numbers in the order in which they are first named.
        rest, turn, writes, reads = (state == k for k in range(4))
        oe, rd, wr = ~pins.oe_n, ~pins.rd_n, ~pins.wr_n
        always(m, ~rest | ~(oe | rd | wr | pins.data_oe), "at_rest")
        always(m, ~turn | oe & ~(rd | wr | pins.data_oe), "at_turn")
        always(m, ~reads | oe & ~(wr | pins.data_oe), "at_reads")
        always(m, ~writes | pins.data_oe & ~(oe | rd), "at_writes")
        late = Signal(range(_LATE + 2))             # words pushed since there was no space
        m.d.sync += late.eq(Mux(self.space, 0, late + dut.push))
        always(m, self.space | (late + dut.push <= _LATE), "space")
        once = self._before(m, self.space, "space")
        twice = self._before(m, once, "space2")
        always(m, pins.rd_n | once, "stops")
        always(m, ~dut.push | twice, "stopped")
        always(m, late <= Mux(once, 0, Mux(twice, 1, _LATE)), "late")
        reached(m, (got == 3) & there & self._before(m, pins.txe_n & ~pins.wr_n, "paused"),
                "paused")
        reached(m, read & (got == 2), "read_after_writes")
        reached(m, taken & self._before(m, self._before(m, dut.push, "p0"), "p1"), "write_after")
        return m

    def _rules(self, m, pins):
        """Assert the rules of the bus."""
        oe, driven = ~pins.oe_n, pins.data_oe
        before = {name: self._before(m, value, name) for name, value in (
            ("oe", oe), ("driven", driven), ("rd", ~pins.rd_n), ("wr", ~pins.wr_n),
            ("rxf", ~pins.rxf_n), ("txe", ~pins.txe_n))}
        always(m, pins.rd_n | oe & before["oe"], "oe_first")
        always(m, ~(oe & driven), "one_driver")
        always(m, ~(oe & before["driven"]) & ~(driven & before["oe"]), "rest")
        always(m, pins.wr_n | driven, "driven")
        always(m, pins.wr_n | before["wr"] | before["txe"], "txe_first")
        always(m, pins.rd_n | before["rd"] | before["rxf"], "rxf_first")

    @staticmethod
    def _before(m, value, name):
        """A value in the clock before."""
        value = Value.cast(value)
        register = Signal(len(value), name=f"{name}_before")
        m.d.sync += register.eq(value)
        return register
