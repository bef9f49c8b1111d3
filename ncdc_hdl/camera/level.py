"""Converts samples of a sensor to bytes: black level, and a curve of straight pieces."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.sensors.level import CURVE_BITS, LINEAR, PIECES, SAMPLE_BITS

__all__ = ["LEVEL", "Level"]

LEVEL = data.StructLayout({"black": SAMPLE_BITS,
                           "curve": data.ArrayLayout(CURVE_BITS, PIECES + 1)})
"""Black level and nodes of the curve, see ``ncdc_spec.sensors.level``."""

_PIECE_BITS = 8


class Level(wiring.Component):
    """Computes :func:`ncdc_spec.sensors.level.levelled` of a sample in every clock.

    Timing: free-running; ``o`` follows ``i`` after ``latency`` clocks.

    Members
    -------
    level : ``In(LEVEL)``
        Constant while samples come.
    i : ``In(12)``
    o : ``Out(8)``
    """

    latency = 6

    def __init__(self):
        super().__init__({"level": In(LEVEL, init={"curve": LINEAR}), "i": In(SAMPLE_BITS),
                          "o": Out(8)})

    def elaborate(self, platform):
        m = Module()
        # Above black.
        above = self.i - self.level.black
        d = register(m, "above_black", Mux(above[-1], 0, above[:SAMPLE_BITS]))
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
