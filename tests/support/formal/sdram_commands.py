"""The SDRAM controller's commands: rows, the data sheet's times, refreshes in time."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In

from formal.properties import always, given, inner, reached
from formal.sdram_hosts import CHIP
from formal.wrapper import Wrapper
from ncdc_boards.sdram.chips import clocks_of
from ncdc_boards.sdram.layouts import AddressMapping
from ncdc_boards.sdram.sequencer import Sequencer

__all__ = ["Commands"]


class Commands(Wrapper):
    """``Sequencer`` with any segments, offered when the hosts like, reset at any time.

    An observer keeps account of the commands on its own, by the data sheet's rules. Asserts that
    words are read and written in the segments' order, each in the row asked for; that no command
    breaks a time; that a refresh that is due comes within ``longest`` clocks, less than the
    design's own bound, and so that no two are further apart than the chip allows; None: nothing of
    that. ``banks`` and ``kind`` make the design's parts, ``period`` its time between refreshes.
    """

    def __init__(self, data_width=8, max_burst=1, longest=22, *, kind=Sequencer, banks=None,
                 period=None):
        self.mapping = AddressMapping(CHIP, data_width, max_burst)
        self.clocks = clocks_of(CHIP, 1e9)
        self.dut = kind(self.mapping, self.clocks, tag_bits=1)
        assert longest is None or longest < self.dut.delay
        if banks:
            self.dut.banks = banks(self.mapping, self.clocks)
        if period:
            self.dut.init_refresh.period = period
        self.longest = longest
        super().__init__({"valid": In(1), "job": In(self.dut.job)})

    def elaborate(self, platform):
        m = Module()
        dut, mapping = self.dut, self.mapping
        fragment = self.design(m, dut)
        job, command = self.job, dut.command
        given(m, (job.words != 0) & (job.words <= mapping.max_burst)
              & (job.column + job.words <= 1 << mapping.column_bits))
        m.d.comb += [dut.i.valid.eq(self.valid), dut.i.payload.eq(job)]
        self._segments(m, fragment)
        self._rows_and_times(m, fragment)
        self._states(m, fragment)
        if self.longest:
            self._refreshes(m, fragment)
        names = ("active", "precharge", "precharge_all", "read", "write", "refresh", "mode")
        given_now = Cat(command[name] for name in names)
        always(m, (given_now & (given_now - 1)) == 0, "one_command")
        return m

    def _segments(self, m, fragment):
        """Words come in the segments' order: the observer keeps the two under way."""
        dut, command = self.dut, self.dut.command
        first = Signal(dut.job)
        second = Signal(dut.job)
        count = Signal(2)                   # segments under way
        taken, word, over = dut.i.valid & dut.i.ready, Signal(), Signal()
        m.d.comb += [word.eq(command.read | command.write), over.eq(word & (first.words == 1))]
        m.d.sync += count.eq(count + taken - over)
        with m.If(over):
            m.d.sync += first.eq(Mux(count == 2, second.as_value(), self.job.as_value()))
        with m.Elif(word):
            m.d.sync += [first.column.eq(first.column + 1), first.words.eq(first.words - 1)]
        with m.Elif(taken & (count == 0)):
            m.d.sync += first.eq(self.job)
        with m.If(taken):
            m.d.sync += second.eq(self.job)
        always(m, ~word | (count != 0) & (command.column == first.column)
               & (command.bank == first.bank) & (command.write == first.write)
               & (dut.tag == first.tag), "word_in_turn")
        self.word_row = first.row
        inside_first, inside_second = (data.View(dut.job, inner(fragment, name))
                                       for name in ("first", "second"))
        first_valid, second_valid = (inner(fragment, f"{name}_valid")
                                     for name in ("first", "second"))
        last_word, one_word = inner(fragment, "last_word"), inner(fragment, "one_word")
        always(m, count == first_valid + second_valid, "under_way")
        always(m, ~first_valid | (inside_first.as_value() == first.as_value()), "first")
        next_one = Mux(first_valid, second.as_value(), first.as_value())
        always(m, ~second_valid | (inside_second.as_value() == next_one), "second")
        always(m, ~first_valid | (last_word == (inside_first.words == 1)), "last_word")
        always(m, ~second_valid | (one_word == (inside_second.words == 1)), "one_word")
        for name, valid, each in (("first", first_valid, inside_first),
                                  ("second", second_valid, inside_second)):
            always(m, ~valid | (each.words != 0) & (each.words <= self.mapping.max_burst),
                   f"words_of_{name}")
        reached(m, over & (count == 2) & (first.bank == second.bank) & (first.row != second.row),
                "next_row_of_the_bank")

    def _rows_and_times(self, m, fragment):
        """Each word in its row; no command before its time."""
        command, clocks, mapping = self.dut.command, self.clocks, self.mapping
        beats, word = mapping.beats, command.read | command.write
        since_other = {name: _since(m, given, name, clocks.cas + beats + 1) for name, given in
                       (("read", command.read), ("write", command.write),
                        ("refresh", command.refresh), ("mode", command.mode))}
        opened = inner(fragment, "banks", "opened")
        actives = []
        for k in range(4):
            rows = inner(fragment, "banks", f"row{k}")
            busy = inner(fragment, "banks", f"busy{k}")
            held = inner(fragment, "banks", f"held{k}")
            here = command.bank == k
            row, is_open = Signal(mapping.chip.row_bits, name=f"seen{k}"), Signal(name=f"open{k}")
            active, closes = command.active & here, command.precharge & here | command.precharge_all
            with m.If(active):
                m.d.sync += [row.eq(command.row), is_open.eq(1)]
            with m.If(closes):
                m.d.sync += is_open.eq(0)
            always(m, (is_open == opened[k]) & (~is_open | (row == rows)), f"account{k}")
            always(m, ~(word & here) | is_open & (row == self.word_row), f"own_row{k}")
            always(m, ~active | ~is_open, f"closed_first{k}")
            always(m, ~(command.refresh | command.mode) | ~is_open, f"all_closed{k}")
            since = {"active": _since(m, active, f"active{k}", clocks.rc),
                     "precharge": _since(m, closes, f"precharge{k}", clocks.rp),
                     "read": _since(m, command.read & here, f"read{k}", beats),
                     "write": _since(m, command.write & here, f"write{k}", beats - 1 + clocks.wr)}
            actives.append(since["active"])
            rules = [("rcd", word & here, since["active"], clocks.rcd, busy),
                     ("rp", active | command.refresh | command.mode, since["precharge"], clocks.rp,
                      busy),
                     ("rfc", active | command.refresh | command.mode, since_other["refresh"],
                      clocks.rfc, busy),
                     ("mrd", active | command.refresh | command.mode, since_other["mode"],
                      clocks.mrd, busy),
                     ("ras", closes & is_open, since["active"], clocks.ras, held),
                     ("wr", closes & is_open, since["write"], beats - 1 + clocks.wr, held),
                     ("cut", closes & is_open, since["read"], beats, held)]
            for name, now, age, least, wait in rules:
                always(m, ~now | (age >= least), f"{name}{k}")
                always(m, _covers(wait, age, least), f"{name}_met{k}")
            always(m, ~active | (since["active"] >= clocks.rc), f"rc{k}")
            always(m, is_open | (since["active"] >= clocks.rc) | (
                since["active"] >= self.dut.banks.times["ras"] + since["precharge"]), f"rc_met{k}")
            always(m, _covers(held, since["active"], self.dut.banks.times["ras"]), f"long_ras{k}")
        another = inner(fragment, "banks", "another")
        for k, age in enumerate(actives):
            always(m, ~command.active | (command.bank == k) | (age >= clocks.rrd), f"rrd{k}")
            always(m, _covers(another, age, clocks.rrd), f"rrd_met{k}")
        for name, now, before, least, wait in (
                ("turn", command.write, "read", clocks.cas + beats + 1, "write_waits"),
                ("reads", command.read, "read", beats, "read_waits"),
                ("writes", command.write, "write", beats, "write_waits"),
                ("write_read", command.read, "write", beats, "read_waits")):
            always(m, ~now | (since_other[before] >= least), name)
            if least > 1:
                always(m, _covers(inner(fragment, "banks", wait), since_other[before], least),
                       f"{name}_met")
        self._prepared(m, fragment, opened)

    def _prepared(self, m, fragment, opened):
        """What the design knows of the rows of its two segments."""
        first_valid, second_valid = (inner(fragment, f"{name}_valid")
                                     for name in ("first", "second"))
        first, second = (data.View(self.dut.job, inner(fragment, name))
                         for name in ("first", "second"))
        looked_up, to_close, to_open = (inner(fragment, name)
                                        for name in ("looked_up", "to_close", "to_open"))
        rows = Array(inner(fragment, "banks", f"row{k}") for k in range(4))
        is_open = Array(opened[k] for k in range(4))
        always(m, ~first_valid | is_open[first.bank] & (rows[first.bank] == first.row), "first_row")
        always(m, ~looked_up | second_valid, "looked_up")
        always(m, looked_up | ~to_close & ~to_open, "nothing_to_do")
        always(m, ~looked_up | Mux(
            to_open, to_close == is_open[second.bank],
            ~to_close & is_open[second.bank] & (rows[second.bank] == second.row)), "prepared")

    def _states(self, m, fragment):
        """No segment is read or written while the memory is refreshed or initialised."""
        dut = self.dut
        state = inner(fragment, "init_refresh", "fsm_state")
        pause, precharge, refresh, run, mode = range(5)     # as the design first names them
        always(m, Mux(dut.ready, (state == precharge) | (state == refresh) | (state == run),
                      (state == pause) | (state == precharge) | (state == refresh)
                      | (state == mode)), "states")
        alone = (state == refresh) | (state == mode)
        none = ~inner(fragment, "first_valid") & ~inner(fragment, "second_valid")
        always(m, ~alone | none & (inner(fragment, "banks", "opened") == 0), "alone")
        always(m, dut.ready | none, "none_before")

    def _refreshes(self, m, fragment):
        """A refresh within its time, counted from the one before it or the initialisation."""
        dut, command, period = self.dut, self.dut.command, self.dut.init_refresh.period
        timer, over = (inner(fragment, "init_refresh", name) for name in ("timer", "over"))
        most = self.clocks.refresh
        since = Signal(range(most + 2))     # clocks without a refresh
        age = Signal(range(most + 2))       # clocks for which one has been due
        with m.If(command.refresh | ~dut.ready):
            m.d.sync += since.eq(0)
        with m.Elif(since <= most):
            m.d.sync += since.eq(since + 1)
        due = Signal()
        m.d.comb += due.eq(dut.ready & dut.init_refresh.due)
        with m.If(~due | command.refresh):
            m.d.sync += age.eq(0)
        with m.Elif(age <= most):
            m.d.sync += age.eq(age + 1)
        always(m, since < most, "refresh_in_time")
        always(m, age <= self.longest, "due_no_longer")
        always(m, over == (timer == 0), "timer_over")
        always(m, ~dut.ready | (inner(fragment, "init_refresh", "more") == 1), "one_refresh")
        always(m, ~dut.ready | (timer < period), "timer_from")
        always(m, ~dut.ready | due | (since + timer <= period) & (age == 0), "timer_since")
        always(m, ~due | (timer + age == period - 1) & (since <= period + 1 + age), "timer_due")
        reached(m, command.refresh & (age > 0), "refresh")


def _since(m, event, name, most):
    """Clocks since the event, 1 in the clock after it, and ``most`` if it is longer ago."""
    since = Signal(range(most + 1), name=f"since_{name}", init=most)
    with m.If(event):
        m.d.sync += since.eq(1)
    with m.Elif(since != most):
        m.d.sync += since.eq(since + 1)
    always(m, (since != 0) & (since <= most), f"counted_{name}")
    return since


def _covers(wait, age, least):
    """Whether the shift register has a one for each clock that the rule still wants waited."""
    holds = Const(1)
    for clocks in range(1, least):
        ones = (1 << least - clocks) - 1
        holds = holds & ((age != clocks) | ((wait & ones) == ones))
    return holds
