"""When the tag stage accepts look-ups, and when it makes its entries invalid."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.layouts import set_bits

__all__ = ["Clearing"]


class Clearing(wiring.Component):
    """Invalidates all entries after a frame's last look-up and after reset, a set per clock.

    The tag stage is closed from the clock after the frame's last look-up was accepted until the
    last set has been cleared, so that no look-up meets an entry of another frame.

    Timing: ``clearing`` begins in the clock after ``passed_on`` and lasts for as many clocks as
    there are sets; ``closed`` ends with it.

    Parameters
    ----------
    options : CacheOptions
        ``sets`` is used.

    Members
    -------
    accepted : ``In(1)``
        A frame's last look-up enters the tag stage in this clock.
    passed_on : ``In(1)``
        A frame's last look-up leaves the tag stage in this clock.
    closed : ``Out(1)``
        No look-up may be accepted.
    clearing : ``Out(1)``
        The entries of ``set`` are to be made invalid in this clock.
    set : ``Out``
        The number of a set; 0 while ``clearing`` is low.
    """

    def __init__(self, options):
        self.options = options
        super().__init__({
            "accepted": In(1),
            "passed_on": In(1),
            "closed": Out(1, init=1),
            "clearing": Out(1, init=1),
            "set": Out(set_bits(options)),
        })

    def elaborate(self, platform):
        m = Module()
        with m.If(self.accepted):
            m.d.sync += self.closed.eq(1)
        with m.If(self.passed_on):
            m.d.sync += self.clearing.eq(1)
        with m.If(self.clearing):
            m.d.sync += self.set.eq(self.set + 1)
            with m.If(self.set == self.options.sets - 1):
                m.d.sync += [self.clearing.eq(0), self.closed.eq(0), self.set.eq(0)]
        return m
