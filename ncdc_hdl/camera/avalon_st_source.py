"""Avalon-ST video as a stream of samples."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.layouts import SIZE_BITS, VIDEO_FAULTS, VIP_FAULTS
from ncdc_hdl.camera.samples import samples, upper
from ncdc_hdl.camera.video_frames import VideoFrames
from ncdc_hdl.lib.pipeline import register

__all__ = ["AvalonStSource"]

_CONTROL, _VIDEO = 15, 0    # types of packets
_TYPE_BITS = 4              # lowest ones of a packet's first beat
_SIZES = 16                 # bits of a width or a height in a control packet, four in a symbol


class AvalonStSource(wiring.Component):
    """Takes video whose frames are packets of ``count`` symbols per beat, the first one lowest.

    A row ends after ``width`` samples, a frame with its packet. With ``control`` a packet's
    first beat is its type, as in Intel's Video and Image Processing Suite. Type 0 is a frame. Type
    15 is a control packet: frames after one of another size are bad. Other types are skipped.

    ``ready`` is for the same clock (ready latency 0), and low for some clocks after a packet only.
    A packet that begins within another one ends it as bad. Beats outside of a packet are dropped.

    Timing: free-running; a beat leaves ``latency`` clocks after it was taken.

    Parameters
    ----------
    count, bits : int
        Samples of a beat: 1, 2 or 4; bits of a sample: 8, 10, 12, or 16, of which the upper 12
        count.
    control : bool
        Packets have types.

    Members
    -------
    data, valid, ready, startofpacket, endofpacket, empty
        ``empty``, the symbols of a packet's last beat that do not count, with several only.
    width, height : ``In(SIZE_BITS)``
        Of a frame; constant while one is under way. ``height`` with ``control`` only.
    o : ``Out(samples(count))``
    faults : ``Out(VIDEO_FAULTS)``, with ``control`` ``Out(VIP_FAULTS)``
    """

    latency = 1

    def __init__(self, count, bits, control=False):
        self.count, self.bits, self.control = count, bits, control
        super().__init__({
            "data": In(count * bits), "valid": In(1), "ready": Out(1, init=1),
            "startofpacket": In(1), "endofpacket": In(1),
            **({} if count == 1 else {"empty": In(range(count))}),
            "width": In(SIZE_BITS), **({"height": In(SIZE_BITS)} if control else {}),
            "o": Out(samples(count)), "faults": Out(VIP_FAULTS if control else VIDEO_FAULTS)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.frames = frames = VideoFrames()
        m.d.comb += [
            frames.valid.eq(self.valid), frames.first.eq(self.startofpacket),
            frames.last.eq(self.endofpacket), self.ready.eq(frames.ready)]
        if self.control:
            samples_here, first, short, wrong = self._packets(m, frames)
        else:
            samples_here, first, short, wrong = (
                frames.inside, self.startofpacket, frames.short, Const(0))
        left = Signal(SIZE_BITS)        # samples of the row that are to come
        now = Mux(first, self.width, left)
        row_ends = self.endofpacket | (now <= self.count)
        with m.If(samples_here):
            m.d.sync += left.eq(Mux(row_ends, self.width, now - self.count))
        for k in range(self.count):
            m.d.comb += self.o.sample[k].eq(register(
                m, f"sample{k}", upper(self.data.word_select(k, self.bits))))
        empty = Mux(self.endofpacket, getattr(self, "empty", 0), 0)
        ends = samples_here & self.endofpacket | short
        outputs = {
            "valid": Cat(samples_here, *(samples_here & (empty < self.count - k)
                                         for k in range(1, self.count))),
            "first": samples_here & first, "last": samples_here & row_ends, "end": ends,
            "bad": short | wrong}
        m.d.comb += [getattr(self.o, name).eq(register(m, f"{name}_", value, reset_less=False))
                     for name, value in outputs.items()]
        found = {"short": short, "size": ends & wrong,
                 "stray": self.valid & self.ready & self.endofpacket & ~frames.inside}
        m.d.comb += [self.faults[name].eq(register(m, f"{name}_", found[name], reset_less=False))
                     for name, _ in self.faults.shape()]
        return m

    def _packets(self, m, frames):
        """Of packets with types: samples of a frame are here, they are its first ones, the frame
        under way is short, it has another size."""
        video, control, fresh, sized, wrong = (Signal() for _ in range(5))
        size = Signal(2 * _SIZES)               # of the last control packet
        symbols = len(size) // 4
        beats = Signal(range(symbols // self.count + 1))    # of the control packet, until it has it
        kind = self.data[:_TYPE_BITS]
        payload = frames.inside & ~self.startofpacket
        with m.If(frames.inside & self.startofpacket):
            expected = Cat(self.height, Const(0, _SIZES - SIZE_BITS), self.width)
            m.d.sync += [video.eq(kind == _VIDEO), control.eq(kind == _CONTROL), fresh.eq(1),
                         beats.eq(0), wrong.eq(sized & (size != expected))]
        with m.Elif(payload):
            m.d.sync += fresh.eq(0)
            with m.If(control & (beats != symbols // self.count)):
                nibbles = [self.data.word_select(k, self.bits)[:4] for k in range(self.count)]
                m.d.sync += [size.eq(Cat(*reversed(nibbles), size)), beats.eq(beats + 1),
                             sized.eq(1)]
        return payload & video, fresh, frames.short & video & ~fresh, wrong
