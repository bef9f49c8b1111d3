"""Packets from their parts: a header from memory, the packet's number, the payload."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.link.layouts import ENTRY, JOB, Template
from ncdc_spec.registers.link_map import TEMPLATE_WORDS

__all__ = ["TEMPLATE_ADDRESS_BITS", "Builder"]

TEMPLATE_ADDRESS_BITS = 3 + exact_log2(TEMPLATE_WORDS)      # bank, template, word


class Builder(wiring.Component):
    """Makes the beats of each job's packet: the bytes of its header, then those of its payload.

    A job without a byte of header or payload is ``skipped``: there is no such packet.

    Timing: a clock for each byte of the header, for each word of the payload, and three more.

    Members
    -------
    i : ``In(stream.Signature(JOB))``
        Taken when its packet is complete.
    field_byte, field_bytes : ``In(8)``, ``In(3)``
        Position and length of the packet's number in the header, big endian.
    address, data, write : ``In(TEMPLATE_ADDRESS_BITS)``, ``In(32)``, ``In(1)``
        Write a word of a header: its length in bytes, then the bytes, the first in the lowest.
    bare : ``Out(1)``
        The job is a leader or a trailer, without payload.
    open : ``Out(1)``
        The header is complete; words of the payload may come.
    valid, word : ``In(1)``, ``In(32)``
        Four bytes of the payload have come.
    last : ``Out(1)``
        They are its last ones.
    put, entry : ``Out(1)``, ``Out(ENTRY)``
        A beat; there is no back-pressure.
    skipped : ``Out(1)``
        High for one clock.
    """

    def __init__(self):
        super().__init__({
            "i": In(stream.Signature(JOB)), "field_byte": In(8), "field_bytes": In(3),
            "address": In(TEMPLATE_ADDRESS_BITS), "data": In(32), "write": In(1),
            "bare": Out(1), "open": Out(1), "valid": In(1), "word": In(32), "last": Out(1),
            "put": Out(1), "entry": Out(ENTRY), "skipped": Out(1)})

    def elaborate(self, platform):
        m = Module()
        job, beat = self.i.p, self.entry.beat
        # A header is not written while it is read.
        m.submodules.headers = headers = block_memory(32, 1 << TEMPLATE_ADDRESS_BITS)
        write, read = headers.write_port(), headers.read_port()
        at, following = Signal(8), Signal(8)    # byte of the header, and the next one
        length = Signal(8)                      # bytes of the header
        word = Signal(range(TEMPLATE_WORDS))    # word of the header with the next byte
        count = Signal(len(job.last) - 2)       # words of the payload that have come
        ends, last = Signal(), Signal()         # the header's last byte, the packet's last beat
        over = Signal()                         # bytes are left after the last whole beat
        lane = at[:2]                           # lane of the byte, then of the payload's first one
        filled = Signal(3)                      # lanes of the last beat, less one
        m.d.comb += [
            write.addr.eq(self.address), write.data.eq(self.data), write.en.eq(self.write),
            read.en.eq(1), read.addr.eq(Cat(word, job.template, job.bank)),
            following.eq(at + 1), word.eq(following[2:] + 1), ends.eq(following == length),
            self.bare.eq((job.template == Template.LEADER) | (job.template == Template.TRAILER)),
            filled.eq(lane + Mux(self.bare, 0, job.last[:2])), over.eq(filled[2]),
            self.last.eq(count == job.last[2:]),
            self.entry.again.eq(job.again), beat.last.eq(last),
            beat.empty.eq(Mux(last, ~filled[:2], 0)), self.i.ready.eq(last | self.skipped),
        ]
        with m.FSM():
            with m.State("REST"):
                m.d.comb += word.eq(0)
                m.d.sync += [at.eq(-1), count.eq(0)]
                with m.If(self.i.valid):
                    m.next = "LENGTH"
            with m.State("LENGTH"):
                m.d.sync += [length.eq(read.data), at.eq(following)]
                m.next = "HEADER"
                with m.If(read.data[:8] == 0):
                    m.next = "PAYLOAD"
                    with m.If(self.bare):
                        m.d.comb += self.skipped.eq(1)
                        m.next = "REST"
            with m.State("HEADER"):
                m.d.sync += at.eq(following)
                m.d.comb += [self.put.eq((lane == 3) | last), last.eq(ends & self.bare)]
                with m.If(ends):
                    m.next = "PAYLOAD"
                with m.If(last):
                    m.next = "REST"
            with m.State("PAYLOAD"):
                m.d.comb += [self.open.eq(1), self.put.eq(self.valid),
                             last.eq(self.valid & self.last & ~over)]
                with m.If(self.valid):
                    m.d.sync += count.eq(count + 1)
                    with m.If(self.last):
                        m.next = "REST"
                        with m.If(over):
                            m.next = "REST-OF-IT"
            with m.State("REST-OF-IT"):
                m.d.comb += [self.put.eq(1), last.eq(1)]
                m.next = "REST"
        self._lanes(m, read.data, lane, following)
        return m

    def _lanes(self, m, header, lane, following):
        """Bytes to the lanes in which they are sent; those of an incomplete beat are held."""
        inside, digit = self._number(m, following)
        held = [Signal(8, name=f"held{k}") for k in range(3)]
        turned = [Signal(8, name=f"turned{k}") for k in range(4)]
        given = [Signal(8, name=f"given{k}") for k in range(4)]
        turns = Mux(self.open, lane, 0)
        for k in range(4):
            m.d.comb += [
                given[k].eq(Mux(self.open, self.word.word_select(k, 8),
                                Mux(inside, digit, header.word_select(k, 8)))),
                turned[k].eq(Array(given[k - turn] for turn in range(4))[turns]),
                self.entry.beat.data.word_select(k, 8).eq(
                    Mux(k < lane, held[k], turned[k]) if k < 3 else turned[k]),
            ]
            if k < 3:
                with m.If(Mux(self.open, self.valid, lane == k)):
                    m.d.sync += held[k].eq(turned[k])

    def _number(self, m, following):
        """Whether the byte of the header is one of the number, and that byte."""
        left = Signal(3)                        # bytes left of it, once it has begun
        now = Mux(following == self.field_byte, self.field_bytes, left)
        inside, digit = Signal(), Signal(8)
        m.d.sync += [left.eq(now - (now != 0)), inside.eq(now != 0),
                     digit.eq(Array([0, *(self.i.p.number.word_select(k, 8) for k in range(3)),
                                     *[0] * 4])[now])]
        with m.If(~self.i.valid):
            m.d.sync += left.eq(0)
        return inside, digit
