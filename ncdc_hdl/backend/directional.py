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
            "Kh0": ((-1, -2), (-1, 2)), "Kh1": ((1, -2), (1, 2))}


class Direction(wiring.Component):
    """The direction in which colour differences vary less, of a 6x6 raw window.

    Equal to ``ncdc_model.golden.directional.twice_direction``, whose docstring has the equations.
    Timing: free-running, ``latency`` clocks.

    Members
    -------
    samples : ``In(ArrayLayout(8, 32))``
        Those of ``DIRECTIONAL.samples``.
    o : ``Out(StructLayout({"whole": 1, "half": 1, "minus": 1}))``
        The factor s: 1, or a half, or 0 if neither is set; negative with ``minus``.
    bend : ``Out(BEND)``
        Sums of the middle second differences, along the rows and along the columns, after
        ``bend_latency`` clocks: those of the crest.
    """

    latency = 7
    bend_latency = 3
    _DROPPED = 2        # lowest bits of each sample that are ignored
    _BIAS = 8

    def __init__(self):
        super().__init__({"samples": In(_SAMPLES), "o": Out(_STEP), "bend": Out(BEND)})

    def elaborate(self, platform):
        m = Module()
        at = {position: sample[self._DROPPED:]
              for position, sample in zip(DIRECTIONAL.samples, self.samples)}
        turned = {(i, j): sample for (j, i), sample in at.items()}
        (h, bend_x), (v, bend_y) = self._variation(m, "h", at), self._variation(m, "v", turned)
        m.d.comb += [self.bend.x.eq(bend_x), self.bend.y.eq(bend_y)]
        along, down = self._flags(m, "h", h, v), self._flags(m, "v", v, h)
        m.d.comb += [self.o.whole.eq(along[0] | down[0]), self.o.half.eq(along[1] | down[1]),
                     self.o.minus.eq(down[0] | down[1])]
        return m

    @staticmethod
    def _variation(m, name, at):
        """Sum of the second differences along the rows of ``at``, 5 clocks later, and that of the
        middle ones of rows 2 and 3, 3 clocks later."""
        register = partial(pipeline.register, m)
        pairs, differences = {}, {}
        for j, i in ((2, 0), (2, 1), (2, 2), (3, 0), (3, 1), (3, 2), (1, 1), (4, 1)):
            # Cycle 1: add samples in pairs. Cycle 2: subtract.
            for a, b in ((i, i + 3), (i + 1, i + 2)):
                if (j, a, b) not in pairs:
                    pairs[j, a, b] = register(f"{name}_p{j}{a}{b}", at[j, a] + at[j, b])
            differences[j, i] = register(f"{name}_d{j}{i}",
                                         pairs[j, i, i + 3] - pairs[j, i + 1, i + 2])
        # Cycles 3 to 5: magnitudes, added two by two. A negative d has -d - 1, its bits inverted.
        terms = [(d ^ d[-1].replicate(len(d)))[:-1] for d in differences.values()]
        for level in range(3):
            terms = [register(f"{name}_s{level}{k}", terms[k] + terms[k + 1])
                     for k in range(0, len(terms), 2)]
        return terms[0], register(f"{name}_bend", differences[2, 1] + differences[3, 1])

    def _flags(self, m, name, less, more):
        """Whether s is 1, and whether it is 1/2, for the sum ``less``; 2 clocks later."""
        register = partial(pipeline.register, m)
        # Cycle 6.
        twice = register(f"{name}_twice", less + self._BIAS // 2) << 1
        fourfold = register(f"{name}_fourfold", less + self._BIAS // 4) << 2
        once = register(f"{name}_once", more)
        thrice = register(f"{name}_thrice", (more << 1) + more)
        # Cycle 7.
        whole = register(f"{name}_whole", twice <= once)
        some = register(f"{name}_some", fourfold <= thrice)
        return whole, some & ~whole


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

    latency = 4

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
            bend = register(f"bend_{axis}", bend)
            # Cycle 2: n is 0, 1, 2, 2, 3, 3, 4, 4, as a sum of two.
            n = Mux(eighth.any(), eighth[1:] + 1, 0)
            once = Mux(n[0], bend, Mux(n[2], bend << 1, 0))
            twice = Mux(n[1] | n[2], bend << 1, 0)
            products.append(register(f"product_{axis}", once + twice))
        # Cycle 3: add. Cycle 4: strength and the half.
        total = register("total", sum(products))
        scaled = Mux(self.strength[1], total << 1, Mux(self.strength[0], total, 0))
        m.d.sync += self.o.eq(32 - scaled)
        return m


class DirectionalPoints(WindowDecoder):
    """The colours of four neighbouring samples by the kernels of
    ``ncdc_model.golden.directional``, whose docstring has the equations.

    Nothing is rounded or clamped. So that each kernel has one position, the samples of a row are
    put out green first; ``reversed`` says where that is not their order from left to right. The
    chroma of the upper row comes first among the colours; it is blue if ``swapped``. Otherwise
    equal bit for bit to ``ncdc_model.golden.directional.directional_colours``.

    Of a grey sensor (``mono``) green is that of ``ncdc_model.golden.picture.grey_corners``, and the
    other two colours say nothing.

    Timing: free-running, ``latency`` clocks.

    Members
    -------
    samples : ``In(ArrayLayout(8, 32))``
        Those of ``DIRECTIONAL.samples``.
    red_column, red_row : ``In(1)``
        Whether the first sample is in a column, a row, that holds red samples.
    mono : ``In(1)``
        Whether the sensor is grey; constant during a frame.
    o : ``Out(ArrayLayout(signed(15), 12))``
        Row by row, in each the green sample, then the chroma sample; of each the chroma of the
        upper row, green, the chroma of the lower row.
    reversed : ``Out(2)``
        For each row, whether its chroma sample is left of the green one.
    swapped : ``Out(1)``
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
        m.d.comb += [self._direction.samples.eq(self.samples),
                     self.bend.eq(self._direction.bend)]
        return m

    @staticmethod
    def _fours(m, name, sums, keys):
        """Sums of two pairs each, one clock after those."""
        return sums | {key: pipeline.register(m, f"{name}_{key}", sums[f"{key}0"] + sums[f"{key}1"])
                       for key in keys}

    def _at_green(self, m, name, sums):
        """Chroma of the same row, green, chroma of the other row."""
        direction = self._direction.o
        sums = self._fours(m, name, sums, ("D", "Kv", "Kh"))
        own = self._own(m, name, sums["c"])
        same = self._at_green_along(m, f"{name}_h", sums, "H", "Q", "Kv", direction,
                                    direction.minus)
        other = self._at_green_along(m, f"{name}_v", sums, "V", "P", "Kh", direction,
                                     ~direction.minus)
        return same, self._later(m, name, own), other

    def _at_green_along(self, m, name, sums, near, far, knights, direction, minus):
        """a + b + s (a - b) with the sums named."""
        register = partial(pipeline.register, m)
        c, near, far = (sums[key] for key in ("c", near, far))
        # Cycle 4.
        a = register(f"{name}_a0", (near << 2) - far)
        b = register(f"{name}_b0", (c << 2) + near)
        twice_c = register(f"{name}_c2", c << 1)
        # Cycle 5.
        a = register(f"{name}_a1", a + twice_c)
        rest = register(f"{name}_k", sums[knights] - (sums["D"] << 1))
        b = register(f"{name}_b1", b << 1)
        # Cycle 6.
        a, b = register(f"{name}_a2", a), register(f"{name}_b2", b + rest)
        # Cycle 7.
        mean, step = register(f"{name}_mean", a + b), register(f"{name}_step", a - b)
        return self._stepped(m, name, mean, step, direction, minus)

    def _at_chroma(self, m, name, sums):
        """The own chroma, green, the other chroma."""
        direction = self._direction.o
        sums = self._fours(m, name, sums, ("D",))
        register = partial(pipeline.register, m)
        c, h, v, p, q = (sums[key] for key in "cHVPQ")
        # Cycle 4.
        near, across = register(f"{name}_near", h + v), register(f"{name}_hv", h - v)
        far, bend = register(f"{name}_far", p + q), register(f"{name}_qp", q - p)
        fourfold = register(f"{name}_c4", c << 2)
        # Cycle 5.
        t = register(f"{name}_t", fourfold - far)
        thrice = register(f"{name}_hv3", (across << 1) + across)
        bend, near = register(f"{name}_qp1", bend), register(f"{name}_near1", near)
        diagonal = register(f"{name}_D1", sums["D"])
        # Cycle 6.
        half_more = register(f"{name}_t15", t + (t >> 1))
        e = register(f"{name}_e", thrice - bend)
        other = register(f"{name}_other", (diagonal << 1) + t) << 1
        near = register(f"{name}_near2", near)
        # Cycle 7.
        green = register(f"{name}_green", (near << 2) + half_more)
        e, other = register(f"{name}_e1", e), register(f"{name}_other1", other)
        own = self._own(m, name, c)
        # A grey sample has no step and its own value in green.
        green = Mux(self.mono, own, green)
        e_here = Mux(self.mono, 0, e)
        return (self._later(m, name, own),
                self._stepped(m, f"{name}_g", green, e_here, direction, direction.minus),
                self._stepped(m, f"{name}_x", other, e, direction, direction.minus, 1))

    @staticmethod
    def _own(m, name, c):
        """16 c of cycle 7 for a sample of cycle 3."""
        return delay(m, c, 4, f"{name}_own") << 4

    @staticmethod
    def _later(m, name, own):
        """The own colour of cycle 7, in cycle 9."""
        return pipeline.register(m, f"{name}_own_o", delay(m, own[4:], 1, f"{name}_own8") << 4,
                                 _POINTS.elem_shape)

    @staticmethod
    def _stepped(m, name, value, step, direction, minus, shift=0):
        """``value`` + s ``step`` << ``shift``, both of cycle 7."""
        register = partial(pipeline.register, m)
        # Cycle 8: s times the step but for the carry of its sign.
        chosen = Mux(direction.whole, step, Mux(direction.half, step >> 1, 0))
        value = register(f"{name}_v", value)
        inverted = register(f"{name}_i", chosen ^ minus.replicate(len(chosen)),
                            signed(len(chosen)))
        carry = register(f"{name}_n", minus)
        # Cycle 9.
        return register(f"{name}_o", value + ((inverted + carry) << shift), _POINTS.elem_shape)
