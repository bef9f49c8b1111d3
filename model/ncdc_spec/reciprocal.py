"""The table of the reciprocal that divides by the depth of a view."""

__all__ = ["CURVE_BITS", "INDEX_BITS", "RECIPROCAL_BITS", "REST_BITS", "SLOPE_BITS", "SQUARE_BITS",
           "coefficients"]

INDEX_BITS = 7          # of the mantissa's fraction, that select a segment
REST_BITS = 20          # of the fraction after those: t
SQUARE_BITS = 12        # of t, its highest, in the term of t squared
CURVE_BITS = 13         # fraction bits of the coefficient of t squared
SLOPE_BITS = 21         # fraction bits of that of t
RECIPROCAL_BITS = 25    # fraction bits of the reciprocal


def coefficients():
    """Coefficients (c0, c1, c2) of each segment, a list of integer triples.

    The reciprocal of a mantissa a + t, with the segment's start a from 1 to 2, is close to
    c0 - c1 t + c2 t^2. It is exact at the start, the middle and the end of the segment. Segments
    have the width h = 2**-INDEX_BITS.
    """
    table = []
    for k in range(1 << INDEX_BITS):
        # Start, middle and end of the segment in halves of h.
        a, b, c = (2 * ((1 << INDEX_BITS) + k) + j for j in range(3))
        unit = 2 << INDEX_BITS
        # 1 / a;  1 / (a b) + h / (2 a b c) = (c + 1) / (a b c);  1 / (a b c)
        table.append((_rounded(unit << RECIPROCAL_BITS, a),
                      _rounded((c + 1) * unit**2 << SLOPE_BITS, a * b * c),
                      _rounded(unit**3 << CURVE_BITS, a * b * c)))
    return table


def _rounded(numerator, denominator):
    return (2 * numerator + denominator) // (2 * denominator)
