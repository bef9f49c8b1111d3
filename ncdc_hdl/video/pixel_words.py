"""Pixels out of memory words."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["PixelWords"]

_WORD = 32      # bits of a memory word


class PixelWords(wiring.Component):
    """Cuts words of 32 bits into pixels of 3 or 4 bytes, whose lowest three are blue, green, red.

    The first pixel after ``align`` begins with a word's lowest byte. Pixels of 3 bytes are in
    memory without a gap: four of them in three words.

    Timing: latency 0; a pixel per clock. Domain: ``pixel``.

    Parameters
    ----------
    pixel_bytes : int
        3 or 4.

    Members
    -------
    align : ``In(1)``
        The next word begins a pixel; from this clock on.
    i : ``In(stream.Signature(32))``
    o : ``Out(stream.Signature(24))``

    Raises
    ------
    ValueError
        If ``pixel_bytes`` is neither.
    """

    def __init__(self, pixel_bytes):
        if pixel_bytes not in (3, 4):
            raise ValueError(f"a pixel has {pixel_bytes} bytes, 3 or 4 are needed")
        self.pixel_bytes = pixel_bytes
        super().__init__({"align": In(1), "i": In(stream.Signature(_WORD)),
                          "o": Out(stream.Signature(24))})

    def elaborate(self, platform):
        m = Module()
        rest = Signal(24)           # unused bytes of the last word, lowest first
        bytes_left = Signal(2)      # their number
        left = Signal(2)            # the same, 0 while ``align`` is high
        word, o = self.i.payload, self.o
        m.d.comb += left.eq(Mux(self.align, 0, bytes_left))
        with m.Switch(left):
            for count in range(4):
                with m.Case(count):
                    m.d.comb += o.payload.eq(Cat(rest[:8 * count], word)[:24])
        needs_word = left != 3
        m.d.comb += [o.valid.eq(self.i.valid | ~needs_word),
                     self.i.ready.eq(o.ready & needs_word)]
        if self.pixel_bytes == 4:
            return m
        with m.If(o.valid & o.ready):
            # A word of 4 bytes came, or none; 3 bytes left.
            m.d.pixel += bytes_left.eq(left + 1)
            with m.Switch(left):
                for count in range(3):
                    with m.Case(count):
                        m.d.pixel += rest.eq(word[8 * (3 - count):])
        with m.Elif(self.align):
            m.d.pixel += bytes_left.eq(0)
        return m
