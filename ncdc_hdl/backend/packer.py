"""Packs corrected pixels into memory words."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.burst_writer import word_layout
from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.backend.layouts import pixel_layout
from ncdc_hdl.frontend.strips import ORDER, Strips
from ncdc_hdl.lib.groups import lanes_of
from ncdc_model.interface.frames import PIXEL_BYTES

__all__ = ["Packer"]


class Packer(wiring.Component):
    """Gathers pixels of four bytes (blue, green, red, zero) into words, each with its address.

    Pixel (u, v) goes to ``base + 4 (v width + u)``; the pixels come in the order of
    :class:`Strips`. Rows of a raster follow each other without a gap. A row of a strip ends with a
    word of its own, and begins with one: bytes of pixels of other strips are not enabled. The
    frame's last word is sent as soon as the last pixel has come.

    Nothing is sent that is not inside ``base`` .. ``limit`` - 1, in whole words. From the first
    word on that is not, nothing more of the frame is sent but a void word for its end.

    Timing: latency 1; one group per clock, or as many clocks as it has words; the first one
    ``Strips.latency`` clocks after ``start`` at the earliest.

    Parameters
    ----------
    data_width : int
        Bits of a word.
    lanes : int
        Pixels of a group: 1, 2 or 4.

    Members
    -------
    start : ``In(1)``
        Begins a frame, in which nothing of the last one is left.
    base, limit, order : ``In(32)``, ``In(32)``, ``In(ORDER)``
        Byte address of the frame, a multiple of the word, and of what is behind its place; sizes.
        Constant in a frame.
    refuse : ``In(1)``
        Nothing of this frame is to be sent; high before its first pixel comes.
    outside : ``Out(1)``
        Pixels are dropped that are outside the place.
    i : ``In(stream.Signature(pixel_layout(lanes)))``
    o : ``Out(stream.Signature(word_layout(data_width)))``
    """

    latency = 1

    def __init__(self, data_width, lanes=1):
        self.data_width, self.lanes = data_width, lanes
        super().__init__({"start": In(1), "base": In(ADDRESS_BITS), "limit": In(ADDRESS_BITS),
                          "order": In(ORDER), "refuse": In(1), "outside": Out(1),
                          "i": In(stream.Signature(pixel_layout(lanes))),
                          "o": Out(stream.Signature(word_layout(data_width)))})

    def elaborate(self, platform):
        m = Module()
        room = self.data_width // (8 * PIXEL_BYTES)  # pixels of a word
        step = min(self.lanes, room)                 # pixels taken at a time
        parts = self.lanes // step
        # At least one bit: Verilog has no signal of none.
        part = Signal(range(max(parts, 2)))
        group = Cat(Cat(p.b, p.g, p.r, Const(0, 8)) for p in lanes_of(self.i.p))
        pixels = group.word_select(part, 8 * PIXEL_BYTES * step)
        last = self.i.p.last & (part == parts - 1)

        m.submodules.strips = strips = Strips(step)
        address = Signal(ADDRESS_BITS)          # of the next pixel
        row = Signal(ADDRESS_BITS)              # of the first pixel in its row of the strip
        strip = Signal(ADDRESS_BITS)            # of the strip's first pixel
        next_strip = Signal(ADDRESS_BITS)       # of the first pixel of the strip behind it
        word_bits, step_bits = exact_log2(self.data_width // 8), exact_log2(PIXEL_BYTES * step)
        place = address[step_bits:word_bits] if step < room else Const(0)
        row_end = strips.last_column & ~strips.raster
        begun = Signal()                             # the word has pixels already
        complete = (place == room // step - 1) | row_end | last
        put = Signal()                               # pixels go into the word
        closed = Signal()                            # nothing more of the frame is sent
        inside = Signal()                            # the word is in the frame's place
        m.d.comb += [inside.eq(self._inside(*(value[word_bits:]
                                              for value in (address, self.base, self.limit)))),
                     self.outside.eq(put & ~inside & ~closed)]
        with m.If(self.start):
            m.d.sync += closed.eq(self.base[:word_bits] != 0)
        with m.Elif(put & ~inside | self.refuse):
            m.d.sync += closed.eq(1)
        void = closed | ~inside
        m.d.comb += [strips.order.eq(self.order), strips.start.eq(self.start),
                     strips.advance.eq(put | strips.begin)]
        # `next_strip` is a clock late, which no strip is short enough to notice.
        m.d.sync += next_strip.eq(strip + strips.strip * PIXEL_BYTES)

        o = self.o.p
        with m.If(~self.o.valid | self.o.ready):
            m.d.comb += [self.i.ready.eq(part == parts - 1), put.eq(self.i.valid)]
            m.d.sync += self.o.valid.eq(self.i.valid & Mux(void, last, complete))
        with m.If(put):
            m.d.sync += [part.eq(Mux(part == parts - 1, 0, part + 1)), begun.eq(~complete),
                         o.last.eq(last), o.end.eq(row_end | last), o.void.eq(void),
                         o.address.eq(Cat(Const(0, word_bits), address[word_bits:]))]
            for k in range(room // step):
                enable = o.enable.word_select(k, PIXEL_BYTES * step)
                with m.If(place == k):
                    m.d.sync += [o.data.word_select(k, len(pixels)).eq(pixels), enable.eq(-1)]
                with m.Elif(~begun):
                    m.d.sync += enable.eq(0)
            m.d.sync += address.eq(address + PIXEL_BYTES * step)
            with m.If(strips.last_column & ~strips.last_row):
                below = row + self.order.width * PIXEL_BYTES
                m.d.sync += [address.eq(below), row.eq(below)]
            with m.If(strips.last_column & strips.last_row):
                m.d.sync += [address.eq(next_strip), row.eq(next_strip), strip.eq(next_strip)]
        with m.If(self.start):
            m.d.sync += [address.eq(self.base), row.eq(self.base), strip.eq(self.base),
                         begun.eq(0), part.eq(0)]
        return m

    @staticmethod
    def _inside(number, first, end):
        """Whether a word is in the frame's place; arguments count words.

        A method of its own only so that proofs and tests can break it.
        """
        return (number >= first) & (number < end)
