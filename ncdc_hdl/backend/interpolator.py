"""From raw windows to corrected pixels."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.bayer import BayerQuads
from ncdc_hdl.backend.bilinear import Bilinear
from ncdc_hdl.backend.colour import COLOUR, SUMS, Colour, ColourSums
from ncdc_hdl.backend.directional import Crest, DirectionalPoints
from ncdc_hdl.backend.gradient import GradientPoints
from ncdc_hdl.backend.layouts import pixel_layout, window_layout
from ncdc_hdl.lib.credits import Credited, CreditQueue
from ncdc_hdl.lib.groups import lanes_of
from ncdc_hdl.lib.pipeline import DelayMemory, delay, register
from ncdc_spec.interpolation import DIRECTIONAL, FAST, GRADIENT

__all__ = ["Interpolator"]

_DECODERS = {FAST: BayerQuads, GRADIENT: GradientPoints, DIRECTIONAL: DirectionalPoints}
_QUEUED = 32    # fewest groups: a smaller queue takes as much memory

class Interpolator(wiring.Component):
    """Bayer decoder and bilinear interpolator of windows; blank pixels get the fill.

    The arithmetic runs free; a window is announced only if the output queue has space for its
    pixel. Timing: one group per clock; ``latency`` clocks from a window to its pixel in the queue.

    Parameters
    ----------
    f_bits : int
        Fraction bits of the position in the window.
    lanes : int
        Pixels of a group, each with a decoder and an interpolator of its own.
    interpolation : Interpolation
    colour : bool
        Whether there are white balance and tone after the interpolation, and sums of the colours.
    window_latency : int
        Clocks from ``i.issue`` to the window.

    Members
    -------
    phase, fill : ``In(2)``, ``In(24)``
        (column, row) parity of the red samples; colour of blank pixels, red in the top byte.
        Constant during a frame.
    mono : ``In(1)``
        Whether the sensor is grey: all three colours are its samples. Constant during a frame, and
        ``lanes`` clocks before it; not for the fast interpolation.
    crest : ``In(2)``
        Strength of the crest, 0 to 2; constant during a frame; for the directional interpolation
        only.
    colour, begin, sums : ``In(COLOUR)``, ``In(1)``, ``Out(SUMS)``
        Gains and tone curve, constant during a frame; for pixels with a source. Begins a frame,
        before its first window. Sums of its colours before the gains, for pixels with a source. All
        three only with ``colour``.
    i : ``In(Credited(window_layout(f_bits, lanes, interpolation)))``
    o : ``Out(stream.Signature(pixel_layout(lanes)))``
    """

    def __init__(self, f_bits, lanes=1, interpolation=FAST, colour=False, window_latency=0):
        self.f_bits, self.lanes, self.interpolation = f_bits, lanes, interpolation
        self.window_latency = window_latency
        self.decoders = [_DECODERS[interpolation]() for _ in range(lanes)]
        self.bilinears = [Bilinear(f_bits, interpolation, decoder.signature.members["o"].shape)
                          for decoder in self.decoders]
        self.colours = [Colour() for _ in range(lanes)] if colour else []
        super().__init__({
            "phase": In(2), "fill": In(24),
            "i": In(Credited(window_layout(f_bits, lanes, interpolation))),
            "o": Out(stream.Signature(pixel_layout(lanes))),
        } | ({} if interpolation == FAST else {"mono": In(1)})
            | ({"crest": In(2)} if interpolation == DIRECTIONAL else {})
            | ({"colour": In(COLOUR), "begin": In(1), "sums": Out(SUMS)} if colour else {}))

    @property
    def latency(self):
        """Clocks from a window to its pixel in the queue."""
        return (self.decoders[0].latency + self.bilinears[0].latency
                + sum(part.latency for part in self.colours[:1]))

    @property
    def queued(self):
        """Groups that the queue and the pipelines before it hold, from ``i.issue`` on."""
        return max(_QUEUED, CreditQueue.min_depth(self.window_latency + self.latency))

    def elaborate(self, platform):
        m = Module()
        m.submodules.queue = queue = CreditQueue(
            pixel_layout(self.lanes), depth=self.queued)
        m.d.comb += [
            self.i.space.eq(queue.space), queue.issue.eq(self.i.issue),
            queue.arrive.eq(delay(m, self.i.valid, self.latency, "valid", reset_less=False)),
            Cat(queue.i.first, queue.i.last).eq(
                delay(m, Cat(self.i.payload.first, self.i.payload.last), self.latency, "flags")),
        ]
        mono = None if self.interpolation == FAST else self.mono
        for k, (window, pixel, bayer, bilinear) in enumerate(zip(
                lanes_of(self.i.payload), lanes_of(queue.i), self.decoders, self.bilinears)):
            m.submodules[f"bayer{k}"] = bayer
            m.submodules[f"bilinear{k}"] = bilinear
            m.d.comb += [bayer.samples.eq(window.samples), bilinear.i.eq(bayer.o)]
            blank = delay(m, window.blank, self.latency, f"blank{k}")
            position = {"x": window.fx, "y": window.fy}
            colours = Cat(bilinear.o[2], bilinear.o[1], bilinear.o[0])
            if self.interpolation == FAST:
                m.d.comb += [bayer.red_column.eq(~(window.odd_column ^ self.phase[0])),
                             bayer.red_row.eq(~(window.odd_row ^ self.phase[1]))]
            else:
                # From lane to lane, so that none of these registers has to reach them all.
                mono = register(m, f"mono{k}", mono)
                m.d.comb += bayer.mono.eq(mono)
                # From the other end, the position is 1 - f.
                position = {axis: Mux(window.flipped[axis], (1 << self.f_bits) - f, f)
                            for axis, f in position.items()}
                # Chroma of the upper row is in odd columns: red, if red samples are.
                colours = Mux(self.phase[0], colours,
                              Cat(bilinear.o[0], bilinear.o[1], bilinear.o[2]))
                colours = Mux(self.mono, bilinear.o[1].replicate(3), colours)
            m.d.comb += [getattr(bilinear, f"f{axis}").eq(
                delay(m, f[:len(bilinear.fx)], bayer.latency, f"f{axis}{k}"))
                for axis, f in position.items()]
            if self.interpolation == DIRECTIONAL:
                self._crest(m, k, window)
            if self.colours:
                colours = self._coloured(m, k, colours)
            m.d.comb += Cat(pixel.b, pixel.g, pixel.r).eq(Mux(blank, self.fill, colours))
        if self.colours:
            self._sums(m)
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        return m

    def _crest(self, m, k, window):
        """The crest of lane ``k``, handed to the interpolation in its clock."""
        bayer, bilinear, crest = self.decoders[k], self.bilinears[k], Crest(self.f_bits)
        m.submodules[f"crest{k}"] = crest
        wait = bayer.latency + bilinear.crest_clock - bayer.bend_latency - crest.latency
        m.submodules[f"crest_delay{k}"] = late = DelayMemory(crest.o.shape(), wait)
        m.d.comb += [
            crest.bend.eq(bayer.bend), crest.strength.eq(self.crest),
            crest.fx.eq(delay(m, window.fx, bayer.bend_latency, f"crest_fx{k}")),
            crest.fy.eq(delay(m, window.fy, bayer.bend_latency, f"crest_fy{k}")),
            late.i.eq(crest.o), bilinear.crest.eq(late.o),
        ]

    def _coloured(self, m, k, colours):
        """The ``colours`` of lane ``k`` after gain and tone: blue, green, red."""
        m.submodules[f"colour{k}"] = colour = self.colours[k]
        m.d.comb += [colour.colour.eq(self.colour),
                     Cat(colour.i[2], colour.i[1], colour.i[0]).eq(colours)]
        return Cat(colour.o[2], colour.o[1], colour.o[0])

    def _sums(self, m):
        """Sum up the inputs of the gains, for pixels with a source."""
        m.submodules.sums = sums = ColourSums(self.lanes)
        interpolated = self.latency - self.colours[0].latency
        seen = Cat(self.i.valid & ~window.blank for window in lanes_of(self.i.payload))
        m.d.comb += [sums.begin.eq(self.begin), self.sums.eq(sums.sums),
                     sums.counts.eq(delay(m, seen, interpolated, "seen", reset_less=False)),
                     *(sums.i[k].eq(colour.i) for k, colour in enumerate(self.colours))]
