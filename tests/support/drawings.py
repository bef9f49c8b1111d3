"""What is wrong with the texts of a drawing of boxes: cut, or written over something."""

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.patches import Rectangle

__all__ = ["misplaced"]

_DPI = 90               # of the files
_APART = 1.0            # pixels that are seen between a text and a line, or another text


def misplaced(figure):
    """The texts of a matplotlib Figure that cross the border of a box or another text, and with
    what: list of (str, str)."""
    figure.set_dpi(_DPI)
    renderer = FigureCanvasAgg(figure).get_renderer()
    texts, boxes = [], []
    for axes in figure.axes:
        texts += [(one.get_text(), one.get_window_extent(renderer)) for one in axes.texts
                  if one.get_text()]
        boxes += [one.get_window_extent(renderer) for one in axes.patches
                  if isinstance(one, Rectangle)]
    found = [(text, "box") for text, extent in texts for box in boxes
             if _overlap(extent, box) and not _inside(extent, box)]
    return found + [(text, other) for k, (text, extent) in enumerate(texts)
                    for other, another in texts[:k] if _overlap(extent, another)]


def _overlap(one, other):
    return (min(one.x1, other.x1) - max(one.x0, other.x0) > -_APART
            and min(one.y1, other.y1) - max(one.y0, other.y0) > -_APART)


def _inside(one, box):
    return (one.x0 >= box.x0 + _APART and one.x1 <= box.x1 - _APART
            and one.y0 >= box.y0 + _APART and one.y1 <= box.y1 - _APART)
