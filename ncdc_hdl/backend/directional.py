"""Directional Bayer decoder: four full colours from a 6x6 raw window, with adders alone."""

from functools import partial

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.window_decoder import PAIRS, WindowDecoder
from ncdc_hdl.lib import pipeline
from ncdc_hdl.lib.pipeline import delay
from ncdc_spec.interpolation import DIRECTIONAL

__all__ = ["BEND", "Crest", "DirectionalPoints", "Direction"]

_SAMPLES = data.ArrayLayout(8, len(DIRECTIONAL.samples))
# Sample (j, i), colour k, in units of a sixteenth: index 6 j + 3 i + k. The kernels' weights of one
# sign sum up to 36 sixteenths, those of the other to 20: 15 bits hold every value.
_POINTS = data.ArrayLayout(signed(15), 12)
# Middle second differences of rows 2 and 3, and of columns 2 and 3, of coarse samples: two of each.
BEND = data.StructLayout({"x": signed(9), "y": signed(9)})
_STEP = data.StructLayout({"whole": 1, "half": 1, "minus": 1})
_KNIGHTS = {"Kv0": ((-2, -1), (-2, 1)), "Kv1": ((2, -1), (2, 1)),
            "Kh0": ((-1, -2), (1, -2)), "Kh1": ((-1, 2), (1, 2))}


class Direction(wiring.Component):
    """The direction in which colour differences vary less, of a 6x6 raw window.

    Equal to ``ncdc_model.golden.directional.twice_direction``, whose docstring has the equations.
    With the difference v - h, its magnitude m and the larger one l of h and v, these are::

        s = 1 if 2 m >= l + 8, 1/2 if 4 m >= l + 8, else 0; negative if h is l

    Timing: free-running, ``latency`` clocks.

    Members
    -------
    samples : ``In(ArrayLayout(8, 32))``
        Those of ``DIRECTIONAL.samples``.
    mono : ``In(1)``
        Whether the sensor is grey: there is no direction then. Constant during a frame.
    o : ``Out(StructLayout({"whole": 1, "half": 1, "minus": 1}))``
        The factor s: with ``whole`` 1, with ``half`` alone a half, else 0; negative with ``minus``.
    bend : ``Out(BEND)``
        Sums of the middle second differences, along the rows and along the columns, after
        ``bend_latency`` clocks: those of the crest.
    """

    latency = 8
    bend_latency = 3
    _DROPPED = 2        # lowest bits of each sample that are ignored

    def __init__(self):
        super().__init__({"samples": In(_SAMPLES), "mono": In(1), "o": Out(_STEP),
                          "bend": Out(BEND)})

    def elaborate(self, platform):
        m = Module()
        register = partial(pipeline.register, m)
        at = {position: sample[self._DROPPED:]
              for position, sample in zip(DIRECTIONAL.samples, self.samples)}
        turned = {(i, j): sample for (j, i), sample in at.items()}
        (h, bend_x), (v, bend_y) = self._variation(m, "h", at), self._variation(m, "v", turned)
        m.d.comb += [self.bend.x.eq(bend_x), self.bend.y.eq(bend_y)]
        # Cycle 6. The bias of 7 is part of both h and v.
        difference = register("difference", v - h)
        h, v = register("h", h), register("v", v)
        # Cycle 7: the magnitude is ``rest`` and one more if the difference is negative.
        negative = difference[-1]
        minus = register("minus", negative)
        rest = register("rest", Mux(self.mono, 0, difference ^ negative.replicate(
            len(difference)))[:len(h)])
        larger = register("larger", Mux(negative, h, v))
        # Cycle 8: rest + minus > larger / 2, or a quarter, rounded down: by the sign of a
        # difference, after which there is no logic.
        for flag, bits in ((self.o.whole, 1), (self.o.half, 2)):
            m.d.sync += flag.eq((Cat(0, larger[bits:]) - Cat(minus, rest))[-1])
        m.d.sync += self.o.minus.eq(minus)
        return m

    @staticmethod
    def _variation(m, name, at):
        """Sum of the second differences along the rows of ``at`` and 7 more, 5 clocks later, and
        that of the middle ones of rows 2 and 3, 3 clocks later."""
        register = partial(pipeline.register, m)
        differences = {}
        for j, columns in ((2, range(3)), (3, range(3)), (1, (1,)), (4, (1,))):
            # Cycle 1: subtract samples two apart. Cycle 2: subtract neighbouring differences.
            first = {i: register(f"{name}_e{j}{i}", at[j, i] - at[j, i + 2])
                     for i in range(columns[0], columns[-1] + 2)}
            for i in columns:
                differences[j, i] = register(f"{name}_d{j}{i}", first[i] - first[i + 1])
        # Cycles 3 to 5: magnitudes, added two by two. A negative d has -d - 1, its bits inverted.
        # Each adder has a carry: seven in all.
        terms = [(d ^ d[-1].replicate(len(d)))[:-1] for d in differences.values()]
        for level in range(3):
            terms = [register(f"{name}_s{level}{k}", _sum_and_one(terms[k], terms[k + 1]))
                     for k in range(0, len(terms), 2)]
        return terms[0], register(f"{name}_bend", differences[2, 1] + differences[3, 1])


def _sum_and_one(a, b):
    """a + b + 1 by one adder: the one is its carry."""
    return (Cat(1, a) + Cat(1, b))[1:]


class Crest(wiring.Component):
    """What is added to a pixel's colours where bilinear blending cuts off a crest, and a half for
    the rounding::

        o = 32 - strength (n(fx) bend.x + n(fy) bend.y)         in 64ths of a grey level

    Equal but for the 32 to ``ncdc_model.golden.directional.crest_of``, whose docstring has n.
    Timing: free-running, ``latency`` clocks.

    Parameters
    ----------
    f_bits : int
        Fraction bits of fx and fy, at least 4.

    Members
    -------
    bend : ``In(BEND)``
    fx, fy : ``In(f_bits)``
    strength : ``In(2)``
        0, 1 or 2; constant during a frame.
    o : ``Out(signed(14))``
    """

    latency = 5

    def __init__(self, f_bits):
        super().__init__({"bend": In(BEND), "fx": In(f_bits), "fy": In(f_bits),
                          "strength": In(2), "o": Out(signed(14))})

    def elaborate(self, platform):
        m = Module()
        register = partial(pipeline.register, m)
        products = []
        for axis, bend, fraction in (("x", self.bend.x, self.fx), ("y", self.bend.y, self.fy)):
            # Cycle 1: eighths of 2 f or of 2 (1 - f), whichever is smaller.
            eighth = register(f"eighth_{axis}", fraction[-4:-1] ^ fraction[-1].replicate(3))
            # Cycle 2: n is 0, 1, 2, 2, 3, 3, 4, 4.
            n = register(f"n_{axis}", Mux(eighth.any(), eighth[1:] + 1, 0))
            bend = delay(m, bend, 2, f"bend_{axis}")
            # Cycle 3: n times the bend as a sum of two.
            once = Mux(n[0], bend, Mux(n[2], bend << 1, 0))
            twice = Mux(n[1] | n[2], bend << 1, 0)
            products.append(register(f"product_{axis}", once + twice))
        # Cycle 4: add. Cycle 5: strength and the half.
        total = register("total", sum(products))
        scaled = Mux(self.strength[1], total << 1, Mux(self.strength[0], total, 0))
        m.d.sync += self.o.eq(32 - scaled)
        return m


class DirectionalPoints(WindowDecoder):
    """The colours of four neighbouring samples by the kernels of
    ``ncdc_model.golden.directional``, whose docstring has the equations.

    Nothing is rounded or clamped. The chroma of the upper row comes first among the colours: it is
    red or blue as that row's samples are. Otherwise equal bit for bit to
    ``ncdc_model.golden.directional.directional_colours``.

    Of a grey sensor (``mono``) green is that of ``ncdc_model.golden.picture.grey_corners``, and the
    other two colours say nothing.

    Timing: free-running, ``latency`` clocks.

    Members
    -------
    samples : ``In(ArrayLayout(8, 32))``
        Those of ``DIRECTIONAL.samples``; that of the first point is green.
    mono : ``In(1)``
        Whether the sensor is grey; constant during a frame.
    o : ``Out(ArrayLayout(signed(15), 12))``
        Point by point; of each the chroma of the upper row, green, the chroma of the lower row.
    bend : ``Out(BEND)``
        As of :class:`Direction`, after ``bend_latency`` clocks.
    """

    latency = Direction.latency + 2     # choose a step by the direction, add it
    bend_latency = Direction.bend_latency

    def __init__(self):
        self._direction = Direction()
        super().__init__(DIRECTIONAL, _POINTS, PAIRS | _KNIGHTS, {"bend": Out(BEND)})

    def elaborate(self, platform):
        m = super().elaborate(platform)
        m.submodules.direction = self._direction
        m.d.comb += [self._direction.samples.eq(self.samples), self._direction.mono.eq(self.mono),
                     self.bend.eq(self._direction.bend)]
        return m

    @staticmethod
    def _fours(m, name, sums, keys):
        """Sums of two pairs each, in cycle 2."""
        return {key: pipeline.register(m, f"{name}_{key}", sums[f"{key}0"] + sums[f"{key}1"])
                for key in keys}

    def _at_green(self, m, name, sums):
        """Chroma of the same row, green, chroma of the other row."""
        register, step = partial(pipeline.register, m), self._direction.o
        c, fours = sums["c"], self._fours(m, name, sums, ("D", "Kv", "Kh"))
        # Cycle 3: what both lines have in common.
        rest = register(f"{name}_rest", (register(f"{name}_c1", c) << 2) - fours["D"])
        same, other = (
            self._at_green_along(m, f"{name}_{near}", (c, sums[near], sums[far], fours[knights]),
                                 rest, minus) for near, far, knights, minus in
            (("H", "Q", "Kv", step.minus), ("V", "P", "Kh", ~step.minus)))
        return same, self._own(m, name, c), other

    def _at_green_along(self, m, name, sums, rest, minus):
        """a + b + s (a - b) with the sums along and across the line."""
        register = partial(pipeline.register, m)
        c, near, far, knights = sums
        # Cycle 2.
        a = register(f"{name}_a2", (near << 2) - far)
        c2, near2 = register(f"{name}_c2", c), register(f"{name}_near2", near)
        # Cycle 3.
        a = register(f"{name}_a3", a + (c2 << 1))
        b = register(f"{name}_b3", knights + (near2 << 1))
        # Cycle 4.
        a, b = register(f"{name}_a4", a), register(f"{name}_b4", b + (rest << 1))
        # Cycle 5.
        mean, step = register(f"{name}_mean", a + b), register(f"{name}_step", a - b)
        return self._stepped(m, name, self._late(m, mean), self._late(m, step), minus)

    def _at_chroma(self, m, name, sums):
        """The own chroma, green, the other chroma."""
        register, minus = partial(pipeline.register, m), self._direction.o.minus
        c, h, v, p, q = (sums[key] for key in "cHVPQ")
        # Cycle 2.
        near, across = register(f"{name}_near", h + v), register(f"{name}_hv", h - v)
        far, bend = register(f"{name}_far", p + q), register(f"{name}_qp", q - p)
        diagonal, c2 = self._fours(m, name, sums, ("D",))["D"], register(f"{name}_c2", c)
        # Cycle 3.
        t = register(f"{name}_t", (c2 << 2) - far)
        thrice = register(f"{name}_hv3", (across << 1) + across)
        bend, near = register(f"{name}_qp3", bend), register(f"{name}_near3", near)
        diagonal = register(f"{name}_D3", diagonal)
        # Cycle 4.
        half_more = register(f"{name}_t15", t + (t >> 1))
        step = register(f"{name}_e", thrice - bend)
        other = register(f"{name}_other", (diagonal << 1) + t)
        near = register(f"{name}_near4", near)
        # Cycle 5.
        green = register(f"{name}_green", (near << 2) + half_more)
        step, other = register(f"{name}_e5", step), register(f"{name}_other5", other)
        green, step, other = (self._late(m, value) for value in (green, step, other))
        # A grey sample has no step and its own value in green.
        grey = delay(m, c, 7, f"{name}_grey") << 4
        return (self._own(m, name, c),
                self._stepped(m, f"{name}_g", Mux(self.mono, grey, green), step, minus),
                self._stepped(m, f"{name}_x", other, step, minus) << 1)

    @staticmethod
    def _late(m, value):
        """A ``value`` of cycle 5 in cycle 8, when the direction is known."""
        return delay(m, value, Direction.latency - 5, f"{value.name}_late")

    def _own(self, m, name, c):
        """The own colour of a point with the sample ``c`` of cycle 1."""
        return delay(m, c, self.latency - 1, f"{name}_own") << 4

    def _stepped(self, m, name, value, step, minus):
        """``value`` + s ``step``, both of cycle 8; ``minus``: the sign of s."""
        register, direction = partial(pipeline.register, m), self._direction.o
        # Cycle 9: s times the step but for the carry of its sign.
        chosen = Mux(direction.whole, step, Mux(direction.half, step >> 1, 0))
        value = register(f"{name}_v", value)
        inverted = register(f"{name}_i", chosen ^ minus.replicate(len(chosen)),
                            signed(len(chosen)))
        carry = register(f"{name}_n", minus)
        # Cycle 10.
        total = (Cat(1, value).as_signed() + Cat(carry, inverted).as_signed()) >> 1
        return register(f"{name}_o", total, signed(_POINTS.elem_shape.width))
