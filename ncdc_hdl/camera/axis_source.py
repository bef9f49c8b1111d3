"""AXI4-Stream video as a stream of samples."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.layouts import SIZE_BITS, VIDEO_FAULTS
from ncdc_hdl.camera.samples import samples, upper
from ncdc_hdl.camera.video_frames import VideoFrames
from ncdc_hdl.lib.pipeline import register

__all__ = ["AxisSource"]


class AxisSource(wiring.Component):
    """Takes video as vendors' CSI-2 cores give it: TUSER with a frame's first beat, TLAST with the
    last beat of a row. A beat has ``count`` samples without bits between them, the first lowest.

    A frame ends with the last beat of row ``height``. TREADY is low for some clocks after it only.
    A frame that has fewer rows when the next one begins ends as bad. Beats after the last row of a
    frame, and before its first beat, are dropped.

    Timing: free-running; a beat leaves ``latency`` clocks after it was taken.

    Parameters
    ----------
    count, bits : int
        Samples of a beat: 1, 2 or 4; bits of a sample: 8, 10, 12, or 16, of which the upper 12
        count.

    Members
    -------
    tdata, tvalid, tready, tuser, tlast
    height : ``In(SIZE_BITS)``
        Rows of a frame, at least 1; constant while a frame is under way.
    o : ``Out(samples(count))``
    faults : ``Out(VIDEO_FAULTS)``
    """

    latency = 1

    def __init__(self, count, bits):
        self.count, self.bits = count, bits
        # The interface's data are whole bytes.
        super().__init__({
            "tdata": In(-(-count * bits // 8) * 8), "tvalid": In(1), "tready": Out(1, init=1),
            "tuser": In(1), "tlast": In(1), "height": In(SIZE_BITS), "o": Out(samples(count)),
            "faults": Out(VIDEO_FAULTS)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.frames = frames = VideoFrames()
        left = Signal(SIZE_BITS)        # rows that are to come after this one
        rows = Mux(self.tuser, self.height - 1, left)
        m.d.comb += [
            frames.valid.eq(self.tvalid), frames.first.eq(self.tuser),
            frames.last.eq(self.tlast & (rows == 0)), self.tready.eq(frames.ready)]
        inside = frames.inside
        with m.If(inside):
            m.d.sync += left.eq(rows - self.tlast)
        for k in range(self.count):
            m.d.comb += self.o.sample[k].eq(register(
                m, f"sample{k}", upper(self.tdata.word_select(k, self.bits))))
        outputs = {
            "valid": inside.replicate(self.count), "first": inside & self.tuser,
            "last": inside & self.tlast, "end": inside & frames.last | frames.short,
            "bad": frames.short}
        m.d.comb += [getattr(self.o, name).eq(register(m, f"{name}_", value, reset_less=False))
                     for name, value in outputs.items()]
        stray = self.tvalid & self.tready & self.tlast & ~inside
        m.d.comb += [self.faults.short.eq(self.o.bad),
                     self.faults.stray.eq(register(m, "stray_", stray, reset_less=False))]
        return m
