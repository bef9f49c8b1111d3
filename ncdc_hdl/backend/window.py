"""From a back-map coordinate to the raw window of the pixel."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.layouts import request_layout
from ncdc_hdl.frontend.layouts import SIZE, coordinate_layout
from ncdc_hdl.lib.groups import lanes_of
from ncdc_spec.interpolation import FAST

__all__ = ["WindowAddress"]


class WindowAddress(wiring.Component):
    """The sample of a pixel's first point, and the position relative to it, per axis::

        x0, fx = floor(x' - offset), x' - offset - x0       offset 0.5 (fast), 0 (gradient)
        blank  = the input's, or x0 outside -1 .. width - core + 1      core 3 (fast), 2 (gradient)

    An x0 of -1 or width - core + 1 is moved to the nearest point inside, see
    ``ncdc_model.golden.picture.window_address``, to which this is equal bit for bit. For windows
    with a margin it also gives the parts outside the frame.
    Timing: three stream stages (subtract, compare, choose), latency 3, one group per clock.

    Parameters
    ----------
    formats : ncdc_spec.descriptor.Formats
        ``coordinate`` is used.
    lanes : int
        Pixels of a group.
    interpolation : Interpolation

    Members
    -------
    width, height : ``In``
        Distorted image in pixels, constant during a frame.
    i : ``In(stream.Signature(coordinate_layout(formats, lanes)))``
    o : ``Out(stream.Signature(request_layout(formats.coordinate.f_bits, lanes, ...)))``
    """

    latency = 3

    def __init__(self, formats, lanes=1, interpolation=FAST):
        self.q, self.interpolation = formats.coordinate, interpolation
        super().__init__({
            "width": In(SIZE), "height": In(SIZE),
            "i": In(stream.Signature(coordinate_layout(formats, lanes))),
            "o": Out(stream.Signature(request_layout(self.q.f_bits, lanes, interpolation))),
        })

    def elaborate(self, platform):
        m = Module()
        core = self.interpolation.core
        # Per axis, the last x0 or y0 inside the image and the one after it.
        limits = []
        for axis, size in (("x", self.width), ("y", self.height)):
            last_inside = Signal(signed(self.q.i_bits + 1), name=f"inside_{axis}")
            beyond = Signal(signed(self.q.i_bits + 1), name=f"beyond_{axis}")
            m.d.sync += [last_inside.eq(size - core), beyond.eq(size - (core - 1))]
            limits.append((last_inside, beyond))
        # The stages move together: a `ready` path through all of them would be the longest
        # path of the core.
        move = Signal()
        # Synthesis does not merge a flag with its complement: `ready` is `move`, but does not begin
        # where all stages are moved.
        o_empty = Signal(init=1)        # complement of `o.valid`
        m.d.comb += [move.eq(~self.o.valid | self.o.ready),
                     self.i.ready.eq(o_empty | self.o.ready)]
        with m.If(move):
            valid, flags = self.i.valid, Cat(self.i.p.first, self.i.p.last)
            for name in ("shifted", "compared"):
                own_valid, own_flags = Signal(name=f"{name}_valid"), Signal(2, name=f"{name}_flags")
                m.d.sync += [own_valid.eq(valid), own_flags.eq(flags)]
                valid, flags = own_valid, own_flags
            m.d.sync += [self.o.valid.eq(valid), o_empty.eq(~valid),
                         Cat(self.o.p.first, self.o.p.last).eq(flags)]
            for k, (i, o) in enumerate(zip(lanes_of(self.i.p), lanes_of(self.o.p))):
                self._address(m, k, i, o, limits)
        return m

    def _address(self, m, k, i, o, limits):
        """The window ``o`` of the coordinate ``i`` in lane ``k``."""
        offset = int(self.interpolation.offset * (1 << self.q.f_bits))
        blank = Signal(name=f"blank{k}")        # the input's, with the shifted coordinates
        inside = []                             # conditions for an origin near enough to the image
        m.d.sync += blank.eq(i.blank)
        for axis, coordinate, (last, beyond), origin, fraction in (
                ("x", i.x, limits[0], o.x0, o.fx), ("y", i.y, limits[1], o.y0, o.fy)):
            shape = signed(self.q.width + 1)
            shifted = Signal(shape, name=f"shifted_{axis}{k}")  # the coordinate less the offset
            held = Signal(shape, name=f"held_{axis}{k}")        # the same, a stage later
            before = Signal(name=f"before_{axis}{k}")           # its whole part is -1
            at_end = Signal(name=f"at_end_{axis}{k}")           # its whole part is `beyond`
            whole = shifted >> self.q.f_bits
            # Stage 1: subtract.
            m.d.sync += shifted.eq(coordinate - offset)
            # Stage 2: compare.
            m.d.sync += [held.eq(shifted), before.eq(whole == -1), at_end.eq(whole == beyond)]
            # Stage 3: choose; an origin just outside is moved to the nearest point inside.
            m.d.sync += [origin.eq(held >> self.q.f_bits), fraction.eq(held)]
            with m.If(before):
                m.d.sync += [origin.eq(0), fraction.eq(0)]
            with m.Elif(at_end):
                m.d.sync += [origin.eq(last), fraction.eq(-1)]
            inside += [whole >= -1, whole <= beyond]
            if self.interpolation.margin:
                self._edge(m, whole, last, getattr(o, f"edge_{axis}"), f"{axis}{k}")
        passed = Signal(name=f"passed{k}")                  # the input's `blank`, a stage later
        within = Signal(len(inside), name=f"within{k}")     # `inside`, a stage later
        m.d.sync += [passed.eq(blank), within.eq(Cat(inside))]
        m.d.sync += o.blank.eq(passed | ~within.all())

    def _edge(self, m, whole, last, edge, name):
        """Part of a window outside the image; ``whole`` is its first point before it is moved."""
        margin = self.interpolation.margin
        near = Signal(margin, name=f"near_{name}")      # bit n: n + 1 are missing at the beginning
        far = Signal(margin, name=f"far_{name}")        # bit n: n + 1 are missing at the end
        for n in range(margin):
            inward = margin - 1 - n
            at_start, at_end = whole == inward, whole == last - inward
            if inward == 0:
                at_start, at_end = at_start | (whole == -1), at_end | (whole == last + 1)
            m.d.sync += [near[n].eq(at_start), far[n].eq(at_end)]
        m.d.sync += edge.after.eq(far.any())
        m.d.sync += edge.missing.eq(sum(Mux(near[n] | far[n], n + 1, 0) for n in range(margin)))
