"""Drawings of packets: ``python -m ncdc_bench.figures.packet_diagrams docs/figures``."""

import sys
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ncdc_bench.figures.box_drawing import write_figure
from ncdc_spec.protocols.table_two import FIELDS

__all__ = ["FILE", "PACKETS", "draw_packets", "packets_figure"]

FILE = "packets.png"
_ROW = 4            # bytes
_COLUMNS = 4        # drawings side by side
_LINE = "#30507a"
_BROKEN = {("formation", 1): "form-\nation"}     # names too long for their field's bytes
_HEADER = (("status", 2), ("block", 2), ("kind", 1), ("packet", 3))
PACKETS = {         # title: fields and their bytes; 0: as many as there are
    "Table I: request, answer": (("code", 1), ("address", 2), ("value", 2)),
    "GVCP: command": (("0x42", 1), ("flags", 1), ("command", 2), ("length", 2), ("request", 2),
                      ("payload", 0)),
    "GVCP: answer": (("status", 2), ("answer to", 2), ("length", 2), ("request", 2),
                     ("payload", 0)),
    "GVSP: payload (kind 3)": (*_HEADER, ("part of the picture", 0)),
    "Table II: MRAW package": (*((field.name.lower(), field.length) for field in FIELDS),
                               ("image", 0)),
    "GVSP: leader (kind 1)": (
        *_HEADER, ("reserved", 2), ("type", 2), ("time", 8), ("pixel format", 4), ("width", 4),
        ("height", 4), ("column", 4), ("row", 4), ("padding x", 2), ("padding y", 2)),
    "GVSP: trailer (kind 2)": (*_HEADER, ("reserved", 2), ("type", 2), ("height", 4))}


def draw_packets(folder):
    """Write the drawing into ``folder``; the fields of each packet, four bytes a row."""
    write_figure(Path(folder) / FILE, packets_figure())


def packets_figure():
    """The drawing, a matplotlib Figure."""
    rows = -(-len(PACKETS) // _COLUMNS)
    figure = Figure(figsize=(11.5, 6.4))
    grid = figure.subplots(rows, _COLUMNS, height_ratios=(3.6, 11.7))
    for axes in grid.flat[len(PACKETS):]:
        axes.set_axis_off()
    for axes, (title, fields) in zip(grid.flat, PACKETS.items()):
        at = 0
        for name, size in fields:
            at = _field(axes, at, name, size)
        axes.set_title(title, fontsize=10, loc="left")
        axes.set_xlim(-.55, _ROW + .1)
        axes.set_ylim(-11.2 if axes in grid[1] else -3.1, .5)
        for k in range(_ROW):
            axes.text(k + .5, .14, str(k), ha="center", fontsize=7.5, color="#666666")
        axes.set_axis_off()
    return figure


def _field(axes, at, name, size):
    """Draw a field that begins at byte ``at``; where the next one begins."""
    if size == 0:
        at = -(-at // _ROW) * _ROW
        _box(axes, at // _ROW, 0, _ROW, f"{name} ...", at, "white")
        return at + _ROW
    named, first = False, at
    while size:
        part = min(size, _ROW - at % _ROW)
        # The name stands in the longest part that comes first.
        here = not named and (part == size or part >= _ROW // 2)
        named = named or here
        _box(axes, at // _ROW, at % _ROW, part, name if here else "",
             at if at == first or at % _ROW == 0 else None)
        at, size = at + part, size - part
    return at


def _box(axes, row, column, width, text, byte, colour="#eef3fa"):
    axes.add_patch(Rectangle((column, -row - 1), width, 1, facecolor=colour, edgecolor=_LINE,
                             linewidth=1.1))
    axes.text(column + width / 2, -row - .5, _BROKEN.get((text, width), text), ha="center",
              va="center", fontsize=8.5 if len(text) < 8 * width else 7.5, linespacing=1)
    if column == 0 and byte is not None:
        axes.text(-.12, -row - .5, str(byte), ha="right", va="center", fontsize=7.5,
                  color="#666666")


if __name__ == "__main__":
    draw_packets(sys.argv[1])
