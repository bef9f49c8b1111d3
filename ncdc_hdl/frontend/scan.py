"""Scan of the corrected image in normalised coordinates."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.frontend.layouts import SIZE, SPANS, scan_layout
from ncdc_hdl.frontend.ramp import Ramp
from ncdc_hdl.frontend.signatures import SpansRequest
from ncdc_hdl.frontend.strips import Strips
from ncdc_hdl.neural.layouts import pixel_layout
from ncdc_spec.geometry import SCAN

__all__ = ["Scan"]


class Scan(wiring.Component):
    """Every pixel (u, v) of the corrected image as normalised coordinates, ``lanes`` at a time.

    The order is that of :class:`Strips`. Computes, on raw integers, by addition only::

        x = (origin_x + u step_x + half) >> shift      shift = 31 - input.f_bits
        y = (origin_y + v step_y + half) >> shift
        blank = u is in neither valid span of row v

    Equal bit for bit to ``ncdc_model.golden.network.normalised_scan`` and ``ValidRows.mask``: the sums
    are exact, only the shift rounds.

    Timing: the outputs show one group while ``active``; the next one follows ``advance`` at once,
    also from row to row and from strip to strip, unless a row has fewer than 4 groups. ``blank``
    is that of the group shown ``blank_latency`` clocks ago. ``start`` to ``active`` takes
    ``latency`` clocks, more while the host reads the table.

    ``abort`` ends the frame early: the group behind the one that is shown is blank and the last.
    A picture without a pixel ends in the same way, with one blank group.

    Parameters
    ----------
    formats : ncdc_spec.descriptor.Formats
        ``input`` is used.
    lanes : int
        Pixels of a group: 1, 2 or 4.
    nodes : int
        1, or the distance of the nodes between which other hardware makes the coordinates: then
        the scan has none.

    Members
    -------
    start : ``In(1)``
        Begins a frame; while ``active`` it must stay low.
    abort : ``In(1)``
        To be held until the frame has ended.
    parameters : ``In(scan_layout())``
        Constant from ``start`` to the end of the frame.
    table : ``Out(SpansRequest())``
        To the table of valid rows.
    go : ``In(1)``
        If a group is shown in the next clock, it may be left then.
    advance : ``Out(1)``
        The group shown is left: another one may be shown in the next clock.
    active : ``Out(1)``
        A group is shown.
    first, last : ``Out(1)``
        The group shown is the first, the last of the frame; valid while ``active``.
    blank : ``Out(lanes)``
        Which pixels have no source, of the group shown ``blank_latency`` clocks ago.
    pixels : ``Out(ArrayLayout(pixel_layout(formats, lanes), lanes))``
        Coordinates of the group shown, and what the next group adds to them; valid while
        ``active`` (only without nodes).
    begins : ``Out(1)``
        With ``advance`` only: the group that is left is the first one behind a node, and not one
        that ends the frame early (only with nodes).
    will_begin : ``Out(1)``
        The group in the next clock is, if one is shown then (only with nodes).
    cut : ``Out(1)``
        The frame was ended early; valid from its end to the next ``start``.
    """

    blank_latency = 2
    """Clocks from a group shown to its ``blank``: comparisons, and what they tell."""
    latency = Strips.latency + 2
    """Clocks from ``start`` to ``active``: the first group, as the next one, as the one shown."""

    def __init__(self, formats, lanes=1, nodes=1):
        self.q, self.lanes, self.nodes = formats.input, lanes, nodes
        shown = {"pixels": Out(data.ArrayLayout(pixel_layout(formats, lanes), lanes))} \
            if nodes == 1 else {"begins": Out(1), "will_begin": Out(1)}
        super().__init__({
            "start": In(1), "abort": In(1), "parameters": In(scan_layout()),
            "table": Out(SpansRequest()),
            "go": In(1), "advance": Out(1),
            "active": Out(1), "first": Out(1), "last": Out(1), "blank": Out(lanes),
            **shown, "cut": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        m.submodules.strips = strips = Strips(self.lanes)
        # Three groups are known at a time: the one shown, the next one, and behind it the one that
        # `strips` counts. A frame begins with a next group that is void: the one before its first.
        next_void = Signal()            # the next group is void: it is not shown when it is taken
        next_first = Signal()           # it is the frame's first
        next_last = Signal()            # it is the frame's last
        next_column = Signal(SIZE)      # column of its leftmost pixel
        begins_row = Signal()           # it is the first of a row, whose spans are taken with it
        ends_row = Signal()             # it is the last of a row within its strip, or void
        new_row = Signal()              # the group behind it is in another row of the same strip
        new_strip = Signal()            # the group behind it is the first of another strip
        to_top = Signal()               # the group behind it is in the picture's first row
        shown_column = Signal(SIZE)     # of the group shown: column of its leftmost pixel
        shown_new_row = Signal()        # the group behind the one shown is in another row
        shown_new_strip = Signal()      # the group behind the one shown is in another strip
        shown_cut = Signal()            # the group shown is blank, and ends the frame early
        end = Signal()                  # if the next group is taken, it is blank and ends the frame
        final = Signal()                # if the next group is taken, no other one follows
        take = Signal()                 # the next group becomes the one shown
        m.d.comb += [end.eq(self._ends(m)), final.eq(~next_void & (end | next_last))]
        # A group that begins a row waits until the spans of that row have been fetched.
        spans, fetched = self._fetch_spans(m, take & begins_row)
        self._pace(m, strips, take, next_void, final, may_take=~begins_row | fetched,
                   may_follow=~ends_row | fetched & ~begins_row)

        with m.If(take):
            # The next group becomes the one shown.
            m.d.sync += [
                self.first.eq(next_first), self.last.eq(end | next_last),
                shown_column.eq(next_column), shown_new_row.eq(new_row),
                shown_new_strip.eq(new_strip & ~end), shown_cut.eq(end),
            ]
            # The one that `strips` counts becomes the next group.
            m.d.sync += [
                next_void.eq(0),
                next_first.eq(next_void),
                next_last.eq(strips.last_column & strips.last_row & strips.last_strip),
                next_column.eq(strips.u),
                begins_row.eq(ends_row),
                ends_row.eq(strips.last_column),
                new_row.eq(strips.last_column & ~strips.last_row),
                new_strip.eq(strips.last_column & strips.last_row & ~strips.last_strip),
                to_top.eq(strips.last_column & strips.last_row & ~strips.last_strip),
            ]
        with m.If(self.advance & self.last):
            m.d.sync += self.cut.eq(shown_cut)
        with m.If(self.start):
            m.d.sync += [
                self.cut.eq(0), next_void.eq(1), next_first.eq(0), next_last.eq(0),
                begins_row.eq(0), ends_row.eq(1), new_row.eq(1), new_strip.eq(0), to_top.eq(1),
            ]

        if self.nodes == 1:
            self._coordinates(m, strips.begin, take, new_row, new_strip, to_top)
            self._to_come(m, shown_new_row, shown_new_strip)
        else:
            self._segments(m, take, (shown_column, shown_cut), (next_column, end))
        self._blank(m, shown_column, spans, shown_cut)
        return m

    def _to_come(self, m, new_row, new_strip):
        """Tell with each pixel shown where the next one is."""
        for pixel in self.pixels:
            m.d.comb += [pixel.new_row.eq(new_row), pixel.new_strip.eq(new_strip)]

    def _segments(self, m, take, shown, following):
        """Whether the group in the next clock is the first behind a node, and not cut: of (column,
        cut) of the group shown and of the next one. Strips begin on nodes, so that the column
        tells."""
        shown, following = (~Cat(cut, column[:exact_log2(self.nodes)]).any()
                            for column, cut in (shown, following))
        m.d.comb += self.will_begin.eq(Mux(take, following, shown))

    def _ends(self, m):
        """Whether the frame is to end early: it is aborted, or the picture has no pixel."""
        empty = Signal()
        m.d.sync += empty.eq((self.parameters.width == 0) | (self.parameters.height == 0))
        return self.abort | empty

    def _pace(self, m, strips, take, next_void, final, may_take, may_follow):
        """Decide when the next group is taken, and when the one shown is left.

        Both are decided a clock ahead, since they reach registers all over the scan. ``may_take``:
        the spans of the next group are there. ``may_follow``: so are those of the one behind it.
        """
        next_valid = Signal()           # there is a next group, void or not
        will_take = Signal()            # ``take`` in the next clock
        take_again = Signal()           # after a ``take`` in this clock, another one may follow
        step = Signal()                 # ``take``, or the clock before a frame's first one
        will_show = Signal()            # ``active`` in the next clock
        m.d.comb += [
            strips.order.width.eq(self.parameters.width),
            strips.order.height.eq(self.parameters.height),
            strips.order.strip.eq(self.parameters.strip),
            strips.start.eq(self.start),
            strips.advance.eq(step),
            will_show.eq(take & ~next_void | self.active & ~self.advance),
            take_again.eq(~final & may_follow),
            will_take.eq(strips.begin | Mux(take, take_again, next_valid & may_take)
                         & (~will_show | self.go)),
        ]
        m.d.sync += [
            self.active.eq(will_show),
            self.advance.eq(will_show & self.go),
            *([self.begins.eq(will_show & self.go & self.will_begin)] if self.nodes > 1 else []),
            take.eq(will_take),
            step.eq(will_take | strips.soon),
        ]
        with m.If(take):
            m.d.sync += next_valid.eq(~final)

    def _fetch_spans(self, m, take):
        """The spans of the row shown, and whether those of the next one can be taken.

        The spans of the next row have had a row's time to arrive. Only the host, if it reads the
        table without a pause, or a very short row could hold them back.
        """
        table = self.table
        spans = Signal(SPANS)           # of the row shown
        following = Signal(SPANS)       # of the row behind it, once `fetched`
        fetched = Signal()              # `following` has come from the table
        bottom = Signal(SIZE)           # the number of the picture's last row
        at_bottom = Signal()            # the row asked for is the last one; a clock late
        m.d.sync += [bottom.eq(self.parameters.height - 1), at_bottom.eq(table.row == bottom)]
        with m.If(~fetched):
            m.d.sync += [following.eq(table.spans), fetched.eq(table.fresh)]
        with m.If(take):
            m.d.sync += [spans.eq(following), fetched.eq(0),
                         table.row.eq(Mux(at_bottom, 0, table.row + 1))]
        with m.If(self.start):
            m.d.sync += [fetched.eq(0), table.row.eq(0)]
        return spans, fetched

    def _coordinates(self, m, load, take, new_row, new_strip, top):
        """One ramp for y, and one for the x of each lane; the sums are rounded on the way out.

        The largest sum is 0.9999 + half a step of the input format: below one, it cannot wrap.
        Beyond the last column it may, and is not used.
        """
        p = self.parameters
        shift = SCAN.f_bits - self.q.f_bits
        half = 1 << (shift - 1)
        stride = Signal(signed(SCAN.width + 2))     # of x, from a group to the next one
        first_x = Signal(signed(SCAN.width))        # x of the leftmost column, and the half
        first_y = Signal(signed(SCAN.width))        # y of the first row, and the half
        step_x3 = Signal(signed(SCAN.width))        # three steps of x
        m.d.comb += stride.eq(p.step_x * self.lanes)
        m.d.sync += [first_x.eq(p.origin_x + half), first_y.eq(p.origin_y + half),
                     step_x3.eq(p.step_x + (p.step_x << 1))]
        m.submodules.y = y = Ramp(shift)
        m.d.comb += [y.first.eq(first_y), y.stride.eq(p.step_y), y.load.eq(load), y.take.eq(take),
                     y.step.eq(new_row), y.restart.eq(top)]
        for k, pixel in enumerate(self.pixels):
            m.submodules[f"x{k}"] = x = Ramp(shift)
            m.d.comb += [x.stride.eq(stride), x.load.eq(load), x.take.eq(take), x.step.eq(1),
                         x.restart.eq(new_row), x.rebase.eq(new_strip)]
            if k == 0:
                m.d.comb += x.first.eq(first_x)
            else:
                m.d.sync += x.first.eq(first_x + (step_x3 if k == 3 else p.step_x * k))
            m.d.comb += [
                pixel.x.eq(x.sum >> shift), pixel.x_step.eq(stride >> shift),
                pixel.y.eq(y.sum >> shift), pixel.y_step.eq(p.step_y >> shift),
                pixel.x_carry.eq(x.carry), pixel.y_carry.eq(y.carry),
            ]

    def _blank(self, m, column, spans, cut):
        """``blank`` of the group at ``column``; all of it if the frame is ``cut`` with it."""
        # Cycle 1: compare the columns of the group with the ends of both spans.
        cut_late = Signal()
        m.d.sync += cut_late.eq(cut)
        for k in range(self.lanes):
            u = column | k
            inside = Signal(4, name=f"inside{k}")   # behind the start, before the stop; each span
            m.d.sync += inside.eq(Cat(u >= spans.start0, u < spans.stop0,
                                      u >= spans.start1, u < spans.stop1))
            # Cycle 2: a pixel outside of both spans is blank.
            m.d.sync += self.blank[k].eq(cut_late | ~(inside[:2].all() | inside[2:].all()))
