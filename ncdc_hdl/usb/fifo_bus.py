"""The bus of an FTDI chip in 245 synchronous FIFO mode, in the chip's clock domain."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.usb.layouts import ChipPins, word_layout

__all__ = ["FifoBus"]


class FifoBus(wiring.Component):
    """Moves words between two queues and the chip, one direction at a time.

    A word goes to the chip in each clock in which WR# and TXE# are low, and comes from it in each
    in which RD# and RXF# are low (FTDI, "FT232H", version 2.1, 4.4). Every pin that the FPGA drives
    comes from a register, so setup times are only those of the pins. TXE# and RXF# are evaluated in
    the clock in which they are valid, so that no word is lost or doubled when they rise.

    OE# is low a clock before RD#. Between the two directions the bus is idle for a clock. WR# falls
    only if TXE# was low, RD# only if RXF# was. They stay low when those rise, so that a pause of
    the chip costs no further clocks.

    Timing: one word per clock; a change of direction takes 3 clocks to reads and 2 to writes.

    Parameters
    ----------
    lanes : int
        Bytes of a word.
    turn : int
        Clocks after which a direction gives way, if the other one has words to move.

    Members
    -------
    pins : ``Out(ChipPins(lanes))``
        Its ``clock`` is not used: it is that of this component's domain.
    to_host : ``In(stream.Signature(word_layout(lanes)))``
    from_host, push : ``Out(word_layout(lanes))``, ``Out(1)``
        A word has come, for one clock.
    space : ``In(1)``
        There is space for two more words.
    """

    def __init__(self, lanes, turn=512):
        self.lanes, self.turn = lanes, turn
        word = word_layout(lanes)
        super().__init__({
            "pins": Out(ChipPins(lanes)), "to_host": In(stream.Signature(word)),
            "from_host": Out(word), "push": Out(1), "space": In(1)})

    def elaborate(self, platform):
        m = Module()
        pins = self.pins
        there = Signal()                # a word at the pins waits for the chip
        accepted = Signal()             # the chip takes it in this clock
        load = Signal()                 # the next word goes to the pins
        wants_read, wants_write = Signal(), Signal()
        clocks = Signal(range(self.turn + 1))       # clocks left for this direction
        over = Signal()                 # none are left
        wrote = Signal()                # the last direction was to the host
        m.d.comb += [
            accepted.eq(self._accepted(pins)),
            wants_read.eq(~pins.rxf_n & self.space),
            wants_write.eq(~pins.txe_n & (there & ~accepted | self.to_host.valid)),
            over.eq(clocks == 0), self.to_host.ready.eq(load),
        ]
        with m.If(load):
            m.d.sync += [pins.data_o.eq(self.to_host.p.data), pins.be_o.eq(self.to_host.p.enable)]
        m.d.sync += there.eq(load | there & ~accepted)
        m.d.sync += [self.from_host.data.eq(pins.data_i), self.from_host.enable.eq(pins.be_i),
                     self.push.eq(~pins.rd_n & ~pins.rxf_n)]
        with m.If(~over):
            m.d.sync += clocks.eq(clocks - 1)
        with m.FSM():
            with m.State("REST"):
                m.d.sync += clocks.eq(self.turn)
                with m.If(wants_read & (wrote | ~wants_write)):
                    m.d.sync += [pins.oe_n.eq(0), wrote.eq(0)]
                    m.next = "TURN"
                with m.Elif(wants_write):
                    m.d.comb += load.eq(~there)
                    m.d.sync += [pins.data_oe.eq(1), pins.wr_n.eq(0), wrote.eq(1)]
                    m.next = "WRITE"
            with m.State("TURN"):
                with m.If(wants_read):
                    m.d.sync += pins.rd_n.eq(0)
                    m.next = "READ"
                with m.Elif(wants_write):
                    m.d.sync += pins.oe_n.eq(1)
                    m.next = "REST"
            with m.State("READ"):
                m.d.sync += pins.rd_n.eq(~(self.space & (~pins.rd_n | ~pins.rxf_n)))
                with m.If(wants_write & (over | ~wants_read)):
                    m.d.sync += [pins.rd_n.eq(1), pins.oe_n.eq(1)]
                    m.next = "REST"
            with m.State("WRITE"):
                following = load | there & ~accepted        # next value of ``there``
                with m.If(wants_read & (over | ~wants_write)):
                    m.d.sync += [pins.wr_n.eq(1), pins.data_oe.eq(0)]
                    m.next = "REST"
                with m.Else():
                    m.d.comb += load.eq((~there | accepted) & self.to_host.valid)
                    m.d.sync += pins.wr_n.eq(~(following & (~pins.txe_n | ~pins.wr_n)))
        return m

    @staticmethod
    def _accepted(pins):
        """Whether the chip takes the word. A method of its own only so that tests can break it."""
        return ~pins.wr_n & ~pins.txe_n
