"""Raster scan of the corrected image in normalised coordinates."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.frontend.layouts import SIZE, SPANS, scan_layout
from ncdc_hdl.neural.layouts import pixel_layout
from ncdc_model.geometry import SCAN

__all__ = ["Scan"]


class Scan(wiring.Component):
    """Every pixel (u, v) of the corrected image, rows top down, as normalised coordinates.

    Computes, on raw integers, by addition only::

        x = (origin_x + u step_x + half) >> shift      shift = 31 - input.f_bits
        y = (origin_y + v step_y + half) >> shift
        blank = u is in neither valid span of row v

    Equal bit for bit to ``ncdc_model.network.normalised_scan`` and ``ValidRows.mask``: the sums
    are exact, only the shift rounds. Timing: the outputs show one pixel while ``active``; the
    next one follows ``advance`` at once, also from row to row. ``start`` to ``active`` takes
    2 clocks, more while the host reads the table.

    Parameters
    ----------
    formats : ncdc_model.descriptor.Formats
        ``input`` is used.

    Members
    -------
    start : ``In(1)``
        Begins a frame; while ``active`` it must stay low.
    parameters : ``In(scan_layout())``
        Constant while ``active``.
    row, spans, fresh : ``Out``, ``In(SPANS)``, ``In(1)``
        To the table of valid rows.
    advance : ``In(1)``
        The pixel shown is taken.
    active, blank, first, last : ``Out(1)``
    pixel : ``Out(pixel_layout(formats))``
        x, y, and what the next pixel adds to them.
    """

    def __init__(self, formats):
        self.q = formats.input
        super().__init__({
            "start": In(1), "parameters": In(scan_layout()),
            "row": Out(SIZE), "spans": In(SPANS), "fresh": In(1),
            "advance": In(1),
            "active": Out(1), "pixel": Out(pixel_layout(formats)),
            "blank": Out(1), "first": Out(1), "last": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        p = self.parameters
        shift = SCAN.f_bits - self.q.f_bits
        half = 1 << (shift - 1)
        # The largest sum is 0.9999 + half a step of the input format: below one, it cannot wrap.
        sum_x, sum_y = Signal(signed(SCAN.width)), Signal(signed(SCAN.width))
        u, v = Signal(SIZE), Signal(SIZE)
        spans = Signal(SPANS)
        last_column, last_row = Signal(), Signal()
        next_x, next_y = Signal.like(sum_x), Signal.like(sum_y)
        pixel = self.pixel
        for total, following, step, x, x_step, x_carry in (
                (sum_x, next_x, p.step_x, pixel.x, pixel.x_step, pixel.x_carry),
                (sum_y, next_y, p.step_y, pixel.y, pixel.y_step, pixel.y_carry)):
            m.d.comb += [
                following.eq(total + step),
                x.eq(total >> shift), x_step.eq(step >> shift),
                # What the adder carried from the dropped bits into those that are kept.
                x_carry.eq((following ^ total ^ step)[shift]),
            ]
        m.d.comb += [
            pixel.last_column.eq(last_column),
            self.blank.eq(~((u >= spans.start0) & (u < spans.stop0)
                            | (u >= spans.start1) & (u < spans.stop1))),
            self.first.eq((u == 0) & (v == 0)),
            last_column.eq(u == p.width - 1),
            last_row.eq(v == p.height - 1),
            self.last.eq(last_column & last_row),
        ]

        def begin_row():
            return [spans.eq(self.spans), self.row.eq(self.row + 1),
                    u.eq(0), sum_x.eq(p.origin_x + half)]

        with m.FSM():
            with m.State("IDLE"):
                with m.If(self.start):
                    m.d.sync += [self.row.eq(0), v.eq(0), sum_y.eq(p.origin_y + half)]
                    m.next = "FETCH"
            with m.State("FETCH"):
                with m.If(self.fresh):
                    m.d.sync += begin_row()
                    m.next = "RUN"
            with m.State("RUN"):
                # The next row's spans have had a whole row's time to arrive; only the host
                # reading the table without a pause could hold them back.
                ready = ~last_column | last_row | self.fresh
                m.d.comb += self.active.eq(ready)
                with m.If(self.advance):
                    m.d.sync += [u.eq(u + 1), sum_x.eq(next_x)]
                    with m.If(last_column):
                        m.d.sync += [*begin_row(), v.eq(v + 1), sum_y.eq(next_y)]
                    with m.If(self.last):
                        m.next = "IDLE"
        return m
