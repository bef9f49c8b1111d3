"""The gate that waits for the camera's rows: no window passes before its rows are in memory."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In

from formal.properties import always, constant, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_hdl.backend.layouts import request_layout
from ncdc_hdl.backend.row_gate import RowGate
from ncdc_hdl.frontend.layouts import SIZE
from ncdc_hdl.lib.groups import lanes_of
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.interpolation import FAST

__all__ = ["Rows"]


class Rows(Wrapper):
    """``RowGate`` with any requests, any counter, aborts and a consumer that stalls.

    Asserts, for any number of rows ``need``: a group that waits for so many passes only after the
    counter has shown them in this frame; payloads pass both stages unchanged, each once, but for
    pixels that an abort blanks; what is offered stays until it is taken. Without ``state`` nothing
    is said of the gate's own registers, which induction needs.
    """

    def __init__(self, lanes=1, state=True, needs=FAST):
        self.state, self.needs = state, needs
        self.dut = RowGate(1, lanes, needs)
        super().__init__({
            "start": In(1), "follow": In(1), "height": In(SIZE), "abort": In(1),
            "camera_rows": In(SIZE), "need": In(SIZE), "valid": In(1),
            "payload": In(request_layout(1, lanes, needs)), "ready": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        fragment = self.design(m, dut)
        rows, limit, c_valid, c, early, leaves = (
            inner(fragment, name) for name in ("rows", "limit", "c_valid", "c", "early", "leaves"))
        waiting = data.View(dut.i.p.shape(), c)
        m.d.comb += [
            dut.start.eq(self.start), dut.follow.eq(self.follow), dut.height.eq(self.height),
            dut.abort.eq(self.abort), dut.camera_rows.eq(self.camera_rows),
            dut.i.valid.eq(self.valid), dut.i.payload.eq(self.payload), dut.o.ready.eq(self.ready)]

        # Settings change with a start alone, at which nothing is under way; the first request
        # comes 3 clocks later or more, and waits until it is taken.
        before, later = Signal(14, reset_less=True), Signal(reset_less=True)
        settings = Cat(self.height, self.follow)
        started = Signal(2)
        m.d.sync += [before.eq(settings), later.eq(1), started.eq(Cat(self.start, started))]
        given(m, ~later | self.start | (settings == before))
        given(m, self.height <= MAX_SIZE)
        given(m, ~(self.start & (dut.o.valid | c_valid)))
        given(m, ~((self.start | started.any()) & self.valid))
        constant(m, self.need)

        # Whether the counter has shown `need` rows in this frame.
        shown = Signal()
        m.d.sync += shown.eq((self.camera_rows >= self.need) | (shown & ~self.start))
        if self.state:
            for name, flag in (("c_empty", c_valid), ("o_empty", dut.o.valid)):
                always(m, inner(fragment, name) == ~flag, name)
            always(m, (rows < self.need) | shown | (self.need == 0), "rows_are_shown")
            always(m, self.start | ~self.follow | (limit == 0) | Mux(
                limit == MAX_SIZE, rows >= self.height, rows >= limit + self.needs.after),
                "limit_is_of_rows")
            always(m, ~started[0] | (limit == 0), "limit_starts_anew")
        def shown_for(lane, there):
            last = (lane.y0 + self.needs.after) | (self.needs.tile_height - 1)
            needs = Mux(last + 1 < self.height, last + 1, self.height)
            return (~(there & self.follow & ~lane.blank & (needs == self.need))
                    | shown | (self.need == 0))
        for k, lane in enumerate(lanes_of(dut.o.p)):
            always(m, shown_for(lane, dut.o.valid), f"row_is_there{k}")
        if self.state:
            for k, lane in enumerate(lanes_of(waiting)):
                always(m, shown_for(lane, c_valid & ~early[k]), f"row_was_there{k}")

        self._unchanged(m, waiting, c_valid, leaves)
        taken, aborted = Signal(), Signal()
        m.d.sync += [taken.eq(leaves), aborted.eq(self.abort)]
        reached(m, self.follow & taken & ~aborted & (Value.cast(dut.o.payload) != 0)
                & (limit != MAX_SIZE), "passes_below_the_end")
        reached(m, self.follow & dut.i.valid & ~dut.i.ready & ~dut.o.valid, "waits")
        return m

    def _unchanged(self, m, waiting, c_valid, leaves):
        """From ``i`` to the first stage, and from there to ``o``."""
        dut = self.dut
        before, came = Signal.like(self.payload), Signal()
        was, had, left = Signal.like(self.payload), Signal(), Signal()
        offered, held, aborted = Signal.like(self.payload), Signal(), Signal()
        m.d.sync += [
            before.eq(self.payload), came.eq(dut.i.valid & dut.i.ready),
            was.eq(waiting), had.eq(c_valid), left.eq(leaves),
            offered.eq(dut.o.payload), held.eq(dut.o.valid & ~self.ready), aborted.eq(self.abort)]
        always(m, ~leaves | (c_valid & (~dut.o.valid | self.ready)), "nothing_over_it")
        always(m, ~(dut.i.valid & dut.i.ready) | ~c_valid | leaves, "nothing_over_what_waits")
        always(m, c_valid == (came | (had & ~left)), "comes_once")
        always(m, ~c_valid | (waiting.as_value() == Mux(came, before.as_value(), was.as_value())),
               "comes_unchanged")
        always(m, dut.o.valid == (held | left), "passes_once")
        expected = Signal.like(self.payload)
        m.d.comb += expected.eq(Mux(held, offered.as_value(), was.as_value()))
        with m.If(aborted & ~held):
            for lane, out in zip(lanes_of(expected), lanes_of(dut.o.p)):
                m.d.comb += lane.blank.eq(out.blank)
        always(m, ~dut.o.valid | (dut.o.payload.as_value() == expected.as_value()),
               "passes_unchanged")
