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
from ncdc_hdl.lib.pipeline import register
from ncdc_spec.frames import BGR8, BGRX8, MONO8, OUTPUT_FORMATS

__all__ = ["FORMAT", "Packer"]

FORMAT = range(len(OUTPUT_FORMATS))     # of codes of formats
_MOST = BGRX8.pixel_bytes               # units of a group, at most
_CARRIED = BGR8.pixel_bytes - 1         # units that a group leaves for another word, at most


class Packer(wiring.Component):
    """Gathers pixels, in the format that a register chooses, into words, each with its address.

    Pixel (u, v) goes to ``base + n (v width + u)``, n the bytes of a pixel; the pixels come in the
    order of :class:`Strips`. Rows of a raster follow each other without a gap. A row of a strip
    ends with a word of its own, and begins with one: bytes of pixels of other strips are not
    enabled. The frame's last word is sent as soon as the last pixel has come.

    Bytes are moved by units of as many as there are lanes: every group has n of them, and begins at
    a multiple. A group of three units may end in a later word than it begins in. It is taken with
    the last word that it completes; units behind that are carried into the next group's word, or
    sent in a word of their own at the end of a row.

    Nothing is sent that is not inside ``base`` .. ``limit`` - 1, in whole words. From the first
    word on that is not, nothing more of the frame is sent but a void word for its end.

    Timing: latency 1; one group per clock, or as many clocks as words are complete with it; the
    first group ``Strips.latency`` clocks after ``start`` at the earliest.

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
    format : ``In(FORMAT)``
        Code of an ``OutputFormat``. Constant in a frame, as are the next three.
    base, limit, order : ``In(32)``, ``In(32)``, ``In(ORDER)``
        Byte address of the frame, a multiple of the word, and of what is behind its place; sizes,
        of which the height is 2 at least where there are several strips.
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
        self.units = data_width // (8 * lanes)      # of a word
        super().__init__({"start": In(1), "format": In(FORMAT), "base": In(ADDRESS_BITS),
                          "limit": In(ADDRESS_BITS), "order": In(ORDER), "refuse": In(1),
                          "outside": Out(1), "i": In(stream.Signature(pixel_layout(lanes))),
                          "o": Out(stream.Signature(word_layout(data_width)))})

    def elaborate(self, platform):
        m = Module()
        units, word_bits = self.units, exact_log2(self.data_width // 8)
        # At least one bit: Verilog has no signal of none.
        part = Signal(range(max(2, _MOST // units)))    # words before this one that the group is in
        number = Signal(ADDRESS_BITS - word_bits)       # of the word
        place = Signal(exact_log2(units))               # unit of the word in which the group begins
        end = Signal(range(units + _MOST))              # unit behind the group, from this word on
        carried = Signal()                              # units of the last group are in the word
        begun = Signal()                                # the word has pixels already
        put = Signal()                                  # pixels go into the word
        closed = Signal()                               # nothing more of the frame is sent

        m.submodules.strips = strips = Strips(self.lanes)
        in_strips = register(m, "in_strips", ~strips.raster)
        ending = self.i.p.last | (strips.last_column & in_strips)
        complete = end >= units
        # Units that complete no word wait for the next group, if one follows.
        final = (end <= units) | (end < 2 * units) & ~ending
        last = self.i.p.last & final
        first, behind, present = (value[word_bits:] for value in (self.base, self.limit,
                                                                  Cat(Const(0, word_bits), number)))
        inside = self._inside(present, first, behind)
        void = closed | ~inside
        m.d.comb += [
            self.outside.eq(put & ~inside & ~closed),
            strips.order.eq(self.order), strips.start.eq(self.start),
            strips.advance.eq(put & final | strips.begin),
        ]
        o = self.o.p
        with m.If(~self.o.valid | self.o.ready):
            m.d.comb += [self.i.ready.eq(final), put.eq(self.i.valid)]
            m.d.sync += self.o.valid.eq(self.i.valid & Mux(void, last, complete | ending))
        with m.If(put):
            m.d.sync += [part.eq(Mux(final, 0, part + 1)), begun.eq(~complete & ~ending),
                         carried.eq(final & (end > units)),
                         o.last.eq(last), o.end.eq(ending & final), o.void.eq(void),
                         o.address.eq(Cat(Const(0, word_bits), number))]
        self._fill(m, put, part, place, end, begun, carried)
        behind_it = Signal(len(number))                 # number of the next word
        m.d.comb += behind_it.eq(number + 1)
        self._advance(m, put, final, strips, Cat(place, number), end,
                      Mux(complete, behind_it, number))
        with m.If(self.start):
            m.d.sync += [closed.eq(self.base[:word_bits] != 0),
                         begun.eq(0), carried.eq(0), part.eq(0)]
        with m.Elif(put & ~inside | self.refuse):
            m.d.sync += closed.eq(1)
        return m

    @staticmethod
    def _inside(number, first, end):
        """Whether a word is in the frame's place; arguments count words.

        A method of its own only so that proofs and tests can break it.
        """
        return (number >= first) & (number < end)

    def _by_format(self, of_mono, of_bgr, otherwise):
        """What belongs to the format."""
        return Mux(self.format == BGR8.code, of_bgr,
                   Mux(self.format == MONO8.code, of_mono, otherwise))

    def _advance(self, m, put, final, strips, address, end, number):
        """Keep ``address``, of the next group, in units, and ``end``; ``number``: of the word that
        is filled next."""
        lane_bits, place_bits = exact_log2(self.lanes), exact_log2(self.units)
        size = self._by_format(1, BGR8.pixel_bytes, _MOST)      # units of a group
        width = self.order.width[lane_bits:]
        stride = Signal(range((_MOST << len(width)) + 1))   # units from row to row
        row = Signal(len(address))              # of the first group in the row of the strip
        next_strip = Signal(len(address))       # of the first group of the strip behind it
        top = Signal()                          # the row is the picture's first
        below = Signal(len(address))            # of the first group in the row below
        m.d.sync += stride.eq(self._by_format(width, BGR8.pixel_bytes * width, _MOST * width))
        behind = Cat(end[:place_bits], number)
        m.d.comb += below.eq(row + stride)
        anew = Mux(strips.last_row, next_strip, below)
        with m.If(put):
            m.d.sync += address[place_bits:].eq(number)
            with m.If(~final):
                m.d.sync += end.eq(end - self.units)
            with m.Elif(strips.last_column):
                m.d.sync += [address.eq(anew), end.eq(anew[:place_bits] + size), row.eq(anew),
                             top.eq(strips.last_row)]
                # The strip behind begins where the first row of this one ends.
                with m.If(top):
                    m.d.sync += next_strip.eq(behind)
            with m.Else():
                m.d.sync += [address.eq(behind), end.eq(end[:place_bits] + size)]
        with m.If(self.start):
            m.d.sync += [address.eq(self.base[lane_bits:]), end.eq(size),
                         row.eq(self.base[lane_bits:]), top.eq(1)]

    def _fill(self, m, put, part, place, end, begun, carried):
        """Put the units of the group that are in the word there, and those carried into it, which
        the group follows without a gap."""
        units, bits, o = self.units, 8 * self.lanes, self.o.p
        turned = Cat(self._turned(m, place))
        # Of each group, in case that it is taken and units are left.
        kept = [Signal(bits, name=f"kept{k}") for k in range(min(_CARRIED, units - 1))]
        word = turned.word_select(part, bits * units) if units < _MOST else turned
        for k in range(units):
            there = (k < end) & ((k >= place) | (part != 0)) if k < units - 1 else end >= units
            unit = word.word_select(k % _MOST, bits)
            data, enable = o.data.word_select(k, bits), o.enable.word_select(k, self.lanes)
            with m.If(put & there):
                m.d.sync += [data.eq(unit), enable.eq(-1)]
            with m.Elif(put & ~begun):
                m.d.sync += enable.eq(0)
                if k < len(kept):
                    m.d.sync += [data.eq(kept[k]), enable.eq(carried.replicate(self.lanes))]
        with m.If(put):
            m.d.sync += [unit.eq(turned.word_select((units + k) % _MOST, bits))
                         for k, unit in enumerate(kept)]

    def _turned(self, m, place):
        """The group's units, that of place p as number p modulo 4: a list of four."""
        pixels = lanes_of(self.i.p)
        of_four = Cat(Cat(p.b, p.g, p.r, Const(0, 8)) for p in pixels)
        of_three = Cat(Cat(p.b, p.g, p.r) for p in pixels)
        mono = Cat(p.g for p in pixels)
        turned = []
        for k in range(_MOST):
            turn = (k - place)[:2] if self.units > 1 else k
            unit = Signal(8 * self.lanes, name=f"turned{k}")
            with m.If(self.format == BGR8.code):
                m.d.comb += unit.eq(of_three.word_select(turn, len(unit)))
            with m.Elif(self.format == MONO8.code):
                m.d.comb += unit.eq(mono)
            with m.Else():
                m.d.comb += unit.eq(of_four.word_select(k, len(unit)))
            turned.append(unit)
        return turned
