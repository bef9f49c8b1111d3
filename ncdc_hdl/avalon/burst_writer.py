"""Burst writes of a word stream to memory."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ADDRESS_BITS, WriteHost

__all__ = ["BurstWriter", "word_layout"]


def word_layout(data_width):
    """A word to write: its bytes, which of them count, and whether it is the frame's last."""
    return data.StructLayout({"data": data_width, "enable": data_width // 8, "last": 1})


class BurstWriter(wiring.Component):
    """Writes the words of a frame to consecutive addresses, in bursts.

    A burst begins when all of its words are queued, so that it occupies the memory for no longer
    than it must; the frame's last burst may be shorter.

    Parameters
    ----------
    data_width : int
        Bits of a word.
    burst : int
        Words of a burst; the queue holds two.

    Members
    -------
    start, base : ``In(1)``, ``In(32)``
        Begins a frame at byte address ``base`` (a multiple of the word); only while not busy.
    i : ``In(stream.Signature(word_layout(data_width)))``
    done : ``Out(1)``
        High for one clock when the memory has accepted the last word.
    bus : ``Out(WriteHost(data_width, burst))``
    """

    def __init__(self, data_width, *, burst):
        self.data_width, self.burst = data_width, burst
        super().__init__({
            "start": In(1), "base": In(ADDRESS_BITS),
            "i": In(stream.Signature(word_layout(data_width))),
            "done": Out(1),
            "bus": Out(WriteHost(data_width, burst)),
        })

    def elaborate(self, platform):
        m = Module()
        layout = word_layout(self.data_width)
        m.submodules.fifo = fifo = SyncFIFOBuffered(width=layout.size, depth=2 * self.burst)
        word = data.View(layout, fifo.r_data)
        ended = Signal()                             # the frame's last word is in the queue
        left = Signal(range(self.burst + 1))         # words of the present burst
        address = Signal(ADDRESS_BITS)
        log2_bytes = (self.data_width // 8).bit_length() - 1
        m.d.comb += [
            fifo.w_data.eq(Value.cast(self.i.payload)), fifo.w_en.eq(self.i.valid & ~ended),
            self.i.ready.eq(fifo.w_rdy & ~ended),
            self.bus.writedata.eq(word.data), self.bus.byteenable.eq(word.enable),
            self.bus.write.eq((left != 0) & fifo.r_rdy),
        ]
        with m.If(self.i.valid & self.i.ready & self.i.p.last):
            m.d.sync += ended.eq(1)
        with m.If(left == 0):
            full = fifo.level >= self.burst
            with m.If(full | ended & (fifo.level != 0)):
                count = Mux(full, self.burst, fifo.level)
                m.d.sync += [left.eq(count), self.bus.burstcount.eq(count),
                             self.bus.address.eq(address),
                             address.eq(address + (count << log2_bytes))]
        with m.If(self.bus.write & ~self.bus.waitrequest):
            m.d.comb += fifo.r_en.eq(1)
            m.d.sync += left.eq(left - 1)
            with m.If(word.last):
                m.d.comb += self.done.eq(1)
                m.d.sync += ended.eq(0)
        with m.If(self.start):
            m.d.sync += address.eq(self.base)
        return m
