"""The start of a burst on one lane: when the lane has settled, whether its sync byte is right."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.csi2.layouts import LANE

__all__ = ["SETTLE_BITS", "BurstCheck", "Settling", "settle_clocks"]

SETTLE_BITS = 6
"""Bits of the number of byte clocks that a lane needs to settle."""

_MARK = 0b10111         # bits 3 to 7 of the sync byte: the first that is one, and those after it


def settle_clocks(lane_hz):
    """Clocks that :class:`Settling` counts for lanes of ``lane_hz`` bits per second: the middle of
    T_HS-SETTLE (D-PHY), 85 ns and 6 bits to 145 ns and 10 bits, less three clocks of registers."""
    bits = 115e-9 * lane_hz + 8
    return max(1, round(bits / 8) - 3)


class Settling(wiring.Component):
    """Whether a lane is in high-speed mode, and has settled.

    Its Dn wire is high in the stop state, and below the threshold of a single-ended input from
    T_HS-PREPARE on. From there the lane needs ``settle`` clocks: T_HS-SETTLE of D-PHY, 85 ns and 6
    bits to 145 ns and 10 bits. The first two of them are those of the synchroniser.

    Members
    -------
    low_power : ``In(1)``
        Level of Dn, at any time.
    settle : ``In(SETTLE_BITS)``
        Constant.
    active : ``Out(1)``
    """

    def __init__(self):
        super().__init__({"low_power": In(1), "settle": In(SETTLE_BITS), "active": Out(1)})

    def elaborate(self, platform):
        m = Module()
        stopped, count = Signal(init=1), Signal(SETTLE_BITS)
        m.submodules.low_power = FFSynchronizer(self.low_power, stopped, init=1)
        m.d.sync += self.active.eq(~stopped & (count == self.settle))
        with m.If(stopped):
            m.d.sync += count.eq(0)
        with m.Elif(count != self.settle):
            m.d.sync += count.eq(count + 1)
        return m


class BurstCheck(wiring.Component):
    """Checks the sync byte of each burst of a lane, at any alignment.

    A word aligner may find a sync byte in the middle of a burst too. Here only zeros may precede
    it, as D-PHY sends them. So one wrong bit is enough for a bad burst.

    Members
    -------
    i : ``In(LANE)``
    ended, good : ``Out(1)``
        ``ended`` is high for a clock after a burst. ``good``, of that burst, stays until the next
        one ends.
    """

    def __init__(self):
        super().__init__({"i": In(LANE), "ended": Out(1), "good": Out(1)})

    def elaborate(self, platform):
        m = Module()
        before = Signal(init=1)         # a reset ends no burst
        some, known, right = Signal(), Signal(), Signal()
        first = Signal(8)
        bits = Cat(first, self.i.data)
        m.d.sync += [before.eq(self.i.active), self.ended.eq(before & ~self.i.active)]
        with m.If(self.i.active):
            with m.If(~some):
                m.d.sync += [first.eq(self.i.data), some.eq(self.i.data != 0)]
            with m.Elif(~known):
                m.d.sync += [known.eq(1), right.eq(Cat(
                    ~first[:k].any() & (bits[k:k + 5] == _MARK) for k in range(8)).any())]
        with m.Else():
            m.d.sync += [some.eq(0), known.eq(0), right.eq(0)]
            with m.If(before):
                m.d.sync += self.good.eq(right)
        return m
