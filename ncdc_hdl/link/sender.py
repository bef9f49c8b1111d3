"""Headers from memory, with the packet's number in them, and payloads behind them."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.link.layouts import JOB, PIECE
from ncdc_model.interface.link_map import TEMPLATE_WORDS

__all__ = ["Sender", "TEMPLATE_ADDRESS_BITS"]

TEMPLATE_ADDRESS_BITS = 3 + exact_log2(TEMPLATE_WORDS)      # bank, template, word


class Sender(wiring.Component):
    """Sends the header and the payload of each job, once all of the payload is there.

    A packet that has begun is never short of bytes. A job without a byte of header or payload is
    ``skipped``: no such packet is sent.

    Timing: two clocks between two packets; four bytes per clock, but at the end of the header.

    Parameters
    ----------
    data_width, depth : int
        As of :class:`PayloadReader`.

    Members
    -------
    i : ``In(stream.Signature(JOB))``
    words, level : from a :class:`PayloadReader`
    field_byte, field_bytes : ``In(8)``, ``In(3)``
        Where the packet's number stands in the header, big endian.
    address, data, write : ``In(TEMPLATE_ADDRESS_BITS)``, ``In(32)``, ``In(1)``
        Write a word of a header: its length in bytes, then the bytes, the first in the lowest.
    o : ``Out(stream.Signature(PIECE))``
    again : ``Out(1)``
        Of the packet that is at ``o``: it was sent before.
    waiting : ``Out(1)``
        A packet waits for its payload.
    skipped : ``Out(1)``
        For one clock, with ``again``.
    """
    def __init__(self, data_width, depth):
        self.data_width = data_width
        super().__init__({
            "i": In(stream.Signature(JOB)), "words": In(stream.Signature(data_width)),
            "level": In(range(depth + 1)), "field_byte": In(8), "field_bytes": In(3),
            "address": In(TEMPLATE_ADDRESS_BITS), "data": In(32), "write": In(1),
            "o": Out(stream.Signature(PIECE)), "again": Out(1), "waiting": Out(1),
            "skipped": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        job, o, word_bits = self.i.p, self.o, exact_log2(self.data_width // 8)
        # A header is not written while it is sent.
        m.submodules.headers = headers = block_memory(32, 1 << TEMPLATE_ADDRESS_BITS)
        write, read = headers.write_port(), headers.read_port()
        index, following = Signal(range(TEMPLATE_WORDS)), Signal(range(TEMPLATE_WORDS))
        left = Signal(len(job.bytes))           # bytes of the header, then of the payload
        short = Signal()                        # these are the last of them
        part = Signal(range(self.data_width // 32 + 1))     # of the word
        there = Signal()                        # the payload is
        m.d.comb += [
            write.addr.eq(self.address), write.data.eq(self.data), write.en.eq(self.write),
            read.en.eq(1), read.addr.eq(Cat(following, job.template, job.bank)),
            following.eq(index), self.again.eq(job.again), short.eq(left <= 4),
            there.eq((self.level << word_bits) >= job.bytes),
            o.p.bytes.eq(Mux(short, left, 4)),
        ]
        m.d.sync += index.eq(following)
        with m.FSM():
            with m.State("WAIT"):
                m.d.comb += [following.eq(0), self.waiting.eq(self.i.valid & ~there)]
                with m.If(self.i.valid & self._complete(there)):
                    m.next = "LENGTH"
            with m.State("LENGTH"):
                m.d.comb += following.eq(1)
                m.d.sync += [left.eq(read.data[:8]), part.eq(0)]
                m.next = "HEADER"
                with m.If(read.data[:8] == 0):
                    m.d.comb += [self.skipped.eq(job.bytes == 0),
                                 self.i.ready.eq(self.skipped)]
                    m.d.sync += left.eq(job.bytes)
                    m.next = "PAYLOAD"
                    with m.If(self.skipped):
                        m.next = "WAIT"
            with m.State("HEADER"):
                m.d.comb += [o.valid.eq(1), o.p.data.eq(self._numbered(m, read.data, index)),
                             o.p.last.eq(short & (job.bytes == 0))]
                with m.If(o.ready):
                    m.d.comb += following.eq(index + 1)
                    m.d.sync += left.eq(Mux(short, job.bytes, left - 4))
                    with m.If(short):
                        m.d.comb += self.i.ready.eq(job.bytes == 0)
                        m.next = "PAYLOAD"
                    with m.If(o.p.last):
                        m.next = "WAIT"
            with m.State("PAYLOAD"):
                end = part == self.data_width // 32 - 1
                m.d.comb += [o.valid.eq(self.words.valid), o.p.last.eq(short),
                             o.p.data.eq(self.words.payload.word_select(part, 32)),
                             self.words.ready.eq(o.ready & (short | end)),
                             self.i.ready.eq(o.ready & o.valid & short)]
                with m.If(o.ready & o.valid):
                    m.d.sync += [left.eq(left - 4), part.eq(Mux(end, 0, part + 1))]
                    with m.If(short):
                        m.next = "WAIT"
        return m

    @staticmethod
    def _complete(there):
        """Whether a packet may begin. A method of its own only so that proofs can break it."""
        return there

    def _numbered(self, m, word, index):
        """A word of the header with what it has of the packet's number."""
        number = Cat(self.i.p.number, Const(0, 32))[:32]
        # The bytes in the order in which they are sent, the first one lowest.
        big = Signal(32)
        with m.Switch(self.field_bytes):
            for count in range(1, 5):
                with m.Case(count):
                    m.d.comb += big.eq(Cat(number.word_select(k, 8)
                                           for k in reversed(range(count))))
        # Over two words of the header.
        lane, lanes = self.field_byte[:2], Signal(8)
        field = Signal(64)
        m.d.comb += [field.eq(big << (lane << 3)),
                     lanes.eq(((1 << self.field_bytes) - 1)[:4] << lane)]
        first = Signal()            # the word has the field's first byte
        second = Signal()           # it is the one behind that
        m.d.comb += [first.eq(index == self.field_byte[2:] + 1),
                     second.eq(index == self.field_byte[2:] + 2)]
        return Cat(Mux(first & lanes[k], field.word_select(k, 8),
                       Mux(second & lanes[4 + k], field.word_select(4 + k, 8),
                           word.word_select(k, 8))) for k in range(4))
