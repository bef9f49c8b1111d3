"""Scan of the corrected image in normalised coordinates."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.frontend.layouts import SIZE, SPANS, scan_layout
from ncdc_hdl.frontend.ramp import Ramp
from ncdc_hdl.frontend.strips import Strips
from ncdc_hdl.neural.layouts import pixel_layout
from ncdc_model.geometry import SCAN

__all__ = ["Scan"]


class Scan(wiring.Component):
    """Every pixel (u, v) of the corrected image as normalised coordinates, ``lanes`` at a time.

    The order is that of :class:`Strips`. Computes, on raw integers, by addition only::

        x = (origin_x + u step_x + half) >> shift      shift = 31 - input.f_bits
        y = (origin_y + v step_y + half) >> shift
        blank = u is in neither valid span of row v

    Equal bit for bit to ``ncdc_model.network.normalised_scan`` and ``ValidRows.mask``: the sums
    are exact, only the shift rounds.

    Timing: the outputs show one group while ``active``; the next one follows ``advance`` at once,
    also from row to row and from strip to strip, unless a row has fewer than 4 groups. ``blank``
    is that of the group shown ``blank_latency`` clocks ago. ``start`` to ``active`` takes
    ``latency`` clocks, more while the host reads the table.

    ``abort`` ends the frame early: the group behind the one that is shown is blank and the last.
    So does a picture without a pixel, whose only group that is.

    Parameters
    ----------
    formats : ncdc_model.descriptor.Formats
        ``input`` is used.
    lanes : int
        Pixels of a group: 1, 2 or 4.

    Members
    -------
    start : ``In(1)``
        Begins a frame; while ``active`` it must stay low.
    abort : ``In(1)``
        To be held until the frame has ended.
    parameters : ``In(scan_layout())``
        Constant from ``start`` to the end of the frame.
    row, spans, fresh : ``Out``, ``In(SPANS)``, ``In(1)``
        To the table of valid rows.
    go : ``In(1)``
        If a group is shown in the next clock, it may be left then.
    advance : ``Out(1)``
        The group shown is left: another one may be shown in the next clock.
    active, first, last : ``Out(1)``
    blank : ``Out(lanes)``
    pixels : ``Out(ArrayLayout(pixel_layout(formats, lanes), lanes))``
        x, y, and what the next group adds to them.
    cut : ``Out(1)``
        The frame was ended early; until the next ``start``.
    """

    blank_latency = 2
    latency = Strips.latency + 2

    def __init__(self, formats, lanes=1):
        self.q, self.lanes = formats.input, lanes
        super().__init__({
            "start": In(1), "abort": In(1), "parameters": In(scan_layout()),
            "row": Out(SIZE), "spans": In(SPANS), "fresh": In(1),
            "go": In(1), "advance": Out(1),
            "active": Out(1), "first": Out(1), "last": Out(1), "blank": Out(lanes),
            "pixels": Out(data.ArrayLayout(pixel_layout(formats, lanes), lanes)),
            "cut": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        p = self.parameters
        m.submodules.strips = strips = Strips(self.lanes)
        # The group that follows the one shown: there is one, if only the one before a frame's
        # first, which nobody sees; it is that one, it is the first of a frame, it is the first of a
        # row, whose spans are to be taken with it.
        running, void, frame_begins, row_begins = Signal(), Signal(), Signal(), Signal()
        # It is the last of a row; others follow it in this strip, in another one; it is the last.
        row_ends, new_row, new_strip, complete = Signal(), Signal(), Signal(), Signal()
        top, column = Signal(), Signal(SIZE)         # the next row is the first one; its column
        take = Signal()                              # it becomes the group shown
        takes = Signal()                             # ``take`` in the next clock
        step = Signal()                              # ``take``, or before the first group
        further = Signal()                           # if so, yet another one can follow at once
        shown = Signal()                             # ``active`` in the next clock
        ending = Signal()                            # the group shown is blank and ends the frame
        end, empty = Signal(), Signal()
        shown_row, shown_strip, shown_column = Signal(), Signal(), Signal(SIZE)
        spans, fetched = self._fetch_spans(m, take & row_begins)
        m.d.comb += [
            strips.order.width.eq(p.width), strips.order.height.eq(p.height),
            strips.order.strip.eq(p.strip), strips.start.eq(self.start),
            strips.advance.eq(step),
            shown.eq(take & ~void | self.active & ~self.advance),
            end.eq(self.abort | empty),
            takes.eq(strips.begin | Mux(take, further, running & (~row_begins | fetched))
                     & (~shown | self.go)),
            further.eq((void | ~(end | complete)) & (~row_ends | fetched & ~row_begins)),
        ]
        # Decided a clock ahead: both reach registers all over the scan.
        m.d.sync += [
            empty.eq((p.width == 0) | (p.height == 0)), self.active.eq(shown),
            self.advance.eq(shown & self.go),
            take.eq(takes), step.eq(takes | strips.soon),
        ]
        with m.If(take):
            m.d.sync += [
                row_ends.eq(strips.last_column),
                new_row.eq(strips.last_column & ~strips.last_row),
                new_strip.eq(strips.last_column & strips.last_row & ~strips.last_strip),
                top.eq(strips.last_column & strips.last_row & ~strips.last_strip),
                complete.eq(strips.last_column & strips.last_row & strips.last_strip),
                column.eq(strips.u), void.eq(0), frame_begins.eq(void), row_begins.eq(row_ends),
                running.eq(void | ~(end | complete)),
                self.first.eq(frame_begins), self.last.eq(end | complete), ending.eq(end),
                shown_row.eq(new_row), shown_strip.eq(new_strip & ~end), shown_column.eq(column),
            ]
        with m.If(self.advance & self.last):
            m.d.sync += self.cut.eq(ending)
        with m.If(self.start):
            m.d.sync += [self.cut.eq(0), void.eq(1), frame_begins.eq(0), row_begins.eq(0),
                         row_ends.eq(1), new_row.eq(1), new_strip.eq(0), top.eq(1), complete.eq(0)]

        self._coordinates(m, strips.begin, take, new_row, new_strip, top)
        for pixel in self.pixels:
            m.d.comb += [pixel.new_row.eq(shown_row), pixel.new_strip.eq(shown_strip)]
        self._blank(m, shown_column, spans, ending)
        return m

    def _fetch_spans(self, m, take):
        """The spans of the row shown, and whether those of the next one can be taken.

        They have had a row's time to arrive; only the host reading the table without a pause, or
        a very short row, could hold them back.
        """
        spans, following, fetched = Signal(SPANS), Signal(SPANS), Signal()
        bottom, at_bottom = Signal(SIZE), Signal()
        m.d.sync += [bottom.eq(self.parameters.height - 1), at_bottom.eq(self.row == bottom)]
        with m.If(~fetched):
            m.d.sync += [following.eq(self.spans), fetched.eq(self.fresh)]
        with m.If(take):
            m.d.sync += [spans.eq(following), fetched.eq(0),
                         self.row.eq(Mux(at_bottom, 0, self.row + 1))]
        with m.If(self.start):
            m.d.sync += [fetched.eq(0), self.row.eq(0)]
        return spans, fetched

    def _coordinates(self, m, load, take, new_row, new_strip, top):
        p, shift = self.parameters, SCAN.f_bits - self.q.f_bits
        half = 1 << (shift - 1)
        # The largest sum is 0.9999 + half a step of the input format: below one, it cannot wrap.
        # Beyond the last column it may, and is not used.
        stride = Signal(signed(SCAN.width + 2))
        first_x, first_y, step_x3 = (Signal(signed(SCAN.width), name=name)
                                     for name in ("first_x", "first_y", "step_x3"))
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

    def _blank(self, m, column, spans, ending):
        """Two stages: comparisons, and what they tell."""
        late = Signal()
        m.d.sync += late.eq(ending)
        for k in range(self.lanes):
            u, inside = column | k, Signal(4, name=f"inside{k}")
            m.d.sync += [
                inside.eq(Cat(u >= spans.start0, u < spans.stop0,
                              u >= spans.start1, u < spans.stop1)),
                self.blank[k].eq(late | ~(inside[:2].all() | inside[2:].all())),
            ]
