"""The row above the picture: what is shown, how large, and what to keep of it."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QButtonGroup,
    QHBoxLayout,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from ncdc_host.gui.flow_layout import FlowLayout
from ncdc_host.gui.picture_view import MODES
from ncdc_host.gui.plain_text import PlainLabel

__all__ = ["ViewBar"]

_TIPS = {
    "before": "The raw frame, live: the device's correction is off, for all its users (1)",
    "after": "The corrected picture, live (2)",
    "side by side": "A raw frame next to the corrected picture (3)",
    "wipe": "A raw frame under the corrected picture; drag the line, or ← → (4)",
}


class ViewBar(QWidget):
    """Signals ``mode_chosen(mode)``; the other buttons are joined to actions by who owns it."""
    mode_chosen = Signal(str)

    def __init__(self):
        super().__init__()
        # Rows that break where the window is narrow: no button makes it wider.
        self._row = FlowLayout(self)
        policy = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)
        self.modes, group = {}, QButtonGroup(self)
        for mode in MODES:
            button = self.modes[mode] = QToolButton(text=mode.capitalize(), checkable=True,
                                                    toolTip=_TIPS[mode])
            button.clicked.connect(lambda _, mode=mode: self.mode_chosen.emit(mode))
            group.addButton(button)
            self._row.addWidget(button)
        self.again = self._button("New raw frame", "The raw frame to compare with is a still: "
                                  "take another one (R)")
        self.freeze = self._button("Freeze", "Keep this picture on the screen (space)")
        self.freeze.setCheckable(True)
        self.steer = self._button("Move view", "Drag, wheel and arrow keys move the device's view, "
                                  "for all its users, instead of the picture in the window (V)")
        self.steer.setCheckable(True)
        self.reset = self._button("Reset view", "Look as the lens was trained (Home)")
        self.save = self._button("Save …", "Save the picture that is shown (Ctrl+S)")
        self._row.addWidget(self._zoom_group())
        self.show_scale(None)

    def _zoom_group(self):
        """The buttons that zoom, and how much, which stay together."""
        group = QWidget()
        row = QHBoxLayout(group)
        row.setContentsMargins(6, 0, 0, 0)
        row.setSpacing(4)
        self.scale = PlainLabel(alignment=Qt.AlignmentFlag.AlignCenter)
        self.scale.setFixedWidth(self.scale.fontMetrics().horizontalAdvance("3200 %"))
        self.zoom_out = QToolButton(text="−", toolTip="Smaller (−)")
        self.zoom_in = QToolButton(text="+", toolTip="Larger (+)")
        self.fit = QToolButton(text="Fit", toolTip="As large as the window (F)")
        self.whole = QToolButton(text="1:1", toolTip="A pixel on the screen for each of the "
                                                     "picture (0)")
        for widget in (self.zoom_out, self.scale, self.zoom_in, self.fit, self.whole):
            row.addWidget(widget)
        return group

    def _button(self, text, tip):
        button = QToolButton(text=text, toolTip=tip)
        self._row.addWidget(button)
        return button

    def show_mode(self, mode, comparing):
        """Show which mode it is; ``comparing``: with a still raw frame."""
        self.modes[mode].setChecked(True)
        self.again.setVisible(comparing)

    def show_scale(self, scale):
        """Show the zoom; None: there is no picture to zoom."""
        self.scale.setText("–" if scale is None else f"{100 * scale:.0f} %")
        for button in (self.zoom_out, self.zoom_in, self.fit, self.whole):
            button.setEnabled(scale is not None)
