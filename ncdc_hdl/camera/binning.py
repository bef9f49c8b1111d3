"""A sensor's rows binned by 2 in both axes, with their Bayer pattern."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.layouts import ROWS
from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.sensors.level import SAMPLE_BITS

__all__ = ["READ_CLOCKS", "Binning"]

READ_CLOCKS = 2     # latency of a row of samples: the memory, and its output register
_SUM = 1


class Binning(wiring.Component):
    """Computes :func:`ncdc_spec.sensors.grid.binned` of the frames that pass, if ``on``.

    A result leaves with the last of its four samples, a row with the end of its lower rows. A row's
    samples after ``width`` are undefined.

    Timing: free-running; ``o`` follows ``i`` after ``latency`` clocks.

    Parameters
    ----------
    width : int
        Samples of the longest row.

    Members
    -------
    on : ``In(1)``
        Constant while a frame is under way.
    i, o : ``In(ROWS)``, ``Out(ROWS)``
    """

    latency = _SUM + READ_CLOCKS + _SUM + 1
    """Sum of two in a row, the row above it, sum of four, output."""

    def __init__(self, width):
        self.width = width
        super().__init__({"on": In(1), "i": In(ROWS), "o": Out(ROWS)})

    def elaborate(self, platform):
        m = Module()
        i, o = self.i, self.o
        x, y = Signal(range(self.width)), Signal(2)     # position of the sample; y modulo 4
        last, before = Signal(SAMPLE_BITS), Signal(SAMPLE_BITS)
        with m.If(i.valid):
            m.d.sync += [x.eq(x + (x != self.width - 1)), last.eq(i.sample), before.eq(last)]
        with m.If(i.row_end):
            m.d.sync += [x.eq(0), y.eq(y + 1)]
        with m.If(~i.frame):
            m.d.sync += [x.eq(0), y.eq(0)]
        second, lower = x[1], y[1]      # second sample of the pair; the lower row of its pair
        # The sums of both upper rows are interleaved in pairs.
        m.submodules.sums = sums = block_memory(SAMPLE_BITS + 1, -(-self.width // 4) * 4)
        write, read = sums.write_port(), sums.read_port()
        pair = register(m, "pair", i.sample + before)
        position = register(m, "position", Cat(x[0], y[0], x[2:]))
        m.d.comb += [write.addr.eq(position), write.data.eq(pair), read.addr.eq(position)]
        m.d.comb += write.en.eq(register(m, "upper", i.valid & second & ~lower, reset_less=False))
        above = register(m, "above", read.data)
        four = register(m, "four", above + delay(m, pair, READ_CLOCKS, "pair") + 2)
        m.d.sync += o.sample.eq(Mux(self.on, four >> 2,
                                    delay(m, i.sample, self.latency - 1, "sample")))
        for name, value in (("valid", i.valid & (~self.on | second & lower)),
                            ("row_end", i.row_end & (~self.on | lower)), ("frame", i.frame)):
            m.d.sync += getattr(o, name).eq(
                delay(m, value, self.latency - 1, name, reset_less=False))
        return m
