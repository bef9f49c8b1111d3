"""From a stream of samples to entries of a queue, in the sensor's clock domain."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.camera.entry_packer import EntryPacker
from ncdc_hdl.camera.grid import Grid
from ncdc_hdl.camera.layouts import (
    ENTRY,
    GRID,
    REPORT,
    SETTINGS,
    SIZE_BITS,
    Kind,
)
from ncdc_hdl.camera.level import Level
from ncdc_hdl.camera.samples import samples
from ncdc_hdl.lib.gains import BALANCE, NO_BALANCE, gain_of
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.errors import InputError

__all__ = ["SensorPort"]


class SensorPort(wiring.Component):
    """Captures the window of each frame that begins while it is enabled.

    Every frame that begins is ended by an entry with its REPORT, with each fault. Faults are a row
    that is too short or too long, too few or too many of them, a full queue, and what the source
    reports. After a full queue the frame's samples are dropped. Its end waits for space, and a
    frame that begins before there is space is missed and counted. So is one that begins before
    the end of another one, which is bad then. Each row outside of the window leaves an entry
    without samples, which shows that the sensor's clock runs.

    With ``grid`` the window refers to the result of :func:`ncdc_spec.sensors.grid.gridded`;
    faults are those of the sensor's rows, as without ``grid``. A row longer than ``grid``
    is a fault if samples are moved or binned.

    Parameters
    ----------
    count : int
        Samples per clock: 1, 2 or 4.
    grid : int, optional
        Samples of the longest row that a sensor sends; by default samples are not moved.

    Members
    -------
    i : ``In(samples(count))``
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

    Raises
    ------
    InputError
        If there is a grid, and more than one sample per clock.
    """
    def __init__(self, count=1, grid=None):
        if grid is not None and count != 1:
            raise InputError(f"the grid stage takes 1 sample per clock, the camera has {count}")
        self.count, self.row = count, grid
        super().__init__({"i": In(samples(count)), "enable": In(1), "settings": In(SETTINGS),
                          **({} if grid is None else {"grid": In(GRID)}),
                          "balance": In(BALANCE, init=NO_BALANCE), "active": Out(1),
                          "entry": Out(ENTRY), "push": Out(1), "space": In(1)})

    def elaborate(self, platform):
        m = Module()
        settings = self.settings
        now = self._frames(m)
        enable = self.enable
        if self.row is not None:
            now, sample, shown, row_end = self._even(m, now)
            # A frame whose first samples came before `enable`, when settings could change, is
            # ignored.
            enable &= delay(m, enable, Grid.latency + 1 + Level.latency, "enable",
                            reset_less=False)
        else:
            sample, shown, row_end = self.i.sample, now["valid"], now["last"]
        group, y = self._position(m, now)
        later = {"wrong_line": delay(m, now["last"] & self._wrong_length(m, group, now["valid"]),
                                     1 + Level.latency, "wrong_line", reset_less=False),
                 "wrong_rows": delay(m, y + now["last"] != settings.sent_height,
                                     1 + Level.latency, "wrong_rows")}
        # With more samples per clock an entry may be complete with a frame's first ones: its
        # beginning comes a clock earlier.
        early = int(self.count > 1)
        later |= {name: delay(m, now[name], 1 + Level.latency, name, reset_less=False)
                  for name in ("lost", "end", "bad")}
        # Whether a frame counts is found a clock before: it decides about its first samples.
        begins = delay(m, now["begins"], Level.latency - early, "begins", reset_less=False)
        later["begins"] = register(m, "enabled_begins", begins & enable, reset_less=False)
        if self.row is not None:
            # Position in the binned frame.
            group, y = (Mux(self.grid.binning, Cat(value[0] & value[1], value[2:]), value)
                        for value in (group, y))
        x = [Cat(Const(k, exact_log2(self.count)), group) for k in range(self.count)]
        window = self._window(m, x, y, shown, row_end, now["last"])
        later |= {name: delay(m, signal, Level.latency, name, reset_less=False)
                  for name, signal in window.items()}
        levelled = []
        for k, gain in enumerate(self._gains(m, x, y, now["frame"])):
            m.submodules[f"level{k}"] = level = Level()
            m.d.comb += [level.level.eq(settings.level), level.gain.eq(gain),
                         level.i.eq(register(m, f"sample{k}", sample[k]))]
            levelled.append(level.o)
        self._entries(m, levelled, later, enable)
        return m

    def _frames(self, m):
        """What happens in a clock: the samples of ``i`` that are valid, the last ones of a row; a
        frame is there, begins, begins before the end of another one, ends, is bad."""
        i, under_way = self.i, Signal()
        with m.If(i.end):
            m.d.sync += under_way.eq(0)
        with m.Elif(i.first):
            m.d.sync += under_way.eq(1)
        return {"valid": i.valid, "last": i.last, "frame": i.first | under_way,
                "begins": i.first & ~under_way, "lost": i.first & under_way,
                "end": i.end, "bad": i.bad}

    def _even(self, m, now):
        """Signals of :meth:`_frames` after the grid stage; its samples, those that are valid, and
        that a row of them ends."""
        m.submodules.grid = grid = Grid(self.row)
        m.d.comb += [grid.settings.eq(self.grid), grid.i.frame.eq(now["frame"]),
                     grid.i.valid.eq(now["valid"]), grid.i.sample.eq(self.i.sample[0]),
                     grid.i.row_end.eq(now["last"])]
        now = {name: delay(m, value, Grid.latency + 1, name, reset_less=False)
               for name, value in now.items()}
        return (now, [register(m, "even_sample", grid.o.sample)],
                register(m, "even_valid", grid.o.valid, reset_less=False),
                register(m, "even_row_end", grid.o.row_end, reset_less=False))

    def _position(self, m, now):
        """Number of the clock of the row, and of the row, among those sent; counters stop at
        their largest value."""
        group, y = Signal(SIZE_BITS - exact_log2(self.count)), Signal(SIZE_BITS)
        with m.If(now["last"] | now["end"]):
            m.d.sync += group.eq(0)
        with m.Elif(now["valid"].any()):
            m.d.sync += group.eq(group + ~group.all())
        with m.If(now["end"]):
            m.d.sync += y.eq(0)
        with m.Elif(now["last"]):
            m.d.sync += y.eq(y + ~y.all())
        return group, y

    def _wrong_length(self, m, group, valid):
        """A row that ends with the samples of this clock has a wrong length."""
        part = exact_log2(self.count)
        end = register(m, "row_length", self.settings.sent_width - 1, SIZE_BITS)
        wrong = group != end[part:]
        if part:
            wrong |= valid != Cat(Const(1), *(end[:part] >= k for k in range(1, self.count)))
        if self.row is not None:
            wrong |= (group >= self.row) & self.grid.as_value().any()
        return wrong

    def _gains(self, m, x, y, frame):
        """The gain of each sample of the clock before, by its position.

        An evened frame begins in the third column and row, which does not change the colours.
        """
        settings, balance = self.settings, Signal.like(self.balance, name="frame_balance")
        # Loaded between two frames. A frame's last sample still reads it a clock later.
        with m.If(~frame):
            m.d.sync += balance.eq(self.balance)
        red_row = register(m, "red_row", ~(y[0] ^ settings.top[0] ^ balance.phase[1]))
        return [gain_of(balance, register(
            m, f"red_column{k}", ~(column[0] ^ settings.left[0] ^ balance.phase[0])), red_row)
            for k, column in enumerate(x)]

    def _window(self, m, x, y, shown, row_end, last):
        """Signals of the clock before: the samples in the window; a row of the window ends with
        them or before them; a row of the sensor has ended outside of the window."""
        settings, part = self.settings, exact_log2(self.count)
        left, top = settings.left, settings.top
        if self.row is not None:
            # An evened frame begins in the third column and row.
            begin = Mux(self.grid.weight.any(), 2, 0)
            left, top = register(m, "left", left + begin), register(m, "top", top + begin)
        right = register(m, "right", left + settings.width - 1)
        bottom = register(m, "bottom", top + settings.height)
        # Comparisons in one clock, their AND in the next.
        in_rows = register(m, "in_rows", (y >= top) & (y < bottom))
        beyond_left, before_end = (
            register(m, name, Cat(inside(column) for column in x))
            for name, inside in (("beyond_left", lambda column: column >= left),
                                 ("before_end", lambda column: column <= right)))
        at_end = register(m, "at_end", x[0][part:] == right[part:])
        sent = register(m, "sent", shown, reset_less=False)
        ended, sent_ended = (register(m, name, value, reset_less=False)
                             for name, value in (("ended", row_end), ("sent_ended", last)))
        return {"inside": sent & beyond_left & before_end & in_rows.replicate(self.count),
                # A row of the window may end before its last sample.
                "closes": in_rows & (sent.any() & at_end | ended & before_end[0]),
                "outside": sent_ended & ~in_rows}

    def _entries(self, m, levelled, now, enable):
        """Collect bytes, push entries, and record faults."""
        capturing = Signal()            # a frame is under way whose BEGIN is in the queue
        full = Signal()                 # the queue was full in this frame
        owed = Signal()                 # the END of a frame waits for space
        report, lines, missed = Signal(REPORT), Signal(REPORT["lines"].shape), Signal(16)
        begin = Signal()
        m.submodules.packer = packer = EntryPacker(self.count)
        going = capturing & ~full
        m.d.comb += [
            begin.eq(now["begins"] & ~capturing & ~owed & self.space),
            self.active.eq(self.enable | now["begins"] | capturing | owed),
            packer.data.eq(Cat(levelled)), packer.clear.eq(begin), packer.taken.eq(self.space),
            packer.turn.eq(self.settings.left[:exact_log2(self.count)]),
            # The first sample may come in the clock in which the frame begins.
            packer.inside.eq(now["inside"] & (going | begin).replicate(self.count)),
            packer.closes.eq(now["closes"] & going),
        ]
        with m.If(packer.valid):
            m.d.comb += [self.entry.kind.eq(Mux(packer.row_end, Kind.ROW_END, Kind.WORD)),
                         self.entry.data.eq(packer.o), self.push.eq(self.space)]
            m.d.sync += full.eq(~self.space)
        with m.Elif(begin):
            m.d.comb += [self.entry.kind.eq(Kind.BEGIN), self.push.eq(1)]
        with m.Elif(owed):
            m.d.comb += [self.entry.kind.eq(Kind.END), self.push.eq(self.space),
                         self.entry.data.eq(report)]
            with m.If(self.space):
                m.d.sync += owed.eq(0)
        with m.Elif(now["outside"] & going):
            # Its loss does no harm: some of them are enough.
            m.d.comb += [self.entry.kind.eq(Kind.ALIVE), self.push.eq(self.space)]
        overflow = self._overflow(full, packer.valid & ~self.space)
        # A row of one sample ends before there is a frame: the frame is bad.
        so_far = Mux(begin, now["closes"], lines)
        counted = so_far + (now["wrong_line"] & ~so_far.all())
        with m.If(begin):
            m.d.sync += [capturing.eq(1), full.eq(0)]
        with m.If(capturing | begin):
            m.d.sync += lines.eq(counted)
        with m.If(now["begins"] & ~begin | now["lost"] & enable):
            m.d.sync += missed.eq(missed + 1)
        # With more samples per clock an end in the clock of a beginning is the former frame's.
        with m.If((now["end"] | now["lost"]) & (capturing | (begin if self.count == 1 else 0))):
            m.d.sync += [
                capturing.eq(0), owed.eq(1), report.rows.eq(now["wrong_rows"]),
                report.overflow.eq(overflow), report.lines.eq(counted),
                report.missed.eq(missed), report.bad.eq(now["lost"] | now["bad"]),
            ]
        with m.Elif(owed & packer.valid & ~self.space):
            # The second entry of the last row is lost.
            m.d.sync += report.overflow.eq(1)

    @staticmethod
    def _overflow(full, now):
        """Whether the queue was full in the frame, or is full in its last clock.

        A method of its own only so that proofs can break it.
        """
        return full | now
