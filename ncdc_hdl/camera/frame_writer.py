"""From entries of a sensor's queue to words of a frame in memory, in buffers of a store."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.burst_writer import word_layout
from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.camera.layouts import ENTRY, REPORT, SAMPLES, SIZE_BITS, Kind
from ncdc_hdl.lib.pipeline import register

__all__ = ["COUNTS", "FrameWriter", "AREA"]

AREA = data.StructLayout({"base": ADDRESS_BITS, "limit": ADDRESS_BITS, "pitch": SIZE_BITS,
                           "width": SIZE_BITS, "height": SIZE_BITS})
"""Byte address of a frame, of the end of its area, and bytes from row to row, multiples of a
word; bytes of a row; rows."""

COUNTS = data.StructLayout({"lines": 32, "cut": 32, "overflows": 32, "missed": 32, "stopped": 32,
                            "bad": 32})
"""Counts since the reset: rows of a wrong length, frames with a wrong number of rows, frames whose
samples or beginning met a full queue, frames whose clock stopped, frames that the source reported
as bad."""


class FrameWriter(wiring.Component):
    """Writes each frame to its area, row by row, and reports whether it is good.

    Nothing is ever written outside the area: words of a row beyond ``width`` and rows
    beyond ``height`` or ``limit`` are dropped. A frame is over when the memory has taken its last
    word. It is good if its report is clean and each row had the right length, was in the area
    and no longer than the pitch. If no entry comes for
    ``limit`` clocks in a frame, its clock has stopped. The frame is over, and bad, and later
    entries of it are dropped.

    Parameters
    ----------
    data_width : int
        Bits of a word of the memory.

    Members
    -------
    i : ``In(stream.Signature(ENTRY))``
    area : ``In(AREA)``
        Valid from the clock after ``begins`` until ``ends``.
    limit : ``In(32)``
        Clocks without an entry, in a frame; 0: any number.
    begins, ends, good : ``Out(1)``, ``Out(1)``, ``Out(1)``
        High for one clock: a frame begins; it is over; it is good.
    o : ``Out(stream.Signature(word_layout(data_width)))``
        To a burst writer; each row's last word is an ``end`` and a ``last``.
    done : ``In(1)``
        The memory has taken the last word of one more row, in order.
    failed : ``In(1)``
        The memory has answered that a write of this frame failed: it is bad.
    rows : ``Out(SIZE_BITS)``
        Rows of the frame that are in memory.
    counts : ``Out(COUNTS)``
    """
    def __init__(self, data_width):
        self.data_width = data_width
        super().__init__({
            "i": In(stream.Signature(ENTRY)), "area": In(AREA), "limit": In(32),
            "begins": Out(1), "ends": Out(1), "good": Out(1),
            "o": Out(stream.Signature(word_layout(data_width))), "done": In(1), "failed": In(1),
            "rows": Out(SIZE_BITS), "counts": Out(COUNTS),
        })

    def elaborate(self, platform):
        m = Module()
        i, o, area = self.i, self.o, self.area
        report = data.View(REPORT, i.p.data)
        rows = Signal(SIZE_BITS)        # rows that have ended
        column = Signal(SIZE_BITS + 1)  # byte of the row at which the next entry begins
        closings = Signal(SIZE_BITS)    # last words of rows that were passed on
        wrong = Signal()                # a row had a wrong length
        clean = Signal()                # no fault is reported, and the clock did not stop
        idle = Signal(32)               # clocks without an entry
        word_space = Signal()           # a word may be passed on
        samples, row_end, frame_end, stopped, close = (Signal() for _ in range(5))
        row, fits, moved = Signal(ADDRESS_BITS), Signal(), Signal()     # see _address
        new = i.valid & (i.p.kind == Kind.BEGIN)        # a frame begins as soon as it is taken
        m.d.comb += [word_space.eq(~o.valid | o.ready), frame_end.eq(i.p.kind == Kind.END)]
        m.d.sync += [idle.eq(Mux(i.valid, 0, idle + 1)), self.rows.eq(self.rows + self.done)]
        with m.FSM():
            with m.State("BETWEEN"):
                m.d.comb += [i.ready.eq(1), self.begins.eq(new)]
                with m.If(self.begins):
                    m.d.sync += [rows.eq(0), self.rows.eq(0), closings.eq(0), wrong.eq(0)]
                    m.next = "AREA"
            with m.State("AREA"):
                m.next = "ROWS"
            with m.State("ROWS"):
                m.d.comb += [
                    i.ready.eq(word_space & ~new & ~moved),
                    samples.eq(i.valid & i.ready & (i.p.kind != Kind.ALIVE) & ~frame_end),
                    row_end.eq(i.p.kind == Kind.ROW_END),
                    stopped.eq((self.limit != 0) & (idle == self.limit)),
                ]
                with m.If(samples & row_end):
                    in_rows = rows < area.height
                    as_long = (column < area.width) & (column + SAMPLES >= area.width)
                    m.d.sync += [rows.eq(rows + ~rows.all()),
                                 wrong.eq(wrong | ~as_long | in_rows & ~fits)]
                # A frame interrupted by a reset has no end.
                with m.If(i.valid & i.ready & frame_end | new | stopped):
                    faults = Cat(report.rows, report.overflow, report.bad, report.lines)
                    m.d.sync += clean.eq(frame_end & ~stopped & ~faults.any())
                    m.next = "CLOSE"
            with m.State("CLOSE"):
                # A row that was begun is ended, for the bursts of the next frame.
                with m.If(word_space):
                    m.d.comb += close.eq(column != 0)
                    m.next = "WAIT"
            with m.State("WAIT"):
                with m.If(~o.valid & (self.rows == closings)):
                    m.d.comb += [self.ends.eq(1),
                                 self.good.eq(clean & ~wrong & (rows == area.height))]
                    m.next = "BETWEEN"
        with m.If(self.failed):
            m.d.sync += wrong.eq(1)
        last = samples & row_end & (rows < area.height) & fits | close
        self._words(m, samples & (rows < area.height) & fits, last, column, row)
        self._address(m, last, column, row, fits, moved)
        with m.If(last):
            m.d.sync += closings.eq(closings + 1)
        self._count(m, i.valid & i.ready & frame_end, report, stopped)
        return m

    def _address(self, m, last, column, row, fits, moved):
        """Address of the ``row`` of the next entry, and whether that ``fits`` the area;
        if it has just ``moved``, `fits` is not yet valid."""
        area, word_bits = self.area, exact_log2(self.data_width // 8)
        started = Signal()                          # the area of a new frame is known
        row_bytes = Signal(SIZE_BITS + 1)           # bytes of a row, in whole words
        end = Signal(ADDRESS_BITS + 1)              # end of the row in memory
        changed = Signal()                          # `row` is new
        whole = (area.width + (self.data_width // 8 - 1))[word_bits:]
        m.d.sync += [
            row_bytes.eq(Cat(Const(0, word_bits), whole)), end.eq(row + row_bytes),
            fits.eq((end <= area.limit) & (row_bytes <= area.pitch)),
            changed.eq(last | started),
        ]
        m.d.comb += moved.eq(changed | register(m, "changed_before", changed, reset_less=False))
        with m.If(last):
            m.d.sync += [column.eq(0), row.eq(row + area.pitch)]
        with m.If(self.begins):
            m.d.sync += [column.eq(0), started.eq(1)]
        with m.If(started):
            m.d.sync += [started.eq(0), row.eq(area.base)]

    def _words(self, m, samples, last, column, row):
        """Gather entries to words, each with its address."""
        i, o = self.i, self.o
        area = self.area
        entries = self.data_width // (8 * SAMPLES)
        word_bits, entry_bits = exact_log2(self.data_width // 8), exact_log2(SAMPLES)
        gathered, enable = Signal(self.data_width), Signal(entries)
        slot = Signal(range(max(2, entries)))
        inside, complete = Signal(), Signal()
        m.d.comb += [
            slot.eq(column[entry_bits:word_bits]),
            inside.eq(samples & (column < area.width)),
            complete.eq(inside & (slot == entries - 1) | last),
        ]
        word, enabled = Signal.like(gathered), Signal.like(enable)
        m.d.comb += [word.eq(gathered), enabled.eq(enable)]
        with m.If(inside):
            m.d.comb += [word.word_select(slot, 8 * SAMPLES).eq(i.p.data),
                         enabled.bit_select(slot, 1).eq(1)]
            m.d.sync += column.eq(column + SAMPLES)
        m.d.sync += [gathered.eq(word), enable.eq(Mux(complete, 0, enabled))]
        with m.If(o.ready):
            m.d.sync += o.valid.eq(0)
        with m.If(complete):
            begun = Cat(Const(0, word_bits), column[word_bits:])     # first byte of the word
            m.d.sync += [
                o.valid.eq(1), o.p.data.eq(word), o.p.address.eq(row + begun),
                o.p.enable.eq(Cat(bit.replicate(SAMPLES) for bit in enabled)),
                o.p.end.eq(last), o.p.last.eq(last), o.p.void.eq(~enabled.any()),
            ]

    def _count(self, m, ended, report, stopped):
        """Add the report at a frame's end to the counters."""
        counts, missed = self.counts, Signal(16)        # missed frames that are counted
        m.d.sync += counts.stopped.eq(counts.stopped + stopped)
        with m.If(ended):
            m.d.sync += [
                counts.lines.eq(counts.lines + report.lines),
                counts.cut.eq(counts.cut + report.rows),
                counts.overflows.eq(counts.overflows + report.overflow),
                counts.bad.eq(counts.bad + report.bad),
                counts.missed.eq(counts.missed + (report.missed - missed)[:16]),
                missed.eq(report.missed),
            ]
