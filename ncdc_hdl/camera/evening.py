"""A sensor's rows moved to an even grid, along rows and columns."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.binning import READ_CLOCKS
from ncdc_hdl.camera.layouts import GRID, ROWS
from ncdc_hdl.camera.moved import TAPS, Moved
from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.sensors.level import SAMPLE_BITS

__all__ = ["Evening"]

_UNMOVED = 2        # first samples of a line, as in the golden model


class Evening(wiring.Component):
    """Computes :func:`ncdc_spec.sensors.grid.evened` of the frames that pass.

    With sample (x, y) sample (x - 2, y - 2) of the result leaves. The results of the first two
    columns and rows are undefined, and so is the rest of a row longer than ``width``. With
    ``weight`` 0 each sample leaves unchanged.

    Timing: free-running; ``o`` follows ``i`` after ``latency`` clocks. Rows have at least three
    samples.

    Parameters
    ----------
    width : int
        Samples of the longest row.

    Members
    -------
    weight : ``In(2)``
        Constant while a frame is under way.
    i, o : ``In(ROWS)``, ``Out(ROWS)``
    """

    latency = (1 + Moved.latency) + (READ_CLOCKS + Moved.latency)
    """Taps of a row, and their result; the same for a column."""

    def __init__(self, width):
        self.width = width
        super().__init__({"weight": In(GRID["weight"].shape), "i": In(ROWS), "o": Out(ROWS)})

    def elaborate(self, platform):
        m = Module()
        sample, now = self._along_rows(m)
        sample, now = self._along_columns(m, sample, now)
        m.d.comb += [self.o.sample.eq(sample),
                     *(getattr(self.o, name).eq(value) for name, value in now.items())]
        return m

    def _along_rows(self, m):
        """Moved samples of a row, with what happens in their clocks."""
        i = self.i
        taps = Signal(TAPS, reset_less=True)
        with m.If(i.valid):
            m.d.sync += taps.eq(Cat(i.sample, *(taps[k] for k in range(4))))
        index = _index(m, "index", i.valid, i.row_end | ~i.frame)
        return self._moved(m, "row", taps, register(m, "index_d", index), {
            name: register(m, f"{name}_i", getattr(i, name), reset_less=False)
            for name in ("frame", "valid", "row_end")})

    def _along_columns(self, m, sample, now):
        """The same for columns: a memory has the last four rows, a word the four samples of a
        column."""
        column = Signal(range(self.width))
        with m.If(now["row_end"] | ~now["frame"]):
            m.d.sync += column.eq(0)
        with m.Elif(now["valid"]):
            m.d.sync += column.eq(column + (column != self.width - 1))
        index = _index(m, "row", now["row_end"], ~now["frame"])
        m.submodules.rows = rows = block_memory(4 * SAMPLE_BITS, self.width)
        write, read = rows.write_port(), rows.read_port()
        above = register(m, "above", read.data)
        sample = delay(m, sample, READ_CLOCKS, "sample")
        index = delay(m, index, READ_CLOCKS, "row")
        now = {name: delay(m, value, READ_CLOCKS, name, reset_less=False)
               for name, value in now.items()}
        m.d.comb += [read.addr.eq(column), write.addr.eq(delay(m, column, READ_CLOCKS, "column")),
                     write.data.eq(Cat(sample, above)), write.en.eq(now["valid"])]
        taps = Signal(TAPS)
        m.d.comb += taps.eq(Cat(sample, above))
        return self._moved(m, "column", taps, index, now)

    def _moved(self, m, name, taps, index, now):
        """The middle one of ``taps`` moved; ``index`` is that of the newest."""
        m.submodules[name] = moved = Moved()
        first = index < 2 + _UNMOVED
        # A sample that does not move leaves with its own clock.
        middle = Mux(self.weight.any(), taps[2], taps[0])
        m.d.comb += [moved.taps.eq(Cat(taps[0], taps[1], middle, taps[3], taps[4])),
                     moved.odd.eq(index[0]),
                     moved.weight.eq(Mux(first, 0, self.weight))]
        return moved.o, {key: delay(m, value, moved.latency, f"{name}_{key}", reset_less=False)
                         for key, value in now.items()}


def _index(m, name, step, clear):
    """Index of a line's sample; 6 wraps to 4, so that even and odd are preserved."""
    index = Signal(3, name=name)
    with m.If(clear):
        m.d.sync += index.eq(0)
    with m.Elif(step):
        m.d.sync += index.eq(Mux(index[2], Cat(~index[0], index[1:]), index + 1))
    return index
