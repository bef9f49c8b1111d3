"""What the Bayer decoders of 6x6 raw windows share: which sample goes where, and their sums."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.pipeline import register

__all__ = ["PAIRS", "WindowDecoder"]

# Pairs of samples around one, as (row, column) from there; D is the sum of D0 and D1.
PAIRS = {"H": ((0, -1), (0, 1)), "V": ((-1, 0), (1, 0)), "Q": ((0, -2), (0, 2)),
         "P": ((-2, 0), (2, 0)), "D0": ((-1, -1), (-1, 1)), "D1": ((1, -1), (1, 1))}


class WindowDecoder(wiring.Component):
    """Base of the decoders: four colours from the samples of a window.

    The window comes reflected where it must be for the first point to be green. So each kernel has
    its fixed points. The samples of a pair are added once for all points that have it, though for
    some it is D0 and for others H.

    A subclass has ``latency`` and the methods ``_at_green(m, name, sums)`` and
    ``_at_chroma(m, name, sums)``. Each takes a point's sample ``c`` and the sums of its pairs, of
    cycle 1, and gives the chroma of the same row, green, and the chroma of the other row in the
    last cycle.

    Parameters
    ----------
    interpolation : Interpolation
    points : ArrayLayout
        Twelve colours.
    green_pairs : dict
        Pairs of samples around a green one, as of PAIRS, which are those around the others.
    members : dict
        Further members of the signature.
    """

    def __init__(self, interpolation, points, green_pairs=PAIRS, members=None):
        self._interpolation, self._green_pairs = interpolation, green_pairs
        super().__init__({
            "samples": In(data.ArrayLayout(8, len(interpolation.samples))),
            "mono": In(1), "o": Out(points), **(members or {}),
        })

    def elaborate(self, platform):
        m = Module()
        at = dict(zip(self._interpolation.samples, self.samples))
        margin, sums = self._interpolation.margin, {}

        def pair(a, b):
            """The sum of the samples at two positions, in cycle 1."""
            if (a, b) not in sums:
                sums[a, b] = register(m, "pair_{}{}_{}{}".format(*a, *b), at[a] + at[b])
            return sums[a, b]

        for row in range(2):
            upper, lower = (2, 0) if row else (0, 2)    # colours of this row, of the other one
            for column in range(2):
                j, i, green = margin + row, margin + column, row == column
                around = {name: pair(*((j + y, i + x) for y, x in positions)) for name, positions
                          in (self._green_pairs if green else PAIRS).items()}
                name = f"{'g' if green else 'c'}{row}"
                around["c"] = register(m, f"{name}_c", at[j, i])
                kernels = self._at_green if green else self._at_chroma
                same_row, green_here, other = kernels(m, name, around)
                first = 6 * row + 3 * column
                m.d.comb += [self.o[first + upper].eq(same_row), self.o[first + 1].eq(green_here),
                             self.o[first + lower].eq(other)]
        return m
