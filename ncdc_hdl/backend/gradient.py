"""Gradient-corrected Bayer decoder: four full colours from a 6x6 raw window, with adders only."""

from amaranth import *
from amaranth.lib import data

from ncdc_hdl.backend.window_decoder import WindowDecoder
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.interpolation import GRADIENT

__all__ = ["GradientPoints"]

# Point (j, i), colour k, in units of a sixteenth: index 6 j + 3 i + k. The kernels' weights of one
# sign sum up to 28 sixteenths, those of the other to 12: 14 bits hold every value.
_POINTS = data.ArrayLayout(signed(14), 12)


class GradientPoints(WindowDecoder):
    """Colours of four neighbouring samples by the kernels of Malvar, He and Cutler (2004).

    Each row of two points has a green sample and a chroma sample, red or blue. With the sample c,
    the sums of its neighbours left and right, H, above and below, V, of its four diagonal ones, D,
    and of those two positions away along the row, Q, and along the column, P, in sixteenths::

        green at chroma     8 c + 4 (H + V) - 2 (P + Q)
        chroma at chroma   12 c + 4 D - 3 (P + Q)                 the other one
        chroma at green    10 c + 8 H - 2 D - 2 Q + P             that of the same row
                           10 c + 8 V - 2 D - 2 P + Q             that of the other row

    Nothing is rounded or clamped. The chroma of the upper row comes first among the colours: it is
    red or blue as that row's samples are. Otherwise equal bit for bit to
    ``ncdc_model.golden.picture.gradient_colours``.

    With a grey sensor (``mono``) green is that of ``ncdc_model.golden.picture.grey_corners``. The
    other two colours have no meaning: at chroma, H and V are replaced by c, P and Q by zero, which
    gives 8 c + 4 (c + c).

    Timing: free-running, ``latency`` clocks.

    Members
    -------
    samples : ``In(ArrayLayout(8, 24))``
        The samples of ``GRADIENT.samples``; that of the first point is green.
    mono : ``In(1)``
        Whether the sensor is grey; constant during a frame.
    o : ``Out(ArrayLayout(signed(14), 12))``
        Point by point; for each the chroma of the upper row, green, the chroma of the lower row.
    """

    latency = 4

    def __init__(self):
        super().__init__(GRADIENT, _POINTS)

    def _at_green(self, m, name, sums):
        """Chroma of the same row, green, chroma of the other row."""
        c, h, v, p, q = (sums[key] for key in "cHVPQ")
        # Cycle 2.
        diagonal = register(m, f"{name}_D", sums["D0"] + sums["D1"])
        five = register(m, f"{name}_c5", (c << 2) + c)
        along = register(m, f"{name}_h0", (h << 3) + p)
        across = register(m, f"{name}_v0", (v << 3) + q)
        p, q = register(m, f"{name}_P3", p), register(m, f"{name}_Q3", q)
        # Cycle 3.
        common = register(m, f"{name}_k", five - diagonal)
        along = register(m, f"{name}_h1", along - (q << 1))
        across = register(m, f"{name}_v1", across - (p << 1))
        # Cycle 4.
        return (self._last(m, f"{name}_h", along + (common << 1)),
                self._last(m, f"{name}_own", delay(m, c, 2, f"{name}_c") << 4),
                self._last(m, f"{name}_v", across + (common << 1)))

    def _at_chroma(self, m, name, sums):
        """The own chroma, green, the other chroma."""
        c, h, v, p, q = (sums[key] for key in "cHVPQ")
        # Cycle 2.
        diagonal = register(m, f"{name}_D", sums["D0"] + sums["D1"])
        near = register(m, f"{name}_near", Mux(self.mono, c, h) + Mux(self.mono, c, v))
        far = register(m, f"{name}_far", Mux(self.mono, 0, p) + Mux(self.mono, 0, q))
        three = register(m, f"{name}_c3", (c << 1) + c)
        once = register(m, f"{name}_c1", c)
        # Cycle 3.
        green = register(m, f"{name}_g1", (once << 1) + near)
        other = register(m, f"{name}_o1", three + diagonal)
        thrice = register(m, f"{name}_far3", (far << 1) + far)
        twice = register(m, f"{name}_far2", far << 1)
        # Cycle 4.
        return (self._last(m, f"{name}_own", register(m, f"{name}_c2", once) << 4),
                self._last(m, f"{name}_g", (green << 2) - twice),
                self._last(m, f"{name}_o", (other << 2) - thrice))

    @staticmethod
    def _last(m, name, value):
        """The register of an output."""
        return register(m, f"{name}_o", value, _POINTS.elem_shape)
