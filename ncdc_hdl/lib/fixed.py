"""Fixed-point building blocks of the gateware."""

from amaranth import *

__all__ = ["add_signed", "saturate"]


def add_signed(a, b, subtract, carry):
    """a + b + carry, or a - b - carry if the one-bit ``subtract`` is set, in one carry chain.

    ``carry`` is the bit that rounds b: b + carry is added or subtracted. A subtraction
    adds ~b and the inverted carry; both share the adder through one extra bit at the bottom.
    """
    flipped = (b ^ subtract.replicate(len(b)))[:len(b)].as_signed() if b.shape().signed else \
        Cat(b ^ subtract.replicate(len(b)), subtract).as_signed()
    total = Cat(Const(1, 1), a).as_signed() + Cat(carry ^ subtract, flipped).as_signed()
    return total >> 1


def saturate(value, q):
    """The signed ``value`` limited to the range of format ``q``, as a signed value of its width.

    A value fits if all bits above those of the format are copies of its sign; only these are
    compared. A value that does not fit becomes the limit on its side, a constant.
    """
    sign, above = value[-1], value[q.width - 1:]
    fits = ~(above ^ sign.replicate(len(above))).any()
    limit = Mux(sign, Const(q.lo, signed(q.width)), Const(q.hi, signed(q.width)))
    return Mux(fits, value[:q.width].as_signed(), limit)
