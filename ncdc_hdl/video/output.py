"""The corrected stream on a VGA connector."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.fifo import AsyncFIFOBuffered
from amaranth.lib.wiring import In, Out

__all__ = ["VideoOut"]


class VideoOut(wiring.Component):
    """Shows each frame of a pixel stream in a video mode, centred, black around it.

    The stream crosses from the domain ``sync`` to the domain ``pixel`` in a queue. A frame begins
    when its first pixel waits at the top of the picture; what comes before is dropped. When the
    queue runs dry the rest of the frame stays black, and the next complete frame is shown.

    Timing: colours and sync pulses are registered; a pixel is on the pins 2 clocks of ``pixel``
    after the counters reach its place.

    Parameters
    ----------
    mode : ncdc_hdl.video.modes.VideoMode
    width, height : int
        Of the stream's frames; not larger than the mode.
    depth : int
        Pixels that the queue holds, a power of two.

    Members
    -------
    valid, ready, data, startofpacket : the stream, red in the top byte of 24
    hsync, vsync, blank_n, r, g, b : to the connector's converter
    """

    def __init__(self, mode, width, height, *, depth=1024):
        self.mode, self.width, self.height, self.depth = mode, width, height, depth
        super().__init__({
            "valid": In(1), "ready": Out(1), "data": In(24), "startofpacket": In(1),
            "hsync": Out(1), "vsync": Out(1), "blank_n": Out(1),
            "r": Out(8), "g": Out(8), "b": Out(8)})

    def elaborate(self, platform):
        m = Module()
        mode = self.mode
        m.submodules.queue = queue = AsyncFIFOBuffered(
            width=25, depth=self.depth, r_domain="pixel", w_domain="sync")
        m.d.comb += [queue.w_data.eq(Cat(self.data, self.startofpacket)),
                     queue.w_en.eq(self.valid), self.ready.eq(queue.w_rdy)]
        first, colour = queue.r_data[24], queue.r_data[:24]

        x, y = Signal(range(sum(mode.horizontal))), Signal(range(sum(mode.vertical)))
        end_x, end_y = x == sum(mode.horizontal) - 1, y == sum(mode.vertical) - 1
        m.d.pixel += x.eq(Mux(end_x, 0, x + 1))
        with m.If(end_x):
            m.d.pixel += y.eq(Mux(end_y, 0, y + 1))

        left, top = (mode.size[0] - self.width) // 2, (mode.size[1] - self.height) // 2
        inside = Signal()
        begins = Signal()
        shown, take = Signal(), Signal()
        showing = Signal()      # the frame that began at the top of the picture goes on
        m.d.comb += [
            inside.eq((x >= left) & (x < left + self.width)
                      & (y >= top) & (y < top + self.height)),
            begins.eq((x == left) & (y == top)),
            shown.eq(inside & queue.r_rdy & Mux(begins, first, showing & ~first)),
            # Out of step, everything up to the next frame's first pixel is dropped.
            take.eq(shown | (queue.r_rdy & ~first & ~showing)),
            queue.r_en.eq(take),
        ]
        with m.If(inside):
            m.d.pixel += showing.eq(shown)

        def pulse(count, lengths):
            start = lengths[0] + lengths[1]
            return ((count >= start) & (count < start + lengths[2])) ^ (not mode.high)
        m.d.pixel += [
            Cat(self.b, self.g, self.r).eq(Mux(shown, colour, 0)),
            self.blank_n.eq((x < mode.size[0]) & (y < mode.size[1])),
            self.hsync.eq(pulse(x, mode.horizontal)), self.vsync.eq(pulse(y, mode.vertical)),
        ]
        return m
