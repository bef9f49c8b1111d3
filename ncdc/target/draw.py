"""Draws a target's page, with a ruler and what to type, as PDF or SVG."""

import io

from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from matplotlib.patches import Rectangle as Patch
from matplotlib.transforms import Affine2D

from ncdc.target.layout import Circle

__all__ = ["RULER_MM", "page"]

RULER_MM = 100
_INCH_MM = 25.4
_TICK_MM, _LINE_MM = 2.0, 0.2
_RULER_BELOW_MM = 11.0      # so far below the points that it does not touch them in a photo
_TEXT_POINTS, _NARROW_MM = 7, 200.0


def page(layout, form):
    """Bytes of the page of a :class:`ncdc.target.layout.Layout`; ``form``: "pdf" or "svg".

    One millimetre of the layout is one of the paper. The same layout gives the same bytes.
    """
    width, height = layout.paper
    figure = Figure(figsize=(width / _INCH_MM, height / _INCH_MM))
    # From millimetres, downwards, to inches, upwards.
    transform = Affine2D().scale(1, -1).translate(0, height).scale(1 / _INCH_MM) \
        + figure.dpi_scale_trans
    for shape in layout.shapes:
        figure.add_artist(_patch(shape, transform))
    _foot(figure, layout, transform)
    file = io.BytesIO()
    settings = {"svg.fonttype": "none", "svg.hashsalt": "ncdc", "pdf.fonttype": 42}
    stamp = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}[form]
    with rc_context(settings):
        figure.savefig(file, format=form, metadata={"Title": layout.description} | stamp)
    return file.getvalue()


def _patch(shape, transform):
    fill = {"facecolor": "black", "edgecolor": "none", "linewidth": 0, "transform": transform}
    if isinstance(shape, Circle):
        return Ellipse((shape.x, shape.y), shape.diameter, shape.diameter, **fill)
    return Patch((shape.x, shape.y), shape.width, shape.height, **fill)


def _foot(figure, layout, transform):
    """The ruler, and next to it the kind of page and the option to type."""
    left, top = layout.foot
    top += _RULER_BELOW_MM
    fill = {"facecolor": "black", "edgecolor": "none", "linewidth": 0, "transform": transform}
    figure.add_artist(Patch((left, top), RULER_MM, _LINE_MM, **fill))
    for mark in range(0, RULER_MM + 1, 10):
        # The outer edges of the first and the last tick are 100 mm apart.
        x = left + min(max(0, mark - _LINE_MM / 2), RULER_MM - _LINE_MM)
        size = _TICK_MM * (1.5 if mark in (0, RULER_MM) else 1)
        figure.add_artist(Patch((x, top - size), _LINE_MM, size, **fill))
    words = [(left + RULER_MM + 3, top - 2.2, f"{RULER_MM} mm if printed at 100 %, without "
                                              f"fitting to the page: measure it"),
             (left, top + 4, f"{layout.description}"),
             (left, top + 7.5, f"ncdc calibrate PHOTO... --target {layout.target} "
                               f"-o points.json")]
    size = _TEXT_POINTS
    if layout.paper[0] < _NARROW_MM:
        size *= layout.paper[0] / _NARROW_MM
        words[0] = (left, top - 4.5, words[0][2])
    for x, y, text in words:
        figure.text(x, y, text, transform=transform, fontsize=size, va="center",
                    family="DejaVu Sans")
