"""Raw rows of the nodes of a row, for the nodes below them."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.memory import Fifo
from ncdc_hdl.lib.pipeline import DelayMemory, register
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.nodes import row_nodes
from ncdc_spec.view_rows import ROW_BITS

__all__ = ["RawRows"]


class RawRows(wiring.Component):
    """Queue from the raw row of each node to the node below, which needs it to choose its matrix.

    Equal to ``ncdc_model.golden.view_rows.next_rows``. The nodes of a row leave the network in the
    order in which those below them enter it, so that a queue suffices. A strip's last row is not
    queued, and its first one, which takes row 0, takes nothing from the queue.

    Timing: ``row`` is the one of the node that is issued next; ``ready`` is high if it is there,
    ``latency`` clocks after the node above has arrived. Nodes are at least 4 clocks apart.

    Parameters
    ----------
    coordinate : Q
        Format of ``y``.
    nodes : int
        S.
    way : int
        Clocks from a node's ``issue`` to its ``arrive``.

    Members
    -------
    start : ``In(1)``
        Begins a frame, and drops what an aborted one has left; no node is under way.
    issue, top, bottom : ``In(1)``
        A node is issued, in the first row of its strip, in its last row.
    ready : ``Out(1)``
    row : ``Out(ROW_BITS)``
    arrive, y, fits : ``In(1)``, ``In(signed(coordinate.width))``, ``In(1)``
        A node leaves the network, its raw row, and whether that has a meaning.
    """

    latency = 2 + Fifo.latency
    """Clocks from a node's arrival to its row at ``row``: rounding, limits, the queue."""

    def __init__(self, coordinate, nodes, way):
        self.coordinate, self.nodes, self.way = coordinate, nodes, way
        super().__init__({
            "start": In(1), "issue": In(1), "top": In(1), "bottom": In(1), "ready": Out(1),
            "row": Out(ROW_BITS), "arrive": In(1), "y": In(signed(coordinate.width)),
            "fits": In(1)})

    def elaborate(self, platform):
        m = Module()
        fifo = Fifo(width=ROW_BITS, depth=row_nodes(MAX_SIZE, self.nodes))
        m.submodules.fifo = ResetInserter(self.start)(fifo)
        m.submodules.wanted = wanted = DelayMemory(1, self.way)
        m.d.comb += wanted.i.eq(~self.bottom)
        # The row below, rounded to nearest.
        f_bits = self.coordinate.f_bits
        below = register(m, "below", (self.y + (3 << f_bits - 1)) >> f_bits)
        fits = register(m, "fitting", self.fits)
        arrived = register(m, "arrived", self.arrive & wanted.o, reset_less=False)
        # Its limits.
        limited = Mux(below[ROW_BITS:].any(), ~below[-1].replicate(ROW_BITS), below[:ROW_BITS])
        m.d.comb += [
            fifo.w_data.eq(register(m, "limited", Mux(fits, limited, 0))),
            fifo.w_en.eq(register(m, "limited_arrived", arrived, reset_less=False)),
            self.ready.eq(fifo.r_rdy), fifo.r_en.eq(self.issue & ~self.top),
            self.row.eq(Mux(self.top, 0, fifo.r_data)),
        ]
        return m
