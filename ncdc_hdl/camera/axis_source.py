"""AXI4-Stream video as a stream of samples."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.layouts import SIZE_BITS
from ncdc_hdl.camera.samples import samples
from ncdc_hdl.lib.pipeline import register
from ncdc_spec.errors import InputError
from ncdc_spec.sensors.level import SAMPLE_BITS

__all__ = ["AxisSource", "BITS", "COUNTS"]

BITS = (8, 10, 12, 16)
COUNTS = (1, 2, 4)


class AxisSource(wiring.Component):
    """Takes video as vendors' CSI-2 cores give it: TUSER with a frame's first beat, TLAST with the
    last beat of a row. A beat has ``count`` samples without bits between them, the first lowest.

    It is always ready. A frame ends with the last beat of row ``height``. One that has fewer rows
    when the next one begins lacks its ``end``, and is reported. Beats after the last row of a
    frame, and before its first beat, are dropped, and each row of them is reported.

    Timing: free-running; a beat leaves ``latency`` clocks after it came.

    Parameters
    ----------
    count : int
        One of :data:`COUNTS`.
    bits : int
        One of :data:`BITS`; of 16 the upper 12 count.

    Members
    -------
    tdata, tvalid, tready, tuser, tlast
    height : ``In(SIZE_BITS)``
        Rows of a frame, at least 1; constant while a frame is under way.
    o : ``Out(samples(count))``
    short, stray : ``Out(1)``
        High for a clock: a frame had too few rows, a row was outside of a frame.

    Raises
    ------
    InputError
        If the number of samples or of bits is not supported.
    """

    latency = 1

    def __init__(self, count, bits):
        for name, value, known in (("samples per clock", count, COUNTS),
                                   ("bits per sample", bits, BITS)):
            if value not in known:
                raise InputError(f"an AXI4-Stream camera has {', '.join(map(str, known[:-1]))} or "
                                 f"{known[-1]} {name}, not {value}")
        self.count, self.bits = count, bits
        # The interface's data are whole bytes.
        super().__init__({
            "tdata": In(-(-count * bits // 8) * 8), "tvalid": In(1), "tready": Out(1, init=1),
            "tuser": In(1), "tlast": In(1), "height": In(SIZE_BITS), "o": Out(samples(count)),
            "short": Out(1), "stray": Out(1)})

    def elaborate(self, platform):
        m = Module()
        left = Signal(SIZE_BITS)        # rows that are to come after this one
        open_ = Signal()                # a frame is under way
        begins, inside, ends = Signal(), Signal(), Signal()
        rows = Mux(begins, self.height - 1, left)
        m.d.comb += [
            self.tready.eq(1), begins.eq(self.tvalid & self.tuser),
            inside.eq(begins | self.tvalid & open_),
            ends.eq(inside & self.tlast & (rows == 0))]
        with m.If(inside):
            m.d.sync += [open_.eq(~ends), left.eq(rows - self.tlast)]
        for k in range(self.count):
            sample = self.tdata.word_select(k, self.bits)
            m.d.comb += self.o.sample[k].eq(register(
                m, f"sample{k}", sample[-SAMPLE_BITS:] if self.bits > SAMPLE_BITS
                else Cat(Const(0, SAMPLE_BITS - self.bits), sample)))
        m.d.comb += [signal.eq(register(m, f"{name}_", value, reset_less=False))
                     for name, signal, value in (
                         ("valid", self.o.valid, inside.replicate(self.count)),
                         ("first", self.o.first, begins),
                         ("last", self.o.last, inside & self.tlast),
                         ("end", self.o.end, ends), ("short", self.short, begins & open_),
                         ("stray", self.stray, self.tvalid & self.tlast & ~inside))]
        return m
