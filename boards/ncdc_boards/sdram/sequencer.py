"""From segments to commands: carries one out while it opens the next one's row."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_boards.sdram.banks import Banks
from ncdc_boards.sdram.init_refresh import InitRefresh
from ncdc_boards.sdram.layouts import command_layout
from ncdc_spec.errors import InputError

__all__ = ["Sequencer", "job_layout"]


def job_layout(mapping, tag_bits):
    """A segment to be read or written for the host ``tag``."""
    return data.StructLayout(mapping.segment.members | {"write": 1, "tag": tag_bits})


class Sequencer(wiring.Component):
    """Carries segments out in order, a word per ``mapping.beats`` clocks.

    Two segments are under way: words of the first one are read or written, a row for the second
    one is opened. No clock is lost between the two if the row is open by then. Rows stay open until
    another row of the bank is needed, or a refresh comes.

    Timing: a segment's first command is given ``latency`` clocks after it was taken, if its row is
    open and no other is before it. A refresh comes at most ``period + delay`` clocks after the one
    before it.

    Parameters
    ----------
    mapping : AddressMapping
    clocks : SdramTiming
    tag_bits : int

    Members
    -------
    i : stream of segments with ``write`` and ``tag``
    command : ``Out(command_layout(mapping))``
        The command of this clock.
    tag : ``Out(tag_bits)``
        Host of the word that it reads or writes.
    ready : ``Out(1)``
        The memory is initialised.

    Raises
    ------
    InputError
        If bursts are too long for the time between refreshes.
    """

    latency = 3
    """Clocks: taken, looked up, moved to the first position."""

    def __init__(self, mapping, clocks, *, tag_bits):
        self.mapping, self.clocks, self.tag_bits = mapping, clocks, tag_bits
        self.banks = Banks(mapping, clocks)
        self.period = clocks.refresh - self.delay
        if self.period <= self.delay:
            raise InputError(f"max_burst is {mapping.max_burst}: two bursts and a refresh take up "
                             f"to {self.delay} clocks, the limit is half of the {clocks.refresh} "
                             "clocks between refreshes")
        self.init_refresh = InitRefresh(
            clocks, refreshes=mapping.chip.refreshes, period=self.period,
            settle=max(self.banks.times.values()) + self.banks.times["rp"])
        self.job = job_layout(mapping, tag_bits)
        super().__init__({
            "i": In(stream.Signature(self.job)), "command": Out(command_layout(mapping)),
            "tag": Out(tag_bits), "ready": Out(1),
        })

    @property
    def segment_clocks(self):
        """Most clocks that a segment takes, from its look-up to its last word's command.

        A row that was just opened and written must be closed, another opened. Then the
        data of reads leave the bus, and the words come. A command of the next segment may take a
        clock for each.
        """
        times = self.banks.times
        opening = (max(times["ras"], times["write_precharge"], times["read_precharge"])
                   + times["rp"] + max(times["rcd"], times["rrd"]))
        return opening + times["read_write"] + self.mapping.max_burst * times["column"] + 2

    @property
    def delay(self):
        """Most clocks from a refresh being due to its command.

        Two segments are under way; then all banks are closed. Three more clocks are registers, from
        the timer to ``due``, to the second position, and back to ``quiet``.
        """
        times = self.banks.times
        closing = max(times["ras"], times["write_precharge"], times["read_precharge"])
        return 2 * self.segment_clocks + closing + times["rp"] + 3

    def elaborate(self, platform):
        m = Module()
        m.submodules.banks = banks = self.banks
        m.submodules.init_refresh = init_refresh = self.init_refresh
        first_valid = Signal()              # there is a segment of which words are read or written
        second_valid = Signal()             # there is a second segment
        first = Signal(self.job)            # the first segment, without the words already done
        second = Signal(self.job)
        last_word = Signal()                # the first segment has one word left
        one_word = Signal()                 # the second segment has one word
        column = Signal()                   # a word of the first segment is read or written
        rows = Signal()                     # a row is closed or opened for the second one
        prepared = Signal()                 # the second segment's row is open, or opening
        moves = Signal()                    # the second segment becomes the first
        m.d.comb += [
            banks.command.eq(self.command), banks.bank.eq(second.bank), banks.row.eq(second.row),
            banks.column_bank.eq(first.bank), banks.column_write.eq(first.write),
            init_refresh.quiet.eq(~first_valid & ~second_valid), init_refresh.idle.eq(banks.idle),
            init_refresh.precharge_all_allowed.eq(banks.precharge_all_allowed),
            self.ready.eq(init_refresh.ready), self.tag.eq(first.tag),
            self.i.ready.eq(self._may_begin(init_refresh.due) & (~second_valid | moves)),
            moves.eq(prepared & (~first_valid | column & last_word)),
            self.command.precharge_all.eq(init_refresh.precharge_all),
            self.command.refresh.eq(init_refresh.refresh), self.command.mode.eq(init_refresh.mode),
            self.command.read.eq(column & ~first.write),
            self.command.write.eq(column & first.write),
            self.command.bank.eq(Mux(rows, second.bank, first.bank)),
            self.command.row.eq(second.row), self.command.column.eq(first.column),
        ]
        self._prepare(m, second_valid & ~moves, (first_valid, first, second), prepared)
        m.d.comb += rows.eq(self.command.active | self.command.precharge)
        # A word of several clocks has time for both commands. A word of one clock has not,
        # and the row that is opened earlier compensates for it.
        if self.mapping.beats > 1:
            m.d.comb += column.eq(first_valid & banks.column_allowed)
        else:
            m.d.comb += column.eq(first_valid & banks.column_allowed & ~rows)
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [second_valid.eq(1), second.eq(self.i.p), one_word.eq(self.i.p.words == 1)]
        with m.Elif(moves):
            m.d.sync += second_valid.eq(0)
        with m.If(moves):
            m.d.sync += [first_valid.eq(1), first.eq(second), last_word.eq(one_word)]
        with m.Elif(column):
            m.d.sync += [first.column.eq(first.column + 1), first.words.eq(first.words - 1),
                         last_word.eq(first.words == 2), first_valid.eq(~last_word)]
        return m

    def _prepare(self, m, stays, segments, prepared):
        """Look the second segment's row up, close the one that is open, and open its own."""
        banks, command = self.banks, self.command
        first_valid, first, second = segments
        looked_up = Signal()        # its bank has been read
        to_close = Signal()         # its bank has another row open
        to_open = Signal()          # its row is not open
        other_bank = Signal()       # the first segment does not need what is closed
        rows_may = Signal()         # no READ or WRITE is this clock's command
        m.d.comb += [
            prepared.eq(looked_up & ~to_close & ~to_open),
            other_bank.eq(~first_valid | (first.bank != second.bank)),
            rows_may.eq(1 if self.mapping.beats == 1 else ~(command.read | command.write)),
            command.precharge.eq(to_close & other_bank & banks.precharge_allowed & rows_may),
            command.active.eq(to_open & ~to_close & banks.active_allowed & rows_may),
        ]
        with m.If(~stays):
            m.d.sync += [looked_up.eq(0), to_close.eq(0), to_open.eq(0)]
        with m.Elif(~looked_up):
            m.d.sync += [looked_up.eq(1), to_close.eq(banks.is_open & banks.is_other),
                         to_open.eq(~banks.is_open | banks.is_other)]
        with m.Else():
            with m.If(command.precharge):
                m.d.sync += to_close.eq(0)
            with m.If(command.active):
                m.d.sync += to_open.eq(0)

    @staticmethod
    def _may_begin(due):
        """Whether another segment may begin.

        A method of its own only so that proofs and tests can break it.
        """
        return ~due
