"""The SDRAM controller as a whole: words that are read come in order, and are those asked for."""

from amaranth import *
from amaranth.lib.wiring import In

from formal.properties import always, given, reached
from formal.sdram_hosts import CHIP
from formal.wrapper import Wrapper
from ncdc_boards.sdram.controller import SdramController

__all__ = ["WordsRead"]

_ASKED = 4      # bursts that a reader may wait for here


class WordsRead(Wrapper):
    """``SdramController`` with any reads and writes, and a chip whose words hold their own number.

    Asserts that each reader gets the words of its bursts in order, as many as asked, and no other.
    The chip's words cannot be written: what is shown of them is where they are read. ``late`` is
    what the design takes the chip's data to be.
    """

    def __init__(self, reads=2, max_burst=2, late=0):
        self.dut = SdramController(CHIP, 1e9, 8, reads, max_burst, late=late)
        bits = range(max_burst + 1)
        super().__init__({
            "read": In(reads), "write": In(1),
            **{f"address{k}": In(self.dut.mapping.word_bits) for k in range(reads + 1)},
            **{f"words{k}": In(bits) for k in range(reads + 1)}})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        self.design(m, dut)
        self._chip(m)
        for k, bus in enumerate(dut.reads):
            self._reader(m, k, bus)
        bus, left = dut.write, Signal(dut.mapping.words)
        words = getattr(self, f"words{dut.count}")
        given(m, (words != 0) & (words <= dut.mapping.max_burst))
        stays = Signal()
        count = Signal.like(words)
        m.d.comb += [bus.write.eq(self.write), bus.burstcount.eq(words), bus.byteenable.eq(1),
                     bus.address.eq(getattr(self, f"address{dut.count}"))]
        accepted = bus.write & ~bus.waitrequest
        m.d.sync += [stays.eq(bus.write & bus.waitrequest), count.eq(words)]
        with m.If(accepted):
            m.d.sync += left.eq(Mux(left == 0, words, left) - 1)
        given(m, ~stays | bus.write)
        given(m, (left == 0) & ~stays | (words == count))
        return m

    def _chip(self, m):
        """A chip that gives the number of a word in it as the word, CAS latency clocks later."""
        pins, mapping = self.dut.pins, self.dut.mapping
        rows = Array(Signal(mapping.chip.row_bits, name=f"chip_row{k}") for k in range(4))
        command = Cat(pins.we_n, pins.cas_n, pins.ras_n)
        with m.If(~pins.cs_n & (command == 0b011)):
            m.d.sync += rows[pins.ba].eq(pins.a)
        word = Cat(pins.a[:mapping.column_bits], pins.ba, rows[pins.ba])
        for k in range(self.dut.clocks.cas):
            later = Signal(8, name=f"dq{k}")
            m.d.sync += later.eq(word)
            word = later
        m.d.comb += pins.dq_i.eq(word)

    def _reader(self, m, k, bus):
        """Any bursts of one reader, and what comes back."""
        address, words = getattr(self, f"address{k}"), getattr(self, f"words{k}")
        mapping = self.dut.mapping
        asked = [Signal(mapping.burst, name=f"asked{k}_{n}") for n in range(_ASKED + 1)]
        count = Signal(range(_ASKED + 2), name=f"count{k}")
        stays = Signal(name=f"stays{k}")
        command = Cat(address, words)
        before = Signal(len(command), name=f"before{k}")
        accepted, over = Signal(name=f"accepted{k}"), Signal(name=f"over{k}")
        given(m, (words != 0) & (words <= mapping.max_burst))
        given(m, ~stays | self.read[k] & (command == before))
        given(m, ~self.read[k] | (count < _ASKED))
        oldest = asked[0]
        m.d.comb += [bus.read.eq(self.read[k]), bus.address.eq(address), bus.burstcount.eq(words),
                     accepted.eq(bus.read & ~bus.waitrequest),
                     over.eq(bus.readdatavalid & (oldest.words == 1))]
        m.d.sync += [stays.eq(bus.read & bus.waitrequest), before.eq(command),
                     count.eq(count + accepted - over)]
        burst = Cat(address, words)
        with m.If(over):
            m.d.sync += [here.eq(after) for here, after in zip(asked, asked[1:])]
        with m.Elif(bus.readdatavalid):
            m.d.sync += [oldest.word.eq(oldest.word + 1), oldest.words.eq(oldest.words - 1)]
        with m.If(accepted):
            for n in range(_ASKED):
                with m.If(count - over == n):
                    m.d.sync += asked[n].as_value().eq(burst)
        always(m, ~bus.readdatavalid | (count != 0), f"asked_for{k}")
        always(m, ~bus.readdatavalid | (bus.readdata == oldest.word), f"own_word{k}")
        reached(m, over & (count > 1), f"read{k}")
