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
_HALF = 32      # of a grey level, in the unit of signed colours between two points of a row


class Bilinear(wiring.Component):
    """Separable linear interpolation, equations (30)-(32) and Fig. 15, one rounding at the end::

        upper = q00 + fx (q01 - q00)            lower likewise from the second row of points
        o     = round(upper + fy (lower - upper))

    for each colour. ``interpolation`` has the units: those of the points, and those of ``upper``
    and ``lower``, whose lower bits are cut off. Signed colours may leave 0..255: the result is
    clamped. Equal bit for bit to ``ncdc_model.golden.picture.bilinear``. Timing: free-running,
    ``latency`` clocks; a product has a register before it, besides that of the difference, and two
    after it. Nine multipliers of 18 bits: the second step of the fast interpolation has differences
    of more bits, whose products with fy are added one clock later.

    Parameters
    ----------
    f_bits : int
        Fraction bits of fx and fy.
    interpolation : Interpolation
        It determines the units of the colours.
    points : ArrayLayout
        Four points: point (j, i), colour k has the index 6 j + 3 i + k.

    Members
    -------
    i : ``In(points)``
    fx, fy : ``In``
        0 to 1 - 2**-f_bits; up to 1 with signed colours, whose points may come reflected.
    crest : ``In(signed(14))``
        With a crest only: added to all colours with the half of the rounding, in 64ths of a grey
        level, ``crest_clock`` clocks after the four colours.
    o : ``Out(ArrayLayout(8, 3))``
        Red, green, blue.
    """

    latency = 12        # with a sum of 6 clocks and a rounding, or one of 5 and a clamp
    crest_clock = 10    # after which the sum of both steps is complete

    def __init__(self, f_bits, interpolation=FAST, points=QUADS):
        self.f_bits, self.interpolation = f_bits, interpolation
        self.colour = Shape.cast(points.elem_shape)
        self.crested = interpolation == DIRECTIONAL
        super().__init__({"i": In(points), "fx": In(f_bits + self.colour.signed),
                          "fy": In(f_bits + self.colour.signed), "o": Out(data.ArrayLayout(8, 3))}
                         | ({"crest": In(signed(14))} if self.crested else {}))

    def elaborate(self, platform):
        m = Module()
        fx, fy = delay(m, self.fx, 2, "fx"), delay(m, self.fy, 7, "fy")
        more = self.f_bits - self.interpolation.cut(self.f_bits)    # fraction bits of a row
        for colour in range(3):
            q00, q01, q10, q11 = (self.i[6 * j + 3 * i + colour]
                                  for j in range(2) for i in range(2))
            # Cycles 1 to 5: interpolate along both rows of points.
            upper = self._lerp(m, f"u{colour}", q00, q01, fx, more)
            lower = self._lerp(m, f"l{colour}", q10, q11, fx, more)
            # Cycles 6 to 10 or 11: interpolate between the rows.
            total = self._lerp(m, f"v{colour}", upper, lower, fy, 0)
            if not self.colour.signed and not _is_wide(lower - upper):
                # Coordinates of few fraction bits: as late as with more of them.
                total = pipeline.register(m, f"v{colour}_late", total)
            self._rounded(m, colour, total)
        return m

    def _lerp(self, m, name, a, b, fraction, more):
        """a + fraction (b - a) with ``more`` fraction bits than a, 5 clocks later; ``fraction``
        comes 2 clocks after a, b.

        6 clocks later if the difference has more bits than a multiplier block; the part above it
        has its own product.
        """
        register = partial(pipeline.register, m)
        # Cycles 1 and 2: subtract, and the register before the multiplier.
        difference = register(f"{name}_d1", register(f"{name}_d0", b - a))
        wide = _is_wide(difference)
        low = difference[:_BLOCK - 1] if wide else difference
        # Cycles 3 and 4: multiply.
        product = register(f"{name}_p1", register(f"{name}_p0", low * fraction))
        # Cycle 5, if wide: add the product of the bits above the block.
        if wide:
            high = difference[_BLOCK - 1:].as_signed()
            above = register(f"{name}_h1", register(f"{name}_h0", high * fraction))
            product = register(f"{name}_p2", product + (above << _BLOCK - 1))
        # The last cycle: add a. The further fraction bits are the product's.
        product = product >> self.f_bits - more
        total = delay(m, a, 5 if wide else 4, f"{name}_a") + (product >> more)
        return register(f"{name}_s", Cat(product[:more], total),
                        Shape(len(a) + more, self.colour.signed))

    def _rounded(self, m, colour, total):
        """The sum ``total`` of both steps as the output of a ``colour``."""
        row_bits = self.interpolation.row_bits
        if not self.colour.signed:
            # Cycle 12: round. Adding a half carries exactly if the highest bit dropped is set.
            shift = self.interpolation.unit_bits + self.f_bits
            m.d.sync += self.o[colour].eq(total[shift:] + total[shift - 1])
            return
        # Cycle 11: round.
        added = self.crest if self.crested else Const(_HALF)
        rounded = pipeline.register(m, f"r{colour}", total + added) >> row_bits
        # Cycle 12: clamp, by the bits above a byte: a comparison would be a chain of carries.
        negative, above = rounded[-1], rounded[8:-1].any()
        m.d.sync += self.o[colour].eq(Mux(negative, 0, rounded[:8] | above.replicate(8)))


def _is_wide(difference):
    """Whether a ``difference`` has more bits than a multiplier block."""
    return len(difference) > _BLOCK
