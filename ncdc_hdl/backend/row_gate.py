"""Delays windows until the camera has written their rows."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.layouts import request_layout
from ncdc_hdl.frontend.layouts import SIZE
from ncdc_hdl.lib.groups import lanes_of
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.interpolation import FAST

__all__ = ["RowGate"]


class RowGate(wiring.Component):
    """Passes a group of windows once every row that the fetcher may read for it is written.

    A window ends in row y0 + 2, that of the gradient-corrected interpolation in y0 + 3, and a cache
    reads that row's whole tile of four rows, or two. A pixel passes if::

        blank  or  not follow  or  rows >= min(((y0 + 2) | 3) + 1, height)      fast
                                   rows >= min(((y0 + 3) | 1) + 1, height)      gradient

    with ``rows`` the largest ``camera_rows`` of this frame, the first one that of ``start``. Once
    the frame is complete the camera's counter may thus begin again. The same rule applies to a
    fetcher without tiles. All pixels of a group pass together.

    Timing: two stream stages (compare, pass), latency 2, one group per clock. A change of
    ``camera_rows`` takes effect after ``rows_latency`` clocks for a group that comes or waits in
    the first stage.

    Parameters
    ----------
    f_bits : int
        Fraction bits of the position in the window.
    lanes : int
        Pixels of a group.
    interpolation : Interpolation

    Members
    -------
    start : ``In(1)``
        First clock of a frame, of a list of views the first one's; its first group comes at least
        3 clocks later.
    follow : ``In(1)``
        Whether windows are delayed; constant during a frame.
    height : ``In(SIZE)``
        Rows of the distorted image, constant during a frame.
    abort : ``In(1)``
        Pixels that would have to wait pass as blank ones: the camera may have stopped.
    camera_rows : ``In(SIZE)``
        Rows of the frame, from the top, that are in memory.
    i, o : streams of ``request_layout(f_bits, lanes, interpolation)``
    """

    latency = 2
    rows_latency = 3
    """Clocks from a change of ``camera_rows`` to that of its comparison: the count, whether all
    rows are in memory, the limit."""

    def __init__(self, f_bits, lanes=1, interpolation=FAST):
        self.interpolation = interpolation
        super().__init__({
            "start": In(1), "follow": In(1), "height": In(SIZE), "abort": In(1),
            "camera_rows": In(SIZE),
            "i": In(stream.Signature(request_layout(f_bits, lanes, interpolation))),
            "o": Out(stream.Signature(request_layout(f_bits, lanes, interpolation))),
        })

    def elaborate(self, platform):
        m = Module()
        rows = Signal(SIZE)     # the largest ``camera_rows`` of this frame
        limit = Signal(SIZE)    # windows that start above it pass: one comparison with a register
        with m.If(self.start | (self.camera_rows > rows)):
            m.d.sync += rows.eq(self.camera_rows)
        height, after = self.interpolation.tile_height, self._after(self.interpolation)
        tiles = rows >> (height - 1).bit_length()
        unlimited = Signal()    # no window has to wait
        above = Signal(SIZE)    # the limit, unless it is that
        with m.If(self.start):
            m.d.sync += [unlimited.eq(0), above.eq(0), limit.eq(0)]
        with m.Else():
            m.d.sync += [
                unlimited.eq(~self.follow | (rows >= self.height)),
                above.eq(Mux(tiles <= after // height, 0, tiles * height - after)),
                limit.eq(Mux(unlimited, MAX_SIZE, above))]

        # C: a group, and its pixels that were too early a clock ago.
        c_valid = Signal()
        c = Signal.like(self.i.payload)
        early = Signal(len(lanes_of(c)))
        next_early = Signal.like(early)
        waits = Signal()        # one of them was too early
        leaves = Signal()       # the group in C leaves
        moves = ~c_valid | leaves
        # Synthesis does not merge a flag with its complement: `ready` is `moves`, but does not
        # begin where all bits of a group are moved.
        passes = Signal(init=1)         # complement of `waits`
        c_empty = Signal(init=1)        # complement of `c_valid`
        o_empty = Signal(init=1)        # complement of `o.valid`
        m.d.sync += [early.eq(next_early), waits.eq(next_early.any()), passes.eq(~next_early.any())]
        m.d.comb += [
            leaves.eq(c_valid & (~waits | self.abort) & (~self.o.valid | self.o.ready)),
            self.i.ready.eq(c_empty | ((passes | self.abort) & (o_empty | self.o.ready)))]
        with m.If(moves):
            m.d.sync += [c_valid.eq(self.i.valid), c_empty.eq(~self.i.valid),
                         c.eq(self.i.payload)]
        for k, (i, waiting) in enumerate(zip(lanes_of(self.i.p), lanes_of(c))):
            m.d.comb += next_early[k].eq(Mux(self.i.ready, ~i.blank & (i.y0 >= limit),
                                             early[k] & (waiting.y0 >= limit)))
        with m.If(~self.o.valid | self.o.ready):
            m.d.sync += [self.o.valid.eq(leaves), o_empty.eq(~leaves), self.o.payload.eq(c)]
            for k, o in enumerate(lanes_of(self.o.p)):
                m.d.sync += o.blank.eq(lanes_of(c)[k].blank | early[k])
        return m

    @staticmethod
    def _after(interpolation):
        """Rows of a window below y0.

        A method of its own only so that proofs and tests can open the gate a row early.
        """
        return interpolation.after
