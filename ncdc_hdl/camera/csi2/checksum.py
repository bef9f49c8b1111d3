"""Checksum of a payload."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.csi2.layouts import rest_shape
from ncdc_hdl.lib.pipeline import register

__all__ = ["Checksum"]

_BITS = 16
_TAPS = 0x8408      # x^16 + x^12 + x^5 + 1, lowest bit first


class Checksum(wiring.Component):
    """CRC-16 of the specification, over a payload and the checksum that follows it.

    Timing: ``good`` is valid ``latency`` clocks after the last bytes.

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

    latency = 2

    def __init__(self, lanes):
        self.lanes = lanes
        super().__init__({"start": In(1), "valid": In(1), "data": In(8 * lanes),
                          "rest": In(rest_shape(lanes)), "good": Out(1)})

    def elaborate(self, platform):
        m = Module()
        state = Signal(_BITS, reset_less=True)
        # What the data and the state add to the next state, after each number of bytes. Each bit
        # is the parity of some of `bits`.
        bits, terms = Cat(state, self.data), [{k} for k in range(_BITS)]
        of_data, of_state = [], []
        for number in range(self.lanes):
            for bit in range(8):
                terms = _shifted(terms, _BITS + 8 * number + bit)
            for parts, of_it in ((of_state, range(_BITS)), (of_data, range(_BITS, len(bits)))):
                parts.append(Cat(Cat(bits[k] for k in of_it if k in each).xor() for each in terms))
        # `rest` is 0 for all bytes.
        of_data, of_state = (Array([*parts[-1:], *parts[:-1]]) for parts in (of_data, of_state))
        valid = register(m, "valid_d", self.valid, reset_less=False)
        rest = register(m, "rest_d", self.rest)
        part = register(m, "part", of_data[self.rest])
        with m.If(self.start):
            m.d.sync += state.eq((1 << _BITS) - 1)
        with m.Elif(valid):
            m.d.sync += state.eq(of_state[rest] ^ part)
        m.d.comb += self.good.eq(state == 0)
        return m


def _shifted(terms, bit):
    """The sets ``terms`` of the bits of a state after one more ``bit``."""
    feedback = terms[0] ^ {bit}
    shifted = [*terms[1:], set()]
    return [each ^ feedback if _TAPS >> k & 1 else each for k, each in enumerate(shifted)]
