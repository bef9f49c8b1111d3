"""Counters of a receiver's faults, in the clock of the registers."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.csi2.layouts import FAULTS
from ncdc_hdl.lib.pipeline import register

__all__ = ["FAULT_COUNTS", "FaultCounters"]

_BITS = 16

FAULT_COUNTS = data.StructLayout({name: _BITS for name, _ in FAULTS})
"""Faults of each kind since the reset, modulo 65536."""


class FaultCounters(wiring.Component):
    """Counts each fault of :data:`FAULTS`.

    A bit that changes with each fault crosses from the clock of the bytes, which may stop. A packet
    has one fault of a kind at most, and D-PHY's timing keeps packets 295 ns apart (T_HS-EXIT,
    T_LPX, T_HS-PREPARE with T_HS-ZERO). None is lost if that is two clocks of the core or more.

    Parameters
    ----------
    domain : str
        Clock domain of the bytes.

    Members
    -------
    faults : ``In(FAULTS)``
        In ``domain``.
    counts : ``Out(FAULT_COUNTS)``
    """

    def __init__(self, domain="camera"):
        self.domain = domain
        super().__init__({"faults": In(FAULTS), "counts": Out(FAULT_COUNTS)})

    def elaborate(self, platform):
        m = Module()
        for name, _ in FAULTS:
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
