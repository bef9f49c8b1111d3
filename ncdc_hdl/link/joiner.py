"""Pieces of packets, one behind the other, as beats without a pause."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from ncdc_hdl.link.layouts import BEAT, PIECE

__all__ = ["Joiner"]

_AHEAD = 3          # beats that wait before a packet begins: one pause of the pieces, two registers


class Joiner(wiring.Component):
    """Moves the bytes of pieces together to beats of four, and keeps some ahead.

    A packet begins when some beats or its end are there, so that no clock is without one if its
    pieces come with a pause of one clock at most; and not before ``delay`` clocks after the end
    of the last packet.

    Members
    -------
    i : ``In(stream.Signature(PIECE))``, ``again``: ``In(1)``
        Pieces of four bytes, but for one before and one at the end of each packet.
    delay : ``In(32)``
    o : ``Out(stream.Signature(BEAT))``
    ended, ended_again : ``Out(1)``
        For one clock: a packet has gone; ``again``, one that was sent before.
    quiet : ``Out(1)``
        No beat is waiting, and the delay is over.
    """

    depth = 8
    """Beats that are kept: packets, at most."""

    def __init__(self):
        super().__init__({
            "i": In(stream.Signature(PIECE)), "again": In(1), "delay": In(32),
            "o": Out(stream.Signature(BEAT)), "ended": Out(1), "ended_again": Out(1),
            "quiet": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        i = self.i
        entry = data.StructLayout({"beat": BEAT, "again": 1})
        m.submodules.queue = queue = SyncFIFOBuffered(width=entry.size, depth=self.depth)
        new, oldest = Signal(entry), data.View(entry, queue.r_data)
        kept = Signal(24)               # bytes that no beat has as yet
        count = Signal(2)               # how many
        rest = Signal()                 # they are a packet's last ones
        again = Signal()                # of that packet
        piece = Signal(32)              # the bytes of the piece, zeros behind them
        joined = Signal(56)             # they, behind those that are kept
        length = Signal(3)              # bytes that are joined
        m.d.comb += [
            piece.eq(Cat(Mux(k < i.p.bytes, i.p.data.word_select(k, 8), 0) for k in range(4))),
            joined.eq(kept | piece << (count << 3)), length.eq(count + i.p.bytes),
            queue.w_data.eq(new), new.again.eq(Mux(rest, again, self.again)),
            i.ready.eq(queue.w_rdy & ~rest),
        ]
        with m.If(rest):
            m.d.comb += [queue.w_en.eq(queue.w_rdy), new.beat.data.eq(kept), new.beat.last.eq(1),
                         new.beat.empty.eq(-count)]
            with m.If(queue.w_rdy):
                m.d.sync += [rest.eq(0), count.eq(0), kept.eq(0)]
        with m.Elif(i.valid & i.ready):
            m.d.comb += [
                queue.w_en.eq((length >= 4) | i.p.last), new.beat.data.eq(joined[:32]),
                new.beat.last.eq(i.p.last & (length <= 4)),
                new.beat.empty.eq(Mux(length <= 4, -length[:2], 0)),
            ]
            over = i.p.last & (length <= 4)
            m.d.sync += [again.eq(self.again), rest.eq(i.p.last & ~over),
                         count.eq(Mux(over, 0, length[:2])),
                         kept.eq(Mux(over, 0, Mux(length >= 4, joined[32:], joined[:24])))]
        self._leave(m, queue, oldest, new)
        return m

    def _leave(self, m, queue, oldest, new):
        """Let packets go, each as a whole."""
        o = self.o
        ends = Signal(range(self.depth + 1))        # last beats in the queue
        begun = Signal()                        # a packet is going
        pause = Signal(32)                      # clocks until the next one may
        put = queue.w_en & queue.w_rdy & new.beat.last
        gone = Signal()                         # a last beat
        m.d.comb += [
            o.valid.eq(queue.r_rdy & (begun | (pause == 0) & self._enough(queue.r_level, ends))),
            o.payload.eq(oldest.beat), queue.r_en.eq(o.valid & o.ready),
            gone.eq(queue.r_en & oldest.beat.last),
            self.ended.eq(gone), self.ended_again.eq(gone & oldest.again),
            self.quiet.eq((queue.r_level == 0) & (pause == 0)),
        ]
        m.d.sync += ends.eq(ends + put - gone)
        with m.If(o.valid):
            m.d.sync += begun.eq(~gone)
        with m.If(gone):
            m.d.sync += pause.eq(self.delay)
        with m.Elif(pause != 0):
            m.d.sync += pause.eq(pause - 1)

    @staticmethod
    def _enough(level, ends):
        """Whether a packet may go. A method of its own only so that proofs can break it."""
        return (level >= _AHEAD) | (ends != 0)
