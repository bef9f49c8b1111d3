"""The newest corrected frame in memory on a screen, at the screen's own rate."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.cdc import FFSynchronizer, PulseSynchronizer
from amaranth.lib.fifo import AsyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ReadHost
from ncdc_hdl.video.beam import Beam
from ncdc_hdl.video.frame_reader import SCREEN, FrameReader, marked
from ncdc_hdl.video.pixel_words import PixelWords

__all__ = ["PICTURE", "ScanOut"]

PICTURE = data.StructLayout({"b": 8, "g": 8, "r": 8, "visible": 1, "hsync": 1, "vsync": 1})
"""Signals to a screen for each pixel clock."""

_WORD = 32
_READ_AHEAD = 128       # fewest words requested and not yet received


class ScanOut(wiring.Component):
    """Shows the newest corrected frame, centred, black around it.

    After each picture the store's newest frame is claimed. It stays claimed, and so intact, until
    the next picture has been shown. Without a new one the old one is shown again. Words are
    prefetched through a queue from the domain ``sync`` to ``pixel``. If the queue runs dry
    within a picture, its rest is black, and ``underruns`` counts; the next one is right again.
    Before the first frame the screen is black. A reset of ``sync`` alone must last at least a clock
    of each domain: the queue misses a shorter one, and gives old words in the next picture.

    Timing: a pixel is at ``picture`` 1 clock of ``pixel`` after the beam's counters reach it.

    Parameters
    ----------
    mode : ncdc_hdl.video.modes.VideoMode
    width, height : int
        Size of the frames; not larger than the mode.
    pixel_bytes : int
        Bytes of a pixel in memory: 3 (BGR8) or 4 (BGRX8).
    depth : int
        Words that the queue holds, a power of two.
    max_burst : int
        Words of a burst.

    Members
    -------
    screen : ``Out(SCREEN)``
    bus : ``Out(ReadHost(32, max_burst))``
    memory_rst : ``In(1)``
    picture : ``Out(PICTURE)``
        In the domain ``pixel``.
    shown, underruns : ``Out(32)``, ``Out(32)``
        Pictures with a frame begun since the reset; pictures whose words came too late.

    Raises
    ------
    ValueError
        If a frame is larger than the mode.
    """

    latency = 1
    """Clocks of ``pixel`` from the beam's position to ``picture``."""

    def __init__(self, mode, width, height, *, pixel_bytes=3, depth=1024, max_burst=32):
        if width > mode.size[0] or height > mode.size[1]:
            raise ValueError(f"the frames have {width}x{height} pixels, the mode "
                             f"{mode.size[0]}x{mode.size[1]}")
        self.mode, self.width, self.height = mode, width, height
        self.pixel_bytes, self.depth, self.max_burst = pixel_bytes, depth, max_burst
        self.words = -(-width * height * pixel_bytes // (_WORD // 8))
        super().__init__({
            "screen": Out(SCREEN), "bus": Out(ReadHost(_WORD, max_burst)), "memory_rst": In(1),
            "picture": Out(PICTURE), "shown": Out(32), "underruns": Out(32)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.reader = reader = FrameReader(
            _WORD, self.words, depth=max(_READ_AHEAD, 4 * self.max_burst), max_burst=self.max_burst)
        m.submodules.queue = queue = AsyncFIFOBuffered(
            width=_WORD + 1, depth=self.depth, r_domain="pixel", w_domain="sync")
        m.submodules.beam = beam = Beam(self.mode)
        m.submodules.begin = begin = PulseSynchronizer("pixel", "sync")
        m.submodules.late = late = PulseSynchronizer("pixel", "sync")
        some = Signal()             # ``reader.some``; it changes only in the vertical blanking
        m.submodules.some = FFSynchronizer(reader.some, some, o_domain="pixel")
        wiring.connect(m, reader.screen, wiring.flipped(self.screen))
        wiring.connect(m, reader.bus, wiring.flipped(self.bus))
        m.d.comb += [
            reader.memory_rst.eq(self.memory_rst), reader.begin.eq(begin.o),
            begin.i.eq(beam.below),
            queue.w_data.eq(reader.o.payload), queue.w_en.eq(reader.o.valid),
            reader.o.ready.eq(queue.w_rdy),
        ]
        with m.If(begin.o & reader.some):
            m.d.sync += self.shown.eq(self.shown + 1)
        with m.If(late.o):
            m.d.sync += self.underruns.eq(self.underruns + 1)
        self._show(m, queue, beam, some, late)
        return m

    def _show(self, m, queue, beam, some, late):
        """The side of the domain ``pixel``: pixels out of the queue, synchronous to the beam."""
        m.submodules.pixels = pixels = PixelWords(self.pixel_bytes)
        top = data.View(marked(_WORD), queue.r_data)
        left, above = ((all_ - size) // 2 for all_, size in zip(self.mode.size,
                                                                (self.width, self.height)))
        inside = Signal()           # the beam is in the frame
        first = Signal()            # the beam is on its first pixel
        last = Signal()             # the beam is on its last one
        going = Signal()            # the frame is shown, up to the last pixel
        lit = Signal()              # this pixel is shown
        m.d.comb += [
            inside.eq((beam.x >= left) & (beam.x < left + self.width)
                      & (beam.y >= above) & (beam.y < above + self.height)),
            first.eq((beam.x == left) & (beam.y == above)),
            last.eq((beam.x == left + self.width - 1) & (beam.y == above + self.height - 1)),
            pixels.align.eq(first), pixels.i.payload.eq(top.word),
            # The first pixel waits for a first word, no other takes one.
            pixels.i.valid.eq(queue.r_rdy & (top.first == first)),
            pixels.o.ready.eq(inside & (first | going)),
            lit.eq(pixels.o.ready & pixels.o.valid),
            # Without synchronisation, words are dropped up to the next frame's first one.
            queue.r_en.eq(pixels.i.ready & pixels.i.valid
                          | queue.r_rdy & ~top.first & ~going & ~first),
            late.i.eq(some & last & ~lit),
        ]
        with m.If(inside):
            m.d.pixel += going.eq(lit & ~last)
        m.d.pixel += [
            Cat(self.picture.b, self.picture.g, self.picture.r).eq(
                Mux(lit, pixels.o.payload, 0)),
            self.picture.visible.eq(beam.visible), self.picture.hsync.eq(beam.hsync),
            self.picture.vsync.eq(beam.vsync)]
