"""Fences: nothing is asked for, or written, outside a frame's buffer in memory."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In

from formal.properties import always, constant, given, inner, reached
from formal.queue_state import entries
from formal.wrapper import Wrapper
from ncdc_hdl.avalon.burst_writer import BurstWriter, word_layout
from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.avalon.read_commands import command_layout
from ncdc_hdl.avalon.read_fence import ReadFence
from ncdc_hdl.backend.layouts import pixel_layout
from ncdc_hdl.backend.packer import FORMAT, Packer
from ncdc_hdl.frontend.strips import ORDER
from ncdc_spec.view_list import PITCH_BITS

__all__ = ["FencedReads", "FencedWords", "WordsInBursts"]


class FencedReads(Wrapper):
    """``ReadFence`` with any commands, any buffer that is not empty.

    Asserts that all words of a command are inside the buffer, whole, and aligned, and that each
    command that is taken leaves once, with as many words, in order.
    """

    def __init__(self, kind=ReadFence, shortest=1):
        self.shortest = shortest
        self.dut = kind(64, 2, shortest=shortest)
        super().__init__({"base": In(ADDRESS_BITS), "limit": In(ADDRESS_BITS), "valid": In(1),
                          "command": In(command_layout(2)), "ready": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        fragment = self.design(m, dut)
        constant(m, self.base)
        constant(m, self.limit)
        settled = Signal(2)                     # two clocks have gone by
        m.d.sync += settled.eq(Cat(1, settled))
        given(m, ~ResetSignal())
        given(m, (self.command.words >= self.shortest) & (self.command.words <= 2))
        given(m, ~self.valid | settled.all())
        m.d.comb += [dut.base.eq(self.base), dut.limit.eq(self.limit),
                     dut.i.valid.eq(self.valid), dut.i.payload.eq(self.command),
                     dut.o.ready.eq(self.ready)]
        o = dut.o.p
        asked = dut.o.valid & ~dut.empty
        end = Signal(ADDRESS_BITS + 1)
        m.d.comb += end.eq(o.address + (o.words << 3))
        always(m, ~asked | ((o.address >= (self.base & ~0x7)) & (end <= self.limit)), "inside")
        always(m, o.address[:3] == 0, "aligned")
        self._in_order(m, fragment)
        reached(m, dut.moved & ~dut.empty, "moved")
        reached(m, asked & (o.address > self.base) & (end == self.limit) & (self.base != 0),
                "to_the_end")
        return m

    def _in_order(self, m, fragment):
        """The words of the commands under way, oldest first, and what the relay holds."""
        dut, o = self.dut, self.dut.o.p
        level = Signal(range(3))
        words = [Signal.like(self.command.words, name=f"words{k}") for k in range(2)]
        enters, leaves = dut.i.valid & dut.i.ready, dut.o.valid & self.ready
        m.d.sync += level.eq(level + enters - leaves)
        with m.If(leaves):
            m.d.sync += words[0].eq(words[1])
        for k in range(2):
            with m.If(enters & (level - leaves == k)):
                m.d.sync += words[k].eq(self.command.words)
        always(m, ~dut.o.valid | (o.words == words[0]), "as_many_words")
        free, full, held, aside = (inner(fragment, "relay", name)
                                   for name in ("free", "full", "o", "aside"))
        always(m, full == ~free, "full_flag")
        always(m, level == dut.o.valid + ~free, "all_leave")
        always(m, free | dut.o.valid, "the_oldest_is_offered")
        always(m, free | (aside[ADDRESS_BITS:-1] == words[1]), "words_aside")
        # What was found inside is inside: of what is offered this is in "inside" above.
        for name, item, there in (("held", held, dut.o.valid), ("aside", aside, ~free)):
            end = Signal(ADDRESS_BITS + 1, name=f"{name}_end")
            count = item[ADDRESS_BITS:-1]
            m.d.comb += end.eq((item[:ADDRESS_BITS] & ~0x7) + (count << 3))
            always(m, ~(there & item[-1] & ~dut.empty) | (
                ((item[:ADDRESS_BITS] & ~0x7) >= (self.base & ~0x7)) & (end <= self.limit)),
                f"{name}_inside")
            always(m, ~there | ((count >= self.shortest) & (count <= 2)), f"{name}_words")


class FencedWords(Wrapper):
    """``Packer`` with any pixels, formats, sizes, strips, base and limit, reset at any time; if it
    is ``placed`` with any origin and pitch.

    Asserts that each word that is no void one is inside the buffer, aligned, and where the one
    before it ends unless that one said otherwise.
    """

    def __init__(self, kind=Packer, data_width=64, lanes=1, placed=False):
        self.dut, self.word, self.placed = (kind(data_width, lanes, placed), data_width // 8,
                                            placed)
        super().__init__({
            "start": In(1), "base": In(ADDRESS_BITS), "limit": In(ADDRESS_BITS),
            "order": In(ORDER), "format": In(FORMAT), "reject": In(1), "valid": In(1),
            "pixel": In(pixel_layout(lanes)), "ready": In(1),
            **({"origin": In(ADDRESS_BITS), "pitch": In(PITCH_BITS)} if placed else {})})

    def elaborate(self, platform):
        m = Module()
        dut, o = self.dut, self.dut.o.p
        fragment = self.design(m, dut)
        if self.placed:
            m.d.comb += [dut.origin.eq(self.origin), dut.pitch.eq(self.pitch)]
        # A frame's registers rest from its start on; it begins when the last one's words are gone.
        base, limit = Signal(ADDRESS_BITS), Signal(ADDRESS_BITS)
        running = Signal()
        with m.If(self.start):
            m.d.sync += [base.eq(self.base), limit.eq(self.limit), running.eq(1)]
        given(m, ~(running & ~self.start) | ((self.base == base) & (self.limit == limit)))
        given(m, ~self.start | ~dut.o.valid)
        given(m, ~self.valid | (running & ~self.start))
        m.d.comb += [dut.start.eq(self.start), dut.base.eq(self.base), dut.limit.eq(self.limit),
                     dut.order.eq(self.order), dut.format.eq(self.format),
                     dut.reject.eq(self.reject),
                     dut.i.valid.eq(self.valid), dut.i.payload.eq(self.pixel),
                     dut.o.ready.eq(self.ready)]
        end = Signal(ADDRESS_BITS + 1)
        m.d.comb += end.eq(o.address + self.word)
        closed = inner(fragment, "closed")
        always(m, ~dut.o.valid | running, "runs")
        always(m, ~running | closed | (base[:exact(self.word)] == 0), "closed_if_unaligned")
        always(m, ~dut.o.valid | o.void | ((o.address >= base) & (end <= limit)), "inside")
        always(m, ~dut.o.valid | (o.address[:exact(self.word)] == 0), "aligned")
        always(m, ~dut.o.valid | ~o.void | (o.last & o.end), "void_is_last")
        reached(m, dut.o.valid & o.void, "void")
        reached(m, dut.o.valid & ~o.void & (end == limit) & (base != 0) & ~o.last, "to_the_end")
        return m


class WordsInBursts(Wrapper):
    """``BurstWriter`` with words that are inside a buffer and follow each other in it.

    Asserts that each word on the bus, whose address is its burst's and one more for each word
    before it, is inside.
    """

    def __init__(self, burst=2):
        self.burst, self.dut = burst, BurstWriter(8, burst=burst)
        super().__init__({"valid": In(1), "word": In(word_layout(8)), "waitrequest": In(1),
                          "base": In(ADDRESS_BITS), "limit": In(ADDRESS_BITS)})

    def elaborate(self, platform):
        m = Module()
        dut, bus, word = self.dut, self.dut.bus, self.word
        fragment = self.design(m, dut)
        _, bursts = self.queues
        given(m, ~ResetSignal())
        constant(m, self.base)
        constant(m, self.limit)

        def inside(first, count):
            end = Signal(ADDRESS_BITS + 1)
            m.d.comb += end.eq(first + count)
            return (first >= self.base) & (end <= self.limit)

        m.d.comb += [dut.i.valid.eq(self.valid), dut.i.payload.eq(word),
                     bus.waitrequest.eq(self.waitrequest)]
        count, address = inner(fragment, "count"), inner(fragment, "address")
        given(m, ~self.valid | word.void | (inside(word.address, 1) & (
            (count == 0) | (word.address == (address + count)[:ADDRESS_BITS]))))
        given(m, ~word.void | (word.end & word.last))
        always(m, (count == 0) | inside(address, count), "gathered")
        layout = data.StructLayout({"address": len(bus.address),
                                    "count": range(self.burst + 1), "last": 1})
        for number, (there, item) in enumerate(entries(m, bursts)):
            burst = data.View(layout, item)
            always(m, ~there | (burst.count == 0) | inside(burst.address, burst.count),
                   f"queued{number}")
        always(m, ~bus.write | inside(bus.address, bus.burstcount), "inside")
        reached(m, bus.write & (bus.burstcount == self.burst)
                & (bus.address + bus.burstcount == self.limit) & (self.base != 0), "to_the_end")
        reached(m, dut.done & ~bus.write, "void")
        return m


def exact(count):
    """log2 of a power of two."""
    return count.bit_length() - 1
