"""Groups of windows as boxes of samples that can be read in one clock."""

from functools import reduce
from itertools import combinations
from operator import and_, or_

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2, exact_log2

from ncdc_hdl.backend.layouts import request_layout
from ncdc_hdl.lib.groups import lanes_of
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.interpolation import FAST

__all__ = ["Boxes", "box_layout"]

_EDGES = "x0", "y0", "x1", "y1"     # of a box


def box_layout(f_bits, lanes, interpolation=FAST):
    """A box: samples (x0, y0) to (x1, y1), both included, of the lanes in ``mask`` of ``group``.

    ``used`` is high unless all of these lanes are blank; ``end`` marks the group's last box. Of a
    group of several lanes it is only known whether it is the ``first`` or ``last`` of the frame.
    """
    flags = data.StructLayout({"first": 1, "last": 1})
    return data.StructLayout({
        **dict.fromkeys(_EDGES, range(MAX_SIZE)), "used": 1, "mask": lanes, "end": 1,
        "group": request_layout(f_bits, lanes, interpolation) if lanes == 1 else flags})


class Boxes(wiring.Component):
    """One box for all windows of a group if it can be read in one clock; else one per half.

    A box fits if it has no more words in a row (``Interpolation.box_words``) and no more rows than
    the tile memory outputs, and no more rows of tiles than can be looked up. A group that does not
    fit is cut in halves, these likewise, from left to right; the window of one pixel always fits.
    Blank pixels take no part.

    Only the part in the frame counts, for windows with a margin.

    Timing: a single lane passes unchanged, with latency 0. Several lanes take one more stage than
    halvings to a single lane; one box per clock. Windows with a margin take one stage more.

    Parameters
    ----------
    f_bits : int
        Fraction bits of the position in the window.
    lanes : int
        Pixels of a group: 1, 2 or 4.
    interpolation : Interpolation

    Members
    -------
    i : ``In(stream.Signature(request_layout(f_bits, lanes, interpolation)))``
    o : ``Out(stream.Signature(box_layout(f_bits, lanes, interpolation)))``
    """

    def __init__(self, f_bits, lanes, interpolation=FAST):
        self.f_bits, self.lanes, self.interpolation = f_bits, lanes, interpolation
        super().__init__({
            "i": In(stream.Signature(request_layout(f_bits, lanes, interpolation))),
            "o": Out(stream.Signature(box_layout(f_bits, lanes, interpolation))),
        })

    @property
    def latency(self):
        """Clocks from a group to its first box: a stage for the part in the frame, one per halving,
        and the boxes one by one."""
        clipped = 1 if self.interpolation.margin else 0
        return clipped + (0 if self.lanes == 1 else ceil_log2(self.lanes) + 1)

    def elaborate(self, platform):
        m = Module()
        ready = Signal()        # the next stage takes the boxes of the single lanes
        moves = Signal()        # the same, for what moves with it
        group, valid, boxes = self._single(m, ready, moves)
        if self.lanes == 1:
            (box,), o = boxes, self.o.p
            m.d.comb += [o[name].eq(box[name]) for name in (*_EDGES, "used")]
            m.d.comb += [o.mask.eq(1), o.end.eq(1), o.group.eq(group), self.o.valid.eq(valid),
                         ready.eq(self.o.ready), moves.eq(~valid | ready)]
            return m
        self._parts(m, group, valid, boxes, ready, moves)
        return m

    def _single(self, m, ready, moves):
        """What of the group goes on, whether there is one, and the box of each of its lanes."""
        needs = self.interpolation
        layout = data.StructLayout(dict.fromkeys(_EDGES, range(MAX_SIZE)) | {"used": 1} | (
            {"end_x": range(2 * MAX_SIZE), "end_y": range(2 * MAX_SIZE)} if self.lanes > 1 else {}))
        boxes = [Signal(layout) for _ in range(self.lanes)]
        for lane, box in zip(lanes_of(self.i.p), boxes):
            m.d.comb += box.used.eq(~lane.blank)
            for axis in "xy":
                low, high = lane[f"{axis}0"] - needs.margin, lane[f"{axis}0"] + needs.after
                if needs.margin:
                    edge = lane[f"edge_{axis}"]
                    low = low + Mux(edge.after, 0, edge.missing)
                    high = high - Mux(edge.after, edge.missing, 0)
                m.d.comb += [box[f"{axis}0"].eq(low), box[f"{axis}1"].eq(high)]
                if self.lanes > 1:
                    bits, length = self._longest(axis)
                    m.d.comb += box[f"end_{axis}"].eq(low + (length << bits))
        arrives = Signal(self.o.p.group.shape())        # of the group, what goes on with its box
        m.d.comb += arrives.eq(self.i.p if self.lanes == 1 else Cat(self.i.p.first, self.i.p.last))
        if not needs.margin:
            m.d.comb += self.i.ready.eq(ready)
            return arrives, self.i.valid, boxes
        group = Signal.like(arrives, name="clipped_group")
        valid = Signal(name="clipped_valid")
        clipped = [Signal(layout, name=f"clipped_box{k}") for k in range(self.lanes)]
        # Several lanes: with the stages after it. A single one: as soon as it is empty, too.
        m.d.comb += self.i.ready.eq(ready if self.lanes > 1 else ~valid | ready)
        with m.If(ready if self.lanes > 1 else moves):
            m.d.sync += [valid.eq(self.i.valid), group.eq(arrives)]
            m.d.sync += [new.eq(old) for new, old in zip(clipped, boxes)]
        return group, valid, clipped

    def _parts(self, m, group, valid, boxes, ready, moves):
        """Several lanes: a tree of boxes with a level per stage, output part by part."""
        # Level 0: the lanes themselves, which always fit. All levels of a group move on together.
        # Whether two lanes can be in one box is found at level 0 and goes on with their boxes.
        tree = [boxes]
        near = {(a, b): self._near(boxes[a], boxes[b])
                for a, b in combinations(range(self.lanes), 2)}
        for level in range(1, ceil_log2(self.lanes) + 1):
            arriving_near = near
            arriving = [*tree, [self._join(m, left, right)
                                for left, right in zip(tree[-1][::2], tree[-1][1::2])]]
            stage_valid = Signal(name=f"valid{level}")
            stage_group = Signal.like(group, name=f"group{level}")
            tree = [[Signal.like(box, name=f"box{level}_{k}_{n}") for n, box in enumerate(boxes)]
                    for k, boxes in enumerate(arriving)]
            near = {(a, b): Signal.like(flags, name=f"near{level}_{a}{b}")
                    for (a, b), flags in arriving_near.items()}
            with m.If(moves):
                m.d.sync += [near[lanes].eq(flags) for lanes, flags in arriving_near.items()]
                m.d.sync += [stage_valid.eq(valid), stage_group.eq(group)]
                m.d.sync += [new.eq(old) for news, olds in zip(tree, arriving)
                             for new, old in zip(news, olds)]
            arrives, valid, group = valid, stage_valid, stage_group

        # The part at hand is chosen a clock before: with a group its first one, then the next.
        # So whether all levels move is known from few registers.
        parts = _parts_of(tree)
        chosen = {part: Signal(name="chosen{}_{}".format(*part)) for part in parts}
        ends = Signal()                         # it is the group's last one
        free = ~self.o.valid | self.o.ready
        # Synthesis does not merge a flag with its complement: `ready`, which goes on to earlier
        # stages, is `moves`, but does not begin where many flip-flops are moved.
        empty = Signal(init=1)                  # complement of `valid`
        o_empty = Signal(init=1)                # complement of `o.valid`
        more = Signal(init=1)                   # complement of `ends`
        m.d.comb += [moves.eq(~valid | (free & ends)),
                     ready.eq(empty | ((o_empty | self.o.ready) & ~more))]
        first = _choice(parts, arriving_near, {0: Const(1)})
        following = _choice(parts, near, _ends(chosen))
        with m.If(moves):
            m.d.sync += empty.eq(~arrives)
        with m.If(ready):
            m.d.sync += [own.eq(first[part]) for part, own in chosen.items()]
            last = _ends(first)[self.lanes]
            m.d.sync += [ends.eq(last), more.eq(~last)]
        with m.Elif(free):
            m.d.sync += [own.eq(following[part]) for part, own in chosen.items()]
            last = _ends(following)[self.lanes]
            m.d.sync += [ends.eq(last), more.eq(~last)]
        with m.If(free):
            m.d.sync += [self.o.valid.eq(valid), o_empty.eq(~valid), self.o.p.end.eq(ends),
                         self.o.p.group.eq(group)]
            m.d.sync += [self.o.p[name].eq(_any(Mux(own, parts[part][name], 0)
                                                for part, own in chosen.items()))
                         for name in (*_EDGES, "used")]
            m.d.sync += self.o.p.mask.eq(_any(Mux(own, ((1 << (1 << level)) - 1) << (k << level), 0)
                                              for (level, k), own in chosen.items()))

    def _join(self, m, a, b):
        """The box around two boxes."""
        both = Signal()         # both boxes are used
        box = Signal(data.StructLayout(dict.fromkeys(_EDGES, range(MAX_SIZE)) | {"used": 1}))
        m.d.comb += [both.eq(a.used & b.used), box.used.eq(a.used | b.used)]
        for name, chooses_b in (("x0", b.x0 < a.x0), ("y0", b.y0 < a.y0), ("x1", b.x1 > a.x1),
                                ("y1", b.y1 > a.y1)):
            m.d.comb += box[name].eq(Mux(Mux(both, chooses_b, b.used), b[name], a[name]))
        return box

    def _near(self, a, b):
        """Two flags that are high if two boxes can be in one, for each of them at its beginning.

        A box fits if this holds for any two of its lanes. It is compared for lanes, and not for
        the boxes around them: choice and comparison in turn would be the longest path of a core
        with several lanes.
        """
        unused = ~(a.used & b.used)
        return Cat(unused | self._reaches(a, b), unused | self._reaches(b, a))

    def _reaches(self, a, b):
        """Whether the last sample of ``b`` is not too far after the first one of ``a``."""
        (x_bits, _), (y_bits, _) = self._longest("x"), self._longest("y")
        return (b.x1 >> x_bits < a.end_x >> x_bits) & (b.y1 >> y_bits < a.end_y >> y_bits)

    def _longest(self, axis):
        """log2 of the samples of a unit along an axis, and the units that a box has at most.

        Units are words, and rows of tiles; rows if a box is limited by these.
        """
        needs = self.interpolation
        if axis == "x":
            words, samples = needs.box_words(self.lanes)
            return exact_log2(samples), words
        height, rows = needs.tile_height, needs.tile_rows
        if rows * height <= needs.box_rows:
            return exact_log2(height), rows
        return 0, needs.box_rows


def _any(values):
    """The bits that any of ``values`` has."""
    return reduce(or_, values)


def _parts_of(tree):
    """Boxes of a tree by their level and number: part (n, k) begins with lane k 2**n."""
    return {(level, k): box for level, boxes in enumerate(tree) for k, box in enumerate(boxes)}


def _choice(parts, near, begins):
    """Which of ``parts`` is the largest one that fits and begins with the lane to begin with.

    ``begins`` has a flag for each lane that may be that, ``near`` those of any two lanes that are
    all high if these can be in one box. Halves of a part that fits fit.
    """
    def fits(level, k):
        lanes = range(k << level, k + 1 << level)
        return reduce(and_, (near[pair].all() for pair in combinations(lanes, 2)), Const(1))

    choice = {}
    for level, k in parts:
        larger = level + 1, k >> 1
        alone = ~fits(*larger) if k % 2 == 0 and larger in parts else Const(1)
        choice[level, k] = begins.get(k << level, Const(0)) & fits(level, k) & alone
    return choice


def _ends(choice):
    """Of each lane whether the part of ``choice`` ends before it."""
    ends = {}
    for (level, k), own in choice.items():
        ends[k + 1 << level] = ends.get(k + 1 << level, Const(0)) | own
    return ends
