"""A line above the picture that says what is wrong, with buttons to resolve it."""

from PySide6.QtCore import QEvent, Qt, QTimer
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QStyle, QToolButton

from ncdc_host.gui.colours import message_colours
from ncdc_host.gui.plain_text import PlainLabel

__all__ = ["MessageBar"]

_SECONDS = 10           # that a passing message stays
_ICONS = {"error": QStyle.StandardPixmap.SP_MessageBoxCritical,
          "warning": QStyle.StandardPixmap.SP_MessageBoxWarning,
          "info": QStyle.StandardPixmap.SP_MessageBoxInformation}


class MessageBar(QFrame):
    """Shows a sentence until it is closed, replaced, or, if it passes, for ten seconds."""

    def __init__(self):
        super().__init__()
        self.setObjectName("messageBar")
        self._icon, self._label = QLabel(), PlainLabel()
        self._label.setWordWrap(True)
        self._label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(10, 6, 6, 6)
        self._row.addWidget(self._icon)
        self._row.addWidget(self._label, 1)
        close = QToolButton(text="✕", autoRaise=True, toolTip="Close this message")
        close.clicked.connect(self.clear)
        self._row.addWidget(close)
        self.buttons, self._kind = [], "info"
        self._timer = QTimer(self, singleShot=True, interval=1000 * _SECONDS)
        self._timer.timeout.connect(self.clear)
        self.lasting = False
        self.hide()

    @property
    def text(self):
        """The sentence that is shown; empty if none is."""
        return "" if self.isHidden() else self._label.text()

    def show_message(self, text, kind="error", actions=(), lasting=False):
        """Show a sentence.

        Parameters
        ----------
        text : str
        kind : {"error", "warning", "info"}
        actions : sequence of (str, callable)
            Buttons.
        lasting : bool
            Stays until :meth:`clear`; passing messages do not replace it.
        """
        if self.lasting and not lasting:
            return
        self._clear_buttons()
        self.lasting = lasting
        self._kind = kind
        self._colour()
        size = self.style().pixelMetric(QStyle.PixelMetric.PM_SmallIconSize)
        self._icon.setPixmap(self.style().standardIcon(_ICONS[kind]).pixmap(size))
        self._label.setText(text)
        for name, act in actions:
            button = QPushButton(name)
            button.clicked.connect(act)
            self._row.insertWidget(self._row.count() - 1, button)
            self.buttons.append(button)
        self.show()
        self._timer.stop() if lasting else self._timer.start()

    def _colour(self):
        # The application's palette: this one's own has the colours of its style sheet.
        paper, ink = (colour.name() for colour in message_colours(self._kind,
                                                                  QGuiApplication.palette()))
        sheet = (f"#messageBar {{background: {paper}; border-bottom: 1px solid {ink}}} "
                 f"#messageBar QLabel, #messageBar QToolButton {{color: {ink}}}")
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)

    def changeEvent(self, event):
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and self.styleSheet():
            self._colour()          # the desktop has become dark or light

    def clear(self):
        """Show nothing."""
        self._timer.stop()
        self._clear_buttons()
        self.lasting = False
        self.hide()

    def _clear_buttons(self):
        for button in self.buttons:
            self._row.removeWidget(button)
            button.hide()
            button.deleteLater()
        self.buttons = []
