"""Converts samples of a sensor to bytes: black level, gain, and a curve of straight pieces."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.gains import GAINED_LATENCY, gained
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.sensors.level import CURVE_BITS, LINEAR, PIECES, SAMPLE_BITS
from ncdc_spec.white_balance import GAIN_BITS, UNITY

__all__ = ["LEVEL", "Level"]

LEVEL = data.StructLayout({"black": SAMPLE_BITS,
                           "curve": data.ArrayLayout(CURVE_BITS, PIECES + 1)})
"""Black level and nodes of the curve, see ``ncdc_spec.sensors.level``."""

_PIECE_BITS = 8


class Level(wiring.Component):
    """Computes :func:`ncdc_spec.sensors.level.levelled` of a sample in every clock.

    Timing: free-running; ``o`` follows ``i`` and ``gain`` after ``latency`` clocks. Two
    multipliers.

    Members
    -------
    level : ``In(LEVEL)``
        Constant while samples come.
    i : ``In(12)``
    gain : ``In(10)``
        Gain of this sample, in 256ths.
    o : ``Out(8)``
    """

    latency = 1 + GAINED_LATENCY + 5
    """Clocks from a sample to its byte: above black, the gain; nodes of the piece, their slope,
    rise twice, the byte."""

    def __init__(self):
        super().__init__({"level": In(LEVEL, init={"curve": LINEAR}), "i": In(SAMPLE_BITS),
                          "gain": In(GAIN_BITS, init=UNITY), "o": Out(8)})

    def elaborate(self, platform):
        m = Module()
        d = self._gained(m)
        # Both nodes of the piece.
        piece, nodes = d[_PIECE_BITS:], [self.level.curve[k] for k in range(PIECES + 1)]
        left = register(m, "left", Array(nodes[:-1])[piece])
        right = register(m, "right", Array(nodes[1:])[piece])
        position = register(m, "position", d[:_PIECE_BITS])
        # The rise from the left node, with the registers of a multiplier before and after it.
        slope = register(m, "slope", right - left)
        late = delay(m, position, 1, "position")
        rise = register(m, "rise", register(m, "product", slope * late))
        left = delay(m, left, 3, "left")
        # The byte: not negative, as it lies between two nodes.
        value = (Cat(Const(128, _PIECE_BITS), left) + rise)[_PIECE_BITS:_PIECE_BITS + CURVE_BITS]
        m.d.sync += self.o.eq(Mux(value[-1], 255, value))
        return m

    def _gained(self, m):
        """The sample above black times its gain, at most what a full sample is above black."""
        above = self.i - self.level.black
        above = register(m, "above_black", Mux(above[-1], 0, above[:SAMPLE_BITS]))
        gain = register(m, "gain_of_sample", self.gain)
        full = register(m, "full", ~self.level.black)           # 4095 - black
        return gained(m, "gained", above, gain, full)
