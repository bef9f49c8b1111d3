"""Charts as PNG files, drawn by Pillow: Matplotlib takes two seconds for its import and a chart.

A chart is drawn twice as large as it is written, which smooths its edges. All positions and sizes
are in pixels of the file.
"""

from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ncdc_spec.files import replace_file

__all__ = ["Axes", "BLUE", "Chart", "GREY", "RED", "Scale"]

BLUE, RED, GREY = (31, 119, 180), (214, 39, 40), (128, 128, 128)
_BLACK, _GRID = (0, 0, 0), (225, 225, 225)
_FINE = 2               # pixels of the drawing for one of the file
_TICKS = 7              # of an axis, at most
_TEXT, _SMALL = 14, 12
_DASHES = {"-": None, "--": (7, 4), ":": (2, 3)}


@dataclass(frozen=True)
class Scale:
    """Range of an axis; ``log``: logarithmic."""
    low: float
    high: float
    log: bool = False

    def parts(self, values):
        """Positions of ``values`` as parts of the axis, 0 at ``low``."""
        low, high = self._of((self.low, self.high))
        return (self._of(values) - low) / (high - low)

    def _of(self, values):
        values = np.asarray(values, np.float64)
        return np.log10(np.maximum(values, 1e-300)) if self.log else values

    def ticks(self):
        """Pairs (value, text) of the ticks, and the values of those between them."""
        if self.log:
            return self._powers()
        rough = (abs(self.high - self.low) or 1.0) / _TICKS
        ten = 10.0**np.floor(np.log10(rough))
        step = next(part for part in (1, 2, 5, 10) if part * ten >= rough) * ten
        first, last = sorted((self.low, self.high))
        values = step * np.arange(np.ceil(first / step - 1e-9), np.floor(last / step + 1e-9) + 1)
        return [(value, f"{value + 0.0:.6g}") for value in values], []

    def _powers(self):
        decades = np.arange(np.floor(np.log10(self.low)), np.ceil(np.log10(self.high)) + 1)
        minor = [part * 10.0**power for power in decades for part in range(2, 10)]
        named = [(10.0**power, f"{10.0**power:g}") for power in decades]
        if sum(self.low <= value <= self.high for value, _ in named) < 2:
            named += [(value, f"{value:g}") for value in minor if f"{value:e}"[0] in "25"]
        return ([one for one in named if self.low <= one[0] <= self.high],
                [value for value in minor if self.low <= value <= self.high])


class Chart:
    """A white picture of ``width`` x ``height`` pixels with charts on it."""

    def __init__(self, width, height):
        self._image = Image.new("RGB", (_FINE * width, _FINE * height), "white")
        self.draw = ImageDraw.Draw(self._image)

    def text(self, x, y, text, anchor="mm", size=_TEXT, turned=False):
        """Write at (x, y); ``anchor`` as of Pillow; ``turned``: upwards, with its middle there."""
        font = ImageFont.load_default(_FINE * size)
        if not turned:
            self.draw.text((_FINE * x, _FINE * y), text, _BLACK, font, anchor)
            return
        left, top, right, bottom = font.getbbox(text)
        label = Image.new("L", (right - left, bottom - top), 0)
        ImageDraw.Draw(label).text((-left, -top), text, 255, font)
        label = label.transpose(Image.Transpose.ROTATE_90)
        self._image.paste(_BLACK, (round(_FINE * x) - label.width // 2,
                                   round(_FINE * y) - label.height // 2), label)

    def picture(self, box, pixels):
        """Fill the ``box`` (left, top, right, bottom) with RGB ``pixels`` (height, width, 3)."""
        left, top, right, bottom = (round(_FINE * side) for side in box)
        self._image.paste(Image.fromarray(pixels).resize((right - left, bottom - top),
                                                         Image.Resampling.NEAREST), (left, top))

    def line(self, points, colour, width=1.0, style="-"):
        """Draw through ``points`` (n, 2)."""
        points, wide = _FINE * np.asarray(points, np.float64), max(1, round(_FINE * width))
        if _DASHES[style] is None:
            self.draw.line(points.ravel().tolist(), colour, wide, "curve")
            return
        on, off = (_FINE * part for part in _DASHES[style])
        for start, end in zip(points[:-1], points[1:]):
            length = max(float(np.linalg.norm(end - start)), 1e-9)
            for begin in np.arange(0, length, on + off):
                ends = [start + (end - start) * min(at, length) / length
                        for at in (begin, begin + on)]
                self.draw.line(np.ravel(ends).tolist(), colour, wide)

    def marker(self, x, y, colour, kind="o", radius=3.5, hollow=False):
        """Draw a circle ``o``, a square ``s`` or a diamond ``D``."""
        x, y, radius = _FINE * x, _FINE * y, _FINE * radius
        fill = {"outline" if hollow else "fill": colour} | ({"width": 2 * _FINE} if hollow else {})
        if kind == "o":
            self.draw.ellipse((x - radius, y - radius, x + radius, y + radius), **fill)
        elif kind == "s":
            self.draw.rectangle((x - radius, y - radius, x + radius, y + radius), **fill)
        else:
            self.draw.polygon([(x - radius, y), (x, y - radius), (x + radius, y), (x, y + radius)],
                              **fill)

    def legend(self, x, y, entries):
        """Write a row of ``entries``, pairs (function that draws its sign at (x, y), text), with
        its middle at (x, y)."""
        font = ImageFont.load_default(_FINE * _SMALL)
        widths = [48 + font.getlength(text) / _FINE for _, text in entries]
        x -= sum(widths) / 2
        for (sign, text), width in zip(entries, widths):
            sign(x + 14, y)
            self.text(x + 32, y, text, "lm", _SMALL)
            x += width

    def save(self, path):
        """Write it as PNG; the file is replaced whole or not at all."""
        with replace_file(path) as temporary:
            self._image.reduce(_FINE).save(temporary, "png")


class Axes:
    """A frame with two scales in the ``box`` (left, top, right, bottom) of a :class:`Chart`."""

    def __init__(self, chart, box, x, y):
        self.chart, self.box, self._x, self._y = chart, box, x, y

    def at(self, x, y):
        """Pixels (n, 2) of the chart of values (n,)."""
        left, top, right, bottom = self.box
        return np.stack(np.broadcast_arrays(left + (right - left) * self._x.parts(x),
                                            bottom - (bottom - top) * self._y.parts(y)), axis=-1)

    def frame(self, title, xlabel, ylabel, grid=False):
        """Draw the frame, ticks with their numbers, title and labels."""
        chart, (left, top, right, bottom) = self.chart, self.box
        widest = 0
        for across, scale in ((True, self._x), (False, self._y)):
            named, minor = scale.ticks()
            for value, text in [*((value, "") for value in minor), *named]:
                part = float(scale.parts(value))
                x = left + (right - left) * part if across else left
                y = bottom if across else bottom - (bottom - top) * part
                size, ends = 5 if text else 3, (x, top) if across else (right, y)
                if grid:
                    chart.line([(x, y), ends], _GRID)
                chart.line([(x, y), (x, y + size) if across else (x - size, y)], _BLACK)
                if text:
                    chart.text(*((x, y + 8, text, "ma") if across else (x - 8, y, text, "rm")))
                    widest = max(widest, 0 if across else len(text))
        chart.line([(left, top), (right, top), (right, bottom), (left, bottom), (left, top)],
                   _BLACK)
        chart.text((left + right) / 2, top - 13, title, size=_TEXT + 2)
        chart.text((left + right) / 2, bottom + 38, xlabel)
        chart.text(left - 24 - 8 * widest, (top + bottom) / 2, ylabel, turned=True)

    def line(self, x, y, colour, width=1.6, style="-"):
        """Draw through values (n,)."""
        self.chart.line(self.at(x, y), colour, width, style)

    def bars(self, edges, counts, colour):
        """Fill a bar for each of ``counts`` (n,), between ``edges`` (n + 1,)."""
        bottom = _FINE * self.box[3]
        for (left, top), (right, _) in zip(self.at(edges[:-1], counts), self.at(edges[1:], counts)):
            if _FINE * top < bottom:
                self.chart.draw.rectangle((_FINE * left, _FINE * top, _FINE * right, bottom),
                                          colour)
