"""A sample moved by a fraction of the distance to its neighbours."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.layouts import GRID
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.sensors.level import SAMPLE_BITS

__all__ = ["TAPS", "Moved"]

TAPS = data.ArrayLayout(SAMPLE_BITS, 5)
"""Five samples of a line, the newest first; the one in the middle is moved."""

_SHIFT = 7


class Moved(wiring.Component):
    """Computes a sample of :func:`ncdc_spec.sensors.grid.evened` in every clock.

    Timing: free-running; ``o`` follows the inputs after ``latency`` clocks.

    Members
    -------
    taps : ``In(TAPS)``
    odd : ``In(1)``
        The index of the sample is odd: it moves towards the newest one, else to the oldest.
    weight : ``In(2)``
        Sixteenths; with 0 the sample keeps its value.
    o : ``Out(12)``
    """

    latency = 7
    """Order of the taps, differences, two sums, product, total, limits."""

    def __init__(self):
        super().__init__({"taps": In(TAPS), "odd": In(1), "weight": In(GRID["weight"].shape),
                          "o": Out(SAMPLE_BITS)})

    def elaborate(self, platform):
        m = Module()
        newest, newer, middle, older, oldest = (self.taps[k] for k in range(5))
        # In the direction of the move, as in the golden model.
        near, before, far, beyond = (
            register(m, name, Mux(self.odd, rising, falling)) for name, rising, falling in (
                ("near", newer, older), ("before", older, newer), ("far", newest, oldest),
                ("beyond", oldest, newest)))
        own = register(m, "own", middle)
        slope = register(m, "slope", near - before)
        wide = register(m, "wide", far - beyond)
        trailing = register(m, "trailing", own - beyond)
        sums = register(m, "sums", 4 * slope + wide)
        move = register(m, "move", sums + 2 * register(m, "trailing_d", trailing))
        weight = delay(m, self.weight, 4, "weight")
        product = register(m, "product", Mux(weight[0], move, 0) + Mux(weight[1], 2 * move, 0))
        half = Const(1 << _SHIFT - 1, _SHIFT)
        total = register(m, "total", Cat(half, delay(m, own, 4, "own")) + product)
        value = total >> _SHIFT
        m.d.sync += self.o.eq(Mux(value < 0, 0, Mux(value >> SAMPLE_BITS > 0,
                                                    (1 << SAMPLE_BITS) - 1, value)))
        return m
