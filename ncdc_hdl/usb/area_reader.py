"""Parts of memory as pieces of four bytes."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost
from ncdc_hdl.usb.joiner import PIECE
from ncdc_hdl.usb.payload import PayloadReader
from ncdc_spec.registers.link_map import PAYLOAD_BITS

__all__ = ["AREA", "AreaReader"]

AREA = data.StructLayout({
    "address": ADDRESS_BITS,    # of the first row, a multiple of the memory word
    "pitch": PAYLOAD_BITS,      # bytes from row to row, likewise
    "rows": 24,
    "row": PAYLOAD_BITS,        # bytes of a row, at least 1
    "last": PAYLOAD_BITS,       # bytes of the last row, at least 1
})
"""Rows of bytes in memory."""


class AreaReader(wiring.Component):
    """Reads the bytes of an area, row after row.

    Timing: a piece per clock as long as the memory keeps up.

    Parameters
    ----------
    data_width, depth, burst : int
        As in :class:`PayloadReader`.

    Members
    -------
    i : ``In(stream.Signature(AREA))``
        Taken with its last piece.
    o : ``Out(stream.Signature(PIECE))``
        Four bytes, fewer at the end of a row; ``last`` marks that of the area.
    memory_rst, bus :
        As in :class:`PayloadReader`.
    """

    def __init__(self, data_width, *, depth, burst):
        self.data_width, self.depth, self.burst = data_width, depth, burst
        super().__init__({
            "i": In(stream.Signature(AREA)), "o": Out(stream.Signature(PIECE)),
            "memory_rst": In(1), "bus": Out(ReadHost(data_width, burst))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.payload = payload = PayloadReader(self.data_width, depth=self.depth,
                                                       burst=self.burst)
        connect(m, payload.bus, flipped(self.bus))
        area, o, job = self.i.p, self.o, payload.i
        asked = Signal(len(area.rows))              # rows requested
        address = Signal(ADDRESS_BITS)              # address of the next of them
        sent = Signal(len(area.rows))               # rows sent
        begun = Signal()                            # a row is under way
        rest = Signal(PAYLOAD_BITS)                 # bytes of it, once it is
        left = Signal(PAYLOAD_BITS)                 # bytes of it from this piece on
        whole = Signal(PAYLOAD_BITS)                # bytes of the row
        part = Signal(range(max(2, self.data_width // 32)))     # part of the word
        final, short, done = Signal(), Signal(), Signal()
        pieces = self.data_width // 32
        m.d.comb += [
            payload.memory_rst.eq(self.memory_rst),
            job.valid.eq(self.i.valid & (asked != area.rows)),
            job.p.address.eq(Mux(asked == 0, area.address, address)),
            job.p.bytes.eq(Mux(asked == area.rows - 1, area.last, area.row)),
            final.eq(sent == area.rows - 1), whole.eq(Mux(final, area.last, area.row)),
            left.eq(Mux(begun, rest, whole)), short.eq(left <= 4),
            o.valid.eq(payload.words.valid & self.i.valid),
            o.p.data.eq(payload.words.payload.word_select(part, 32)),
            o.p.bytes.eq(Mux(short, left, 4)), o.p.last.eq(short & final),
            done.eq(o.valid & o.ready), self.i.ready.eq(done & o.p.last),
            payload.words.ready.eq(done & (short | (part == pieces - 1))),
        ]
        with m.If(job.valid & job.ready):
            m.d.sync += [asked.eq(asked + 1), address.eq(job.p.address + area.pitch)]
        with m.If(done):
            m.d.sync += [begun.eq(~short), rest.eq(left - 4), sent.eq(sent + short),
                         part.eq(Mux(short | (part == pieces - 1), 0, part + 1))]
        with m.If(self.i.ready):
            m.d.sync += [asked.eq(0), sent.eq(0)]
        return m
