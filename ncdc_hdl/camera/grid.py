"""An even Bayer grid between a sensor's pins and its window."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.camera.binning import Binning
from ncdc_hdl.camera.evening import Evening
from ncdc_hdl.camera.layouts import GRID, ROWS

__all__ = ["Grid"]


class Grid(wiring.Component):
    """Computes :func:`ncdc_spec.sensors.grid.gridded` of the frames that pass.

    Timing: free-running; ``o`` follows ``i`` after ``latency`` clocks. Samples and ends of rows
    that the result lacks are left out; evened frames have two more columns and rows in front, see
    :class:`Evening`.

    Parameters
    ----------
    width : int
        Samples of the longest row that a sensor sends.

    Members
    -------
    settings : ``In(GRID)``
        Constant while a frame is under way.
    i, o : ``In(ROWS)``, ``Out(ROWS)``
    """

    latency = Binning.latency + Evening.latency

    def __init__(self, width):
        self.width = width
        super().__init__({"settings": In(GRID), "i": In(ROWS), "o": Out(ROWS)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.binning = binning = Binning(self.width)
        m.submodules.evening = evening = Evening(self.width)
        m.d.comb += [binning.on.eq(self.settings.binning),
                     evening.weight.eq(self.settings.weight)]
        connect(m, flipped(self.i), binning.i)
        connect(m, binning.o, evening.i)
        connect(m, evening.o, flipped(self.o))
        return m
