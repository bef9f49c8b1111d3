"""Counters of a source's faults, in the clock of the registers."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.pipeline import register

__all__ = ["FaultCounters", "counts_of"]

_BITS = 16


def counts_of(faults):
    """Layout of the faults of each kind since the reset, modulo 65536."""
    return data.StructLayout({name: _BITS for name, _ in faults})


class FaultCounters(wiring.Component):
    """Counts each fault of a source.

    A bit that changes with each fault crosses from the sensor's clock, which may stop. None is lost
    if faults of a kind are two clocks of the core apart, or more. A packet of CSI-2 has one
    fault of a kind at most, and D-PHY's timing keeps packets 295 ns apart (T_HS-EXIT, T_LPX,
    T_HS-PREPARE with T_HS-ZERO).

    Parameters
    ----------
    layout : StructLayout
        A bit for each kind of fault, high for a clock.
    domain : str
        Clock domain of the faults.

    Members
    -------
    faults : ``In(layout)``
        In ``domain``.
    counts : ``Out(counts_of(layout))``
    """

    def __init__(self, layout, domain="camera"):
        self.layout, self.domain = layout, domain
        super().__init__({"faults": In(layout), "counts": Out(counts_of(layout))})

    def elaborate(self, platform):
        m = Module()
        for name, _ in self.layout:
            # Reset with neither side: a change would be counted.
            changes = Signal(name=f"{name}_changes", reset_less=True)
            seen = Signal(name=f"{name}_seen")
            with m.If(self.faults[name]):
                m.d[self.domain] += changes.eq(~changes)
            m.submodules[name] = FFSynchronizer(changes, seen)
            before = register(m, f"{name}_before", seen)
            with m.If(seen != before):
                m.d.sync += self.counts[name].eq(self.counts[name] + 1)
        return m
