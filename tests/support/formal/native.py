"""Bridges of the system on a chip: Avalon-MM to native ports, Wishbone to Avalon-MM."""

from amaranth import *
from amaranth.lib.wiring import In

from formal.properties import always, constant, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_hdl.avalon.native import NativeReader, NativeWriter
from ncdc_hdl.avalon.wishbone import WishboneAgent

__all__ = ["NativeReads", "NativeWrites", "WishboneAccesses"]

_WIDTH, _BURST, _DEPTH = 8, 3, 2
_STARTS = 1 << 4        # where bursts of writes begin: wider sums take the solver long


class NativeReads(Wrapper):
    """``NativeReader`` with any bursts, and a controller that takes commands when it likes.

    Asserts that the commands are those of the bursts' words, each once and in order; that one that
    is offered stays; that there is one whenever words are owed; that words go through unchanged.
    """

    def __init__(self, design=NativeReader):
        self.dut = design(_WIDTH, _BURST)
        super().__init__({"read": In(1), "address": In(32), "words": In(2), "ready": In(1),
                          "came": In(1), "data": In(_WIDTH)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        fragment = self.design(m, dut)
        bus, port = dut.bus, dut.port
        owed, address = Signal(2), Signal(32)   # commands, and the address of the next
        before, offered = Signal(32), Signal()
        accepted = bus.read & ~bus.waitrequest
        m.d.comb += [bus.read.eq(self.read), bus.address.eq(self.address),
                     bus.burstcount.eq(self.words), port.cmd_ready.eq(self.ready),
                     port.rdata_valid.eq(self.came), port.rdata_data.eq(self.data)]
        given(m, (self.words != 0) & (self.words <= _BURST))
        taken = port.cmd_valid & port.cmd_ready
        m.d.sync += [offered.eq(port.cmd_valid & ~port.cmd_ready), before.eq(port.cmd_addr),
                     owed.eq(Mux(accepted, bus.burstcount, owed - taken)),
                     address.eq(Mux(accepted, bus.address, address + taken))]
        always(m, ~accepted | (owed == 0) | (owed == 1) & taken, "none_lost")
        always(m, port.cmd_valid == (owed != 0), "as_many_as_asked")
        always(m, ~port.cmd_valid | (port.cmd_addr == address), "own_address")
        always(m, ~offered | port.cmd_valid & (port.cmd_addr == before), "held")
        always(m, ~port.cmd_we, "reads")
        always(m, (bus.readdatavalid == self.came) & (bus.readdata == self.data), "own_word")
        # Of the state, for the induction.
        always(m, inner(fragment, "left") == owed, "left_is_owed")
        always(m, (inner(fragment, "address") == address) | (owed == 0), "address_is_next")
        reached(m, accepted & (owed == 1), "next_at_once")
        return m


class NativeWrites(Wrapper):
    """``NativeWriter`` with any bursts, and a controller that asks for the words of the commands
    that it took when it likes.

    Asserts that there is a word whenever it asks; that the watched word, any of the first four,
    leaves as it came, after a command of its own address; and that each burst is answered once,
    one clock after its last word was taken.
    """

    def __init__(self, design=NativeWriter):
        self.dut = design(_WIDTH, _BURST, 4, depth=_DEPTH)
        super().__init__({"write": In(1), "address": In(32), "words": In(2), "data": In(_WIDTH),
                          "ready": In(1), "wanted": In(1), "watched": In(2)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        self.design(m, dut)
        bus, port = dut.bus, dut.port
        came, commands, words = Signal(4), Signal(4), Signal(4)
        left, base = Signal(2), Signal(32)
        stays, before = Signal(), Signal(Cat(self.address, self.words, self.data).shape())
        shown = Cat(self.address, self.words, self.data)
        accepted = bus.write & ~bus.waitrequest
        number = Signal(2)                      # of the word in its burst
        first = left == 0
        address = Mux(first, bus.address, base) + Mux(first, 0, number)
        last = Mux(first, bus.burstcount == 1, left == 1)
        m.d.comb += [bus.write.eq(self.write), bus.address.eq(self.address),
                     bus.burstcount.eq(self.words), bus.writedata.eq(self.data),
                     bus.byteenable.eq(1), port.cmd_ready.eq(self.ready),
                     port.wdata_ready.eq(self.wanted)]
        given(m, (self.words != 0) & (self.words <= _BURST))
        given(m, ~stays | self.write & (shown == before))
        given(m, self.address < _STARTS)
        # The controller asks for words of commands that it took before; none in a reset.
        given(m, ~self.wanted | (words != commands))
        given(m, ~ResetSignal())
        constant(m, self.watched)
        m.d.sync += [stays.eq(bus.write & bus.waitrequest), before.eq(shown)]
        with m.If(accepted):
            m.d.sync += [left.eq(Mux(first, bus.burstcount, left) - 1), came.eq(came + 1),
                         number.eq(Mux(first, 1, number + 1))]
            with m.If(first):
                m.d.sync += base.eq(bus.address)
        commanded = port.cmd_valid & port.cmd_ready
        taken = port.wdata_valid & port.wdata_ready
        m.d.sync += [commands.eq(commands + commanded), words.eq(words + taken)]
        its_address, its_data, its_last = Signal(32), Signal(_WIDTH), Signal()
        with m.If(accepted & (came == self.watched)):
            m.d.sync += [its_address.eq(address), its_data.eq(bus.writedata), its_last.eq(last)]
        always(m, ~self.wanted | port.wdata_valid, "a_word_is_there")
        always(m, ~commanded | (commands < came) & port.cmd_we, "of_a_word")
        always(m, ~commanded | (commands != self.watched) | (port.cmd_addr == its_address),
               "own_address")
        always(m, ~taken | (words != self.watched) | (port.wdata_data == its_data)
               & (port.wdata_we == 1), "own_word")
        due = Signal()                          # the watched word has left a clock ago, as a last
        seen = Signal()                         # it has left a clock ago
        m.d.sync += [seen.eq(taken & (words == self.watched)),
                     due.eq(taken & (words == self.watched) & its_last)]
        always(m, ~seen | (bus.writeresponsevalid == due), "answered_once")
        quiet = Signal()                        # no word has left a clock ago
        m.d.sync += quiet.eq(taken)
        always(m, quiet | ~bus.writeresponsevalid, "answered_then")
        reached(m, due & (self.watched == 3), "second_burst")
        return m


class WishboneAccesses(Wrapper):
    """``WishboneAgent`` with any host, which may give an access up, and any agent.

    Asserts that the agent is asked for one thing at a time; that a write is acknowledged as the
    agent takes it, and a read with its own word, never with that of an access given up; that a
    part of a word is rejected.
    """

    def __init__(self, design=WishboneAgent):
        self.dut = design(4)
        super().__init__({"asked": In(1), "we": In(1), "adr": In(4), "sel": In(4),
                          "waits": In(1), "comes": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        fragment = self.design(m, dut)
        host, agent = dut.host, dut.agent
        owed, own = Signal(), Signal()          # a word is; by this access of the host
        stays, before = Signal(), Signal(9)
        shown = Cat(self.we, self.adr, self.sel)
        m.d.comb += [host.cyc.eq(self.asked), host.stb.eq(self.asked), host.we.eq(self.we),
                     host.adr.eq(self.adr), host.sel.eq(self.sel),
                     agent.waitrequest.eq(self.waits), agent.readdatavalid.eq(self.comes)]
        over = host.ack | host.err
        given(m, ~self.comes | owed)
        given(m, ~(stays & self.asked) | (shown == before))
        given(m, ~ResetSignal())
        m.d.sync += [stays.eq(self.asked & ~over), before.eq(shown)]
        asked = agent.read & ~agent.waitrequest
        with m.If(asked):
            m.d.sync += [owed.eq(1), own.eq(1)]
        with m.Elif(self.comes):
            m.d.sync += owed.eq(0)
        with m.If(~self.asked):
            m.d.sync += own.eq(0)
        read = self.asked & ~self.we
        always(m, ~(agent.read & agent.write), "one_thing")
        always(m, ~owed | ~agent.read & ~agent.write, "one_at_a_time")
        always(m, ~(host.ack & read) | self.comes & owed & own, "own_word")
        always(m, ~(self.comes & read & own) | host.ack, "answered")
        always(m, (host.ack & self.we) == (agent.write & ~agent.waitrequest & self.asked),
               "written_once")
        always(m, ~(host.ack & self.we) | (self.sel == 0xF), "whole_words")
        always(m, ~(agent.read | agent.write) | (agent.address == self.adr), "own_address")
        always(m, ~over | self.asked, "no_other")
        # Of the state, for the induction.
        always(m, inner(fragment, "waiting") == owed, "waiting_is_owed")
        always(m, ~owed | (inner(fragment, "given_up") == ~own), "given_up_is_known")
        always(m, ~(owed & own) | stays & ~before[0], "own_is_a_read")
        reached(m, self.comes & read & ~own, "after_one_given_up")
        reached(m, host.err, "rejected")
        return m
