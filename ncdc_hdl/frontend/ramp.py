"""A coordinate of the scan, by addition of a constant."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_spec.geometry import SCAN

__all__ = ["Ramp"]

_LOW = SCAN.width // 2


class Ramp(wiring.Component):
    """``sum`` = ``first`` + k ``stride`` for the group shown, modulo 2**32, by addition only.

    k is the number of steps since the base was taken. The sum has two halves, the low one
    one group early, so that no carry runs through all bits in one clock.

    Timing: ``sum`` belongs to the group shown by the last ``take``. ``step``,
    ``restart`` and ``rebase`` with ``take`` select the sum of the group after that one. A
    frame begins with ``load``, then a ``take`` with ``restart`` before the first group is shown.

    Parameters
    ----------
    shift : int
        Number of the bit that ``carry`` belongs to.

    Members
    -------
    first, stride : ``In(signed(32))``
        Constant from ``load`` on.
    load : ``In(1)``
        ``first`` becomes the base.
    take : ``In(1)``
        Another group is shown in the next clock.
    step : ``In(1)``
        The sum grows by ``stride``.
    restart : ``In(1)``
        The sum is the base instead.
    rebase : ``In(1)``
        The sum becomes the base; only with ``step``.
    sum : ``Out(signed(32))``
    carry : ``Out(1)``
        Carry of the addition into bit ``shift``, if the next sum is that of a ``step``.
    """

    def __init__(self, shift):
        self.shift = shift
        super().__init__({
            "first": In(signed(SCAN.width)), "stride": In(signed(SCAN.width)),
            "load": In(1), "take": In(1), "step": In(1), "restart": In(1), "rebase": In(1),
            "sum": Out(signed(SCAN.width)), "carry": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        low_bits = max(_LOW, self.shift + 1)
        high_bits = SCAN.width - low_bits
        # The next group's sum, as far as known, and the base in its two halves.
        low = Signal(low_bits)              # low half of the next group's sum
        base_low = Signal(low_bits)         # low half of the base
        base_high = Signal(high_bits)       # high half of the base
        # The sum of the group shown.
        low_shown = Signal(low_bits)        # its low half
        high = Signal(high_bits)            # its high half
        # Controls of the next group's sum: its high half is computed when that group is taken.
        carried = Signal()                  # carry of the addition in the low half
        stepped = Signal()                  # `step`
        restarted = Signal()                # `restart`
        rebased = Signal()                  # `rebase`
        low_sum = Signal(low_bits + 1)      # `low` and the stride, with the carry
        high_sum = Signal(high_bits)        # `high`, the stride, and the carry from below
        m.d.comb += [
            low_sum.eq(low + self.stride[:low_bits]),
            high_sum.eq(high + self.stride[low_bits:] + carried),
            self.sum.eq(Cat(low_shown, high)),
            self.carry.eq((low ^ low_shown ^ self.stride[:low_bits])[self.shift]),
        ]
        with m.If(self.take):
            m.d.sync += [low_shown.eq(low), carried.eq(low_sum[-1]), stepped.eq(self.step),
                         restarted.eq(self.restart), rebased.eq(self.rebase)]
            with m.If(self.restart):
                m.d.sync += low.eq(base_low)
            with m.Elif(self.step):
                m.d.sync += low.eq(low_sum)
            with m.If(self.rebase):
                m.d.sync += base_low.eq(low_sum)
            with m.If(restarted):
                m.d.sync += high.eq(base_high)
            with m.Elif(stepped):
                m.d.sync += high.eq(high_sum)
            with m.If(rebased):
                m.d.sync += base_high.eq(high_sum)
        with m.If(self.load):
            m.d.sync += [Cat(base_low, base_high).eq(self.first), rebased.eq(0)]
        return m
