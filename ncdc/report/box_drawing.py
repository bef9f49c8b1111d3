"""Drawings of boxes and arrows between them."""

from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

__all__ = ["draw_boxes"]

_LINE = "#30507a"


def draw_boxes(path, boxes, arrows, note="", size=(11.5, 4.1), vertical=()):
    """Write a drawing as a PNG file.

    Parameters
    ----------
    path : str
    boxes : sequence of (left, bottom, width, height, text)
    arrows : sequence of (from x, to x, y, text above, text below)
    note : str
        Below the whole.
    size : (float, float)
        Inches.
    vertical : sequence of (x, from y, to y, text to the right)
        Arrows upwards or downwards.
    """
    figure = Figure(figsize=size)
    axes = figure.subplots()
    for left, bottom, width, height, text in boxes:
        axes.add_patch(Rectangle((left, bottom), width, height, facecolor="#eef3fa",
                                 edgecolor=_LINE, linewidth=1.4))
        axes.text(left + width / 2, bottom + height / 2, text, ha="center", va="center",
                  fontsize=10)
    for start, end, y, above, below in arrows:
        axes.annotate("", (end, y), (start, y), arrowprops={
            "arrowstyle": "-|>", "color": _LINE, "linewidth": 1.4})
        axes.text((start + end) / 2, y + .08, above, ha="center", va="bottom", fontsize=9.5,
                  family="monospace")
        axes.text((start + end) / 2, y - .1, below, ha="center", va="top", fontsize=8.5)
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
    figure.savefig(path, dpi=90, format="png", metadata={"Software": None}, bbox_inches="tight")
