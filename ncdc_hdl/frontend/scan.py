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

    Equal bit for bit to ``ncdc_model.golden.network.normalised_scan`` and ``ValidRows.mask``: the
    sums are exact, only the shift rounds.

    Timing: the outputs show one group while ``active``. The next one follows ``advance`` at once,
    also between rows and strips, unless a row has fewer than 4 groups. ``blank``
    belongs to the group shown ``blank_latency`` clocks ago. ``start`` to ``active`` takes
    ``latency`` clocks, more if the host reads the table.

    ``abort`` ends the frame early: the group after the one shown is blank and the last.
    A picture without a pixel also ends with one blank group.

    Parameters
    ----------
    formats : ncdc_spec.descriptor.Formats
        ``input`` is used.
    lanes : int
        Pixels of a group: 1, 2 or 4.
    nodes : int
        1, or the distance of the nodes; then other hardware computes the coordinates between them,
        and the scan has none.
    view : bool
        Whether a view decides which pixels are blank; the scan then has no spans, and only groups
        that end a frame early are blank.

    Members
    -------
    start : ``In(1)``
        Begins a frame; must be low while ``active``.
    abort : ``In(1)``
        Held until the frame has ended.
    parameters : ``In(scan_layout())``
        Constant from ``start`` to the end of the frame.
    table : ``Out(SpansRequest())``
        To the table of valid rows (only without a view).
    go : ``In(1)``
        A group shown in the next clock may advance then.
    advance : ``Out(1)``
        The group shown ends: another one may be shown in the next clock.
    active : ``Out(1)``
        A group is shown.
    first, last : ``Out(1)``
        The group shown is the first, the last of the frame; valid while ``active``.
    blank : ``Out(lanes)``
        Pixels without a source, of the group shown ``blank_latency`` clocks ago.
    pixels : ``Out(ArrayLayout(pixel_layout(formats, lanes), lanes))``
        Coordinates of the group shown, and their increments to the next group; valid while
        ``active`` (only without nodes).
    begins : ``Out(1)``
        Only with ``advance``: the group is the first one after a node, and not one
        that ends the frame early (only with nodes).
    will_begin : ``Out(1)``
        The group of the next clock, if shown, is the first one after a node (only with nodes).
    cut : ``Out(1)``
        The frame was ended early; valid from its end to the next ``start``.
    """

    blank_latency = 2
    """Clocks from a group shown to its ``blank``: comparisons, and their result."""
    latency = Strips.latency + 2
    """Clocks from ``start`` to ``active``: the first group, as the next one, as the one shown."""

    def __init__(self, formats, lanes=1, nodes=1, view=False):
        self.q, self.lanes, self.nodes, self.view = formats.input, lanes, nodes, view
        shown = {"pixels": Out(data.ArrayLayout(pixel_layout(formats, lanes), lanes))} \
            if nodes == 1 else {"begins": Out(1), "will_begin": Out(1)}
        super().__init__({
            "start": In(1), "abort": In(1), "parameters": In(scan_layout()),
            **({} if view else {"table": Out(SpansRequest())}),
            "go": In(1), "advance": Out(1),
            "active": Out(1), "first": Out(1), "last": Out(1), "blank": Out(lanes),
            **shown, "cut": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        m.submodules.strips = strips = Strips(self.lanes)
        # Three groups are known at a time: the one shown, the next one, and the one that
        # `strips` counts. A frame begins with a void next group, before its first.
        next_void = Signal()            # the next group is void: it is not shown when it is taken
        next_first = Signal()           # it is the frame's first
        next_last = Signal()            # it is the frame's last
        next_column = Signal(SIZE)      # column of its leftmost pixel
        begins_row = Signal()           # it is the first of a row, whose spans are taken with it
        ends_row = Signal()             # it is the last of a row within its strip, or void
        new_row = Signal()              # the group after it is in another row of the same strip
        new_strip = Signal()            # the group after it is the first of another strip
        to_top = Signal()               # the group after it is in the picture's first row
        shown_column = Signal(SIZE)     # column of the shown group's leftmost pixel
        shown_new_row = Signal()        # the group after the one shown is in another row
        shown_new_strip = Signal()      # the group after the one shown is in another strip
        shown_cut = Signal()            # the group shown is blank, and ends the frame early
        end = Signal()                  # if the next group is taken, it is blank and ends the frame
        final = Signal()                # if the next group is taken, it is the last
        take = Signal()                 # the next group becomes the one shown
        m.d.comb += [end.eq(self._ends(m)), final.eq(~next_void & (end | next_last))]
        # A group that begins a row waits until the spans of that row have been fetched.
        spans, fetched = (self._rest if self.view else self._fetch_spans)(m, take & begins_row)
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
        """Output the position of the next pixel with each pixel shown."""
        for pixel in self.pixels:
            m.d.comb += [pixel.new_row.eq(new_row), pixel.new_strip.eq(new_strip)]

    def _segments(self, m, take, shown, following):
        """Whether the group in the next clock is the first after a node, and not cut: of (column,
        cut) of the group shown and of the next one. Strips begin on nodes, so that the column is
        enough."""
        shown, following = (~Cat(cut, column[:exact_log2(self.nodes)]).any()
                            for column, cut in (shown, following))
        m.d.comb += self.will_begin.eq(Mux(take, following, shown))

    def _ends(self, m):
        """Whether the frame is to end early: it is aborted, or the picture has no pixel."""
        empty = Signal()
        m.d.sync += empty.eq((self.parameters.width == 0) | (self.parameters.height == 0))
        return self.abort | empty

    def _pace(self, m, strips, take, next_void, final, may_take, may_follow):
        """Decide when the next group is taken, and when the one shown ends.

        Both are decided a clock early, since they reach registers all over the scan. ``may_take``:
        the spans of the next group are there. ``may_follow``: so are those of the group after it.
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
        table without a pause, or a very short row could delay them.
        """
        table = self.table
        spans = Signal(SPANS)           # of the row shown
        following = Signal(SPANS)       # of the row after it, once `fetched`
        fetched = Signal()              # `following` has come from the table
        bottom = Signal(SIZE)           # the number of the picture's last row
        row = Signal(SIZE)              # the row that was requested
        after = Signal(SIZE)            # the row after it; a clock late
        m.d.sync += [bottom.eq(self.parameters.height - 1),
                     after.eq(Mux(row == bottom, 0, row + 1)), row.eq(table.row)]
        # With the end of a row, not a clock later: the table has it in a register.
        m.d.comb += table.row.eq(Mux(self.start, 0, Mux(take, after, row)))
        with m.If(~fetched):
            m.d.sync += [following.eq(table.spans), fetched.eq(table.fresh)]
        with m.If(take):
            m.d.sync += [spans.eq(following), fetched.eq(0)]
        with m.If(self.start):
            m.d.sync += fetched.eq(0)
        return spans, fetched

    def _rest(self, m, take):
        """No spans, and whether a row may be taken: rows last 4 clocks, as with spans."""
        recent = Signal(3)
        m.d.sync += recent.eq(Cat(take | self.start, recent))
        return None, ~recent.any()

    def _coordinates(self, m, load, take, new_row, new_strip, top):
        """One ramp for y, and one for the x of each lane; the sums are rounded at the output.

        The largest sum is 0.9999 + half a step of the input format: below one, it cannot wrap.
        Beyond the last column it may wrap, and is not used.
        """
        p = self.parameters
        shift = SCAN.f_bits - self.q.f_bits
        half = 1 << (shift - 1)
        stride = Signal(signed(SCAN.width + 2))     # step of x from group to group
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
        """``blank`` of the group at ``column``; all lanes if the frame is ``cut`` with it."""
        # Cycle 1: compare the columns of the group with the ends of both spans.
        cut_late = Signal()
        m.d.sync += cut_late.eq(cut)
        if self.view:
            m.d.sync += self.blank.eq(cut_late.replicate(self.lanes))
            return
        for k in range(self.lanes):
            u = column | k
            inside = Signal(4, name=f"inside{k}")   # after the start, before the stop; each span
            m.d.sync += inside.eq(Cat(u >= spans.start0, u < spans.stop0,
                                      u >= spans.start1, u < spans.stop1))
            # Cycle 2: a pixel outside of both spans is blank.
            m.d.sync += self.blank[k].eq(cut_late | ~(inside[:2].all() | inside[2:].all()))
