"""Scan of the corrected image in normalised coordinates."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.frontend.layouts import SIZE, SPANS, scan_layout
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
    are exact, only the shift rounds. Timing: the outputs show one group while ``active``; the
    next one follows ``advance`` at once, also from row to row and from strip to strip, unless a
    row is shorter than 2 clocks. ``start`` to ``active`` takes 2 clocks, more while the host reads
    the table.

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
        Constant while ``active``.
    row, spans, fresh : ``Out``, ``In(SPANS)``, ``In(1)``
        To the table of valid rows.
    advance : ``In(1)``
        The group shown is taken.
    active, first, last : ``Out(1)``
    blank : ``Out(lanes)``
    pixels : ``Out(ArrayLayout(pixel_layout(formats, lanes), lanes))``
        x, y, and what the next group adds to them.
    cut : ``Out(1)``
        The frame was ended early; until the next ``start``.
    """

    def __init__(self, formats, lanes=1):
        self.q, self.lanes = formats.input, lanes
        super().__init__({
            "start": In(1), "abort": In(1), "parameters": In(scan_layout()),
            "row": Out(SIZE), "spans": In(SPANS), "fresh": In(1),
            "advance": In(1),
            "active": Out(1), "first": Out(1), "last": Out(1), "blank": Out(lanes),
            "pixels": Out(data.ArrayLayout(pixel_layout(formats, lanes), lanes)),
            "cut": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        p = self.parameters
        shift = SCAN.f_bits - self.q.f_bits
        half = 1 << (shift - 1)
        m.submodules.strips = strips = Strips(self.lanes)
        m.d.comb += [strips.order.width.eq(p.width), strips.order.height.eq(p.height),
                     strips.order.strip.eq(p.strip), strips.start.eq(self.start),
                     strips.advance.eq(self.advance)]
        # The largest sum is 0.9999 + half a step of the input format: below one, it cannot wrap.
        # Beyond the last column it may, and is not used.
        sum_y, next_y = Signal(signed(SCAN.width)), Signal(signed(SCAN.width))
        x_stride, y_stride = Signal(signed(SCAN.width + 2)), p.step_y
        spans, ending = Signal(SPANS), Signal()
        new_row, new_strip, complete = Signal(), Signal(), Signal()
        m.d.comb += [
            x_stride.eq(p.step_x * self.lanes), next_y.eq(sum_y + y_stride),
            complete.eq(strips.last_column & strips.last_row & strips.last_strip),
            new_row.eq(strips.last_column & ~strips.last_row),
            new_strip.eq(strips.last_column & strips.last_row & ~strips.last_strip),
            self.last.eq(ending | complete),
        ]
        columns = []
        for k in range(self.lanes):
            pixel, u = self.pixels[k], strips.u | k
            sum_x, next_x, left_x = (Signal(signed(SCAN.width), name=f"{name}{k}")
                                     for name in ("sum_x", "next_x", "left_x"))
            columns.append((sum_x, next_x, left_x))
            m.d.comb += [
                next_x.eq(sum_x + x_stride),
                pixel.x.eq(sum_x >> shift), pixel.x_step.eq(x_stride >> shift),
                pixel.y.eq(sum_y >> shift), pixel.y_step.eq(y_stride >> shift),
                # What the adder carried from the dropped bits into those that are kept.
                pixel.x_carry.eq((next_x ^ sum_x ^ x_stride)[shift]),
                pixel.y_carry.eq((next_y ^ sum_y ^ y_stride)[shift]),
                pixel.new_row.eq(new_row), pixel.new_strip.eq(new_strip & ~ending),
                self.blank[k].eq(ending | ~((u >= spans.start0) & (u < spans.stop0)
                                            | (u >= spans.start1) & (u < spans.stop1))),
            ]

        def begin_row():
            """Take the spans, and ask for those of the row that will follow."""
            return [spans.eq(self.spans),
                    self.row.eq(Mux(self.row == p.height - 1, 0, self.row + 1))]

        with m.FSM():
            with m.State("IDLE"):
                with m.If(self.start):
                    m.d.sync += [self.row.eq(0), self.cut.eq(0)]
                    m.next = "FETCH"
            with m.State("FETCH"):
                with m.If(self.fresh):
                    m.d.sync += begin_row()
                    m.d.sync += [self.first.eq(1), sum_y.eq(p.origin_y + half),
                                 ending.eq(self.abort | (p.width == 0) | (p.height == 0))]
                    for k, (sum_x, _, left_x) in enumerate(columns):
                        left = p.origin_x + half + p.step_x * k
                        m.d.sync += [sum_x.eq(left), left_x.eq(left)]
                    m.next = "RUN"
            with m.State("RUN"):
                # The next row's spans have had a whole row's time to arrive; only the host
                # reading the table without a pause, or a very short row, could hold them back.
                m.d.comb += self.active.eq(~strips.last_column | self.last | self.fresh)
                with m.If(self.advance):
                    m.d.sync += [self.first.eq(0), ending.eq(self.abort)]
                    m.d.sync += [sum_x.eq(next_x) for sum_x, next_x, _ in columns]
                    with m.If(strips.last_column):
                        m.d.sync += begin_row()
                    with m.If(new_row):
                        m.d.sync += sum_y.eq(next_y)
                        m.d.sync += [sum_x.eq(left_x) for sum_x, _, left_x in columns]
                    with m.If(new_strip):
                        m.d.sync += sum_y.eq(p.origin_y + half)
                        m.d.sync += [left_x.eq(next_x) for _, next_x, left_x in columns]
                    with m.If(self.last):
                        m.d.sync += self.cut.eq(ending)
                        m.next = "IDLE"
        return m
