"""What the Bayer decoders of 6x6 raw windows share: which sample goes where, and their sums."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.pipeline import delay, register

__all__ = ["PAIRS", "WindowDecoder"]

# Pairs of samples around one, as (row, column) from there; D is the sum of D0 and D1.
PAIRS = {"H": ((0, -1), (0, 1)), "V": ((-1, 0), (1, 0)), "Q": ((0, -2), (0, 2)),
         "P": ((-2, 0), (2, 0)), "D0": ((-1, -1), (-1, 1)), "D1": ((1, -1), (1, 1))}


class WindowDecoder(wiring.Component):
    """Base of the decoders: four colours from the samples of a window.

    A subclass has ``latency`` and the methods ``_at_green(m, name, sums)`` and
    ``_at_chroma(m, name, sums)``. Each takes the sums of :meth:`_around` of cycle 3, and gives the
    chroma of the same row, green, and the chroma of the other row in the last cycle.

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
            "red_column": In(1), "red_row": In(1), "mono": In(1),
            "o": Out(points), "reversed": Out(2), "swapped": Out(1), **(members or {}),
        })

    def elaborate(self, platform):
        m = Module()
        # Cycle 1: whether the first point is red or blue, which selects hundreds of bits.
        chroma_first = register(m, "chroma_first", ~(self.red_row ^ self.red_column))
        samples = {position: register(m, f"s{n}", sample) for n, (position, sample) in
                   enumerate(zip(self._interpolation.samples, self.samples))}
        m.d.comb += [
            self.reversed.eq(delay(m, Cat(chroma_first, ~chroma_first), self.latency - 1,
                                   "reversed")),
            self.swapped.eq(delay(m, ~self.red_row, self.latency, "swapped")),
        ]
        for row in range(2):
            # In the lower row, green is first where chroma is first in the upper one.
            chroma_left = chroma_first ^ row
            green = self._around(m, f"g{row}", samples, 2 + row, chroma_left, self._green_pairs)
            chroma = self._around(m, f"c{row}", samples, 2 + row, ~chroma_left, PAIRS)
            upper, lower = (2, 0) if row else (0, 2)    # colours of this row, of the other one
            for first, (same_row, green_here, other) in (
                    (0, self._at_green(m, f"g{row}", green)),
                    (3, self._at_chroma(m, f"c{row}", chroma))):
                m.d.comb += [self.o[6 * row + first + upper].eq(same_row),
                             self.o[6 * row + first + 1].eq(green_here),
                             self.o[6 * row + first + lower].eq(other)]
        return m

    @staticmethod
    def _around(m, name, samples, row, right, pairs):
        """Sums of the ``pairs`` around the sample in ``row`` and column 2, or 3 if ``right``, and
        that sample as ``c``, in a dict; 2 clocks later."""
        positions = {(0, 0), *(position for pair in pairs.values() for position in pair)}
        # Cycle 2: choose the column.
        at = {(j, i): register(m, f"{name}_s{j + 2}{i + 2}",
                               Mux(right, samples[row + j, 3 + i], samples[row + j, 2 + i]))
              for j, i in sorted(positions)}
        # Cycle 3: add the samples of each pair.
        sums = {key: register(m, f"{name}_{key}", at[a] + at[b]) for key, (a, b) in pairs.items()}
        return {"c": register(m, f"{name}_c", at[0, 0]), **sums}
