"""Look-ups that the tag stage has passed on and that still have to read their samples."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.forwarding import EARLIER

__all__ = ["Pending"]


class Pending(wiring.Component):
    """Numbers the look-ups passed on, and counts those that still have to read their samples.

    Look-ups are numbered modulo 2**n with n = ``options.sequence_bits``. Numbers from ``retired``
    up to ``number`` - 1 are those of pending look-ups.

    Timing: all outputs are registers, or one gate after registers. They follow ``push`` and
    ``retire`` after one clock.

    Parameters
    ----------
    options : CacheOptions
        ``pending`` and ``sequence_bits`` are used.

    Members
    -------
    push : ``In(1)``
        The look-up in the act stage is passed on in this clock; only allowed while ``space``.
    retire : ``In(1)``
        The oldest look-up passed on reads its samples in this clock.
    number : ``Out(sequence_bits)``
        The number of the look-up in the act stage, which is also that of the next one passed on.
    retired : ``Out(sequence_bits)``
        The number of the oldest look-up that still has to read; ``number`` if there is none.
    wrapped : ``Out(1)``
        ``number`` has wrapped to 0 and ``retired`` has not: the numbers of pending look-ups are
        those not below ``retired``, and those below ``number``.
    more : ``Out(EARLIER)``
        Bit k: more than k look-ups are pending.
    space : ``Out(1)``
        One more look-up may be passed on.
    """

    latency = 1
    """Clocks from ``retire`` to its effect on ``space`` and ``retired``."""

    def __init__(self, options):
        self.options = options
        super().__init__({
            "push": In(1),
            "retire": In(1),
            "number": Out(options.sequence_bits),
            "retired": Out(options.sequence_bits),
            "wrapped": Out(1),
            "more": Out(EARLIER),
            "space": Out(1, init=1),
        })

    def elaborate(self, platform):
        m = Module()
        limit = self.options.pending
        bits = self.options.sequence_bits
        # `number` and `retired`, each with one bit more, which counts their wraps.
        numbers = Signal(bits + 1)
        retirals = Signal(bits + 1)
        # Look-ups passed on that still have to read: `numbers - retirals`.
        level = Signal(range(limit + 1))
        m.d.comb += [
            self.number.eq(numbers),
            self.retired.eq(retirals),
            self.wrapped.eq(numbers[-1] != retirals[-1]),
        ]
        with m.If(self.push):
            m.d.sync += numbers.eq(numbers + 1)
        with m.If(self.retire):
            m.d.sync += retirals.eq(retirals + 1)
        # `space` registers `level != limit`: a retirement always frees a slot, a push leaves
        # one unless the level was one below the limit.
        with m.If(self.push != self.retire):
            m.d.sync += [
                level.eq(Mux(self.push, level + 1, level - 1)),
                self.space.eq(self.retire | (level != limit - 1)),
                self.more.eq(Mux(self.push, Cat(1, self.more),
                                 Cat(self.more[1:], level > EARLIER))),
            ]
        return m
