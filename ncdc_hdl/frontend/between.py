"""From nodes to coordinates: the block after the network at nodes."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.frontend.node_network import node_layout
from ncdc_hdl.frontend.segments import Segments
from ncdc_hdl.lib.fixed import saturate
from ncdc_hdl.lib.pipeline import delay, register

__all__ = ["NodesToCoordinates"]

_HALVES = 2             # clocks from the low half of a sum to the high one
_SUM_LATENCY = 2 + _HALVES      # latency of a sum: addend, low half, high half


class NodesToCoordinates(wiring.Component):
    """Coordinates of the pixels between nodes, by adding second differences, ``lanes`` at a time.

    4 S^2 times the coordinate is a whole number. From pixel to pixel it grows by ``slope``, which
    itself grows by twice the ``bend`` of :func:`segment_layout`. It is exact and rounded once.
    Equal bit for bit to ``ncdc_model.golden.network.coordinates``.

    Timing: one group per clock, ``latency`` clocks from ``advance`` to ``o``; free-running. What
    ``begins`` a segment needs one from :class:`Segments`: ``ready`` is high if it will be there.

    Parameters
    ----------
    axes, coarse, nodes : as for :class:`Segments`
    lanes : int
        Pixels of a group.

    Members
    -------
    i : ``In(stream.Signature(node_layout(axes)))``
    flush : ``In(1)``
        Nodes and segments are dropped.
    ready : ``Out(1)``
        A group that begins a segment may advance in the next clock.
    advance : ``In(1)``
        The next group's coordinates are computed.
    begins : ``In(1)``
        Only with ``advance``: it is the first group after a node.
    o : ``Out(ArrayLayout({name: format}, lanes))``
        Of each axis in ``coarse``.
    fits : ``Out(1)``
        All four nodes around the group of ``o`` fit (only with a view).
    """

    def __init__(self, axes, coarse, nodes, lanes=1):
        self.coarse, self.nodes, self.lanes = coarse, nodes, lanes
        self.segments = Segments(axes, coarse, nodes)
        self.scale = 2 + 2 * exact_log2(nodes)          # 4 S^2 as a shift
        fits = {"fits": Out(1)} if "column" in axes else {}
        super().__init__({
            "i": In(stream.Signature(node_layout(axes))), "flush": In(1),
            "ready": Out(1), "advance": In(1), "begins": In(1),
            "o": Out(data.ArrayLayout(data.StructLayout(
                {name: signed(q.width) for name, q in coarse.items()}), lanes)),
        } | fits)

    @property
    def latency(self):
        """Clocks from ``advance`` to the coordinates: slope, its increment per group in two (4
        lanes) or one (2 lanes), value, the lanes' values if several, rounding."""
        several = self.lanes > 1
        return _SUM_LATENCY + exact_log2(self.lanes) + _SUM_LATENCY + several + 1

    def elaborate(self, platform):
        m = Module()
        m.submodules.segments = segments = self.segments
        wiring.connect(m, wiring.flipped(self.i), segments.i)
        m.d.comb += [
            segments.flush.eq(self.flush), segments.o.ready.eq(self.begins),
            self.ready.eq(segments.o.valid & ~self.begins),
        ]
        valid = delay(m, self.advance, _SUM_LATENCY, "slope_valid", reset_less=False)
        anew = delay(m, self.begins, _SUM_LATENCY, "slope_anew")
        for name, fine in segments.axes.items():
            self._axis(m, name, fine, valid, anew)
        if "fits" in self.signature.members:
            fits = Signal()                             # of the group that advances
            begun = register(m, "begun_fits", fits)
            m.d.comb += [fits.eq(Mux(self.begins, segments.o.p.fits, begun)),
                         self.fits.eq(delay(m, fits, self.latency, "fits"))]
        return m

    @staticmethod
    def _sum(m, name, shape, enable, begins, start, step):
        """A sum that grows by ``step`` with each ``enable``, and is ``start`` with those that
        ``begins``, ``_SUM_LATENCY`` clocks later.

        Its high half is added two clocks after the low one, so that no carry runs through both,
        and has a clock for routing. A sum that begins anew is cleared before,
        which needs no multiplexer after the adder; the output is therefore a register of its own.
        """
        width = Shape.cast(shape).width
        cut = width // 2

        def signal(what, shape):
            return Signal(shape, name=f"{name}_{what}", reset_less=True)

        wide_start, wide_step = Signal(shape), Signal(shape)
        m.d.comb += [wide_start.eq(start), wide_step.eq(step)]
        addend = register(m, f"{name}_addend", Mux(begins, wide_start, wide_step), shape)
        low_enable = register(m, f"{name}_low_enable", enable, reset_less=False)
        # Low half.
        low = signal("low", cut)                # the sum
        seen = signal("seen", cut + 1)          # its output, and the carry
        total = Signal(cut + 1, name=f"{name}_low_total")
        m.d.comb += total.eq(low + addend[:cut])
        with m.If(low_enable):
            m.d.sync += [low.eq(total), seen.eq(total)]
        with m.If(begins):
            m.d.sync += low.eq(0)
        # High half. The carry enters the chain as the sum of one bit more below.
        late = delay(m, seen, 1, f"{name}_seen")
        high_addend = delay(m, addend[cut:].as_signed(), _HALVES, f"{name}_high_addend")
        high, o = signal("high", signed(width - cut)), signal("sum", signed(width))
        high_total = (Cat(Const(1, 1), high).as_signed()
                      + Cat(late[-1], high_addend).as_signed()) >> 1
        with m.If(delay(m, low_enable, _HALVES, f"{name}_high_enable", reset_less=False)):
            m.d.sync += [high.eq(high_total), o.eq(Cat(late[:-1], high_total[:width - cut]))]
        with m.If(delay(m, begins, _HALVES, f"{name}_high_begins")):
            m.d.sync += high.eq(0)
        return o

    def _axis(self, m, name, fine, valid, anew):
        coarse = self.coarse[name]
        drop = self.scale + fine.f_bits - coarse.f_bits
        # Between nodes the value may exceed them by a quarter of their difference.
        shape = signed(fine.width + 1 + self.scale)
        segment, lanes = self.segments.o.p[name], self.lanes

        def later(what, value, clocks=1):
            return delay(m, value, clocks, f"{name}_{what}")

        bend = Signal.like(segment.bend, name=f"{name}_bend", reset_less=True)
        base = Signal.like(segment.base, name=f"{name}_base", reset_less=True)
        with m.If(self.begins):
            m.d.sync += [bend.eq(segment.bend), base.eq(segment.base)]
        # Slope: that of the group's first pixel.
        slope = self._sum(m, f"{name}_slope", segment.slope.shape(), self.advance, self.begins,
                          segment.slope, bend << exact_log2(2 * lanes))
        early = later("early_bend", bend, _SUM_LATENCY - 2)
        bend, base = later("late_bend", early), later("late_base", base, _SUM_LATENCY - 1)
        # Parts: differences of the lanes' values to the first one's, and the next group's.
        if lanes == 1:
            parts, growth, clocks = [], slope, 0
        elif lanes == 2:
            parts, clocks = [later("part1", slope)], 1
            growth = later("growth", slope + bend) << 1
        else:
            # Three times a number would be made of multiplier blocks.
            bends = bend, bend << 1, later("bend3", early + (early << 1))
            one, two, three = (later(f"sum{k}", slope + part) for k, part in enumerate(bends, 1))
            parts = [later("part1", slope, 2), later("part2", one << 1),
                     later("part3", two + (two << 1))]
            growth, clocks = later("growth", three << 2), 2
        # Value: 4 S^2 times that of the group's first pixel.
        step = Signal.like(growth, name=f"{name}_step", reset_less=True)
        begins, start = later("anew", anew, clocks), later("start", base, clocks)
        enable = delay(m, valid, clocks, f"{name}_valid", reset_less=False)
        with m.If(enable):
            m.d.sync += step.eq(growth)
        value = self._sum(m, f"{name}_value", shape, enable, begins, start << self.scale,
                          step)
        values = [value]
        if lanes > 1:
            # Lanes: each one's value, when it is there.
            parts = [later(f"ready{k}", part, _SUM_LATENCY - 1) for k, part in enumerate(parts, 1)]
            values = [later("lane0", value)] + [
                register(m, f"{name}_lane{k}", value + later(f"late{k}", part), shape)
                for k, part in enumerate(parts, 1)]
        # Rounding: the half is part of the nodes' values.
        for k, total in enumerate(values):
            m.d.comb += self.o[k][name].eq(register(
                m, f"{name}_o{k}", saturate((total >> drop), coarse), signed(coarse.width)))
