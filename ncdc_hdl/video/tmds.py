"""Eight bits to ten, as DVI sends them: transition-minimised differential signalling."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["CONTROL", "TmdsEncoder"]

CONTROL = (0b1101010100, 0b0010101011, 0b0101010100, 0b1010101011)
"""Words for the control bits (C1, C0) = 0 to 3; Digital Visual Interface 1.0, section 3.3.3."""


class TmdsEncoder(wiring.Component):
    """Encodes a byte of a colour, or two control bits, into a word of ten bits.

    The first step chains the bits by XOR, or XNOR if a byte has more than
    four ones, which leaves few transitions. The second one inverts the word if that brings
    the sum of the bits sent nearer to as many ones as zeros. Digital Visual Interface 1.0
    (Digital Display Working Group), figure 3-5.

    Timing: latency 2 clocks of ``pixel``.

    Members
    -------
    colour : ``In(8)``
    control : ``In(2)``
        C0 and C1, sent while ``visible`` is low.
    visible : ``In(1)``
    word : ``Out(10)``
        The lowest bit is sent first.
    """

    latency = 2

    def __init__(self):
        super().__init__({"colour": In(8), "control": In(2), "visible": In(1), "word": Out(10)})

    def elaborate(self, platform):
        m = Module()
        # First clock: few transitions.
        d, ones = self.colour, Signal(range(9))
        complement = Signal()               # chain by XNOR
        chain = [Signal(name=f"chain{k}") for k in range(8)]
        m.d.comb += [ones.eq(sum(d[k] for k in range(8))),
                     complement.eq((ones > 4) | ((ones == 4) & ~d[0])), chain[0].eq(d[0])]
        for k in range(1, 8):
            m.d.comb += chain[k].eq(chain[k - 1] ^ d[k] ^ complement)
        q = Signal(9)                       # q_m of the specification
        q_control, q_visible = Signal(2), Signal()
        # Ones less zeros of q's eight bits, in halves: -4 to 4.
        excess = Signal(signed(4))
        m.d.pixel += [q.eq(Cat(*chain, ~complement)), q_control.eq(self.control),
                      q_visible.eq(self.visible), excess.eq(sum(chain) - 4)]
        # Second clock: as many ones as zeros.
        sent = Signal(signed(5))            # ones less zeros sent so far, in halves
        invert = Signal()
        even = (sent == 0) | (excess == 0)
        m.d.comb += invert.eq(Mux(even, ~q[8], (sent < 0) == (excess < 0)))
        with m.If(q_visible):
            m.d.pixel += [
                self.word.eq(Cat(q[:8] ^ invert.replicate(8), q[8], invert)),
                # Bits 8 and 9 also count: both one, both zero, or one of each.
                sent.eq(sent + Mux(invert, -excess, excess)
                        + Mux(even, 0, Mux(invert, Cat(q[8]), -Cat(~q[8])))),
            ]
        with m.Else():
            m.d.pixel += [self.word.eq(Array(CONTROL)[q_control]), sent.eq(0)]
        return m
