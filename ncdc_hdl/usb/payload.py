"""Prefetches bytes from memory."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost
from ncdc_hdl.avalon.read_commands import ReadCommands
from ncdc_hdl.lib.memory import Fifo
from ncdc_spec.registers.link_map import PAYLOAD_BITS

__all__ = ["PART", "PayloadReader"]

PART = data.StructLayout({"address": ADDRESS_BITS, "bytes": PAYLOAD_BITS})
"""Bytes in memory, starting at a multiple of a word."""


class PayloadReader(wiring.Component):
    """Requests the bytes of each part from the memory, and queues the words in order.

    Words are requested only if the queue has space for them.

    Parameters
    ----------
    data_width : int
        Bits of a word of the memory.
    depth : int
        Words that the queue holds.
    burst : int
        Most words of a read.

    Members
    -------
    i : ``In(stream.Signature(PART))``
    words : ``Out(stream.Signature(data_width))``
        The parts; each begins with a word of its own.
    memory_rst, bus :
        As in :class:`ReadCommands`.
    """

    def __init__(self, data_width, *, depth, burst):
        self.data_width, self.depth, self.burst = data_width, depth, burst
        super().__init__({
            "i": In(stream.Signature(PART)), "words": Out(stream.Signature(data_width)),
            "memory_rst": In(1), "bus": Out(ReadHost(data_width, burst)),
        })

    def elaborate(self, platform):
        m = Module()
        word_bits = exact_log2(self.data_width // 8)
        m.submodules.queue = queue = Fifo(width=self.data_width, depth=self.depth)
        m.submodules.commands = commands = ReadCommands(self.data_width, self.burst,
                                                        limit=self.depth)
        wiring.connect(m, commands.bus, wiring.flipped(self.bus))
        m.d.comb += [
            commands.memory_rst.eq(self.memory_rst),
            queue.w_data.eq(commands.word), queue.w_en.eq(commands.valid),
            self.words.payload.eq(queue.r_data), self.words.valid.eq(queue.r_rdy),
            queue.r_en.eq(self.words.ready),
        ]
        left = Signal(len(self.i.p.bytes) - word_bits + 1)  # words not yet requested
        address = Signal(ADDRESS_BITS)                  # address of the first of them
        claimed = Signal(range(self.depth + 1))         # words requested and not taken
        space = Signal()                                # space for a burst, in addition to those
        asked = Signal()
        words = Signal(range(self.burst + 1))           # words of the next command
        whole = self.i.p.bytes + (self.data_width // 8 - 1)
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [left.eq(whole >> word_bits), address.eq(self.i.p.address)]
        m.d.comb += [
            self.i.ready.eq(left == 0), words.eq(Mux(left < self.burst, left, self.burst)),
            commands.i.valid.eq((left != 0) & space),
            commands.i.p.address.eq(address), commands.i.p.words.eq(words),
            asked.eq(commands.i.valid & commands.i.ready),
        ]
        with m.If(asked):
            m.d.sync += [left.eq(left - words), address.eq(address + (words << word_bits))]
        following = claimed + Mux(asked, words, 0) - (self.words.valid & self.words.ready)
        m.d.sync += [claimed.eq(following), space.eq(following <= self.depth - self.burst)]
        return m
