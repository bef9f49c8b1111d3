"""Checksum of a payload."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.csi2.layouts import rest_shape

__all__ = ["Checksum"]

_BITS = 16
_TAPS = 0x8408      # x^16 + x^12 + x^5 + 1, lowest bit first


class Checksum(wiring.Component):
    """CRC-16 of the specification, over a payload and the checksum that follows it.

    Timing: ``good`` is valid in the clock after the last bytes.

    Parameters
    ----------
    lanes : int
        Bytes of a word, a power of two.

    Members
    -------
    start : ``In(1)``
        High for a clock before the first word.
    valid, data : ``In(1)``, ``In(8 * lanes)``
    rest : ``In(rest_shape(lanes))``
        Number of bytes in the word modulo ``lanes``.
    good : ``Out(1)``
        The last two bytes were the checksum of those before them.
    """

    def __init__(self, lanes):
        self.lanes = lanes
        super().__init__({"start": In(1), "valid": In(1), "data": In(8 * lanes),
                          "rest": In(rest_shape(lanes)), "good": Out(1)})

    def elaborate(self, platform):
        m = Module()
        state = Signal(_BITS, reset_less=True)
        # Each bit of the state after some bytes is the parity of some of these bits.
        bits = Cat(state, self.data)
        terms = [{k} for k in range(_BITS)]
        after = []
        for number in range(self.lanes):
            for bit in range(8):
                terms = _shifted(terms, _BITS + 8 * number + bit)
            after.append(Cat(Cat(bits[k] for k in sorted(each)).xor() for each in terms))
        with m.If(self.start):
            m.d.sync += state.eq((1 << _BITS) - 1)
        with m.Elif(self.valid):
            with m.Switch(self.rest):
                for rest in range(self.lanes):
                    with m.Case(rest):
                        m.d.sync += state.eq(after[rest - 1])
        m.d.comb += self.good.eq(state == 0)
        return m


def _shifted(terms, bit):
    """The sets ``terms`` of the bits of a state after one more ``bit``."""
    feedback = terms[0] ^ {bit}
    shifted = [*terms[1:], set()]
    return [each ^ feedback if _TAPS >> k & 1 else each for k, each in enumerate(shifted)]
