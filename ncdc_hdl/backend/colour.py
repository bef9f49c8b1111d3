"""White balance and tone of a pixel, and the sums of a frame's colours."""

from functools import partial

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib import pipeline
from ncdc_hdl.lib.choice import chosen
from ncdc_hdl.lib.gains import GAINED_LATENCY, gained
from ncdc_hdl.lib.pipeline import delay
from ncdc_spec.tone import LINEAR, NODE_BITS, NODE_POSITIONS
from ncdc_spec.white_balance import GAIN_BITS, UNITY

__all__ = ["COLOUR", "COLOURS", "Colour", "ColourSums", "SUMS"]

COLOURS = data.ArrayLayout(8, 3)
"""A pixel: red, green, blue."""

COLOUR = data.StructLayout({"gains": data.ArrayLayout(GAIN_BITS, 3),
                            "tone": data.ArrayLayout(NODE_BITS, len(NODE_POSITIONS))})
"""Gains of the colours, and nodes of the tone curve, see :mod:`ncdc_model.golden.colour`."""

SUMS = data.StructLayout({name: 32 for name in ("red", "green", "blue", "pixels")})
"""Sums of a frame's colours, and the number of their pixels."""

_POSITION_BITS = 6         # bits of a position in the longest piece of the curve


class Colour(wiring.Component):
    """Gain and tone of the three colours of a pixel::

        v = min(255, (gain_c i_c + 128) >> 8)
        o_c = min(255, (64 left + f (right - left) + 32) >> 6)

    left and right are the nodes of the piece that holds v, f the position of v in it in 64ths. Two
    pieces make an octave. The highest one of v and the bit below it select the piece, f is
    the bits below these two, moved to the top. Equal bit for bit to
    :func:`ncdc_model.golden.colour.coloured`. Timing: free-running, ``latency`` clocks. One
    register is before each product and two after it. Two multipliers a colour.

    Members
    -------
    colour : ``In(COLOUR)``
        Constant during a frame. Its reset value changes no pixel.
    i, o : ``In(COLOURS)``, ``Out(COLOURS)``
    """

    latency = 1 + GAINED_LATENCY + 6
    """Clocks from a pixel to its result: a register, gain, piece 1, nodes 2, rise 2, sum 1."""

    def __init__(self):
        super().__init__({
            "colour": In(COLOUR, init={"gains": [UNITY] * 3, "tone": LINEAR}),
            "i": In(COLOURS), "o": Out(COLOURS)})

    def elaborate(self, platform):
        m = Module()
        for c in range(3):
            balanced = self._gain(m, c)
            m.d.sync += self.o[c].eq(self._tone(m, c, balanced))
        return m

    def _gain(self, m, c):
        """The colour ``c`` after its gain, 4 clocks later."""
        # Cycle 1: the register before the multiplier. Cycles 2 to 4: multiply, round and clamp.
        value = pipeline.register(m, f"value{c}", self.i[c])
        return gained(m, f"balanced{c}", value, self.colour.gains[c], 255)

    def _tone(self, m, c, value):
        """The colour ``c`` of ``value`` after the tone curve, 5 clocks later."""
        register = partial(pipeline.register, m)
        # Cycle 5: the piece, and the position in it in 64ths.
        piece, position = Cat(value[:2], Const(0, 2)), Const(0, _POSITION_BITS)   # length 1 below 4
        for top in range(2, 8):
            below = _POSITION_BITS + 1 - top           # zeros below the position's own bits
            piece = Mux(value[top], Cat(value[top - 1], Const(top, 3)), piece)
            position = Mux(value[top], Cat(Const(0, below), value[:top - 1]), position)
        piece = register(f"piece{c}", piece)
        position = register(f"position{c}", position)
        # Cycle 6: both nodes of the piece.
        left, right = self._nodes(piece)
        left, right = register(f"left{c}", left), register(f"right{c}", right)
        # Cycle 7: their difference, the register before the multiplier.
        difference = register(f"difference{c}", right - left)
        # Cycles 8 and 9: the rise from the left node.
        rise = register(f"rise_p1_{c}", register(
            f"rise_p0_{c}", difference * delay(m, position, 2, f"position{c}")))
        left = delay(m, left, 3, f"left{c}")
        # Cycle 10: the byte. Between two nodes no sum is negative.
        half = Const(1 << _POSITION_BITS - 1, _POSITION_BITS)
        total = Signal(_POSITION_BITS + NODE_BITS, name=f"tone_total{c}")
        m.d.comb += total.eq(Cat(half, left) + rise)
        return Mux(total[-1], 255, total[_POSITION_BITS:-1])


    def _nodes(self, piece):
        """The nodes left and right of ``piece``.

        The left node of an odd piece is the right one of the even piece before it: three choices
        of 8 nodes instead of two of 16.
        """
        nodes = [self.colour.tone[k] for k in range(len(NODE_POSITIONS))]
        odd, octave = piece[0], piece[1:]
        first, middle, last = (chosen(ones, octave)
                               for ones in (nodes[:-1:2], nodes[1::2], nodes[2::2]))
        return Mux(odd, middle, first), Mux(odd, last, middle)


class ColourSums(wiring.Component):
    """Sums of the colours of a frame's pixels, and their number.

    A sum is at most 4096 x 4096 x 255, which its 32 bits hold. Timing: a group per clock. The
    sums contain it after ``latency`` clocks; ``begin`` clears them in the next clock but one.

    Parameters
    ----------
    lanes : int
        Pixels of a group.

    Members
    -------
    begin : ``In(1)``
        Begins a frame, in a clock before its first pixel and after the last one's last.
    counts : ``In(lanes)``
        Whether each pixel of the group is to be counted.
    i : ``In(ArrayLayout(COLOURS, lanes))``
    sums : ``Out(SUMS)``
    """

    latency = 3

    def __init__(self, lanes):
        self.lanes = lanes
        super().__init__({"begin": In(1), "counts": In(lanes),
                          "i": In(data.ArrayLayout(COLOURS, lanes)), "sums": Out(SUMS)})

    def elaborate(self, platform):
        m = Module()
        register = partial(pipeline.register, m, reset_less=False)
        anew = register("anew", self.begin)
        counted = [[Mux(counts, pixel[c], 0) for c in range(3)]
                   for counts, pixel in zip(self.counts, (self.i[k] for k in range(self.lanes)))]
        for c, name in enumerate(("red", "green", "blue", "pixels")):
            terms = [pixel[c] for pixel in counted] if c < 3 else list(self.counts)
            # Cycle 1: select. Cycle 2: added up over the group. Cycle 3: over the frame.
            terms = [register(f"{name}_term{k}", term) for k, term in enumerate(terms)]
            group = register(f"{name}_group", sum(terms[1:], start=terms[0]))
            m.d.sync += self.sums[name].eq(Mux(anew, 0, self.sums[name] + group))
        return m
