"""Bridges to AXI: the rules of its specification, with any host that keeps to Avalon-MM's, and any
memory that keeps to AXI's."""

from amaranth import *
from amaranth.lib.wiring import In

from formal.properties import always, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_hdl.axi.bus import PAGE_BITS
from ncdc_hdl.axi.lite_bridge import LiteBridge
from ncdc_hdl.axi.read_bridge import ReadBridge
from ncdc_hdl.axi.write_bridge import WriteBridge

__all__ = ["Accesses", "Reads", "Writes"]

_WIDTH, _BURST, _PENDING = 8, 3, 3


def held(m, valid, ready, payload, bus_rst, name):
    """Assert that what is offered stays, and as it is, until it is taken."""
    stood = Signal(name=f"{name}_stood", reset_less=True)
    before = Signal(len(payload), name=f"{name}_before", reset_less=True)
    m.d.sync += [stood.eq(valid & ~ready & ~bus_rst), before.eq(payload)]
    always(m, ~stood | valid & (payload == before), f"{name}_held")


def in_page(m, valid, address, beats, name):
    """Assert that a burst does not cross the end of a page."""
    last = address[:PAGE_BITS] + beats
    always(m, ~valid | (last < (1 << PAGE_BITS)), f"{name}_in_page")


class Reads(Wrapper):
    """``ReadBridge``, with words of a byte, so that a page has 4,096 of them.

    The host goes through resets of the design as if nothing had happened, as ``ReadCommands`` does.
    Asserts: AR is held; no burst crosses a page; as many words are asked for as the host asked for,
    at its addresses; each word that comes reaches the host; no more bursts than stated.
    """

    def __init__(self, kind=ReadBridge):
        self.dut = kind(_WIDTH, _BURST, _PENDING)
        super().__init__({
            "read": In(1), "address": In(32), "words": In(2), "memory_rst": In(1),
            "arready": In(1), "rvalid": In(1), "rlast": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut, host, axi = self.dut, self.dut.host, self.dut.axi
        fragment = self.design(m, dut)
        offered, owed, second = (inner(fragment, name) for name in ("offered", "owed", "second"))
        m.d.comb += [
            host.read.eq(self.read), host.address.eq(self.address),
            host.burstcount.eq(self.words), dut.memory_rst.eq(self.memory_rst),
            axi.arready.eq(self.arready), axi.rvalid.eq(self.rvalid), axi.rlast.eq(self.rlast)]
        # The host holds its command.
        stands = Signal(reset_less=True)
        command, now = Signal(34, reset_less=True), Cat(self.address, self.words)
        m.d.sync += [stands.eq(self.read & host.waitrequest & ~self.memory_rst), command.eq(now)]
        given(m, ~self.read | (self.words != 0))
        given(m, ~self.read | (self.address < (1 << 32) - 16))
        given(m, ~stands | self.read & (command == now))
        # What the memory owes: bursts, and words of all of them.
        accepted, ended = axi.arvalid & axi.arready, self.rvalid & self.rlast
        bursts = Signal(4, reset_less=True)
        m.d.sync += bursts.eq(Mux(self.memory_rst, 0, bursts + accepted - ended))
        given(m, ~self.rvalid | (bursts != 0) | self.memory_rst)
        held(m, axi.arvalid, axi.arready, Cat(axi.araddr, axi.arlen), self.memory_rst, "ar")
        in_page(m, axi.arvalid, axi.araddr, axi.arlen, "ar")
        always(m, owed == bursts + offered, "owed_is_known")
        always(m, owed <= _PENDING, "most_owed")
        always(m, axi.rready & (host.readdatavalid == self.rvalid), "no_word_lost")
        # Words of commands that the host has given, less those that were offered to the memory.
        taken = self.read & ~host.waitrequest
        asked, offers = Signal(8, reset_less=True), Signal(8, reset_less=True)
        begun = self._begins(m, offered, accepted)
        m.d.sync += [asked.eq(asked + Mux(taken, self.words, 0)),
                     offers.eq(offers + Mux(begun, axi.arlen + 1, 0))]
        with m.If(self.memory_rst):
            m.d.sync += [asked.eq(0), offers.eq(0)]
        total = (offers + Mux(begun, axi.arlen + 1, 0))[:8]
        first = Signal(2)               # words of the command that are offered already
        m.d.comb += first.eq(Mux(second, (1 << PAGE_BITS) - command[:PAGE_BITS], 0))
        always(m, total == (asked + first)[:8], "all_asked_for")
        always(m, ~second | stands & (command[:PAGE_BITS] + command[32:] > (1 << PAGE_BITS)),
               "second_of_a_command")
        # The burst is the command's: it begins at its address.
        at, from_ = Signal(32, reset_less=True), Signal(32)
        m.d.comb += from_.eq(Mux(second, Cat(Const(0, PAGE_BITS), self.address[PAGE_BITS:] + 1),
                                 self.address))
        with m.If(self.read & (~offered | axi.arready)):
            m.d.sync += at.eq(from_)
        always(m, ~offered | (axi.araddr == at), "at_its_address")
        reached(m, second & (bursts != 0), "crosses")
        reached(m, owed == _PENDING, "full")
        forgot = Signal(reset_less=True)
        with m.If(self.memory_rst & (bursts > 1)):
            m.d.sync += forgot.eq(1)
        reached(m, forgot & ended & ~self.memory_rst, "forgotten")
        return m

    def _begins(self, m, offered, accepted):
        """The first clock in which a burst is offered."""
        old = Signal(reset_less=True)
        m.d.sync += old.eq(offered & ~accepted & ~self.memory_rst)
        return offered & ~old


class Writes(Wrapper):
    """``WriteBridge``, with words of a byte.

    The host goes through resets of the design as if nothing had happened, as ``BurstWriter`` does.
    Asserts: AW and W are held; no burst crosses a page; WLAST comes with the last of as many words
    as AW named, and with no other; addresses are the host's; each of the host's words is offered;
    no more bursts than stated; each of the host's bursts is answered once, as failed if an answer
    to a part of it is.
    """

    def __init__(self, kind=WriteBridge):
        self.dut = kind(_WIDTH, _BURST, _PENDING)
        super().__init__({
            "write": In(1), "address": In(32), "words": In(2), "word": In(_WIDTH),
            "memory_rst": In(1), "awready": In(1), "wready": In(1), "bvalid": In(1),
            "bresp": In(2)})

    def elaborate(self, platform):
        m = Module()
        dut, host, axi = self.dut, self.dut.host, self.dut.axi
        fragment = self.design(m, dut)
        named, offered, left, piece, owed, beats = (inner(fragment, name) for name in (
            "named", "offered", "left", "piece", "owed", "beats"))
        bus_rst = self.memory_rst
        m.d.comb += [
            host.write.eq(self.write), host.address.eq(self.address), host.writedata.eq(self.word),
            host.burstcount.eq(self.words), dut.memory_rst.eq(bus_rst),
            axi.awready.eq(self.awready), axi.wready.eq(self.wready),
            axi.bvalid.eq(self.bvalid), axi.bresp.eq(self.bresp)]
        taken = self.write & ~host.waitrequest
        begins = taken & (piece == 0)
        self._host(m, fragment, taken, begins)
        held(m, axi.awvalid, axi.awready, Cat(axi.awaddr, axi.awlen), bus_rst, "aw")
        held(m, axi.wvalid, axi.wready, Cat(axi.wdata, axi.wstrb, axi.wlast), bus_rst, "w")
        in_page(m, axi.awvalid, axi.awaddr, axi.awlen, "aw")

        # Bursts that are not answered: those of which all words, and the address, were accepted.
        under_way = (piece != 0) | offered
        bodies, addresses = Signal(4, reset_less=True), Signal(4, reset_less=True)
        m.d.sync += [
            bodies.eq(Mux(bus_rst, 0, bodies + (axi.wvalid & axi.wready & axi.wlast)
                          - self.bvalid)),
            addresses.eq(Mux(bus_rst, 0, addresses + (axi.awvalid & axi.awready) - self.bvalid))]
        given(m, ~self.bvalid | (bodies != 0) & (addresses != 0) | bus_rst)
        always(m, owed <= _PENDING, "most_owed")
        always(m, owed == addresses + named, "addresses_are_known")
        always(m, owed == bodies + under_way, "words_are_known")
        count = Signal(2, reset_less=True)      # words that were taken of the burst under way
        with m.If(taken):
            m.d.sync += count.eq(Mux(begins, 1, count + 1))
        always(m, ~offered | (axi.wlast == (piece == 0)), "last_is_the_last")
        always(m, ~under_way | (beats + 1 == count + piece), "as_many_as_named")
        always(m, ~under_way | (count + piece <= _BURST) & (count != 0), "count")
        always(m, ~named | (beats < _BURST), "beats")
        always(m, ~begins | ~named | axi.awready, "one_address")
        self._answers(m, fragment, taken & (left == 0), bus_rst)
        reached(m, begins & (left != 0) & named, "crosses")
        reached(m, owed == _PENDING, "full")
        reached(m, named & (bodies > addresses) & ~under_way, "words_first")
        forgot = Signal(reset_less=True)
        with m.If(bus_rst & (left > 1)):
            m.d.sync += forgot.eq(1)
        reached(m, forgot & host.writeresponsevalid, "forgotten")
        return m

    def _host(self, m, fragment, taken, begins):
        """A host that holds its word; its words and addresses are those on the bus."""
        host, axi, bus_rst = self.dut.host, self.dut.axi, self.memory_rst
        left, piece, page, named, offered = (inner(fragment, name) for name in (
            "left", "piece", "page", "named", "offered"))
        stands = Signal(reset_less=True)
        now = Cat(self.address, self.words, self.word)
        command = Signal(len(now), reset_less=True)
        mine = Signal(2, reset_less=True)           # words of its burst to come
        first = Signal(32, reset_less=True)         # address of its burst
        m.d.sync += [stands.eq(self.write & host.waitrequest & ~bus_rst), command.eq(now),
                     mine.eq(Mux(bus_rst, 0, Mux(
                         taken, Mux(mine == 0, self.words, mine) - 1, mine)))]
        with m.If(taken & (mine == 0)):
            m.d.sync += first.eq(self.address)
        given(m, ~self.write | (self.words != 0) & (self.address < (1 << 32) - (1 << 14)))
        given(m, ~stands | self.write & (command == now))
        always(m, mine == left, "no_word_lost")
        always(m, (piece <= left) & (left < _BURST), "pieces")
        always(m, (left == 0) | (page == first[PAGE_BITS:] + 1), "page_after")
        # What is taken is offered in the next clock.
        was_taken, word = Signal(reset_less=True), Signal(_WIDTH, reset_less=True)
        began, at = Signal(reset_less=True), Signal(32, reset_less=True)
        m.d.sync += [was_taken.eq(taken & ~bus_rst), word.eq(self.word),
                     began.eq(begins & ~bus_rst),
                     at.eq(Mux(mine == 0, self.address,
                                  Cat(Const(0, PAGE_BITS), first[PAGE_BITS:] + 1)))]
        always(m, ~was_taken | offered & (axi.wdata == word), "offered_at_once")
        always(m, ~began | named & (axi.awaddr == at), "at_its_address")

    def _answers(self, m, fragment, begun, bus_rst):
        """Each of the host's bursts gets one answer."""
        host = self.dut.host
        left, piece, owed, finals, spoiled = (inner(fragment, name) for name in (
            "left", "piece", "owed", "finals", "spoiled"))
        due = Signal(4, reset_less=True)        # the host's bursts that are owed an answer
        worst = Signal(reset_less=True)         # an answer since the host's last one is a failure
        m.d.sync += due.eq(Mux(bus_rst, 0, due + begun - host.writeresponsevalid))
        with m.If(bus_rst | host.writeresponsevalid):
            m.d.sync += worst.eq(0)
        with m.Elif(self.bvalid & self.bresp[1]):
            m.d.sync += worst.eq(1)
        always(m, ~host.writeresponsevalid | (due != 0), "asked_for")
        # Those whose last part is begun, and one of which a part is to come.
        always(m, due == sum(finals) + (left != piece), "no_answer_lost")
        for k in range(_PENDING):
            always(m, ~finals[k] | (owed > k), f"final{k}")
        always(m, worst == spoiled, "failures_are_known")
        always(m, ~host.writeresponsevalid
               | (host.response[1] == (self.bresp[1] | worst)), "failure_is_reported")
        reached(m, host.writeresponsevalid & worst & ~self.bresp[1], "first_part_failed")


class Accesses(Wrapper):
    """``LiteBridge`` on an agent that waits as it likes, and forgets in a reset.

    Asserts: answers come once for each access, and only for one, and are held; the agent is asked
    for one thing at a time, and its strobe is held; nothing is waited for that it does not owe.
    """

    def __init__(self, kind=LiteBridge):
        self.dut = kind(2)
        super().__init__({
            "awvalid": In(1), "wvalid": In(1), "arvalid": In(1), "bready": In(1), "rready": In(1),
            "strobes": In(4), "memory_rst": In(1), "waitrequest": In(1), "readdatavalid": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut, axi, bus = self.dut, self.dut.axi, self.dut.bus
        fragment = self.design(m, dut)
        reading, writing, awaiting, named, given_, asked, done, came = (
            inner(fragment, name) for name in ("reading", "writing", "awaiting", "named", "given",
                                               "asked", "done", "came"))
        bus_rst = self.memory_rst
        m.d.comb += [
            *(getattr(axi, name).eq(getattr(self, name))
              for name in ("awvalid", "wvalid", "arvalid", "bready", "rready")),
            axi.wstrb.eq(self.strobes), dut.memory_rst.eq(bus_rst),
            bus.waitrequest.eq(self.waitrequest), bus.readdatavalid.eq(self.readdatavalid)]
        # The two resets overlap: what the bus forgets, the agent forgets.
        given(m, ~bus_rst | ResetSignal())
        counts = {name: Signal(name=f"of_{name}", reset_less=True) for name in ("aw", "w", "ar")}
        for name, ends in (("aw", axi.bvalid & axi.bready), ("w", axi.bvalid & axi.bready),
                           ("ar", axi.rvalid & axi.rready)):
            taken = getattr(axi, f"{name}valid") & getattr(axi, f"{name}ready")
            m.d.sync += counts[name].eq(
                Mux(bus_rst, 0, counts[name] + taken - ends))
            always(m, ~taken | ~counts[name], f"one_{name}")
        always(m, (named == counts["aw"]) & (given_ == counts["w"]) & (asked == counts["ar"]),
               "what_is_here")
        always(m, ~axi.bvalid | counts["aw"] & counts["w"], "answer_to_a_write")
        always(m, ~axi.rvalid | counts["ar"], "answer_to_a_read")
        always(m, reading + writing + awaiting <= 1, "one_thing")
        always(m, ~writing | named & given_ & ~done, "write_of_the_bus")
        always(m, ~(reading | awaiting) | asked & ~came, "read_of_the_bus")
        held(m, axi.bvalid, axi.bready, axi.bresp, bus_rst, "b")
        held(m, axi.rvalid, axi.rready, axi.rdata, bus_rst, "r")
        # The agent: a strobe stands until it is accepted, and through a reset.
        strobe = bus.read | bus.write
        held(m, strobe, ~self.waitrequest | ResetSignal(),
             Cat(bus.read, bus.write, bus.address), bus_rst, "strobe")
        owes = Signal()                         # a reset makes the agent forget
        m.d.sync += owes.eq(bus.read & ~self.waitrequest | owes & ~self.readdatavalid)
        given(m, ~self.readdatavalid | owes)
        always(m, awaiting == owes, "owed")
        again = Signal(reset_less=True)
        with m.If(awaiting & ResetSignal() & ~bus_rst):
            m.d.sync += again.eq(1)
        reached(m, again & axi.rvalid & axi.rready, "asked_again")
        reached(m, axi.bvalid & (axi.bresp != 0), "rejected")
        reached(m, came & writing, "both")
        return m
