"""Wrong saturations, to see that tests find them."""

from amaranth import *

from ncdc_hdl.lib.fixed import saturate

__all__ = ["WRONG_SATURATIONS"]


def one_below(value, q):
    """Saturation whose upper limit is one too low."""
    return Mux(value >= q.hi, q.hi - 1, saturate(value, q))


def one_above(value, q):
    """Saturation whose lower limit is one too high."""
    return Mux(value <= q.lo, q.lo + 1, saturate(value, q))


def wrapped(value, q):
    """No saturation at all."""
    return value[:q.width].as_signed()


WRONG_SATURATIONS = one_below, one_above, wrapped
