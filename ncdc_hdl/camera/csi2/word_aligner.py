"""Word alignment of one lane by its sync byte."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.csi2.layouts import BYTES, LANE
from ncdc_hdl.lib.pipeline import register
from ncdc_spec.sensors.csi2 import SYNC_BYTE

__all__ = ["WordAligner"]


class WordAligner(wiring.Component):
    """Finds the sync byte at any of eight bit positions, and gives the bytes after it.

    Timing: free-running. A byte leaves ``latency`` clocks after its last bit.

    Members
    -------
    i : ``In(LANE)``
    o : ``Out(BYTES)``
    """

    latency = 1

    def __init__(self):
        super().__init__({"i": In(LANE), "o": Out(BYTES)})

    def elaborate(self, platform):
        m = Module()
        active = self.i.active
        before = Signal(7)              # the last bits of the clock before; zero before a burst
        offset = Signal(3)              # bit position of the first bit of a byte in `bits`
        locked = Signal()
        active_before = Signal(init=1)  # a reset ends no burst
        bits = Cat(before, self.i.data)
        # No shift of the sync byte by fewer than eight bits overlaps with it: one match at most.
        matches = [bits[k:k + 8] == SYNC_BYTE for k in range(8)]
        with m.If(active):
            m.d.sync += before.eq(self.i.data[1:])
            with m.If(~locked & Cat(matches).any()):
                m.d.sync += [locked.eq(1), offset.eq(Cat(
                    Cat(match for k, match in enumerate(matches) if k >> bit & 1).any()
                    for bit in range(3)))]
        with m.Else():
            m.d.sync += [before.eq(0), locked.eq(0)]
        aligned = bits
        for bit in (2, 1, 0):
            width = 7 + (1 << bit)
            aligned = Mux(offset[bit], aligned[1 << bit:(1 << bit) + width], aligned[:width])
        m.d.sync += active_before.eq(active)
        m.d.comb += [self.o.data.eq(register(m, "data", aligned)),
                     self.o.valid.eq(register(m, "valid", locked & active, reset_less=False)),
                     self.o.active.eq(active_before)]
        return m
