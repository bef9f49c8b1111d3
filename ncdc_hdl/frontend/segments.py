"""Computes the start of each segment between two nodes of a row."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.frontend.node_network import node_layout

__all__ = ["Segments", "segment_layout"]

def segment_layout(axes, nodes):
    """Start value and increments of a segment between two nodes, for each axis.

    ``base`` is the value at its first pixel in the nodes' format. 4 S^2 times the value
    grows by ``slope`` to the next pixel, and the growth itself by twice ``bend`` per pixel. With a
    view ``fits`` is high if it is at all four nodes.
    """
    return data.StructLayout({name: data.StructLayout({
        "base": signed(fine.width + 1), "bend": signed(fine.width + 2),
        "slope": signed(fine.width + 4 + exact_log2(nodes))}) for name, fine in axes.items()}
        | ({"fits": 1} if "column" in axes else {}))


class Segments(wiring.Component):
    """Starts of the segments of a frame, on raw integers of four nodes P0 to P3 in a row::

        bend  = (P3 - P2) - (P1 - P0)
        slope = 4 S (P2 - P1) - (S - 1) bend
        base  = P1 + half        half of a coordinate's last bit, for the rounding to come

    All exact. Timing: stream stages; a segment every other clock; the first three nodes of a row
    one per clock, ``latency`` clocks from a segment's last node. Up to four segments at a time are
    processed, so that the four nodes of a row's first one arrive while those before are still in
    use.

    Parameters
    ----------
    axes : dict
        Format of each axis at the nodes, by its name.
    coarse : dict
        Format of its values between them.
    nodes : int
        Distance S of the nodes.

    Members
    -------
    i : ``In(stream.Signature(node_layout(axes)))``
    flush : ``In(1)``
        All nodes and segments are dropped.
    o : ``Out(stream.Signature(segment_layout(...)))``
    """

    latency = 4
    """Clocks from the last node to its segment: difference, bend, slope in two."""

    def __init__(self, axes, coarse, nodes):
        self.axes, self.coarse, self.nodes = axes, coarse, nodes
        super().__init__({
            "i": In(stream.Signature(node_layout(axes))), "flush": In(1),
            "o": Out(stream.Signature(segment_layout(axes, nodes))),
        })

    def elaborate(self, platform):
        m = Module()
        valid = [Signal(name=f"{name}_valid") for name in ("around", "bent", "sloped")]
        valid.append(self.o.valid)
        # A stage loads from the one before it only when it is empty: no chain of conditions runs
        # through all of them. The last one also loads while its segment is taken.
        takes = [~own for own in valid[:-1]] + [~self.o.valid | self.o.ready]
        m.d.comb += self.i.ready.eq(takes[0] | self.flush)
        with m.If(takes[0]):
            m.d.sync += valid[0].eq(self.i.valid & self.i.p.whole)
        for before, own, take in zip(valid, valid[1:], takes[1:]):
            with m.If(take):
                m.d.sync += own.eq(before)
                with m.If(before):
                    m.d.sync += before.eq(0)
        with m.If(self.flush):
            m.d.sync += [own.eq(0) for own in valid]
        for name, fine in self.axes.items():
            self._axis(m, name, fine, takes)
        if "fits" in self.o.p.shape().members:
            self._fits(m, takes)
        return m

    def _fits(self, m, takes):
        """Whether the four nodes around a segment fit, through the same stages."""
        before = Signal(3, reset_less=True)             # the nodes before the one that comes
        around, bent, sloped = (Signal(name=f"{name}_fits", reset_less=True)
                                for name in ("around", "bent", "sloped"))
        with m.If(takes[0] & self.i.valid):
            m.d.sync += [before.eq(Cat(before[1:], self.i.p.fits)),
                         around.eq(before.all() & self.i.p.fits)]
        for take, own, value in zip(takes[1:], (bent, sloped, self.o.p.fits),
                                    (around, bent, sloped)):
            with m.If(take):
                m.d.sync += own.eq(value)

    def _axis(self, m, name, fine, takes):
        bits, shift = fine.width, exact_log2(self.nodes)
        half = 1 << (fine.f_bits - self.coarse[name].f_bits - 1)
        node, o = self.i.p[name], self.o.p[name]

        def signal(what, width):
            return Signal(signed(width), name=f"{name}_{what}", reset_less=True)

        p = [signal(f"p{k}", bits) for k in (1, 2, 3)]
        steps = [signal(f"step{k}", bits + 1) for k in range(3)]    # P1 - P0, P2 - P1, P3 - P2
        base, step, bend = (signal("base", bits + 1), signal("step", bits + 1),
                            signal("bend", bits + 2))
        next_base, next_bend = signal("next_base", bits + 1), signal("next_bend", bits + 2)
        rise = signal("rise", bits + 4)                 # 4 (P2 - P1) - bend
        # Cycle 1: shift the nodes and their differences.
        with m.If(takes[0] & self.i.valid):
            m.d.sync += [a.eq(b) for a, b in zip(p, [*p[1:], node])]
            m.d.sync += [a.eq(b) for a, b in zip(steps, [*steps[1:], node - p[2]])]
        # Cycle 2: the bend.
        with m.If(takes[1]):
            m.d.sync += [base.eq(p[0] + half), step.eq(steps[1]),
                         bend.eq(steps[2] - steps[0])]
        # Cycle 3: a part of the slope: S times this, and a bend.
        with m.If(takes[2]):
            m.d.sync += [rise.eq((step << 2) - bend), next_base.eq(base), next_bend.eq(bend)]
        # Cycle 4: the slope.
        with m.If(takes[3]):
            m.d.sync += [o.slope.eq((rise << shift) + next_bend), o.base.eq(next_base),
                         o.bend.eq(next_bend)]
