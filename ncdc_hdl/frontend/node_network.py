"""The network at nodes: scan, shared pipelines, and the queue of nodes after them."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.frontend.layouts import (
    join_network,
    network_ports,
    scan_layout,
    view_layout,
    view_rows_ports,
)
from ncdc_hdl.frontend.node_scan import NodeScan
from ncdc_hdl.frontend.raw_rows import RawRows
from ncdc_hdl.frontend.view_transform import ViewTransform
from ncdc_hdl.lib.credits import CreditQueue
from ncdc_hdl.lib.pipeline import DelayMemory, delay, register
from ncdc_hdl.neural.layers import MultiplyLayer, OutputLayer
from ncdc_hdl.neural.tansig import Tansig
from ncdc_spec.nodes import row_nodes
from ncdc_spec.view import NODE
from ncdc_spec.view_rows import SETTLING

__all__ = ["NodeNetwork", "node_axes", "node_layout"]

_SLACK = 16     # queue entries above those under way: for the credits, and a margin


def node_layout(axes):
    """A node's values by the names of its ``axes``, and whether three nodes of its row precede it.

    ``axes``: {name: format}. They are the coordinate x', y' in pixels; with a view also its
    position in the trained picture, ``column`` and ``row``, and whether all of it ``fits``.
    """
    return data.StructLayout({
        **{name: signed(q.width) for name, q in axes.items()}, "whole": 1,
        **({"fits": 1} if "column" in axes else {})})


def node_axes(formats, view=False):
    """The axes of :func:`node_layout`; ``formats`` are those at nodes."""
    return {"x": formats.coordinate, "y": formats.coordinate,
            **({"column": NODE, "row": NODE} if view else {})}


class NodeNetwork(wiring.Component):
    """Coordinates of all nodes of a frame, in the order of :class:`NodeScan`.

    Equal bit for bit to ``ncdc_model.golden.network.network`` at the nodes. One network serves all
    pixels of a group; each of its tan-sigmoids serves ``hardware.share`` neurons in turn. Timing: a
    node every ``interval`` clocks, ``latency`` clocks from its issue to the queue.

    Parameters
    ----------
    hidden_neurons : int
    formats : ncdc_spec.descriptor.Formats
        Formats at nodes.
    nodes : int
        Distance S of the nodes.
    variant : str
        Variant of the tan-sigmoid.
    hardware : ncdc_spec.hardware.Hardware
        Its share, multiplier_bits, view and view_rows are used.

    Members
    -------
    start, stop, scan : as in :class:`NodeScan`; ``stop`` is held until the next ``start``
    view : ``In(view_layout())``
        As in :class:`ViewTransform` (only with a view).
    rows, row_writes : see :func:`view_rows_ports`
    network, writes : see :func:`network_ports`
    o : ``Out(stream.Signature(node_layout(self.axes)))``
    quiet : ``Out(1)``
        No node is in the network or in the queue; rises some clocks late, but is low from the clock
        after the first issue.
    idle : ``Out(1)``
        The network is empty and no node enters it in this clock.
    """

    def __init__(self, hidden_neurons, formats, nodes, variant, hardware):
        self.formats, self.share = formats, hardware.share or 1
        self.interval = max(self.share, hardware.min_node_clocks)
        self.scanner = NodeScan(formats, nodes, self.interval, hardware.view,
                                hardware.view_rows > 0)
        self.transform = (ViewTransform(formats.input, nodes, self.interval,
                                        hardware.multiplier_bits, hardware.view_rows)
                          if hardware.view else None)
        self.axes = node_axes(formats, hardware.view)
        self.hidden = MultiplyLayer(hidden_neurons, formats, self.share, hardware.multiplier_bits,
                                    fixed=hardware.fixed_lens)
        self.tansig = [Tansig(formats.tansig_design(variant))
                       for _ in range(hardware.units(hidden_neurons))]
        self.output = OutputLayer(hidden_neurons, formats, self.share, hardware.multiplier_bits,
                                  hardware.fixed_lens)
        self.raw_rows = (RawRows(formats.coordinate, nodes, self.latency)
                         if hardware.view_rows else None)
        self.under_way = -(-(self.latency + CreditQueue.loop) // self.interval)
        self.queued = max(32, 1 << (self.under_way + _SLACK - 1).bit_length())
        super().__init__({
            "start": In(1), "stop": In(1), "scan": In(scan_layout()),
            "o": Out(stream.Signature(node_layout(self.axes))), "quiet": Out(1, init=1),
            "idle": Out(1), **({"view": In(view_layout())} if hardware.view else {}),
        } | view_rows_ports(hardware) | network_ports(hidden_neurons, formats, hardware))

    @property
    def latency(self):
        """Clocks from a node's issue to its arrival in the queue."""
        return self._network_latency + (self.transform.latency if self.transform else 0)

    def settling(self, columns):
        """Clocks in which the first row of ``columns`` pixels is computed before it counts."""
        if not self.raw_rows:
            return 0
        row = row_nodes(columns, self.scanner.nodes) * self.interval
        return SETTLING * max(row, self.latency + RawRows.latency)

    @property
    def _network_latency(self):
        """Clocks from a node at the hidden neurons to its arrival in the queue."""
        return self.hidden.latency + self.tansig[0].latency + self.output.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.scan = scan = self.scanner
        m.submodules.hidden, m.submodules.output = hidden, output = self.hidden, self.output
        m.submodules.queue = queue = CreditQueue(
            node_layout(self.axes), depth=self.queued,
            restart=max(self.under_way, self.queued // 2))
        before_output = self._network_latency - output.latency
        node = self._view(m, scan, queue) if self.transform else scan
        activated = delay(m, node.issue, before_output, "issue", reset_less=False)
        m.d.comb += [
            scan.start.eq(self.start), scan.stop.eq(self.stop), scan.parameters.eq(self.scan),
            scan.space.eq(queue.space),
            hidden.pixel.x.eq(node.x), hidden.pixel.y.eq(node.y), hidden.turn.eq(node.turn),
            output.first.eq(activated),
            queue.issue.eq(scan.issue),
            queue.arrive.eq(delay(m, activated, output.latency, "output", reset_less=False)),
            queue.i.x.eq(output.o[0]), queue.i.y.eq(output.o[1]),
            queue.i.whole.eq(delay(m, node.whole, self._network_latency, "whole")),
            self.idle.eq(queue.drained & ~scan.issue),
        ]
        join_network(m, self, hidden, output)
        if output.skip:
            m.submodules.inputs = inputs = DelayMemory(
                2 * self.formats.input.width, before_output + output.inputs_clock)
            m.d.comb += [inputs.i.eq(Cat(node.x, node.y)),
                         Value.cast(output.inputs).eq(inputs.o)]
        for k, tansig in enumerate(self.tansig):
            m.submodules[f"tansig{k}"] = tansig
            m.d.comb += [tansig.i.eq(hidden.o[k]), output.i[k].eq(tansig.o)]
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        self._count(m, scan.issue)
        return m

    def _view(self, m, scan, queue):
        """Nodes of the view, for the network; their positions go to the queue past it."""
        m.submodules.transform = transform = self.transform
        m.d.comb += [
            transform.start.eq(self.start), transform.parameters.eq(self.scan),
            transform.view.eq(self.view), transform.edges.eq(scan.edges),
            transform.i_issue.eq(scan.issue), transform.i_whole.eq(scan.whole),
        ]
        if self.raw_rows:
            self._rows(m, scan, transform, queue)
        m.submodules.positions = positions = DelayMemory(
            2 * NODE.width, self._network_latency + transform.early)
        m.d.comb += [positions.i.eq(Cat(transform.column, transform.row)),
                     Cat(queue.i.column, queue.i.row).eq(positions.o),
                     queue.i.fits.eq(delay(m, transform.fits, self._network_latency, "fits"))]
        return transform

    def _rows(self, m, scan, transform, queue):
        """Raw rows of a row's nodes, for those of the row below it."""
        m.submodules.raw_rows = raw_rows = self.raw_rows
        wiring.connect(m, wiring.flipped(self.row_writes), transform.writes)
        m.d.comb += [
            raw_rows.start.eq(self.start), raw_rows.issue.eq(scan.issue), raw_rows.top.eq(scan.top),
            raw_rows.bottom.eq(scan.bottom), scan.ready.eq(raw_rows.ready),
            raw_rows.arrive.eq(queue.arrive), raw_rows.y.eq(queue.i.y),
            raw_rows.fits.eq(queue.i.fits), transform.raw_row.eq(raw_rows.row),
            transform.rows.eq(self.rows), transform.again.eq(scan.again),
            transform.number.eq(scan.number), transform.line.eq(scan.line),
        ]

    def _count(self, m, issue):
        """Whether any node is between its issue and its output from the queue."""
        taken = register(m, "taken", self.o.valid & self.o.ready, reset_less=False)
        issued = register(m, "issued", issue, reset_less=False)
        claimed = Signal(range(self.queued + 1))        # nodes in the network and in the queue
        with m.If(issued != taken):
            m.d.sync += claimed.eq(claimed + Mux(taken, -1, 1))
        m.d.sync += self.quiet.eq((claimed == 0) & ~issued & ~issue)
