"""Header of a packet: its error-correcting code."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.csi2.layouts import HEADER
from ncdc_hdl.lib.pipeline import register

__all__ = ["HeaderDecoder"]

# Parity bits that each of the 24 bits is part of, as numbers with P0 lowest.
_COLUMNS = (0x07, 0x0B, 0x0D, 0x0E, 0x13, 0x15, 0x16, 0x19, 0x1A, 0x1C, 0x23, 0x25,
            0x26, 0x29, 0x2A, 0x2C, 0x31, 0x32, 0x34, 0x38, 0x1F, 0x2F, 0x37, 0x3B)
# Syndromes of an odd number of bits that no single wrong bit has.
_UNUSED = (0x3D, 0x3E)


class HeaderDecoder(wiring.Component):
    """Corrects one wrong bit of a header, and detects two.

    The code's six bits and the two zeros above them count as part of the header. Every single
    wrong bit has a syndrome of an odd number of bits, and the sum of two of these has an even one.

    Timing: free-running; ``o``, ``corrected`` and ``wrong`` follow ``i`` after ``latency`` clocks.

    Members
    -------
    i : ``In(32)``
        The four bytes as sent, the first one lowest.
    o : ``Out(HEADER)``
        The header; undefined if ``wrong``.
    corrected, wrong : ``Out(1)``
        One bit was wrong; more were, and the header is not known.
    """

    latency = 2

    def __init__(self):
        super().__init__({"i": In(32), "o": Out(HEADER), "corrected": Out(1), "wrong": Out(1)})

    def elaborate(self, platform):
        m = Module()
        parity = Cat(Cat(self.i[k] for k, column in enumerate(_COLUMNS) if column >> bit & 1).xor()
                     for bit in range(6))
        syndrome = register(m, "syndrome", parity ^ self.i[24:])
        sent = register(m, "sent", self.i[:24])
        low, high = syndrome[:6], syndrome[6:]
        single = self._single(low, high)
        wrong_bits = Cat(low == column for column in _COLUMNS)
        m.d.comb += [
            self.o.eq(register(m, "header", sent ^ wrong_bits)),
            self.corrected.eq(register(m, "corrected_", single)),
            self.wrong.eq(register(m, "wrong_", syndrome.any() & ~single))]
        return m

    @staticmethod
    def _single(low, high):
        """Whether the syndrome is that of one wrong bit.

        A method of its own only so that proofs can break it.
        """
        odd = low.xor() ^ high.xor()
        unused = Cat(low == value for value in _UNUSED).any()
        return odd & Mux(high.any(), low == 0, ~unused)
