"""Avalon-MM read and write hosts: what they may do, with any memory."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In

from formal.properties import always, given, inner, reached
from formal.queue_state import entries
from formal.wrapper import Wrapper
from ncdc_hdl.avalon.burst_reader import BurstReader
from ncdc_hdl.avalon.burst_writer import BurstWriter, word_layout
from ncdc_hdl.avalon.read_commands import ReadCommands, command_layout

__all__ = ["Commands", "MEMORY", "Reader", "Writer", "check_read_host", "taken_away"]

MEMORY = {"waitrequest": In(1), "readdatavalid": In(1), "memory_rst": In(1)}
"""Inputs of a wrapper that has a memory with a read port."""


def taken_away(m, memory_rst, loses):
    """Whether a reset of the memory took away what the design waits for, until its own reset.

    ``loses``: there is something to be taken away in this clock. The two resets overlap: that of
    the memory is not over before that of the design begins.
    """
    lost = Signal()
    with m.If(memory_rst & loses):
        m.d.sync += lost.eq(1)
    given(m, ~lost | memory_rst)
    return lost


def check_read_host(m, bus, memory, *, limit):
    """Connect a memory that waits and answers when it likes, and check what it is asked.

    Resets of the design take nothing back. A reset of the memory, which the inputs of the wrapper
    ``memory`` say as well, does; while it lasts it may answer anything. Returns the number of
    words that the memory owes.
    """
    owed = Signal(range(2 * limit + 1), reset_less=True)
    waitrequest, readdatavalid = memory.waitrequest, memory.readdatavalid
    accepted = bus.read & ~waitrequest
    given(m, ~readdatavalid | (owed != 0) | memory.memory_rst)
    m.d.comb += [bus.waitrequest.eq(waitrequest), bus.readdatavalid.eq(readdatavalid)]
    m.d.sync += owed.eq(Mux(memory.memory_rst, 0,
                            owed + Mux(accepted, bus.burstcount, 0) - readdatavalid))

    held = Signal(reset_less=True)
    command = Signal(len(bus.address) + len(bus.burstcount), reset_less=True)
    m.d.sync += [held.eq(bus.read & waitrequest & ~memory.memory_rst),
                 command.eq(Cat(bus.address, bus.burstcount))]
    always(m, ~held | (bus.read & (command == Cat(bus.address, bus.burstcount))),
                   "command_held")
    always(m, ~bus.read | (bus.burstcount != 0), "burst_not_empty")
    always(m, owed <= limit, "words_owed")
    return owed


class Commands(Wrapper):
    """``ReadCommands`` given commands as its limit allows, and reset at any time, with the memory
    or without it.

    Asserts the protocol; that exactly the words asked for since the reset are handed on; that
    none asked for before is; that commands are taken again once nothing is owed. ``forget`` leaves
    ``waitrequest`` unseen by the design, ``deaf`` its memory's reset.
    """

    BURST, LIMIT = 3, 6

    def __init__(self, kind=ReadCommands, forget=False, deaf=False):
        self.forget, self.deaf = forget, deaf
        self.dut = kind(8, self.BURST, limit=self.LIMIT)
        super().__init__({"valid": In(1), "command": In(command_layout(self.BURST))} | MEMORY)

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        fragment = self.design(m, dut)
        owed = check_read_host(m, dut.bus, self, limit=self.LIMIT)
        m.d.comb += dut.memory_rst.eq(0 if self.deaf else self.memory_rst)
        if self.forget:
            m.d.comb += dut.bus.waitrequest.eq(0)
        # Words asked for since the reset and not yet come; of a standing command as well.
        fresh = Signal(range(2 * self.LIMIT + 1))
        taken = dut.i.valid & dut.i.ready
        m.d.comb += [dut.i.valid.eq(self.valid), dut.i.payload.eq(self.command)]
        m.d.sync += fresh.eq(fresh + Mux(taken, self.command.words, 0) - dut.valid)
        given(m, ~self.valid | ((self.command.words != 0)
                                     & (fresh + self.command.words <= self.LIMIT)))
        lost = taken_away(m, self.memory_rst, (fresh != 0) | taken)
        read, words = dut.bus.read, dut.bus.burstcount
        due, some, stale = (inner(fragment, name) for name in ("due", "some", "stale"))
        always(m, (due == owed) & (some == (due != 0)), "owed_is_known")
        always(m, owed + Mux(read, words, 0) <= self.LIMIT, "space_for_command")
        always(m, ~read | (words != 0), "words")
        always(m, lost | Mux(stale, fresh == 0, fresh == owed + Mux(read, words, 0)), "fresh")
        always(m, lost | ~dut.valid | (fresh != 0), "asked_for")
        always(m, stale | self.memory_rst | (dut.valid == self.readdatavalid), "all_handed_on")
        # Nothing is owed and no reset comes: the next command is taken in the next clock.
        quiet = Signal(reset_less=True)
        m.d.sync += quiet.eq(~ResetSignal() & ~self.memory_rst & ~read & (owed == 0))
        always(m, ~quiet | read | dut.i.ready, "never_locked_up")
        reached(m, dut.valid & (owed == self.LIMIT), "full")
        reached(m, stale & self.readdatavalid & (owed > 1), "dropped")
        forgot = Signal(reset_less=True)    # the memory forgot words, and a command that it held
        with m.If(self.memory_rst & (owed > 1) & read & self.waitrequest):
            m.d.sync += forgot.eq(1)
        reached(m, forgot & dut.valid & (owed == 1), "forgotten")
        reached(m, lost & stale, "memory_first")
        return m


class Reader(Wrapper):
    """``BurstReader`` with any commands and any reader of its words, reset at any time.

    Asserts, besides the protocol, that its queue never overflows and that exactly the words asked
    for leave it.
    """

    DEPTH, BURST = 5, 3

    def __init__(self, depth=DEPTH, burst=BURST):
        self.depth, self.burst = depth, burst
        self.dut = BurstReader(8, depth=depth, max_burst=burst)
        super().__init__({
            "valid": In(1), "command": In(command_layout(burst)), "ready": In(1)} | MEMORY)

    def elaborate(self, platform):
        m = Module()
        dut, limit = self.dut, self.depth
        fragment = self.design(m, dut)
        [queue] = self.queues
        owed = check_read_host(m, dut.bus, self, limit=limit)
        m.d.comb += dut.memory_rst.eq(self.memory_rst)
        given(m, ~self.valid | ((self.command.words != 0) & (self.command.words <= self.burst)))
        m.d.comb += [dut.i.valid.eq(self.valid), dut.i.payload.eq(self.command),
                     dut.o.ready.eq(self.ready)]
        read, words = dut.bus.read, dut.bus.burstcount
        due, some, stale = (inner(fragment, "commands", name) for name in ("due", "some", "stale"))
        claimed = inner(fragment, "claimed")
        promised = Signal(range(4 * limit))
        taken, left = dut.i.valid & dut.i.ready, dut.o.valid & dut.o.ready
        m.d.sync += promised.eq(promised + Mux(taken, self.command.words, 0) - left)
        lost = taken_away(m, self.memory_rst, (promised != queue.level) | taken)
        came = Mux(stale, 0, owed + Mux(read, words, 0))
        always(m, (due == owed) & (some == (due != 0)), "owed_is_known")
        always(m, owed + Mux(read, words, 0) <= limit, "space_for_command")
        always(m, ~read | (words != 0), "words")
        always(m, Mux(lost, promised >= queue.level, promised == queue.level + came), "promised")
        always(m, ~lost | stale, "lost_is_stale")
        always(m, (promised == claimed) & (claimed <= limit), "claimed")
        reached(m, queue.level == self.depth, "full")
        reached(m, stale & self.readdatavalid & self.valid, "dropped")
        reached(m, lost & (queue.level > 1), "memory_first")
        return m


class Writer(Wrapper):
    """``BurstWriter`` with any words and any memory, reset at any time, the memory too or not.

    Asserts the protocol: a word and its command are held while the memory waits; a burst has as
    many words as its first one said, one address and one count, also across a reset. Asserts that
    a word to be written is always there.
    ``forget`` leaves ``waitrequest`` unseen by the design.
    """

    def __init__(self, burst=2, forget=False, deaf=False):
        self.burst, self.forget, self.deaf = burst, forget, deaf
        self.dut = BurstWriter(8, burst=burst)
        super().__init__({"valid": In(1), "word": In(word_layout(8)), "waitrequest": In(1),
                          "memory_rst": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut, bus = self.dut, self.dut.bus
        fragment = self.design(m, dut)
        words, bursts = self.queues
        given(m, ~self.word.void | (self.word.end & self.word.last))
        m.d.comb += [dut.i.valid.eq(self.valid), dut.i.payload.eq(self.word),
                     bus.waitrequest.eq(0 if self.forget else self.waitrequest),
                     dut.memory_rst.eq(0 if self.deaf else self.memory_rst)]

        accepted = bus.write & ~self.waitrequest
        owed = Signal(range(self.burst + 1), reset_less=True)   # words of the burst to be accepted
        command = Cat(bus.address, bus.burstcount)
        begun = Signal(len(command), reset_less=True)
        with m.If(accepted):
            m.d.sync += [owed.eq(Mux(owed == 0, bus.burstcount, owed) - 1), begun.eq(command)]
        with m.If(self.memory_rst):
            m.d.sync += owed.eq(0)
        beat = Cat(command, bus.writedata, bus.byteenable)
        held, before = Signal(reset_less=True), Signal(len(beat), reset_less=True)
        m.d.sync += [held.eq(bus.write & self.waitrequest & ~self.memory_rst), before.eq(beat)]
        always(m, ~held | (bus.write & (before == beat)), "word_held")
        always(m, (owed == 0) | (begun == command), "one_command")
        always(m, (owed == 0) | bus.write, "burst_goes_on")
        always(m, ~bus.write | ((bus.burstcount != 0) & (bus.burstcount <= self.burst)), "count")

        # The queues: words of bursts that have not begun, then those without a burst as yet.
        left, known = inner(fragment, "left"), inner(fragment, "known")
        count = inner(fragment, "count")
        lost = taken_away(m, self.memory_rst, left != 0)
        always(m, left == Mux(bus.write, Mux(owed == 0, bus.burstcount, owed) - 1, 0), "left")
        layout = data.StructLayout({"address": len(bus.address),
                                    "count": range(self.burst + 1), "last": 1})
        queued = 0
        for number, (there, item) in enumerate(entries(m, bursts)):
            size = data.View(layout, item).count
            queued = queued + Mux(there, size, 0)
            last = data.View(layout, item).last
            always(m, ~there | (((size != 0) | last) & (size <= self.burst)), f"size{number}")
        always(m, lost | (words.level == queued + count + Mux(known, left, 0)), "words_for_bursts")
        always(m, ~lost | ~bus.write, "lost_is_over")
        always(m, count < self.burst, "gathered")
        always(m, ~(words.r_en & ~words.r_rdy), "word_there")
        reached(m, accepted & (owed == 1) & ~known, "across_reset")
        forgot = Signal(reset_less=True)
        with m.If(self.memory_rst & (owed > 0)):
            m.d.sync += forgot.eq(1)
        reached(m, forgot & accepted & (owed == 1) & known, "forgotten")
        reached(m, words.level == words.depth, "full")
        return m
