"""The picture of a live calibration: points, covered parts, and where the target is wanted."""

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QWidget

__all__ = ["LiveView"]

_BACKGROUND = QColor(38, 40, 43)
_MISSING = QColor(226, 88, 34, 70)      # parts of the frame that no picture covers
_EDGE = QColor(255, 255, 255, 45)
_WANTED = QColor(255, 214, 10)
_POINTS = {"taken": QColor(87, 227, 137), "waiting": QColor(87, 227, 137),
           "known": QColor(153, 193, 241)}
_OTHERS = QColor(255, 120, 0)           # of a target that moves, or is blurred
_RADIUS = 3             # of a point, on the screen


class LiveView(QWidget):
    """Paints a QImage, and over it the last answer of :class:`LiveCalibration`."""

    def __init__(self):
        super().__init__()
        self.image, self.about = None, None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(320, 200)
        self.setAccessibleName("Picture with the points found")

    def sizeHint(self):
        return QSize(800, 560)

    def show_frame(self, image, about=None):
        """Paint another frame, and what was found on it."""
        self.image, self.about = image, about
        self.update()

    def _rect(self):
        scale = min(self.width() / self.image.width(), self.height() / self.image.height())
        width, height = scale * self.image.width(), scale * self.image.height()
        return QRectF((self.width() - width) / 2, (self.height() - height) / 2, width, height)

    def paintEvent(self, event):
        painter = QPainter(self)
        painter.fillRect(self.rect(), _BACKGROUND)
        if self.image is None:
            return
        rect = self._rect()
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.drawImage(rect, self.image)
        if self.about is None:
            return
        painter.setClipRect(rect)
        self._paint_coverage(painter, rect)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._paint_wanted(painter, rect)
        self._paint_points(painter, rect)

    def _paint_coverage(self, painter, rect):
        rows = self.about["state"]["coverage"]
        width, height = rect.width() / len(rows[0]), rect.height() / len(rows)
        painter.setPen(QPen(_EDGE, 1))
        for j, row in enumerate(rows):
            for i, cell in enumerate(row):
                box = QRectF(rect.left() + i * width, rect.top() + j * height, width, height)
                if cell == ".":
                    painter.fillRect(box, _MISSING)
                painter.drawRect(box)

    def _paint_wanted(self, painter, rect):
        if not self.about["outline"] or self.about["state"]["done"]:
            return
        outline = QPolygonF([self._at(rect, x, y) for x, y in self.about["outline"]])
        for pen in (QPen(QColor(0, 0, 0, 130), 5), QPen(_WANTED, 2.5, Qt.PenStyle.DashLine)):
            painter.setPen(pen)
            painter.drawPolygon(outline)

    def _paint_points(self, painter, rect):
        painter.setPen(QPen(QColor(0, 0, 0, 170), 1))
        painter.setBrush(_POINTS.get(self.about["state"]["seen"], _OTHERS))
        for x, y in self.about["points"]:
            painter.drawEllipse(self._at(rect, x, y), _RADIUS, _RADIUS)

    def _at(self, rect, x, y):
        return QPointF(rect.left() + (x + .5) * rect.width() / self.image.width(),
                       rect.top() + (y + .5) * rect.height() / self.image.height())
