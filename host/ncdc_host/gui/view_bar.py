"""The row above the picture: what is shown, how large, and what to keep of it."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QButtonGroup, QHBoxLayout, QLabel, QToolButton, QWidget

from ncdc_host.gui.picture_view import MODES

__all__ = ["ViewBar"]

_TIPS = {
    "before": "The raw frame, live: the device's correction is off, for all its users (1)",
    "after": "The corrected picture, live (2)",
    "side by side": "A raw frame beside the corrected picture (3)",
    "wipe": "A raw frame under the corrected picture; drag the line, or ← → (4)",
}


class ViewBar(QWidget):
    """Signals ``mode_chosen(mode)``; the other buttons are joined to actions by who owns it."""
    mode_chosen = Signal(str)

    def __init__(self):
        super().__init__()
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(8, 6, 8, 6)
        self._row.setSpacing(4)
        self.modes, group = {}, QButtonGroup(self)
        for mode in MODES:
            button = self.modes[mode] = QToolButton(text=mode.capitalize(), checkable=True,
                                                    toolTip=_TIPS[mode])
            button.clicked.connect(lambda _, mode=mode: self.mode_chosen.emit(mode))
            group.addButton(button)
            self._row.addWidget(button)
        self._row.addSpacing(12)
        self.again = self._button("Take raw frame again", "The raw frame to compare with is a "
                                  "still: take another one (R)")
        self.freeze = self._button("Freeze", "Keep this picture on the screen (space)")
        self.freeze.setCheckable(True)
        self._row.addStretch(1)
        self.zoom_out = self._button("−", "Smaller (−)")
        self.scale = QLabel("100 %", alignment=Qt.AlignmentFlag.AlignCenter)
        self.scale.setFixedWidth(self.scale.fontMetrics().horizontalAdvance("3200 %"))
        self._row.addWidget(self.scale)
        self.zoom_in = self._button("+", "Larger (+)")
        self.fit = self._button("Fit", "As large as the window (F)")
        self.whole = self._button("1:1", "A pixel on the screen for each of the picture (0)")
        self._row.addSpacing(12)
        self.save = self._button("Save …", "Save the picture that is shown (Ctrl+S)")

    def _button(self, text, tip):
        button = QToolButton(text=text, toolTip=tip)
        self._row.addWidget(button)
        return button

    def show_mode(self, mode, comparing):
        """Show which mode it is; ``comparing``: with a still raw frame."""
        self.modes[mode].setChecked(True)
        self.again.setVisible(comparing)

    def show_scale(self, scale):
        """Show the zoom."""
        self.scale.setText(f"{100 * scale:.0f} %")
