"""Gradient-corrected Bayer decoder: four full colours from a 6x6 raw window, with adders only."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.interpolation import GRADIENT

__all__ = ["GradientPoints"]

# Point (j, i), colour k, in units of a sixteenth: index 6 j + 3 i + k. The kernels' weights of one
# sign sum up to 28 sixteenths, those of the other to 12: 14 bits hold every value.
_POINTS = data.ArrayLayout(signed(14), 12)


class GradientPoints(wiring.Component):
    """Colours of four neighbouring samples by the kernels of Malvar, He and Cutler (2004).

    Each row of two points has a green sample and a chroma sample, red or blue. With the sample c,
    the sums of its neighbours left and right, H, above and below, V, of its four diagonal ones, D,
    and of those two positions away along the row, Q, and along the column, P, in sixteenths::

        green at chroma     8 c + 4 (H + V) - 2 (P + Q)
        chroma at chroma   12 c + 4 D - 3 (P + Q)                 the other one
        chroma at green    10 c + 8 H - 2 D - 2 Q + P             that of the same row
                           10 c + 8 V - 2 D - 2 P + Q             that of the other row

    Nothing is rounded or clamped. So that each kernel is needed once, the points of a row are
    output green first. ``reversed`` is high if that is not their order from left to right. The
    chroma of the upper row comes first among the colours; it is blue if ``swapped``. Otherwise
    equal bit for bit to ``ncdc_model.golden.picture.gradient_colours``.

    With a grey sensor (``mono``) green is that of ``ncdc_model.golden.picture.grey_corners``. The
    other two colours have no meaning: at chroma, H and V are replaced by c, P and Q by zero, which
    gives 8 c + 4 (c + c).

    Timing: free-running, ``latency`` clocks.

    Members
    -------
    samples : ``In(ArrayLayout(8, 24))``
        The samples of ``GRADIENT.samples``.
    red_column, red_row : ``In(1)``
        Whether the first point's sample is in a column, a row, that holds red samples.
    mono : ``In(1)``
        Whether the sensor is grey; constant during a frame.
    o : ``Out(ArrayLayout(signed(14), 12))``
        Row by row, in each the green sample, then the chroma sample; for each the chroma of the
        upper row, green, the chroma of the lower row.
    reversed : ``Out(2)``
        For each row, whether its chroma sample is left of the green one.
    swapped : ``Out(1)``
    """

    latency = 6

    def __init__(self):
        super().__init__({
            "samples": In(data.ArrayLayout(8, len(GRADIENT.samples))),
            "red_column": In(1), "red_row": In(1), "mono": In(1),
            "o": Out(_POINTS), "reversed": Out(2), "swapped": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        # Cycle 1: whether the first point is red or blue, which selects hundreds of bits.
        chroma_first = register(m, "chroma_first", ~(self.red_row ^ self.red_column))
        samples = {position: register(m, f"s{n}", sample)
                   for n, (position, sample) in enumerate(zip(GRADIENT.samples, self.samples))}
        m.d.comb += [
            self.reversed.eq(delay(m, Cat(chroma_first, ~chroma_first), self.latency - 1,
                                   "reversed")),
            self.swapped.eq(delay(m, ~self.red_row, self.latency, "swapped")),
        ]
        for row in range(2):
            # In the lower row, green is first where chroma is first in the upper one.
            chroma_left = chroma_first ^ row
            at = 2 + row
            green = self._around(m, f"g{row}", samples, at, chroma_left)
            chroma = self._around(m, f"c{row}", samples, at, ~chroma_left)
            same_row, own, other_row = self._at_green(m, f"g{row}", green)
            m.d.comb += [self.o[6 * row + (2 if row else 0)].eq(same_row),
                         self.o[6 * row + 1].eq(own),
                         self.o[6 * row + (0 if row else 2)].eq(other_row)]
            own, green_here, other = self._at_chroma(m, f"c{row}", chroma)
            m.d.comb += [self.o[6 * row + 3 + (2 if row else 0)].eq(own),
                         self.o[6 * row + 4].eq(green_here),
                         self.o[6 * row + 3 + (0 if row else 2)].eq(other)]
        return m

    def _around(self, m, name, samples, row, right):
        """Sums around the sample in ``row`` and column 2, or 3 if ``right``; 2 clocks later.

        A dict of the sample ``c``, ``H``, ``V``, ``P``, ``Q`` and, above and below, ``D0``, ``D1``.
        """
        # Cycle 2: choose the column.
        at = {(j, i): register(m, f"{name}_s{j + 2}{i + 2}",
                               Mux(right, samples[row + j, 3 + i], samples[row + j, 2 + i]))
              for j in range(-2, 3) for i in range(-2, 3) if abs(i) + abs(j) <= 2}
        # Cycle 3: add the samples of each pair.
        pairs = {"H": ((0, -1), (0, 1)), "V": ((-1, 0), (1, 0)), "Q": ((0, -2), (0, 2)),
                 "P": ((-2, 0), (2, 0)), "D0": ((-1, -1), (-1, 1)), "D1": ((1, -1), (1, 1))}
        sums = {key: register(m, f"{name}_{key}", at[a] + at[b]) for key, (a, b) in pairs.items()}
        return {"c": register(m, f"{name}_c", at[0, 0]), **sums}

    def _at_green(self, m, name, sums):
        """Chroma of the same row, green, chroma of the other row; 3 clocks later."""
        c, h, v, p, q = (sums[key] for key in "cHVPQ")
        # Cycle 4.
        diagonal = register(m, f"{name}_D", sums["D0"] + sums["D1"])
        five = register(m, f"{name}_c5", (c << 2) + c)
        along = register(m, f"{name}_h0", (h << 3) + p)
        across = register(m, f"{name}_v0", (v << 3) + q)
        p, q = register(m, f"{name}_P3", p), register(m, f"{name}_Q3", q)
        # Cycle 5.
        common = register(m, f"{name}_k", five - diagonal)
        along = register(m, f"{name}_h1", along - (q << 1))
        across = register(m, f"{name}_v1", across - (p << 1))
        # Cycle 6.
        return (self._last(m, f"{name}_h", along + (common << 1)),
                self._last(m, f"{name}_own", delay(m, c, 2, f"{name}_c") << 4),
                self._last(m, f"{name}_v", across + (common << 1)))

    def _at_chroma(self, m, name, sums):
        """The own chroma, green, the other chroma; 3 clocks later."""
        c, h, v, p, q = (sums[key] for key in "cHVPQ")
        # Cycle 4.
        diagonal = register(m, f"{name}_D", sums["D0"] + sums["D1"])
        near = register(m, f"{name}_near", Mux(self.mono, c, h) + Mux(self.mono, c, v))
        far = register(m, f"{name}_far", Mux(self.mono, 0, p) + Mux(self.mono, 0, q))
        three = register(m, f"{name}_c3", (c << 1) + c)
        once = register(m, f"{name}_c1", c)
        # Cycle 5.
        green = register(m, f"{name}_g1", (once << 1) + near)
        other = register(m, f"{name}_o1", three + diagonal)
        thrice = register(m, f"{name}_far3", (far << 1) + far)
        twice = register(m, f"{name}_far2", far << 1)
        # Cycle 6.
        return (self._last(m, f"{name}_own", register(m, f"{name}_c2", once) << 4),
                self._last(m, f"{name}_g", (green << 2) - twice),
                self._last(m, f"{name}_o", (other << 2) - thrice))

    @staticmethod
    def _last(m, name, value):
        """The register of an output."""
        return register(m, f"{name}_o", value, _POINTS.elem_shape)
