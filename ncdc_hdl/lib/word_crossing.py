"""A word that may change at any time, from one clock to another."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

__all__ = ["WordCrossing"]


class WordCrossing(wiring.Component):
    """Gives the domain "there" the newest value of ``i`` as a whole, never bits of two values.

    A value is offered until the other domain has taken it, then the next one. Only a bit that
    says whether there is a new one crosses, and its answer, each through a synchroniser. If the
    other clock stops, the newest value waits for it.

    Timing: ``o`` follows ``i`` after a few clocks of both domains. The wires of the word may take
    up to two clocks of "there".

    Parameters
    ----------
    shape : ShapeLike
    init : optional
        Value of ``o`` after a reset, which must reach both domains.

    Members
    -------
    i : ``In(shape)``
        Of the domain "sync".
    o : ``Out(shape)``
        Of the domain "there".
    """

    def __init__(self, shape, init=None):
        self.init = init
        super().__init__({"i": In(shape, init=init), "o": Out(shape, init=init)})

    def elaborate(self, platform):
        m = Module()
        offered = Signal.like(self.o, init=self.init)
        asked = Signal()            # changes with each value offered
        asked_there = Signal()
        taken = Signal()            # follows it when the value is taken
        taken_here = Signal()
        m.submodules.asked_cdc = FFSynchronizer(asked, asked_there, o_domain="there")
        m.submodules.taken_cdc = FFSynchronizer(taken, taken_here)
        changed = Value.cast(self.i) != Value.cast(offered)
        with m.If(changed & (asked == taken_here)):
            m.d.sync += [Value.cast(offered).eq(Value.cast(self.i)), asked.eq(~asked)]
        word = self._wires(m, Value.cast(offered))
        with m.If(asked_there != taken):
            m.d.there += [Value.cast(self.o).eq(word), taken.eq(asked_there)]
        return m

    @staticmethod
    def _wires(m, offered):
        """The word at the other domain.

        A method of its own only so that tests can have some of its wires take longer.
        """
        return offered
