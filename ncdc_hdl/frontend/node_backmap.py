"""The front end with the network at nodes."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.frontend.between import NodesToCoordinates
from ncdc_hdl.frontend.layouts import (
    coordinate_layout,
    network_ports,
    scan_layout,
    view_layout,
    view_rows_ports,
)
from ncdc_hdl.frontend.node_network import NodeNetwork
from ncdc_hdl.frontend.scan import Scan
from ncdc_hdl.frontend.segments import Segments
from ncdc_hdl.frontend.signatures import SpansRequest
from ncdc_hdl.frontend.valid import ValidTable
from ncdc_hdl.lib.credits import CreditQueue
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.hardware import Hardware
from ncdc_spec.view import COLUMN

__all__ = ["NodeBackMap"]

_QUEUE = 64     # groups in the queue and on the way to it
_LOOKUP = ValidTable.latency + 2    # clocks from a position to whether it has a source


class NodeBackMap(wiring.Component):
    """Network at nodes, coordinates between them, queue; replaces :class:`BackMap`.

    Equal bit for bit to ``ncdc_model.golden.network.coordinates`` of a descriptor with these nodes,
    or with a view to ``ncdc_model.golden.view.view_coordinates``.
    The nodes are computed earlier than the pixels, into their own queue. The scan of pixels waits
    for a node only when it reaches one. Timing: one group of pixels per clock, as long as the
    network gives the nodes of a row in the clocks of its groups; ``start_latency`` to the first
    one.

    Parameters
    ----------
    hidden_neurons : int
        HN.
    formats : ncdc_spec.descriptor.Formats
        Formats of the descriptor.
    nodes : int
        S, above 1.
    variant : str
        Variant of the tan-sigmoid.
    hardware : ncdc_spec.hardware.Hardware
        Its share, multiplier_bits, lanes, view and view_rows are used; hidden is multiply.

    Members: as in :class:`BackMap`. With a view there is a ``table`` for each lane, and:

    view : ``In(view_layout())``
        Constant from ``start`` to the end of the frame, as are origin and step of the trained
        picture in ``scan``.
    rows, row_writes : see :func:`view_rows_ports`

    Raises
    ------
    InputError
        If a tan-sigmoid is to serve more neurons than there are, or there is no such variant.
    """

    def __init__(self, hidden_neurons, formats, nodes, *, variant="mmhbc", hardware=Hardware()):
        self.formats, self.nodes, self.lanes = formats, nodes, hardware.lanes
        self.has_view = hardware.view
        fine = formats.at_nodes()
        self.network_at_nodes = NodeNetwork(hidden_neurons, fine, nodes, variant, hardware)
        coarse = dict.fromkeys(("x", "y"), formats.coordinate)
        if self.has_view:
            coarse |= dict.fromkeys(("column", "row"), COLUMN)
        self.between = NodesToCoordinates(self.network_at_nodes.axes, coarse, nodes, self.lanes)
        table, view = Out(SpansRequest()), {}
        if self.has_view:
            table, view = table.array(self.lanes), {"view": In(view_layout())}
        super().__init__({
            "start": In(1), "abort": In(1), "scan": In(scan_layout()), **view, "table": table,
            "o": Out(stream.Signature(coordinate_layout(formats, self.lanes))),
            "idle": Out(1), "stalled": Out(1), "cut": Out(1),
        } | view_rows_ports(hardware) | network_ports(hidden_neurons, formats, hardware))

    @property
    def start_latency(self):
        """Clocks from ``start`` to the first coordinate at ``o``: four nodes, the network, its
        queue, the segment, the scan's decision, the pixel, with a view its spans, the queue.

        With a table of matrices the ``settling`` comes before."""
        network = self.network_at_nodes
        return (network.scanner.latency + 3 * network.interval + network.latency
                + CreditQueue.latency + Segments.latency + 1 + self._latency
                + CreditQueue.latency)

    def settling(self, columns):
        """Clocks in which the first row of a picture, or of a strip, of ``columns`` settles."""
        return self.network_at_nodes.settling(columns)

    @property
    def _latency(self):
        """Clocks from a group of the scan to its arrival in the queue."""
        return self.between.latency + (_LOOKUP if self.has_view else 0)

    @property
    def interval(self):
        """Clocks from one node to the next."""
        return self.network_at_nodes.interval

    @property
    def lead(self):
        """Most clocks that nodes are computed before use while coordinates wait."""
        network = self.network_at_nodes
        return (self.interval * network.queued - network.latency - CreditQueue.loop + _QUEUE)

    def elaborate(self, platform):
        m = Module()
        m.submodules.scan = scan = Scan(self.formats, self.lanes, self.nodes, self.has_view)
        m.submodules.network_at_nodes = network = self.network_at_nodes
        m.submodules.between = between = self.between
        m.submodules.queue = queue = CreditQueue(
            coordinate_layout(self.formats, self.lanes), depth=_QUEUE, restart=_QUEUE // 2)
        if not self.has_view:
            wiring.connect(m, scan.table, wiring.flipped(self.table))
        wiring.connect(m, network.o, between.i)
        if "writes" in network.signature.members:
            wiring.connect(m, wiring.flipped(self.writes), network.writes)
        self._frames(m, scan, network, between)
        latency = self._latency
        blank = delay(m, scan.blank, latency - scan.blank_latency, "blank")
        coordinates = [field for k in range(self.lanes)
                       for field in (between.o[k].x, between.o[k].y, blank[k])]
        if self.has_view:
            m.d.comb += network.view.eq(self.view)
            coordinates = [field for k in range(self.lanes) for field in (
                *(delay(m, between.o[k][axis], _LOOKUP, f"{axis}{k}") for axis in "xy"),
                blank[k] | self._without_source(m, k, between))]
        if "rows" in self.signature.members:
            m.d.comb += network.rows.eq(self.rows)
            wiring.connect(m, wiring.flipped(self.row_writes), network.row_writes)
        flags = delay(m, Cat(scan.first, scan.last), latency, "flags")
        m.d.comb += [
            scan.start.eq(self.start), scan.abort.eq(self.abort), scan.parameters.eq(self.scan),
            network.scan.eq(self.scan), network.network.eq(self.network),
            scan.go.eq(queue.space & (~scan.will_begin | between.ready)),
            between.advance.eq(scan.advance), between.begins.eq(scan.begins),
            queue.issue.eq(scan.advance),
            queue.arrive.eq(delay(m, scan.advance, latency, "advance", reset_less=False)),
            Value.cast(queue.i).eq(Cat(*coordinates, flags)),
            self.idle.eq(network.idle), self.cut.eq(scan.cut),
            self.stalled.eq(scan.active & ~queue.space),
        ]
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        return m

    def _without_source(self, m, k, between):
        """Whether the pixel of lane ``k`` has no source, ``_LOOKUP`` clocks after its position."""
        table = self.table[k]
        # Negative positions are beyond all others.
        column, row = (between.o[k][name].as_unsigned() for name in ("column", "row"))
        m.d.comb += table.row.eq(row)
        may = between.fits & (row < self.view.plane_height)
        may = delay(m, may, ValidTable.latency + 1, f"may{k}")
        column = delay(m, column, ValidTable.latency, f"column{k}")
        spans = table.spans
        inside = register(m, f"inside{k}", Cat(
            column >= spans.start0, column < spans.stop0,
            column >= spans.start1, column < spans.stop1))
        return register(m, f"no_source{k}", ~(may & (inside[:2].all() | inside[2:].all())))

    def _frames(self, m, scan, network, between):
        """Begin the nodes of a frame, and drop those that an aborted one has left."""
        begun = Signal()                # the nodes of the frame that runs have begun
        waiting = Signal()              # they begin once those of the frame before are gone
        runs = Signal()                 # the frame's last group has not been computed
        m.d.comb += [network.start.eq((self.start | waiting) & network.quiet),
                     network.stop.eq(~runs), between.flush.eq(~begun)]
        with m.If(scan.advance & scan.last):
            m.d.sync += [runs.eq(0), begun.eq(0), waiting.eq(0)]
        with m.If(self.start):
            m.d.sync += [runs.eq(1), waiting.eq(1)]
        with m.If(network.start):
            m.d.sync += [begun.eq(1), waiting.eq(0)]
