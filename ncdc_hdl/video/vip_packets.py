"""Avalon-ST video packets, as in Intel's Video and Image Processing Suite."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["PIXEL", "VIDEO", "VipPackets"]

PIXEL = data.StructLayout({"data": 24, "first": 1, "last": 1})
"""A pixel, red on top, and whether it is a frame's first or last one."""

VIDEO = wiring.Signature({"valid": Out(1), "ready": In(1), "data": Out(24),
                          "startofpacket": Out(1), "endofpacket": Out(1)})
"""Avalon-ST with packets and a ready latency of one clock."""

_CONTROL, _PICTURE = 15, 0      # types of packets
_PROGRESSIVE = 0b0011           # value of the control packet's last symbol
_SYMBOLS = 3                    # symbols of a beat, of eight bits each
_HEADER = 5                     # beats before a frame's pixels


class VipPackets(wiring.Component):
    """Puts a control packet before each frame, and a beat with the packet's type before its pixels.

    The lowest four bits of a packet's first beat are its type: 15 of a control packet, 0 of
    pixels. A control packet has nine symbols, each with four bits in its lowest ones: width and
    height, the upper bits first, and the scan, which is progressive. The lowest symbol of a beat is
    the first. (Intel, "Video and Image Processing Suite User Guide", Avalon Streaming Video.)

    ``ready`` is for the clock after it, as in that suite's cores: a beat is offered only a
    clock after ``ready``, and is then taken.

    Timing: latency 0; five beats more per frame.

    Members
    -------
    i : ``In(stream.Signature(PIXEL))``
    width, height : ``In(16)``
        Size of the frame whose first pixel waits.
    o : ``Out(VIDEO)``
    """

    def __init__(self):
        super().__init__({"i": In(stream.Signature(PIXEL)), "width": In(16), "height": In(16),
                          "o": Out(VIDEO)})

    def elaborate(self, platform):
        m = Module()
        i, o = self.i, self.o
        may = Signal()                      # ``ready`` was high in the clock before
        step = Signal(range(_HEADER + 1))   # beats of the header sent
        m.d.sync += may.eq(o.ready)
        number = Cat(Const(_PROGRESSIVE, 4), self.height, self.width)
        count = len(number) // 4
        nibbles = [number.word_select(count - 1 - k, 4) for k in range(count)]
        m.d.comb += o.valid.eq(i.valid & may)
        with m.If(i.p.first & (step != _HEADER)):
            with m.Switch(step):
                with m.Case(0):
                    m.d.comb += [o.data.eq(_CONTROL), o.startofpacket.eq(1)]
                for k in range(count // _SYMBOLS):
                    with m.Case(1 + k):
                        three = nibbles[_SYMBOLS * k:][:_SYMBOLS]
                        m.d.comb += [
                            o.data.eq(Cat(Cat(nibble, Const(0, 4)) for nibble in three)),
                            o.endofpacket.eq(k == count // _SYMBOLS - 1)]
                with m.Default():
                    m.d.comb += [o.data.eq(_PICTURE), o.startofpacket.eq(1)]
            with m.If(o.valid):
                m.d.sync += step.eq(step + 1)
        with m.Else():
            m.d.comb += [o.data.eq(i.p.data), o.endofpacket.eq(i.p.last), i.ready.eq(may)]
            with m.If(o.valid):
                m.d.sync += step.eq(0)
        return m
