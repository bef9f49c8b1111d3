"""Bytes of packets, read from memory before the packets begin."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost
from ncdc_hdl.avalon.read_commands import ReadCommands
from ncdc_hdl.lib.memory import Fifo
from ncdc_hdl.link.layouts import JOB

__all__ = ["PayloadReader"]


class PayloadReader(wiring.Component):
    """Asks the memory for the payload of each job, and queues the words that come, in order.

    A job is handed on when all of its words are asked for; ``level`` says how many words are there.
    Words are asked for only as far as the queue has room for them.

    Parameters
    ----------
    data_width : int
        Bits of a word of the memory.
    depth : int
        Words that the queue holds: at least a packet, two for packets without pauses.
    burst : int
        Words of a read, at most.

    Members
    -------
    i, o : streams of JOB
        With addresses that are multiples of a word.
    words : ``Out(stream.Signature(data_width))``
        The payloads; each begins with a word of its own.
    level : ``Out(range(depth + 1))``
        Words at ``words``, the one on offer and those behind it.
    memory_rst, bus :
        As of :class:`ReadCommands`.
    """

    def __init__(self, data_width, *, depth, burst):
        self.data_width, self.depth, self.burst = data_width, depth, burst
        super().__init__({
            "i": In(stream.Signature(JOB)), "o": Out(stream.Signature(JOB)),
            "words": Out(stream.Signature(data_width)), "level": Out(range(depth + 1)),
            "memory_rst": In(1), "bus": Out(ReadHost(data_width, burst)),
        })

    def elaborate(self, platform):
        m = Module()
        word_bits = exact_log2(self.data_width // 8)
        m.submodules.queue = queue = Fifo(width=self.data_width, depth=self.depth, checked=False)
        m.submodules.commands = commands = ReadCommands(self.data_width, self.burst,
                                                        limit=self.depth)
        wiring.connect(m, commands.bus, wiring.flipped(self.bus))
        m.d.comb += [
            commands.memory_rst.eq(self.memory_rst),
            queue.w_data.eq(commands.word), queue.w_en.eq(commands.valid),
            self.words.payload.eq(queue.r_data), self.words.valid.eq(queue.r_rdy),
            queue.r_en.eq(self.words.ready), self.level.eq(queue.level),
        ]
        job = Signal(JOB, reset_less=True)              # whose words are asked for
        working = Signal()                              # there is one
        left = Signal(len(job.bytes) - word_bits + 1)   # its words that are not asked for
        address = Signal(ADDRESS_BITS)                  # of the first of them
        claimed = Signal(range(self.depth + 1))         # words asked for and not taken
        room = Signal()                                 # for a burst, beside those
        asked = Signal()
        words = Signal(range(self.burst + 1))           # of the next command
        whole = self.i.p.bytes + (self.data_width // 8 - 1)
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [working.eq(1), job.eq(self.i.payload), left.eq(whole >> word_bits),
                         address.eq(self.i.p.address)]
        with m.Elif(self.o.valid & self.o.ready):
            m.d.sync += working.eq(0)
        m.d.comb += [
            self.i.ready.eq(~working | self.o.valid & self.o.ready),
            self.o.valid.eq(working & (left == 0)), self.o.payload.eq(job),
            words.eq(Mux(left < self.burst, left, self.burst)),
            commands.i.valid.eq(working & (left != 0) & room),
            commands.i.p.address.eq(address), commands.i.p.words.eq(words),
            asked.eq(commands.i.valid & commands.i.ready),
        ]
        with m.If(asked):
            m.d.sync += [left.eq(left - words), address.eq(address + (words << word_bits))]
        following = claimed + Mux(asked, words, 0) - (self.words.valid & self.words.ready)
        m.d.sync += [claimed.eq(following), room.eq(following <= self.depth - self.burst)]
        return m
