"""From segments to commands: one carried out, the next one's row opened meanwhile."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_boards.sdram.banks import Banks
from ncdc_boards.sdram.layouts import command_layout
from ncdc_boards.sdram.upkeep import Upkeep
from ncdc_spec.errors import InputError

__all__ = ["Sequencer", "job_layout"]


def job_layout(place, tag_bits):
    """A segment to be read, or written, for whom ``tag`` tells."""
    return data.StructLayout(place.segment.members | {"write": 1, "tag": tag_bits})


class Sequencer(wiring.Component):
    """Carries segments out in their order, a word per ``place.beats`` clocks.

    Two segments are under way: of the first one words are read or written, for the second one a
    row is opened. Between the two no clock is lost if the row is open by then. Rows stay open until
    another one of the bank is asked for, or a refresh comes.

    Timing: a segment's first command is given ``latency`` clocks after it was taken, if its row is
    open and nobody is before it. A refresh comes at most ``period + delay`` clocks after the one
    before it.

    Parameters
    ----------
    place : Place
    clocks : Clocks
    tag_bits : int

    Members
    -------
    i : stream of segments with ``write`` and ``tag``
    command : ``Out(command_layout(place))``
        The command of this clock.
    tag : ``Out(tag_bits)``
        Whose word it reads or writes.
    ready : ``Out(1)``
        The memory is initialised.

    Raises
    ------
    InputError
        If bursts are so long that there is no time between refreshes.
    """

    latency = 3
    """Clocks: taken, looked up, moved to the first place."""

    def __init__(self, place, clocks, *, tag_bits):
        self.place, self.clocks, self.tag_bits = place, clocks, tag_bits
        self.banks = Banks(place, clocks)
        self.period = clocks.refresh - self.delay
        if self.period <= self.delay:
            raise InputError(f"max_burst is {place.max_burst}: two bursts and a refresh take up to "
                             f"{self.delay} clocks, the limit is half of the {clocks.refresh} "
                             "clocks between refreshes")
        self.upkeep = Upkeep(clocks, refreshes=place.chip.refreshes, period=self.period,
                             settle=max(self.banks.times.values()) + self.banks.times["rp"])
        self.job = job_layout(place, tag_bits)
        super().__init__({
            "i": In(stream.Signature(self.job)), "command": Out(command_layout(place)),
            "tag": Out(tag_bits), "ready": Out(1),
        })

    @property
    def segment_clocks(self):
        """Clocks that a segment takes at most, from its look-up to its last word's command.

        A row that was opened just now and has been written must be closed, another opened; the
        data of reads leave the bus; and the words. A command of the segment behind it may take a
        clock of each.
        """
        times = self.banks.times
        opening = (max(times["ras"], times["write_precharge"], times["read_precharge"])
                   + times["rp"] + max(times["rcd"], times["rrd"]))
        return opening + times["read_write"] + self.place.max_burst * times["column"] + 2

    @property
    def delay(self):
        """Clocks from a refresh being due to its command, at most.

        Two segments are under way; then all banks are closed. Three more are the registers from
        the timer to ``due``, to the second place, and back to ``quiet``.
        """
        times = self.banks.times
        closing = max(times["ras"], times["write_precharge"], times["read_precharge"])
        return 2 * self.segment_clocks + closing + times["rp"] + 3

    def elaborate(self, platform):
        m = Module()
        m.submodules.banks = banks = self.banks
        m.submodules.upkeep = upkeep = self.upkeep
        first_valid = Signal()              # there is a segment of which words are read or written
        second_valid = Signal()             # there is one behind it
        first = Signal(self.job)            # the first segment, without the words that are over
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
            upkeep.quiet.eq(~first_valid & ~second_valid), upkeep.idle.eq(banks.idle),
            upkeep.precharge_all_allowed.eq(banks.precharge_all_allowed),
            self.ready.eq(upkeep.ready), self.tag.eq(first.tag),
            self.i.ready.eq(self._may_begin(upkeep.due) & (~second_valid | moves)),
            moves.eq(prepared & (~first_valid | column & last_word)),
            self.command.precharge_all.eq(upkeep.precharge_all),
            self.command.refresh.eq(upkeep.refresh), self.command.mode.eq(upkeep.mode),
            self.command.read.eq(column & ~first.write),
            self.command.write.eq(column & first.write),
            self.command.bank.eq(Mux(rows, second.bank, first.bank)),
            self.command.row.eq(second.row), self.command.column.eq(first.column),
        ]
        self._prepare(m, second_valid & ~moves, (first_valid, first, second), prepared)
        m.d.comb += rows.eq(self.command.active | self.command.precharge)
        # A word of several clocks leaves room for both commands; one of a single clock does not,
        # and the row that is opened earlier makes up for it.
        if self.place.beats > 1:
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
        looked_up = Signal()        # its bank has been looked at
        to_close = Signal()         # its bank has another row open
        to_open = Signal()          # its row is not open
        other_bank = Signal()       # the first segment does not need what is closed
        rows_may = Signal()         # no word takes this clock's command
        m.d.comb += [
            prepared.eq(looked_up & ~to_close & ~to_open),
            other_bank.eq(~first_valid | (first.bank != second.bank)),
            rows_may.eq(1 if self.place.beats == 1 else ~(command.read | command.write)),
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
        """Whether another segment may be begun.

        A method of its own only so that proofs and tests can break it.
        """
        return ~due
