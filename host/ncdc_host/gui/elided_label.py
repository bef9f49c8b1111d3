"""A label that is cut, with an ellipsis, rather than making its window wider."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import QSizePolicy

from ncdc_host.gui.plain_text import PlainLabel, plain_tip

__all__ = ["ElidedLabel"]


class ElidedLabel(PlainLabel):
    """One line of plain text; the tool tip has all of it while it is cut."""

    def __init__(self):
        super().__init__()
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)

    def minimumSizeHint(self):
        size = super().minimumSizeHint()
        size.setWidth(0)
        return size

    def paintEvent(self, event):
        text = self.fontMetrics().elidedText(self.text(), Qt.TextElideMode.ElideRight,
                                             self.contentsRect().width())
        self.setToolTip(plain_tip(self.text() if text != self.text() else ""))
        painter = QPainter(self)
        painter.drawText(self.contentsRect(), self.alignment(), text)
