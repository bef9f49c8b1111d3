"""A stream stage that breaks a long chain of ``ready`` signals."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["Relay"]


class Relay(wiring.Component):
    """Two slots for items, so that ``i.ready`` is a register and does not depend on ``o.ready``.

    An item that comes in a clock in which ``o`` stalls is put aside; while an item is aside, no
    other one is accepted.

    Timing: latency 1, one item per clock.

    Parameters
    ----------
    shape : ShapeLike
        Shape of an item.

    Members
    -------
    i, o : ``In(stream.Signature(shape))``, ``Out(stream.Signature(shape))``
    """

    latency = 1
    """Clocks from an item at ``i`` to the item at ``o``."""
    capacity = 2
    """Items in it, at most."""

    def __init__(self, shape):
        self.shape = shape
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform):
        m = Module()
        i = Value.cast(self.i.payload)
        o = Signal(len(i), reset_less=True)         # the item that is offered
        aside = Signal(len(i), reset_less=True)     # the item put aside, unless `free`
        free = Signal(init=1)                       # nothing is aside
        # The same complemented, which no synthesis takes for the same register: one of them
        # selects all bits, and `ready` begins at the other one.
        full = Signal()
        m.d.comb += [self.i.ready.eq(free), Value.cast(self.o.payload).eq(o)]
        with m.If(~full):
            m.d.sync += aside.eq(i)
        moves = ~self.o.valid | self.o.ready
        with m.If(moves):
            m.d.sync += [self.o.valid.eq(full | self.i.valid), o.eq(Mux(full, aside, i))]
        m.d.sync += [free.eq(moves | (free & ~self.i.valid)),
                     full.eq(~(moves | (~full & ~self.i.valid)))]
        return m
