"""Drawings of boxes and arrows between them."""

from pathlib import Path

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

__all__ = ["boxes_figure", "draw_boxes", "write_figure"]

_MARGIN = .2            # between the text at an arrow and the boxes, both sides together
_LINE = "#30507a"


def draw_boxes(path, *drawing, **options):
    """Write the drawing of :func:`boxes_figure` by :func:`write_figure`."""
    write_figure(path, boxes_figure(*drawing, **options))


def write_figure(path, figure):
    """Write a matplotlib Figure as the PNG or SVG file that ``path`` names.

    The same figure gives the same bytes: neither a date nor a random identifier is written.
    """
    kind = Path(path).suffix.removeprefix(".")
    metadata = {"png": {"Software": None}, "svg": {"Date": None, "Creator": None}}[kind]
    with rc_context({"svg.hashsalt": "ncdc", "svg.fonttype": "none"}):
        figure.savefig(path, dpi=90, format=kind, metadata=metadata, bbox_inches="tight")


def boxes_figure(boxes, arrows, note="", size=(11.5, 4.1), vertical=()):
    """A drawing, a matplotlib Figure.

    Texts at arrows are made smaller where they would not fit between the boxes.

    Parameters
    ----------
    boxes : sequence of (left, bottom, width, height, text)
    arrows : sequence of (from x, to x, y, text above, text below)
    note : str
        Below the whole.
    size : (float, float)
        Inches.
    vertical : sequence of (x, from y, to y, text to the right)
        Arrows upwards or downwards.
    """
    figure, fitted = Figure(figsize=size), []
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for left, bottom, width, height, text in boxes:
        axes.add_patch(Rectangle((left, bottom), width, height, facecolor="#eef3fa",
                                 edgecolor=_LINE, linewidth=1.4))
        axes.text(left + width / 2, bottom + height / 2, text, ha="center", va="center",
                  fontsize=10)
    for start, end, y, above, below in arrows:
        axes.annotate("", (end, y), (start, y), arrowprops={
            "arrowstyle": "-|>", "color": _LINE, "linewidth": 1.4})
        middle, space = (start + end) / 2, abs(end - start) - _MARGIN
        fitted += [(axes.text(middle, y + .08, above, ha="center", va="bottom", fontsize=9.5,
                              family="monospace"), space),
                   (axes.text(middle, y - .1, below, ha="center", va="top", fontsize=8.5), space)]
    for x, start, end, text in vertical:
        axes.annotate("", (x, end), (x, start), arrowprops={
            "arrowstyle": "-|>", "color": _LINE, "linewidth": 1.4})
        axes.text(x + .1, (start + end) / 2, text, ha="left", va="center", fontsize=8.5)
    left, right = min(box[0] for box in boxes), max(box[0] + box[2] for box in boxes)
    low, high = min(box[1] for box in boxes), max(box[1] + box[3] for box in boxes)
    axes.text((left + right) / 2, low - .35, note, ha="center", va="top", fontsize=8.5)
    axes.set_xlim(left - .1, right + .1)
    axes.set_ylim(low - .8, high + .2)
    axes.set_axis_off()
    for text, space in fitted:
        _fit(text, axes, space)
    return figure


def _fit(text, axes, width):
    """Make a text of ``axes`` small enough for ``width`` of their units."""
    (left, _), (right, _) = axes.transData.transform([(0, 0), (width, 0)])
    wide = text.get_window_extent(axes.figure.canvas.get_renderer()).width
    if wide > right - left:
        text.set_fontsize(text.get_fontsize() * (right - left) / wide)

