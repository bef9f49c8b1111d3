"""Joins pieces of answers to beats."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from ncdc_hdl.link.layouts import BEAT

__all__ = ["PIECE", "Joiner"]

PIECE = data.StructLayout({"data": 32, "bytes": range(5), "last": 1})
"""Bytes of an answer, the first in the lowest; ``last`` ends it."""

_DEPTH = 8          # beats that wait


class Joiner(wiring.Component):
    """Packs the bytes of pieces into beats of four.

    Members
    -------
    i : ``In(stream.Signature(PIECE))``
    o : ``Out(stream.Signature(BEAT))``
    """

    def __init__(self):
        super().__init__({"i": In(stream.Signature(PIECE)), "o": Out(stream.Signature(BEAT))})

    def elaborate(self, platform):
        m = Module()
        i = self.i
        m.submodules.queue = queue = SyncFIFOBuffered(width=BEAT.size, depth=_DEPTH)
        new = Signal(BEAT)
        held = Signal(24)               # bytes that are in no beat yet
        count = Signal(2)               # their number
        rest = Signal()                 # they are an answer's last ones
        piece = Signal(32)              # the bytes of the piece, then zeros
        joined = Signal(56)             # the held bytes, then these
        length = Signal(3)              # bytes that are joined
        m.d.comb += [
            piece.eq(Cat(Mux(k < i.p.bytes, i.p.data.word_select(k, 8), 0) for k in range(4))),
            joined.eq(held | piece << (count << 3)), length.eq(count + i.p.bytes),
            queue.w_data.eq(new), i.ready.eq(queue.w_rdy & ~rest),
            self.o.valid.eq(queue.r_rdy), self.o.payload.eq(queue.r_data),
            queue.r_en.eq(self.o.ready),
        ]
        with m.If(rest):
            m.d.comb += [queue.w_en.eq(queue.w_rdy), new.data.eq(held), new.last.eq(1),
                         new.empty.eq(-count)]
            with m.If(queue.w_rdy):
                m.d.sync += [rest.eq(0), count.eq(0), held.eq(0)]
        with m.Elif(i.valid & i.ready):
            over = i.p.last & (length <= 4)
            m.d.comb += [
                queue.w_en.eq((length >= 4) | i.p.last), new.data.eq(joined[:32]),
                new.last.eq(over), new.empty.eq(Mux(length <= 4, -length[:2], 0)),
            ]
            m.d.sync += [rest.eq(i.p.last & ~over), count.eq(Mux(over, 0, length[:2])),
                         held.eq(Mux(over, 0, Mux(length >= 4, joined[32:], joined[:24])))]
        return m
