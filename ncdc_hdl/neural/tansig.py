"""Tan-sigmoid: exponential by predicted hyperbolic rotations, division by linear vectoring."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from ncdc_hdl.fixed import add_signed

__all__ = ["Tansig"]


class Tansig(wiring.Component):
    """Tan-sigmoid of a hidden neuron, equation (17) with gamma = 1.

    Computes, for a = ``|n|``, by the structure of Fig. 9 and with one addition per stage::

        e = exp(-a)               region table, then u <- u -/+ (u >> s) per fine bit (MMHBC)
        q = (1 - e) / (1 + e)     quotient digits +-2**-i by the remainder's sign (LVC)
        o = sign(n) q

    Equal bit for bit to ``ncdc_model.tansig.tansig``: odd, o(0) = 0, last bit constant.
    Timing: free-running, one value per clock, no stall; ``latency`` clocks from ``i`` to ``o``.
    No multiplier.

    Parameters
    ----------
    design : ncdc_model.tansig.TansigDesign
        Formats, internal width, region table.

    Members
    -------
    i : ``In(signed(design.input.width))``
        n.
    o : ``Out(signed(design.output.width))``
        f(n).
    """

    def __init__(self, design):
        self.design = design
        super().__init__({"i": In(signed(design.input.width)),
                          "o": Out(signed(design.output.width))})

    @property
    def latency(self):
        """Clocks: magnitude, table, its register, rotations, 1 -/+ e, digits but the first
        decision and the last addition, sign."""
        return 3 + len(self.design.shifts) + 1 + self.design.digits - 1 + 1

    def elaborate(self, platform):
        m = Module()
        design = self.design
        width, fine = design.width, design.fine_bits

        def stage(name, shape):
            """A pipeline register that needs no reset: nothing reads it before it is written."""
            return Signal(shape, name=name, reset_less=True)

        # A: sign and magnitude; the most negative n has none and takes the largest.
        bits = design.input.width - 1
        a_magnitude, a_negative = stage("a_magnitude", bits), stage("a_negative", 1)
        negated = Signal(bits + 1)
        m.d.comb += negated.eq(-self.i)
        with m.If(self.i < 0):
            m.d.sync += a_magnitude.eq(Mux(negated[bits], design.input.hi, negated))
        with m.Else():
            m.d.sync += a_magnitude.eq(self.i)
        m.d.sync += a_negative.eq(self.i < 0)

        # T: region table, with a second register that block RAMs can absorb.
        m.submodules.table = table = Memory(shape=width, depth=len(design.table), init=design.table)
        read = table.read_port()
        m.d.comb += read.addr.eq(a_magnitude[fine:])
        t_u = stage("t_u", width)
        m.d.sync += t_u.eq(read.data)
        sign_zero = Cat(a_negative, a_magnitude == 0)
        rest = Cat(a_magnitude[:fine])
        for k in range(2):
            sign_zero_d, rest_d = stage(f"t{k}_sign_zero", 2), stage(f"t{k}_rest", fine)
            m.d.sync += [sign_zero_d.eq(sign_zero), rest_d.eq(rest)]
            sign_zero, rest = sign_zero_d, rest_d

        def delayed(name, value):
            register = stage(name, len(value))
            m.d.sync += register.eq(value)
            return register

        # R: one rotation per fine bit, the highest first; 1.0 itself may appear, hence a bit more.
        u = t_u
        for k, shift in enumerate(design.shifts):
            r_u = stage(f"r{k}_u", width + 1)
            m.d.sync += r_u.eq(add_signed(Cat(u, 0), u[shift:], rest[-1], u[shift - 1]))
            u = r_u
            sign_zero = delayed(f"r{k}_sign_zero", sign_zero)
            rest = delayed(f"r{k}_rest", rest[:-1]) if k < len(design.shifts) - 1 else None

        # N: numerator 1 - e and denominator 1 + e.
        remainder, divisor = stage("n_remainder", signed(width + 2)), stage("n_divisor", width + 2)
        m.d.sync += [remainder.eq((1 << width) - u), divisor.eq((1 << width) + u)]
        sign_zero = delayed("n_sign_zero", sign_zero)

        # L: after digit i the remainder is at most divisor >> i, give or take the roundings, so
        # that the adders shrink. The first digit is always positive, the last needs no remainder.
        quotient = None
        for i in range(1, design.digits):
            negative = Const(0, 1) if i == 1 else remainder[-1]
            bound = (1 << (width + 1 - i)) + i
            l_remainder = stage(f"l{i}_remainder", signed(bound.bit_length() + 1))
            m.d.sync += l_remainder.eq(add_signed(remainder, divisor[i:], ~negative, divisor[i - 1]))
            if i > 1:
                digits = ~negative if quotient is None else Cat(~negative, quotient)
                quotient = delayed(f"l{i}_quotient", digits)
            remainder = l_remainder
            divisor = delayed(f"l{i}_divisor", divisor)
            sign_zero = delayed(f"l{i}_sign_zero", sign_zero)

        # S: -q is ~q below the constant last bit, so that restoring the sign needs no carry.
        top = Cat(~remainder[-1], quotient, 0)
        negative, zero = sign_zero[0], sign_zero[1]
        s_o = stage("s_o", len(self.o))
        m.d.sync += s_o.eq(Mux(zero, 0, Cat(1, top ^ negative.replicate(len(top)))))
        m.d.comb += self.o.eq(s_o)
        return m
