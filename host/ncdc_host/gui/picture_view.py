"""The live picture: one, two side by side, or one wiped over the other; zoomed and moved."""

from PySide6.QtCore import QPoint, QPointF, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

__all__ = ["MODES", "PictureView"]

# Of what the view shows, in the order of the keys 1 to 4.
MODES = ("before", "after", "side by side", "wipe")
_NAMES = ("Before: raw frame", "After: corrected")
_STEP = 1.25            # of zoom
_SCALES = 1 / 16, 32
_GAP = 6                # pixels between two pictures
_WIPE = 0.02            # of the width that an arrow key moves the wipe's line
_GRIP = 9               # pixels around the wipe's line that take hold of it
# Directions of the arrow keys: right, down.
_ARROWS = {Qt.Key.Key_Left: (-1, 0), Qt.Key.Key_Right: (1, 0), Qt.Key.Key_Up: (0, -1),
           Qt.Key.Key_Down: (0, 1)}
_BACKGROUND = QColor(38, 40, 43)
_OUTLINE = QPen(QColor(0, 0, 0, 140), 3), QPen(QColor(255, 255, 255), 1)


class PictureView(QWidget):
    """Paints ``live``, the newest picture, and ``still``, the raw frame it is compared with.

    Both are QImages; they are fitted to the same area, so that sizes may differ. The wheel zooms
    about the cursor, dragging moves the picture, a double click fits it again. While ``steers`` is
    set, wheel, dragging and arrow keys are signalled instead.

    Signals
    -------
    dragged(QPointF, QPointF), pushed(QPointF), wheeled(float, QPointF)
        While it steers: how far the picture was dragged, and from where on, in its pixels; the
        direction of an arrow key; steps of the wheel, and at which pixel.
    pointed(QPoint, str)
        Pixel under the cursor, (-1, -1) if there is none, and its colour.
    scaled(float or None)
        Screen pixels per pixel; None while there is no picture.
    """
    pointed, scaled = Signal(QPoint, str), Signal(object)
    dragged, pushed = Signal(QPointF, QPointF), Signal(QPointF)
    wheeled = Signal(float, QPointF)

    def __init__(self):
        super().__init__()
        self.live = self.still = None
        self.mode, self.text = "after", ""
        self.wipe = 0.5             # the line's position, a share of the picture's width
        self.shade = False          # the picture is an old one
        self.steers, self._outline = False, None
        self._scale, self._middle = None, QPointF(0.5, 0.5)
        self._drag, self._start = None, QPointF()
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(240, 135)
        self.setAccessibleName("Picture")

    def sizeHint(self):
        return QSize(800, 600)

    # What is shown.

    def show_live(self, image):
        """Paint another live picture."""
        self.live = image
        self.update()
        self._tell_scale()

    def show_still(self, image):
        """Paint another raw frame to compare with."""
        self.still = image
        self.update()

    def show_outline(self, rect):
        """Mark a part of the live picture, a QRectF in its pixels; None: no part."""
        if rect != self._outline:
            self._outline = rect
            self.update()

    def set_mode(self, mode):
        """One of :data:`MODES`."""
        self.mode = mode
        self.update()
        self._tell_scale()

    def set_text(self, text, shade=False):
        """A sentence where there is no picture; ``shade``: the picture is an old one."""
        self.text, self.shade = text, shade
        self.update()

    # Zoom.

    @property
    def has_picture(self):
        """Whether there is anything to zoom."""
        return self.live is not None or self.still is not None

    def _tell_scale(self):
        self.scaled.emit(self.scale if self.has_picture else None)

    @property
    def scale(self):
        """Screen pixels per pixel of the live picture."""
        if self._scale is not None:
            return self._scale
        width, height = self._size()
        rect = self._areas()[0]
        return min(rect.width() / width, rect.height() / height)

    @property
    def fitted(self):
        """Whether the picture is scaled with the window."""
        return self._scale is None

    def fit(self):
        """Make the picture as large as the window."""
        self._scale, self._middle = None, QPointF(0.5, 0.5)
        self.update()
        self._tell_scale()

    def zoom(self, factor, about=None):
        """Multiply the zoom; the point ``about`` of the widget stays where it is."""
        self.set_scale(self.scale * factor, about)

    def set_scale(self, scale, about=None):
        """Set the zoom; whole factors show every pixel as a square. Nothing without a picture."""
        if not self.has_picture:
            return
        about = QPointF(about if about is not None else self._areas()[0].center())
        before = self._share(about)
        self._scale = min(max(scale, _SCALES[0]), _SCALES[1])
        after = self._share(about)
        self._middle += before - after
        self._keep_inside()
        self.update()
        self._tell_scale()

    def zoom_in(self):
        self.zoom(_STEP)

    def zoom_out(self):
        self.zoom(1 / _STEP)

    def _size(self):
        image = self.live if self.live is not None else self.still
        return (4, 3) if image is None else (image.width(), image.height())

    def _areas(self):
        """The part of the widget of each picture that is painted."""
        if self.mode != "side by side":
            return [self.rect()]
        half = (self.width() - _GAP) // 2
        return [QRect(0, 0, half, self.height()),
                QRect(self.width() - half, 0, half, self.height())]

    def _rect(self, area):
        """Rectangle of the picture in the widget, not clipped to the ``area``."""
        width, height = (side * self.scale for side in self._size())
        left = area.center().x() + 0.5 - self._middle.x() * width
        top = area.center().y() + 0.5 - self._middle.y() * height
        # Whole pixels on the screen, so that at 100 % each is a pixel of the picture.
        return QRectF(round(left), round(top), width, height)

    def picture_rect(self):
        """Rectangle of the live picture in the widget, a QRectF."""
        return self._rect(self._areas()[-1])

    def _share(self, point):
        """Position of a point in the picture, as shares of its width and height."""
        area = next((one for one in self._areas() if one.contains(QPointF(point).toPoint())),
                    self._areas()[0])
        rect = self._rect(area)
        return QPointF((point.x() - rect.left()) / rect.width(),
                       (point.y() - rect.top()) / rect.height())

    def _pixel(self, point):
        """Position of a point in the picture, in its pixels."""
        share, (width, height) = self._share(point), self._size()
        return QPointF(share.x() * width, share.y() * height)

    def _keep_inside(self):
        self._middle = QPointF(min(max(self._middle.x(), 0), 1), min(max(self._middle.y(), 0), 1))

    # Painting.

    def paintEvent(self, event):
        painter = QPainter(self)
        painter.fillRect(self.rect(), _BACKGROUND)
        areas = self._areas()
        pictures = {"before": [self.live], "after": [self.live],
                    "side by side": [self.still, self.live], "wipe": [self.live]}[self.mode]
        # Each pixel a square if it is large; smooth if several fall on one.
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, self.scale < 2)
        for area, image in zip(areas, pictures):
            painter.setClipRect(area)
            if image is not None:
                painter.drawImage(self._rect(area), image)
        if self.mode == "wipe" and self.still is not None and self.live is not None:
            self._paint_wipe(painter)
        if self._outline is not None:
            self._paint_outline(painter)
        painter.setClipping(False)
        if self.shade:
            painter.fillRect(self.rect(), QColor(38, 40, 43, 170))
        self._paint_names(painter, areas)
        if self.text:
            self._paint_text(painter)

    def _paint_outline(self, painter):
        rect, scale = self.picture_rect(), self.scale
        part = QRectF(rect.topLeft() + scale * self._outline.topLeft(),
                      scale * self._outline.size()).intersected(rect)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for pen in _OUTLINE:
            painter.setPen(pen)
            painter.drawRect(part.adjusted(1, 1, -2, -2))

    def _line(self):
        rect = self._rect(self.rect())
        return rect.left() + self.wipe * rect.width()

    def _paint_wipe(self, painter):
        x = round(self._line())
        painter.setClipRect(QRect(0, 0, max(0, x), self.height()))
        painter.fillRect(self.rect(), _BACKGROUND)
        painter.drawImage(self._rect(self.rect()), self.still)
        painter.setClipping(False)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(0, 0, 0, 120), 4))
        painter.drawLine(x, 0, x, self.height())
        painter.setPen(QPen(Qt.GlobalColor.white, 2))
        painter.drawLine(x, 0, x, self.height())
        painter.setBrush(QColor(255, 255, 255))
        middle = self.height() // 2
        painter.drawEllipse(QPoint(x, middle), 11, 11)
        painter.setPen(QPen(QColor(60, 60, 60), 2))
        for sign in (1, -1):
            painter.drawLine(x + 3 * sign, middle - 4, x + 7 * sign, middle)
            painter.drawLine(x + 3 * sign, middle + 4, x + 7 * sign, middle)

    def _paint_names(self, painter, areas):
        if self.mode == "side by side":
            for area, name, image in zip(areas, _NAMES, (self.still, self.live)):
                if image is not None:
                    self._paint_name(painter, area.left() + 10, name)
        elif self.mode == "wipe" and self.still is not None:
            line = round(self._line())
            self._paint_name(painter, line - 14, _NAMES[0], right=True)
            self._paint_name(painter, line + 14, _NAMES[1])

    def _paint_name(self, painter, x, name, right=False):
        metrics = painter.fontMetrics()
        width, height = metrics.horizontalAdvance(name) + 16, metrics.height() + 6
        box = QRect(x - width if right else x, 10, width, height)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(0, 0, 0, 150))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.drawRoundedRect(box, 4, 4)
        painter.setPen(Qt.GlobalColor.white)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, name)

    def _paint_text(self, painter):
        font = painter.font()
        font.setPointSizeF(font.pointSizeF() * 1.3)
        painter.setFont(font)
        painter.setPen(QColor(225, 225, 225))
        box = self.rect().adjusted(40, 20, -40, -20)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self.text)

    # Mouse and keys.

    def wheelEvent(self, event):
        steps = event.angleDelta().y() / 120
        if steps and self.steers:
            self.wheeled.emit(steps, self._pixel(event.position()))
        elif steps:
            self.zoom(_STEP**steps, event.position())

    def mousePressEvent(self, event):
        if event.button() != Qt.MouseButton.LeftButton:
            return
        on_line = self.mode == "wipe" and abs(event.position().x() - self._line()) <= _GRIP
        self._drag = "line" if on_line else event.position()
        self._start = self._pixel(event.position())
        if not on_line:
            self.setCursor(Qt.CursorShape.ClosedHandCursor)

    def mouseMoveEvent(self, event):
        point = event.position()
        if self._drag == "line":
            rect = self._rect(self.rect())
            self.set_wipe((point.x() - rect.left()) / rect.width())
        elif self._drag is not None and self.steers:
            self.dragged.emit((point - self._drag) / self.scale, self._start)
            self._drag = point
        elif self._drag is not None:
            rect = self._rect(self._areas()[0])
            moved = point - self._drag
            self._scale = self.scale
            self._middle -= QPointF(moved.x() / rect.width(), moved.y() / rect.height())
            self._keep_inside()
            self._drag = point
            self.update()
        elif self.mode == "wipe" and abs(point.x() - self._line()) <= _GRIP:
            self.setCursor(Qt.CursorShape.SplitHCursor)
        else:
            self.unsetCursor()
        self._point(point)

    def mouseReleaseEvent(self, event):
        self._drag = None
        self.unsetCursor()

    def mouseDoubleClickEvent(self, event):
        self.fit()

    def leaveEvent(self, event):
        self.pointed.emit(QPoint(-1, -1), "")

    def keyPressEvent(self, event):
        direction = _ARROWS.get(event.key())
        if direction and self.steers:
            self.pushed.emit(QPointF(*direction))
        elif direction and direction[0] and self.mode == "wipe":
            self.set_wipe(self.wipe + _WIPE * direction[0])
        else:
            super().keyPressEvent(event)

    def set_wipe(self, share):
        """Move the line to a share of the picture's width."""
        self.wipe = min(max(share, 0.0), 1.0)
        self.update()

    def _point(self, point):
        areas = self._areas()
        first = self.mode == "side by side" and areas[0].contains(point.toPoint())
        left = self.mode == "wipe" and point.x() < self._line()
        image = self.still if first or left else self.live
        share = self._share(point)
        if image is None or not (0 <= share.x() < 1 and 0 <= share.y() < 1):
            self.pointed.emit(QPoint(-1, -1), "")
            return
        pixel = QPoint(int(share.x() * image.width()), int(share.y() * image.height()))
        colour = image.pixelColor(pixel)
        self.pointed.emit(pixel, f"{colour.red()} {colour.green()} {colour.blue()}")

    def resizeEvent(self, event):
        self._tell_scale()
