"""Groups of windows as boxes of samples that can be read in one clock."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.layouts import request_layout
from ncdc_hdl.lib.groups import lanes_of
from ncdc_model.fetch.cache_options import TILE_HEIGHT
from ncdc_model.geometry import MAX_SIZE, WINDOW

__all__ = ["Boxes", "box_layout"]

_WORD_BITS = 3          # a word of the tile memory has 8 bytes if there are several lanes


def box_layout(f_bits, lanes):
    """A box: samples (x0, y0) to (x1, y1), both included, of the lanes in ``mask`` of ``group``.

    ``used`` is high unless all of these lanes are blank; ``end`` marks the group's last box.
    """
    return data.StructLayout({
        "x0": range(MAX_SIZE), "y0": range(MAX_SIZE), "x1": range(MAX_SIZE), "y1": range(MAX_SIZE),
        "used": 1, "mask": lanes, "end": 1, "group": request_layout(f_bits, lanes)})


class Boxes(wiring.Component):
    """One box for all windows of a group if it can be read in one clock; else of its halves.

    A box fits if it has at most two words of eight bytes across, each on a multiple of eight, and
    four rows. A group that does not fit is cut in halves, these likewise, from left to right; the
    window of one pixel always fits. Blank pixels take no part.

    Timing: a single lane passes as it is, with latency 0. Several lanes take one more stage than
    halvings to a single lane; one box per clock.

    Parameters
    ----------
    f_bits : int
        Fraction bits of the place in the window.
    lanes : int
        Pixels of a group: 1, 2 or 4.

    Members
    -------
    i : ``In(stream.Signature(request_layout(f_bits, lanes)))``
    o : ``Out(stream.Signature(box_layout(f_bits, lanes)))``
    """

    def __init__(self, f_bits, lanes):
        self.f_bits, self.lanes = f_bits, lanes
        super().__init__({
            "i": In(stream.Signature(request_layout(f_bits, lanes))),
            "o": Out(stream.Signature(box_layout(f_bits, lanes))),
        })

    @property
    def latency(self):
        """Clocks from a group to its first box: a stage per halving, and the boxes one by one."""
        return 0 if self.lanes == 1 else ceil_log2(self.lanes) + 1

    def elaborate(self, platform):
        m = Module()
        if self.lanes == 1:
            i, o = self.i.p, self.o.p
            m.d.comb += [
                o.x0.eq(i.x0), o.y0.eq(i.y0), o.x1.eq(i.x0 + WINDOW - 1),
                o.y1.eq(i.y0 + WINDOW - 1), o.used.eq(~i.blank), o.mask.eq(1), o.end.eq(1),
                o.group.eq(i), self.o.valid.eq(self.i.valid), self.i.ready.eq(self.o.ready)]
            return m
        self._parts(m)
        return m

    def _parts(self, m):
        """Several lanes: a tree of boxes, a level per stage, and one part of it after the other."""
        edges = data.StructLayout({name: range(MAX_SIZE) for name in ("x0", "y0", "x1", "y1")}
                                  | {"used": 1, "fits": 1})
        # Level 0: the lanes themselves. All levels of a group move on together.
        group, valid, boxes = self.i.p, self.i.valid, []
        for lane in lanes_of(group):
            box = Signal(edges)
            m.d.comb += [box.x0.eq(lane.x0), box.y0.eq(lane.y0), box.x1.eq(lane.x0 + WINDOW - 1),
                         box.y1.eq(lane.y0 + WINDOW - 1), box.used.eq(~lane.blank), box.fits.eq(1)]
            boxes.append(box)
        tree = [boxes]
        last_ready = Signal()
        m.d.comb += self.i.ready.eq(last_ready)
        for level in range(1, ceil_log2(self.lanes) + 1):
            joined = [self._join(m, edges, left, right)
                      for left, right in zip(tree[-1][::2], tree[-1][1::2])]
            stage_valid = Signal(name=f"valid{level}")
            stage_group = Signal.like(group, name=f"group{level}")
            stage = [[Signal(edges, name=f"box{level}_{k}_{n}") for n in range(len(boxes))]
                     for k, boxes in enumerate([*tree, joined])]
            with m.If(last_ready):
                m.d.sync += [stage_valid.eq(valid), stage_group.eq(group)]
                m.d.sync += [new.eq(old) for news, olds in zip(stage, [*tree, joined])
                             for new, old in zip(news, olds)]
            tree, valid, group = stage, stage_valid, stage_group

        # From the lane at hand on, the largest part of the tree that fits.
        at = Signal(range(self.lanes))          # the lane at hand
        part = Signal(edges)                    # the largest box that fits and begins there
        size = Signal(range(self.lanes + 1))    # its lanes
        mask = Signal(self.lanes)               # its lanes, a bit each
        end = Signal()                          # it is the group's last box
        for level, boxes in enumerate(tree):
            for k, box in enumerate(boxes):
                with m.If((at == k << level) & box.fits):
                    m.d.comb += [part.eq(box), size.eq(1 << level),
                                 mask.eq(((1 << (1 << level)) - 1) << (k << level))]
        free = ~self.o.valid | self.o.ready
        m.d.comb += [end.eq(at + size == self.lanes), last_ready.eq(~valid | (free & end))]
        with m.If(free):
            m.d.sync += [
                self.o.valid.eq(valid), *(self.o.p[name].eq(part[name]) for name in
                                          ("x0", "y0", "x1", "y1", "used")),
                self.o.p.mask.eq(mask), self.o.p.end.eq(end), self.o.p.group.eq(group)]
            with m.If(valid):
                m.d.sync += at.eq(Mux(end, 0, at + size))

    def _join(self, m, edges, a, b):
        """The box around two boxes."""
        both = Signal()         # both boxes are used
        box = Signal(edges)     # the box around those that are
        m.d.comb += [both.eq(a.used & b.used), box.used.eq(a.used | b.used)]
        for name, chooses_b in (("x0", b.x0 < a.x0), ("y0", b.y0 < a.y0), ("x1", b.x1 > a.x1),
                                ("y1", b.y1 > a.y1)):
            m.d.comb += box[name].eq(Mux(Mux(both, chooses_b, b.used), b[name], a[name]))
        across = box.x1[_WORD_BITS:] - box.x0[_WORD_BITS:]
        m.d.comb += box.fits.eq(~box.used | ((across <= 1) & (box.y1 - box.y0 < TILE_HEIGHT)))
        return box
