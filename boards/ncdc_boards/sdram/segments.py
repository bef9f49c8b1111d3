"""Cuts bursts where a row of the memory ends."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["Segments"]


class Segments(wiring.Component):
    """Splits each burst into one segment, or two if it continues in the next row.

    Timing: a burst's first segment is at ``o`` ``latency`` clocks after the burst was taken.
    ``i.ready`` is a register, low in the reset and in the clock after each burst taken.

    Parameters
    ----------
    mapping : AddressMapping
        A burst is no longer than a row.

    Members
    -------
    i : ``In(stream.Signature(mapping.burst))``
    o : ``Out(stream.Signature(mapping.segment))``
    loads : ``Out(1)``
        High in the clock before a burst's first segment appears at ``o``.
    bursts : ``Out(2)``
        Bursts taken whose last segment has not been.
    """

    latency = 2
    """Clocks: the burst's register, the segment's."""

    def __init__(self, mapping):
        self.mapping = mapping
        super().__init__({
            "i": In(stream.Signature(mapping.burst)), "o": Out(stream.Signature(mapping.segment)),
            "loads": Out(1), "bursts": Out(2),
        })

    def elaborate(self, platform):
        m = Module()
        columns = self.mapping.column_bits
        free = Signal()                         # no burst waits for the segment's register
        waits = Signal()                        # a burst does
        burst = Signal(self.mapping.burst)        # that burst
        valid = Signal()                        # there is a segment
        segment = Signal(self.mapping.segment)    # that segment
        rest = Signal(self.mapping.words)         # words of the burst in the next row
        taken = Signal()                        # the segment is taken
        left = Signal()                         # there is no segment when this clock ends
        column = burst.word[:columns]
        end_column = Signal(columns + 1)            # column after the burst's last word
        crosses = Signal()                      # the burst has words in the next row
        m.d.comb += [
            self.i.ready.eq(free), self.o.valid.eq(valid), self.o.p.eq(segment),
            taken.eq(valid & self.o.ready), left.eq(~valid | taken & segment.last),
            self.loads.eq(waits & left), self.bursts.eq(waits + valid),
            crosses.eq(self._crosses(end_column)),
        ]
        m.d.sync += [free.eq(~waits & ~(self.i.valid & free) | self.loads),
                     waits.eq(self.i.valid & free | waits & ~self.loads)]
        with m.If(free):
            m.d.sync += [burst.eq(self.i.p),
                         end_column.eq(self.i.p.word[:columns] + self.i.p.words)]
        with m.If(self.loads):
            m.d.sync += [
                valid.eq(1), Cat(segment.column, segment.bank, segment.row).eq(burst.word),
                segment.words.eq(Mux(crosses, (-column)[:columns], burst.words)),
                segment.last.eq(~crosses), rest.eq(end_column[:columns]),
            ]
        with m.Elif(taken):
            row = Cat(segment.bank, segment.row)
            m.d.sync += [valid.eq(~segment.last), segment.last.eq(1), segment.words.eq(rest),
                         segment.column.eq(0), row.eq(row + 1)]
        return m

    @staticmethod
    def _crosses(end_column):
        """Whether a burst has words in the next row, from the column after its last one.

        A method of its own only so that proofs and tests can break it.
        """
        return end_column[-1] & end_column[:-1].any()
