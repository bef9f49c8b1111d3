"""A layout that fills rows from left to right and begins another row where one is full."""

from PySide6.QtCore import QPoint, QRect, QSize, Qt
from PySide6.QtWidgets import QLayout

__all__ = ["FlowLayout"]


class FlowLayout(QLayout):
    """Rows of widgets, each in its preferred size; as narrow as its widest widget if need be.

    Parameters
    ----------
    margins : (int, int)
        Pixels at the left and right, and at the top and bottom.
    gap : int
        Pixels between widgets, and between rows.
    """

    def __init__(self, parent=None, margins=(8, 6), gap=4):
        super().__init__(parent)
        across, down = margins
        self.setContentsMargins(across, down, across, down)
        self._gap, self._items = gap, []

    # What QLayout asks for.

    def addItem(self, item):
        self._items.append(item)

    def count(self):
        return len(self._items)

    def itemAt(self, index):
        return self._items[index] if 0 <= index < len(self._items) else None

    def takeAt(self, index):
        return self._items.pop(index) if 0 <= index < len(self._items) else None

    def expandingDirections(self):
        return Qt.Orientation(0)

    def hasHeightForWidth(self):
        return True

    def heightForWidth(self, width):
        return self._rows(QRect(0, 0, width, 0), None)

    def setGeometry(self, rect):
        super().setGeometry(rect)
        self._rows(rect, QRect.topLeft(rect))

    def sizeHint(self):
        sizes = [item.sizeHint() for item in self._shown()]
        width = sum(size.width() for size in sizes) + self._gap * max(0, len(sizes) - 1)
        return self._around(width, max((size.height() for size in sizes), default=0))

    def minimumSize(self):
        sizes = [item.minimumSize() for item in self._shown()]
        return self._around(max((size.width() for size in sizes), default=0),
                            max((size.height() for size in sizes), default=0))

    # Rows.

    def _shown(self):
        return [item for item in self._items if not item.isEmpty()]

    def _around(self, width, height):
        sides = self.contentsMargins()
        return QSize(width + sides.left() + sides.right(), height + sides.top() + sides.bottom())

    def _rows(self, rect, arrange):
        """Arrange the widgets in ``rect``, or only measure if ``arrange`` is None; the height."""
        sides = self.contentsMargins()
        inside = rect.marginsRemoved(sides)
        x, y, height = inside.left(), inside.top(), 0
        for item in self._shown():
            size = item.sizeHint()
            if x > inside.left() and x + size.width() > inside.left() + inside.width():
                x, y, height = inside.left(), y + height + self._gap, 0
            if arrange is not None:
                item.setGeometry(QRect(QPoint(x, y), size))
            x, height = x + size.width() + self._gap, max(height, size.height())
        return y + height - rect.top() + sides.bottom()
