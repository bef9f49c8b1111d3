"""Bilinear interpolation between the colours of four points."""

from functools import partial

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.bayer import QUADS
from ncdc_hdl.lib import pipeline
from ncdc_hdl.lib.pipeline import delay
from ncdc_spec.interpolation import DIRECTIONAL, FAST

__all__ = ["Bilinear"]

_BLOCK = 18     # bits of a multiplier block
_CREST_BITS = 6     # fraction bits of a crest


class Bilinear(wiring.Component):
    """Separable linear interpolation, equations (30)-(32) and Fig. 15, one rounding at the end::

        upper = 2**f q00 + fx (q01 - q00)       lower likewise from the second row of points
        o     = (2**f upper + fy (lower - upper) + half) >> (2 f + u)

    for each colour; u is the points' fraction bits: one for quads, in halves, four for
    gradient-corrected colours, in sixteenths. The latter may leave 0..255: the result is clamped.
    Equal bit for bit to ``ncdc_model.golden.picture.bilinear``. Timing: free-running, ``latency``
    clocks; a product has a register before it, besides that of the difference, and two after it.
    Nine multipliers of 18 bits: the second step's differences have a few more bits, whose products
    with fy are added one clock later.

    Parameters
    ----------
    f_bits : int
        Fraction bits of fx and fy.
    interpolation : Interpolation
        It determines the unit of the colours.
    points : ArrayLayout
        Four points: point (j, i), colour k has the index 6 j + 3 i + k.

    Members
    -------
    i : ``In(points)``
    fx, fy : ``In(f_bits)``
    reversed : ``In(2)``
        For each row, whether its points come right to left; only for signed colours.
    crest : ``In(signed(14))``
        With a crest only: added to all colours with the half of the rounding, in 64ths of a grey
        level, ``crest_clock`` clocks after the four colours.
    o : ``Out(ArrayLayout(8, 3))``
        Red, green, blue.
    """

    crest_clock = 11        # after which the sum of both steps is complete

    def __init__(self, f_bits, interpolation=FAST, points=QUADS):
        self.f_bits, self.unit_bits = f_bits, interpolation.unit_bits
        self.colour = Shape.cast(points.elem_shape)
        self.crested = interpolation == DIRECTIONAL
        super().__init__({"i": In(points), "fx": In(f_bits), "fy": In(f_bits),
                          "o": Out(data.ArrayLayout(8, 3))}
                         | ({"reversed": In(2)} if self.colour.signed else {})
                         | ({"crest": In(signed(14))} if self.crested else {}))

    @property
    def latency(self):
        """Clocks from four colours to the pixel: the last one clamps what can leave 0..255."""
        return 13 if self.colour.signed else 12

    def elaborate(self, platform):
        m = Module()
        fy_before = delay(m, self.fy, 6, "fy")
        fy = pipeline.register(m, "fy_d6", fy_before)
        if self.colour.signed:
            minus_fy = pipeline.register(m, "minus_fy", -delay(m, self.fy, 5, "fy_above"))
            # From the other end, the position is 1 - fx.
            rows = [pipeline.register(m, f"fx{j}_d1", pipeline.register(
                m, f"fx{j}_d0", Mux(self.reversed[j], (1 << self.f_bits) - self.fx, self.fx),
                self.f_bits + 1)) for j in range(2)]
        else:
            rows = [delay(m, self.fx, 2, "fx")] * 2

        register = partial(pipeline.register, m)

        def lerp(name, a, b, fraction, cut=False):
            """a 2**f + fraction (b - a), 5 clocks later; ``fraction`` comes 2 clocks after a, b.

            ``cut``: 6 clocks later; the part of the difference above the block has its own product.
            """
            # Cycles 1 and 2: subtract, and the register before the multiplier.
            subtracted = register(f"{name}_d", b - a)
            difference = delay(m, subtracted, 1, f"{name}_d")
            split = min(_BLOCK, len(difference)) - 1
            low = difference[:split] if cut else difference
            # Cycles 3 and 4: multiply.
            product = register(f"{name}_p1", register(f"{name}_p0", low * fraction))
            # Cycle 5, if cut: add the product of the bits above the block.
            if cut:
                if self.colour.signed:
                    above = self._added(m, f"{name}_h", subtracted[split:].as_signed(), fy_before,
                                        minus_fy)
                else:
                    high = difference[split:].as_signed()
                    above = register(f"{name}_h1", register(f"{name}_h0", high * fraction))
                product = register(f"{name}_p2", product + (above << split))
            # The last cycle: add a.
            first = delay(m, a, 5 if cut else 4, f"{name}_a") << self.f_bits
            return register(f"{name}_s", first + product,
                            Shape(len(a) + self.f_bits, self.colour.signed))

        for colour in range(3):
            q00, q01, q10, q11 = (self.i[6 * j + 3 * i + colour]
                                  for j in range(2) for i in range(2))
            # Cycles 1 to 5: interpolate along both rows of points.
            upper = lerp(f"u{colour}", q00, q01, rows[0])
            lower = lerp(f"l{colour}", q10, q11, rows[1])
            # Cycles 6 to 11: interpolate between the rows.
            self._rounded(m, colour, lerp(f"v{colour}", upper, lower, fy, cut=True))
        return m

    def _rounded(self, m, colour, total):
        """The sum ``total`` of both steps as the output of a ``colour``."""
        register = partial(pipeline.register, m)
        shift = 2 * self.f_bits + self.unit_bits
        # Cycle 12: round. Adding a half carries exactly if the highest bit dropped is set.
        whole, half = total[shift:], total[shift - 1]
        if not self.colour.signed:
            m.d.sync += self.o[colour].eq(whole + half)
            return
        if self.crested:
            finer = total[shift - _CREST_BITS:].as_signed()
            rounded = register(f"r{colour}", finer + self.crest) >> _CREST_BITS
        else:
            rounded = register(f"r{colour}", whole.as_signed() + half)
        # Cycle 13: clamp.
        m.d.sync += self.o[colour].eq(
            Mux(rounded < 0, 0, rounded[:8] | (rounded > 255).replicate(8)))

    @staticmethod
    def _added(m, name, high, fraction, minus):
        """``high * fraction`` 3 clocks later, with adders; ``high`` is signed and has few bits.

        In digits of -2..2 to the base 4 (Booth's recoding). ``minus``: the negated fraction.
        """
        digits = []
        for k in range(0, len(high), 2):
            below = high[k - 1] if k else Const(0, 1)
            upper = high[min(k + 1, len(high) - 1)]
            once, twice = high[k] ^ below, (upper ^ high[k]) & ~(high[k] ^ below)
            signed_fraction = Mux(upper, minus, fraction)
            digits.append(pipeline.register(
                m, f"{name}_digit{k}",
                Mux(once, signed_fraction, Mux(twice, signed_fraction << 1, 0))))
        sums = [pipeline.register(m, f"{name}0_{k}", sum(
            digit << 2 * n for n, digit in enumerate(digits[k:k + 2])))
            for k in range(0, len(digits), 2)]
        return pipeline.register(m, f"{name}1", sum(
            value << 4 * n for n, value in enumerate(sums)))
