"""Cuts bursts where a row of the memory ends."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["Segments"]


class Segments(wiring.Component):
    """Makes of each burst one segment, or two if it goes on in the next row.

    Timing: a burst's first segment is at ``o`` ``latency`` clocks after the burst was taken;
    ``i.ready`` is a register, low in the reset and in the clock behind each burst taken.

    Parameters
    ----------
    place : Place
        A burst is no longer than a row.

    Members
    -------
    i : ``In(stream.Signature(place.burst))``
    o : ``Out(stream.Signature(place.segment))``
    loads : ``Out(1)``
        High in the clock before a burst's first segment appears at ``o``.
    bursts : ``Out(2)``
        Bursts taken whose last segment has not been.
    """

    latency = 2
    """Clocks: the burst's register, the segment's."""

    def __init__(self, place):
        self.place = place
        super().__init__({
            "i": In(stream.Signature(place.burst)), "o": Out(stream.Signature(place.segment)),
            "loads": Out(1), "bursts": Out(2),
        })

    def elaborate(self, platform):
        m = Module()
        columns = self.place.column_bits
        free = Signal()                         # no burst waits for the segment's register
        waits = Signal()                        # a burst does
        burst = Signal(self.place.burst)        # that burst
        valid = Signal()                        # there is a segment
        segment = Signal(self.place.segment)    # that segment
        rest = Signal(self.place.words)         # words of the burst in the next row
        taken = Signal()                        # the segment is taken
        left = Signal()                         # there is no segment when this clock ends
        column = burst.word[:columns]
        behind = Signal(columns + 1)            # column behind the burst's last word
        crosses = Signal()                      # the burst has words in the next row
        m.d.comb += [
            self.i.ready.eq(free), self.o.valid.eq(valid), self.o.p.eq(segment),
            taken.eq(valid & self.o.ready), left.eq(~valid | taken & segment.last),
            self.loads.eq(waits & left), self.bursts.eq(waits + valid),
            crosses.eq(self._crosses(behind)),
        ]
        m.d.sync += [free.eq(~waits & ~(self.i.valid & free) | self.loads),
                     waits.eq(self.i.valid & free | waits & ~self.loads)]
        with m.If(free):
            m.d.sync += [burst.eq(self.i.p),
                         behind.eq(self.i.p.word[:columns] + self.i.p.words)]
        with m.If(self.loads):
            m.d.sync += [
                valid.eq(1), Cat(segment.column, segment.bank, segment.row).eq(burst.word),
                segment.words.eq(Mux(crosses, (-column)[:columns], burst.words)),
                segment.last.eq(~crosses), rest.eq(behind[:columns]),
            ]
        with m.Elif(taken):
            place = Cat(segment.bank, segment.row)
            m.d.sync += [valid.eq(~segment.last), segment.last.eq(1), segment.words.eq(rest),
                         segment.column.eq(0), place.eq(place + 1)]
        return m

    @staticmethod
    def _crosses(behind):
        """Whether a burst has words in the next row, told from the column behind its last one.

        A method of its own only so that proofs and tests can break it.
        """
        return behind[-1] & behind[:-1].any()
