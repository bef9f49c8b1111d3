"""Layouts of the front end's streams and ports."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.groups import grouped
from ncdc_hdl.neural.banks import BANK_WRITES
from ncdc_hdl.neural.layouts import hidden_layout, output_layout
from ncdc_spec.geometry import MAX_SIZE, SCAN
from ncdc_spec.nodes import BEFORE, NODES, row_nodes
from ncdc_spec.view_rows import MAX_MATRICES, NUMBER_BITS, STEPS

__all__ = ["EDGES", "NODE_NUMBER", "ROW_WRITES", "SIZE", "SPANS", "coordinate_layout",
           "join_network", "network_layout", "network_ports", "rows_layout", "scan_layout",
           "view_layout", "view_rows_ports"]

SIZE = range(MAX_SIZE + 1)                       # of a width, a height, the end of a span
SPANS = data.StructLayout({"start0": SIZE, "stop0": SIZE, "start1": SIZE, "stop1": SIZE})

# Of a node: it is the last of its row, in the last row of its strip; it is where the next strip's
# first node will be, in the first row.
EDGES = data.StructLayout({"last_column": 1, "last_row": 1, "next_strip": 1})

NODE_NUMBER = range(-BEFORE, row_nodes(MAX_SIZE, min(NODES[1:])))
"""Of a node's number in the rows of a picture: that at column 0 is 0."""

ROW_WRITES = wiring.Signature({
    "write": Out(1),                        # ``word`` is written
    "bank": Out(1),
    "matrix": Out(range(MAX_MATRICES)),
    "row": Out(2),                          # of the matrix, x, y or depth
    "column": Out(2),                       # of u, v or 1
    "word": Out(signed(NUMBER_BITS)),
})
"""From the registers to a table of matrices; nothing happens if it has no such number."""


def rows_layout():
    """Matrices in use of a table, number of the step in ``STEPS``, bank that frames use."""
    return data.StructLayout({"count": range(MAX_MATRICES + 1), "step": range(len(STEPS)),
                              "bank": 1})


def view_rows_ports(hardware):
    """Ports of a front end for a table of matrices, if ``hardware`` has one.

    rows : ``In(rows_layout())``
        Constant during a frame.
    row_writes : ``In(ROW_WRITES)``
    """
    if not hardware.view_rows:
        return {}
    return {"rows": In(rows_layout()), "row_writes": In(ROW_WRITES)}


def view_layout():
    """The matrix of a view, row by row, raw in ``ncdc_spec.view.FORMATS``, and the trained
    picture's rows."""
    return data.StructLayout({
        "matrix": data.ArrayLayout(data.ArrayLayout(signed(32), 3), 3), "plane_height": SIZE})


def scan_layout():
    """The parameters of a scan.

    ``width`` and ``height`` are the corrected picture's in pixels, ``strip`` the columns of a strip
    (0: the picture is one strip). Origin and step of both coordinates are raw in Q1.31.
    """
    return data.StructLayout({
        "width": SIZE, "height": SIZE, "strip": SIZE,
        "origin_x": signed(SCAN.width), "step_x": signed(SCAN.width),
        "origin_y": signed(SCAN.width), "step_y": signed(SCAN.width),
    })


def network_layout(hidden_neurons, formats, hardware):
    """Weights and biases of the whole network, raw in ``formats``, without those that
    ``hardware`` has in memories."""
    hidden = {} if hardware.in_memory("hidden") else {
        "hidden": hidden_layout(hidden_neurons, formats)}
    return data.StructLayout(hidden | {
        "output": output_layout(hidden_neurons, formats, hardware.in_memory("output"))})


def network_ports(hidden_neurons, formats, hardware):
    """Ports of a front end for the network's parameters.

    network : ``In(network_layout(...))``
        Constant during a frame.
    writes : ``In(BANK_WRITES)``
        Writes to the memories, if neurons share a unit.
    """
    writes = {"writes": In(BANK_WRITES)} if hardware.in_memory("output") else {}
    return {"network": In(network_layout(hidden_neurons, formats, hardware))} | writes


def join_network(m, front_end, hidden, output):
    """Connect :func:`network_ports` to the layers ``hidden`` and ``output``."""
    m.d.comb += output.neurons.eq(front_end.network.output)
    for layer in (hidden, output):
        if "writes" in layer.signature.members:
            wiring.connect(m, wiring.flipped(front_end.writes), layer.writes)
    if "neurons" in hidden.signature.members:
        m.d.comb += hidden.neurons.eq(front_end.network.hidden)


def coordinate_layout(formats, lanes=1):
    """A back-map coordinate: x', y' in pixels, whether the pixel has no source (``blank``);
    ``lanes`` of them as :func:`ncdc_hdl.lib.groups.grouped`."""
    return grouped({"x": signed(formats.coordinate.width), "y": signed(formats.coordinate.width),
                    "blank": 1}, lanes)
