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
from ncdc_spec.view_list import PITCH_BITS

__all__ = ["FORMAT", "Packer"]

FORMAT = range(len(OUTPUT_FORMATS))     # codes of formats
_MAX_UNITS = BGRX8.pixel_bytes               # most units of a group
_CARRIED = BGR8.pixel_bytes - 1         # most units that a group leaves for another word


class Packer(wiring.Component):
    """Gathers pixels, in the format that a register chooses, into words, each with its address.

    Pixel (u, v) goes to ``base + n (v width + u)``, n the bytes of a pixel; the pixels come in the
    order of :class:`Strips`. Rows of a raster follow each other without a gap. A row of a strip
    begins and ends with words of its own: bytes of pixels of other strips are not
    enabled. The frame's last word is sent as soon as the last pixel has come.

    Bytes are moved in units of one byte per lane: every group has n units, and begins at
    a multiple. A group of three units may end in a later word than it begins in. It is taken with
    the last word that it completes. Further units are carried into the next group's word, or
    sent in a word of their own at the end of a row.

    With ``placed`` a picture's first pixel is at ``origin``, and rows may be a ``pitch`` apart.
    Each row of such a picture begins and ends with words of its own, as in a strip.

    Only whole words inside ``base`` .. ``limit`` - 1 are sent. From the first word
    outside on, nothing more of the frame is sent but a void word for its end.

    Timing: latency 1; one group per clock, or a clock for each word that it completes. The
    first group comes at least ``Strips.latency`` clocks after ``start``.

    Parameters
    ----------
    data_width : int
        Bits of a word.
    lanes : int
        Pixels of a group: 1, 2 or 4.
    placed : bool
        Whether there are ``origin`` and ``pitch``.

    Members
    -------
    start : ``In(1)``
        Begins a frame, with nothing left of the last one.
    format : ``In(FORMAT)``
        Code of an ``OutputFormat``. Constant in a frame, as are the next three.
    base, limit, order : ``In(32)``, ``In(32)``, ``In(ORDER)``
        Byte address of the frame, a multiple of the word, and of the end of its area; sizes,
        with a height of at least 2 if there are several strips.
    origin, pitch : ``In(32)``, ``In(PITCH_BITS)``
        Byte address of the first pixel; bytes from row to row, or 0 if rows follow without a gap.
        Multiples of the word, constant from the clock of ``start`` to the end of the frame.
    reject : ``In(1)``
        No word of this frame is sent; high before its first pixel comes.
    outside : ``Out(1)``
        Pixels outside the area are dropped.
    i : ``In(stream.Signature(pixel_layout(lanes)))``
    o : ``Out(stream.Signature(word_layout(data_width)))``
    """

    latency = 1

    def __init__(self, data_width, lanes=1, placed=False):
        self.data_width, self.lanes, self.placed = data_width, lanes, placed
        self.units = data_width // (8 * lanes)      # units of a word
        super().__init__({"start": In(1), "format": In(FORMAT), "base": In(ADDRESS_BITS),
                          "limit": In(ADDRESS_BITS), "order": In(ORDER), "reject": In(1),
                          "outside": Out(1), "i": In(stream.Signature(pixel_layout(lanes))),
                          "o": Out(stream.Signature(word_layout(data_width)))}
                         | ({"origin": In(ADDRESS_BITS), "pitch": In(PITCH_BITS)}
                            if placed else {}))

    def elaborate(self, platform):
        m = Module()
        units, word_bits = self.units, exact_log2(self.data_width // 8)
        # At least one bit: Verilog has no signals without bits.
        part = Signal(range(max(2, _MAX_UNITS // units)))    # earlier words that the group is in
        number = Signal(ADDRESS_BITS - word_bits)       # number of the word
        position = Signal(exact_log2(units))            # unit of the word in which the group begins
        end = Signal(range(units + _MAX_UNITS))         # unit after the group, from this word on
        carried = Signal()                              # units of the last group are in the word
        begun = Signal()                                # the word has pixels already
        put = Signal()                                  # pixels go into the word
        closed = Signal()                               # nothing more of the frame is sent

        m.submodules.strips = strips = Strips(self.lanes)
        apart = ~strips.raster | (self.pitch != 0) if self.placed else ~strips.raster
        in_strips = register(m, "in_strips", apart)
        ending = self.i.p.last | (strips.last_column & in_strips)
        complete = end >= units
        # Units that complete no word wait for the next group, if there is one.
        final = (end <= units) | (end < 2 * units) & ~ending
        last = self.i.p.last & final
        first, limit, present = (value[word_bits:] for value in (self.base, self.limit,
                                                                  Cat(Const(0, word_bits), number)))
        inside = self._inside(present, first, limit)
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
        self._fill(m, put, part, position, end, begun, carried)
        next_number = Signal(len(number))               # number of the next word
        m.d.comb += next_number.eq(number + 1)
        self._advance(m, put, final, strips, Cat(position, number), end,
                      Mux(complete, next_number, number))
        with m.If(self.start):
            m.d.sync += [closed.eq(self._unaligned(word_bits)),
                         begun.eq(0), carried.eq(0), part.eq(0)]
        with m.Elif(put & ~inside | self.reject):
            m.d.sync += closed.eq(1)
        return m

    @staticmethod
    def _inside(number, first, end):
        """Whether a word is in the frame's area; arguments count words.

        A method of its own only so that proofs and tests can break it.
        """
        return (number >= first) & (number < end)

    @property
    def _origin(self):
        """Byte address of the first pixel."""
        return self.origin if self.placed else self.base

    def _unaligned(self, word_bits):
        """Whether the buffer, or the picture in it, does not begin with a word."""
        base = self.base[:word_bits] != 0
        return base | (self.origin[:word_bits] != 0) if self.placed else base

    def _by_format(self, of_mono, of_bgr, otherwise):
        """The value for the format."""
        return Mux(self.format == BGR8.code, of_bgr,
                   Mux(self.format == MONO8.code, of_mono, otherwise))

    def _advance(self, m, put, final, strips, address, end, number):
        """Set ``address``, of the next group, in units, and ``end``; ``number``: of the word that
        is filled next."""
        lane_bits, unit_bits = exact_log2(self.lanes), exact_log2(self.units)
        size = self._by_format(1, BGR8.pixel_bytes, _MAX_UNITS)      # units of a group
        width = self.order.width[lane_bits:]
        # Units from row to row.
        stride = Signal(range(max((_MAX_UNITS << len(width)) + 1, 1 << PITCH_BITS - lane_bits)
                              if self.placed else (_MAX_UNITS << len(width)) + 1))
        row = Signal(len(address))              # address of the first group in the row of the strip
        next_strip = Signal(len(address))       # address of the first group of the next strip
        top = Signal()                          # the row is the picture's first
        below = Signal(len(address))            # address of the first group in the row below
        gapless = self._by_format(width, BGR8.pixel_bytes * width, _MAX_UNITS * width)
        m.d.sync += stride.eq(Mux(self.pitch == 0, gapless, self.pitch[lane_bits:])
                              if self.placed else gapless)
        following = Cat(end[:unit_bits], number)
        m.d.comb += below.eq(row + stride)
        anew = Mux(strips.last_row, next_strip, below)
        with m.If(put):
            m.d.sync += address[unit_bits:].eq(number)
            with m.If(~final):
                m.d.sync += end.eq(end - self.units)
            with m.Elif(strips.last_column):
                m.d.sync += [address.eq(anew), end.eq(anew[:unit_bits] + size), row.eq(anew),
                             top.eq(strips.last_row)]
                # The next strip begins where the first row of this one ends.
                with m.If(top):
                    m.d.sync += next_strip.eq(following)
            with m.Else():
                m.d.sync += [address.eq(following), end.eq(end[:unit_bits] + size)]
        with m.If(self.start):
            first = self._origin[lane_bits:]
            m.d.sync += [address.eq(first), end.eq(size), row.eq(first), top.eq(1)]

    def _fill(self, m, put, part, position, end, begun, carried):
        """Put the group's units in the word into it, and those carried into it, which
        the group follows without a gap."""
        units, bits, o = self.units, 8 * self.lanes, self.o.p
        turned = Cat(self._turned(m, position))
        # Units of each group that are left for the next word.
        held = [Signal(bits, name=f"held{k}") for k in range(min(_CARRIED, units - 1))]
        word = turned.word_select(part, bits * units) if units < _MAX_UNITS else turned
        for k in range(units):
            there = (k < end) & ((k >= position) | (part != 0)) if k < units - 1 else end >= units
            unit = word.word_select(k % _MAX_UNITS, bits)
            data, enable = o.data.word_select(k, bits), o.enable.word_select(k, self.lanes)
            with m.If(put & there):
                m.d.sync += [data.eq(unit), enable.eq(-1)]
            with m.Elif(put & ~begun):
                m.d.sync += enable.eq(0)
                if k < len(held):
                    m.d.sync += [data.eq(held[k]), enable.eq(carried.replicate(self.lanes))]
        with m.If(put):
            m.d.sync += [unit.eq(turned.word_select((units + k) % _MAX_UNITS, bits))
                         for k, unit in enumerate(held)]

    def _turned(self, m, position):
        """The group's units rotated: a list of four, with the unit of position p at p modulo 4."""
        pixels = lanes_of(self.i.p)
        of_four = Cat(Cat(p.b, p.g, p.r, Const(0, 8)) for p in pixels)
        of_three = Cat(Cat(p.b, p.g, p.r) for p in pixels)
        mono = Cat(p.g for p in pixels)
        turned = []
        for k in range(_MAX_UNITS):
            turn = (k - position)[:2] if self.units > 1 else k
            unit = Signal(8 * self.lanes, name=f"turned{k}")
            with m.If(self.format == BGR8.code):
                m.d.comb += unit.eq(of_three.word_select(turn, len(unit)))
            with m.Elif(self.format == MONO8.code):
                m.d.comb += unit.eq(mono)
            with m.Else():
                m.d.comb += unit.eq(of_four.word_select(k, len(unit)))
            turned.append(unit)
        return turned
