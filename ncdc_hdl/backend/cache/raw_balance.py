"""White balance of raw samples as they come from memory, before interpolation."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.gains import BALANCE, GAINED_LATENCY, NO_BALANCE, gain_of, gained
from ncdc_hdl.lib.pipeline import register

__all__ = ["RawBalance"]


class RawBalance(wiring.Component):
    """Gains of the samples of a memory word, whose first byte is in an even column::

        o[k] = min(255, (gain i[k] + 128) >> 8)

    A row has samples of two colours: even bytes have one gain, odd ones another. Equal bit for bit
    to :func:`ncdc_spec.raw_gains.balanced_raw`. Timing: free-running, ``latency`` clocks. A
    multiplier a byte.

    Parameters
    ----------
    data_width : int
        Bits of a memory word.

    Members
    -------
    balance : ``In(BALANCE)``
        Constant during a frame.
    odd_row : ``In(1)``
        The word is of an odd row of the raw frame.
    i, o : ``In(data_width)``, ``Out(data_width)``
    """

    latency = 1 + GAINED_LATENCY
    """Clocks from a word to its result: a register before the multipliers, the product."""

    def __init__(self, data_width):
        super().__init__({"balance": In(BALANCE, init=NO_BALANCE), "odd_row": In(1),
                          "i": In(data_width), "o": Out(data_width)})

    def elaborate(self, platform):
        m = Module()
        phase = self.balance.phase
        red_row = ~(self.odd_row ^ phase[1])
        gains = [register(m, f"gain_{name}", gain_of(self.balance, red_column, red_row))
                 for name, red_column in (("even", ~phase[0]), ("odd", phase[0]))]
        word = register(m, "word", self.i)
        m.d.comb += self.o.eq(Cat(
            gained(m, f"byte{k}", word.word_select(k, 8), gains[k % 2], 255)
            for k in range(len(word) // 8)))
        return m
