"""Packs corrected pixels into memory words."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.burst_writer import word_layout
from ncdc_hdl.backend.layouts import pixel_layout

__all__ = ["Packer", "PIXEL_BYTES"]

PIXEL_BYTES = 4  # blue, green, red, zero: the usual XRGB8888 in little-endian memory


class Packer(wiring.Component):
    """Gathers pixels of four bytes (blue, green, red, zero) into words of ``data_width`` bits.

    The frame's last word is sent as soon as the last pixel has come; its missing bytes are not
    enabled. Timing: one pixel per clock.

    Members
    -------
    i : ``In(stream.Signature(pixel_layout()))``
    o : ``Out(stream.Signature(word_layout(data_width)))``
    """

    def __init__(self, data_width):
        self.data_width = data_width
        super().__init__({"i": In(stream.Signature(pixel_layout())),
                          "o": Out(stream.Signature(word_layout(data_width)))})

    def elaborate(self, platform):
        m = Module()
        lanes = self.data_width // (8 * PIXEL_BYTES)
        # At least one bit: Verilog has no signal of none.
        lane = Signal(range(max(lanes, 2)))
        pixel = Cat(self.i.p.b, self.i.p.g, self.i.p.r, Const(0, 8))
        word, enable = self.o.p.data, self.o.p.enable
        with m.If(~self.o.valid | self.o.ready):
            m.d.comb += self.i.ready.eq(1)
            complete = (lane == lanes - 1) | self.i.p.last
            m.d.sync += self.o.valid.eq(self.i.valid & complete)
            with m.If(self.i.valid):
                m.d.sync += [self.o.p.last.eq(self.i.p.last), lane.eq(Mux(complete, 0, lane + 1))]
                for k in range(lanes):
                    here = lane == k
                    with m.If(here):
                        m.d.sync += word.word_select(k, 8 * PIXEL_BYTES).eq(pixel)
                    kept = enable.word_select(k, PIXEL_BYTES) & (lane != 0).replicate(PIXEL_BYTES)
                    m.d.sync += enable.word_select(k, PIXEL_BYTES).eq(
                        kept | here.replicate(PIXEL_BYTES))
        return m
