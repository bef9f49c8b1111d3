"""From a parallel sensor's pins to entries of a queue, in the sensor's clock domain."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.grid import Grid
from ncdc_hdl.camera.layouts import (
    ENTRY,
    GRID,
    PINS,
    REPORT,
    SAMPLES,
    SETTINGS,
    SIZE_BITS,
    Kind,
)
from ncdc_hdl.camera.level import Level
from ncdc_hdl.lib.gains import BALANCE, NO_BALANCE, gain_of
from ncdc_hdl.lib.pipeline import delay, register

__all__ = ["SensorPort"]


class SensorPort(wiring.Component):
    """Captures the window of each frame that begins while it is enabled.

    A sample counts in each clock with both valid signals high. Every frame that begins is ended by
    an entry with its REPORT, with each fault. Faults are a row that is too short or too long, too
    few or too many of them, a full queue. After a full queue the frame's samples are
    dropped. Its end waits for space, and a frame that begins before there is space is missed and
    counted. Each row outside of the window leaves an entry without samples, which shows that the
    sensor's clock runs.

    With ``grid`` the window refers to the result of :func:`ncdc_spec.sensors.grid.gridded`;
    faults are those of the sensor's rows, as without ``grid``. A row longer than ``grid``
    is a fault if samples are moved or binned.

    Parameters
    ----------
    grid : int, optional
        Samples of the longest row that a sensor sends; by default samples are not moved.

    Members
    -------
    pins : ``In(PINS)``
    enable : ``In(1)``
    settings : ``In(SETTINGS)``
        Constant while ``active``.
    grid : ``In(GRID)``
        Likewise; only with ``grid``.
    balance : ``In(BALANCE)``
        May change at any time; each frame has the gains of its beginning.
    active : ``Out(1)``
        Enabled, or a frame is under way, or its end waits.
    entry, push : ``Out(ENTRY)``, ``Out(1)``
        Entry for the queue; it is written while ``push`` is high.
    space : ``In(1)``
        The queue takes an entry.
    """
    def __init__(self, grid=None):
        self.row = grid
        super().__init__({"pins": In(PINS), "enable": In(1), "settings": In(SETTINGS),
                          **({} if grid is None else {"grid": In(GRID)}),
                          "balance": In(BALANCE, init=NO_BALANCE), "active": Out(1),
                          "entry": Out(ENTRY), "push": Out(1), "space": In(1)})

    def elaborate(self, platform):
        m = Module()
        settings = self.settings
        # Pins have registers; a sample counts if both are valid.
        frame = register(m, "frame", self.pins.frame_valid, reset_less=False)
        line = register(m, "line", self.pins.line_valid & self.pins.frame_valid, reset_less=False)
        sample = register(m, "sample", self.pins.data)
        # A frame under way at the end of a reset is ignored.
        known = register(m, "known", Const(1), reset_less=False)
        enable, even = self.enable, None
        if self.row is not None:
            even = self._even(m, frame, line, sample)
            # Control signals get the same delay. A frame whose first samples came before `enable`,
            # when settings could change, is ignored.
            enable &= delay(m, enable, Grid.latency + 1 + Level.latency, "enable",
                            reset_less=False)
            frame, line, known = (delay(m, value, Grid.latency, name, reset_less=False)
                                  for name, value in (("frame", frame), ("line", line),
                                                      ("known", known)))
            sample = even.sample
        frame_before = register(m, "frame_before", frame, reset_less=False)
        line_before = register(m, "line_before", line, reset_less=False)
        begins, ends, row_ends = Signal(), Signal(), Signal()
        m.d.comb += [begins.eq(frame & ~frame_before & register(m, "was_known", known,
                                                                reset_less=False)),
                     ends.eq(~frame & frame_before), row_ends.eq(~line & line_before)]

        sent_x, sent_y = x, y = self._position(m, frame, line, row_ends)
        ended = register(m, "ended", row_ends, reset_less=False)
        if even is not None:
            # Position in the binned frame.
            x, y = (Mux(self.grid.binning, Cat(value[0] & value[1], value[2:]), value)
                    for value in (x, y))
        inside, row_last, outside = self._window(m, x, y, line, ended, even)

        # Bytes, and the control signals of their clock.
        m.submodules.level = level = Level()
        m.d.comb += [level.level.eq(settings.level), level.gain.eq(self._gain(m, x, y, frame)),
                     level.i.eq(delay(m, sample, 1, "sample"))]
        later = {name: delay(m, signal, level.latency, name, reset_less=False)
                 for name, signal in (("inside", inside), ("row_last", row_last),
                                      ("outside", outside))}
        later |= {name: delay(m, signal, 1 + level.latency, name, reset_less=False)
                  for name, signal in (("begins", begins), ("ends", ends))}
        wrong = sent_x != settings.sent_width
        if self.row is not None:
            wrong |= (sent_x > self.row) & self.grid.as_value().any()
        wrong_length = register(m, "wrong_length", wrong)
        wrong_line = delay(m, ended & wrong_length, level.latency, "wrong_line", reset_less=False)
        rows = sent_y + row_ends
        wrong_rows = delay(m, rows != settings.sent_height, 1 + level.latency, "wrong_rows")
        self._entries(m, level.o, later, enable, wrong_line, wrong_rows)
        return m

    @staticmethod
    def _position(m, frame, line, row_ends):
        """Column and row of the sample among those sent; counters stop at their largest value."""
        x, y = Signal(SIZE_BITS), Signal(SIZE_BITS)
        with m.If(line):
            m.d.sync += x.eq(x + ~x.all())
        with m.Else():
            m.d.sync += x.eq(0)
        # Before the frame begins: its first sample may come at once.
        with m.If(~frame):
            m.d.sync += y.eq(0)
        with m.Elif(row_ends):
            m.d.sync += y.eq(y + ~y.all())
        return x, y

    def _even(self, m, frame, line, sample):
        """The samples after the grid stage."""
        m.submodules.grid = grid = Grid(self.row)
        before = register(m, "line_sent", line, reset_less=False)
        m.d.comb += [grid.settings.eq(self.grid), grid.i.frame.eq(frame), grid.i.valid.eq(line),
                     grid.i.row_end.eq(before & ~line), grid.i.sample.eq(sample)]
        return grid.o

    def _gain(self, m, x, y, frame):
        """The gain of the sample of the clock before, at this position.

        An evened frame begins in the third column and row, which does not change the colours.
        """
        settings, balance = self.settings, Signal.like(self.balance, name="frame_balance")
        # Loaded between two frames. A frame's last sample still reads it a clock later.
        with m.If(~frame):
            m.d.sync += balance.eq(self.balance)
        red_column, red_row = (
            register(m, f"red_{name}", ~(position[0] ^ corner[0] ^ balance.phase[k]))
            for k, (name, position, corner) in enumerate((("column", x, settings.left),
                                                          ("row", y, settings.top))))
        return gain_of(balance, red_column, red_row)

    def _window(self, m, x, y, line, ended, even):
        """(The sample is in the window; a row of the window ends with it or after
        it, a clock later; a row of the sensor has ended outside of the window)."""
        settings, sent_ended = self.settings, ended
        left, top = settings.left, settings.top
        if even is not None:
            line = even.valid
            # An evened frame begins in the third column and row.
            ended = register(m, "even_ended", even.row_end, reset_less=False)
            begin = Mux(self.grid.weight.any(), 2, 0)
            left, top = register(m, "left", left + begin), register(m, "top", top + begin)
        right = register(m, "right", left + settings.width - 1)
        bottom = register(m, "bottom", top + settings.height)
        # Comparisons in one clock, their AND in the next.
        in_rows = register(m, "in_rows", (y >= top) & (y < bottom))
        beyond_left = register(m, "beyond_left", x >= left)
        before_end = register(m, "before_end", x <= right)
        at_end = register(m, "at_end", x == right)
        sent = register(m, "sent", line, reset_less=False)
        inside, row_last, outside = Signal(), Signal(), Signal()
        m.d.comb += [inside.eq(sent & in_rows & beyond_left & before_end),
                     # A row of the window may end before its last sample.
                     row_last.eq(in_rows & (sent & at_end | ended & before_end)),
                     outside.eq(sent_ended & ~in_rows)]
        return inside, row_last, outside

    def _entries(self, m, byte, now, enable, wrong_line, wrong_rows):
        """Collect bytes, push entries, and record faults."""
        capturing = Signal()            # a frame is under way whose BEGIN is in the queue
        full = Signal()                 # the queue was full in this frame
        owed = Signal()                 # the END of a frame waits for space
        report, lines, missed = Signal(REPORT), Signal(14), Signal(16)
        gathered = Signal(8 * (SAMPLES - 1))
        count = Signal(range(SAMPLES))  # bytes gathered
        taken = Signal()                # the byte is part of the frame
        complete = Signal()             # an entry of samples is complete
        begin = Signal()
        m.d.comb += [
            # The first sample may come in the clock in which the frame begins.
            taken.eq(now["inside"] & (capturing & ~full | begin)),
            complete.eq(capturing & ~full
                        & (now["inside"] & (count == SAMPLES - 1) | now["row_last"])),
            begin.eq(now["begins"] & enable & ~owed & self.space),
            self.active.eq(self.enable | capturing | owed),
        ]
        with m.If(complete):
            m.d.comb += [self.entry.kind.eq(Mux(now["row_last"], Kind.ROW_END, Kind.WORD)),
                         self.push.eq(self.space)]
            with m.Switch(count):
                for k in range(SAMPLES):
                    with m.Case(k):
                        m.d.comb += self.entry.data.eq(Cat(gathered[:8 * k], byte))
            m.d.sync += [count.eq(0), full.eq(~self.space)]
        with m.Else():
            with m.If(taken):
                m.d.sync += [count.eq(count + 1),
                             gathered.word_select(Mux(begin, 0, count), 8).eq(byte)]
            with m.If(begin):
                m.d.comb += [self.entry.kind.eq(Kind.BEGIN), self.push.eq(1)]
            with m.Elif(owed):
                m.d.comb += [self.entry.kind.eq(Kind.END), self.push.eq(self.space),
                             self.entry.data.eq(report)]
                with m.If(self.space):
                    m.d.sync += owed.eq(0)
            with m.Elif(now["outside"] & capturing & ~full):
                # Its loss does no harm: some of them are enough.
                m.d.comb += [self.entry.kind.eq(Kind.ALIVE), self.push.eq(self.space)]
        with m.If(capturing & wrong_line):
            m.d.sync += lines.eq(lines + ~lines.all())
        with m.If(now["begins"] & enable):
            # A row of one sample ends before there is a frame: the frame is bad.
            m.d.sync += [capturing.eq(begin), full.eq(0), count.eq(taken),
                         lines.eq(now["row_last"]),
                         missed.eq(missed + ~begin)]
        with m.Elif(now["ends"] & capturing):
            m.d.sync += [
                capturing.eq(0), owed.eq(1), report.rows.eq(wrong_rows),
                report.overflow.eq(self._overflow(full, complete & ~self.space)),
                report.lines.eq(lines + (wrong_line & ~lines.all())), report.missed.eq(missed),
            ]

    @staticmethod
    def _overflow(full, now):
        """Whether the queue was full in the frame, or is full in its last clock.

        A method of its own only so that proofs can break it.
        """
        return full | now
