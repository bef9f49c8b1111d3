"""Histogram of the picture's grey levels, a curve a colour."""

import numpy as np
from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from ncdc_host.gui.colours import dimmed

__all__ = ["HistogramView"]

_COLOURS = QColor(222, 60, 60), QColor(45, 160, 75), QColor(60, 110, 225)


class HistogramView(QWidget):
    """Paints a histogram, and how much of the picture is black or white altogether."""

    def __init__(self):
        super().__init__()
        self._curves, self.clipped = None, (0.0, 0.0)
        self.setFixedHeight(96)
        self.setAccessibleName("Histogram")
        self.setToolTip("How often each grey level is in the picture, black at the left. Below: "
                        "the share of samples that are 0, and that are 255.")

    def sizeHint(self):
        return QSize(240, 96)

    def show_counts(self, counts):
        """Paint ``counts``, ints of shape (3, 256); None: nothing."""
        if counts is None:
            self._curves = None
        else:
            total = max(1, counts.sum())
            self.clipped = counts[:, 0].sum() / total, counts[:, -1].sum() / total
            # The ends are left out of the scale: black surroundings would flatten all the rest.
            highest = max(1.0, np.percentile(counts[:, 1:-1], 99.5))
            self._curves = np.minimum(counts / highest, 1.0)
        self.update()

    def paintEvent(self, event):
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        base, text = self.palette().color(QPalette.ColorRole.Base), dimmed(self.palette())
        line = painter.fontMetrics().height()
        box = self.rect().adjusted(0, 0, -1, -line - 2)
        painter.setPen(self.palette().color(QPalette.ColorRole.Mid))
        painter.setBrush(base)
        painter.drawRect(box)
        if self._curves is None:
            return
        x = np.linspace(box.left() + 1, box.right() - 1, self._curves.shape[1])
        for curve, colour in zip(self._curves, _COLOURS):
            y = box.bottom() - curve * (box.height() - 4)
            points = [QPointF(box.left() + 1, box.bottom()), *map(QPointF, x, y),
                      QPointF(box.right() - 1, box.bottom())]
            fill = QColor(colour)
            fill.setAlpha(45)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(fill)
            painter.drawPolygon(QPolygonF(points))
            painter.setPen(QPen(colour, 1.2))
            painter.drawPolyline(QPolygonF(points[1:-1]))
        painter.setPen(text)
        below = self.rect().adjusted(0, box.height() + 3, 0, 0)
        for share, side, name in ((self.clipped[0], Qt.AlignmentFlag.AlignLeft, "black"),
                                  (self.clipped[1], Qt.AlignmentFlag.AlignRight, "white")):
            painter.drawText(below, side, f"{100 * share:.1f} % {name}")
