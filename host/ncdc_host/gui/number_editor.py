"""A number with limits: a box to type it in, and a slider where one helps."""

import math

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QValidator
from PySide6.QtWidgets import QDoubleSpinBox, QHBoxLayout, QSlider, QSpinBox, QWidget

from ncdc_host.gui.careful import Careful
from ncdc_host.gui.plain_text import plain_tip

__all__ = ["NumberEditor"]

_TICKS = 1000           # of a slider
_DECIMALS = 3           # that are always shown, if the box has so many
_WHOLE_MAX = 2**31 - 1  # of Qt's box for whole numbers


class _Limited:
    """Replaces a typed value beyond a limit by the limit.

    Qt's own boxes drop the digit that goes too far: of 20000 typed where 10000 is the limit, 2000
    would be sent.
    """

    def validate(self, text, position):
        state, *rest = super().validate(text, position)
        if state == QValidator.State.Invalid and self._typed(text) is not None:
            state = QValidator.State.Intermediate
        return state, *rest

    def fixup(self, text):
        number = self._typed(text)
        if number is None:
            return super().fixup(text)
        limit = self.minimum() if number < self.minimum() else self.maximum()
        return self.textFromValue(limit) + self.suffix()

    def _typed(self, text):
        """The number that ``text`` is, with or without the unit; None if it is none."""
        digits = text.removesuffix(self.suffix()).strip()
        number, fine = self.locale().toDouble(digits)
        if not fine or not math.isfinite(number):
            return None
        decimals = digits.partition(self.locale().decimalPoint())[2]
        return number if len(decimals) <= self.decimals() else None


class _Whole(_Limited, Careful, QSpinBox):
    def decimals(self):
        """Digits after the point, as of a box for real numbers."""
        return 0


class _Real(_Limited, Careful, QDoubleSpinBox):
    """Shows the decimals that the number has, but no zeros after the third one."""

    def textFromValue(self, value):
        text = self.locale().toString(value, "f", self.decimals())
        while self.decimals() > _DECIMALS and text.endswith("0") and len(
                text.rpartition(self.locale().decimalPoint())[2]) > _DECIMALS:
            text = text[:-1]
        return text


class _Slider(Careful, QSlider):
    pass


class NumberEditor(QWidget):
    """Signals ``edited(value)`` for what the user does, never for :meth:`show_value`.

    Parameters
    ----------
    name : str
        For screen readers.
    decimals : int
        0: whole numbers.
    unit : str
    slider : {"", "linear", "log"}
    about : str
        A sentence for the tool tip, which shows the limits as well.
    """
    edited = Signal(float)

    def __init__(self, name, decimals=0, unit="", slider="", about=""):
        super().__init__()
        self._about, self._slider_high = about, 0
        self.box = _Real() if decimals else _Whole()
        if decimals:
            self.box.setDecimals(decimals)
        self.box.setSuffix(f" {unit}" if unit else "")
        self.box.setKeyboardTracking(False)
        self.box.setAccessibleName(name)
        self.box.valueChanged.connect(self._box_changed)
        self._log, self.slider = slider == "log", None
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        if slider:
            self.slider = _Slider(Qt.Orientation.Horizontal)
            self.slider.setRange(0, _TICKS)
            self.slider.setAccessibleName(name)
            self.slider.setMinimumWidth(60)
            self.slider.valueChanged.connect(self._slider_changed)
            row.addWidget(self.slider, 1)
        self.box.setMinimumWidth(96)
        row.addWidget(self.box, 0 if slider else 1)
        self.setFocusProxy(self.box)

    @property
    def value(self):
        """The number in the box."""
        return self.box.value()

    def show_value(self, value, low, high, step, slider_high=math.inf):
        """Show what the device has, with the limits and the step that it has now.

        ``slider_high``: where the slider ends, if the box's limit is too far for it.
        """
        whole = isinstance(self.box, QSpinBox)
        with QSignalBlocker(self.box):
            if whole:
                low, high = int(low), int(min(high, _WHOLE_MAX))
                self.box.setRange(low, high)
                self.box.setSingleStep(max(1, int(step)))
                self.box.setValue(int(value))
            else:
                self.box.setRange(low, high)
                self.box.setSingleStep(step)
                self.box.setValue(value)
        self._slider_high = min(self.box.maximum(), max(slider_high, self.box.value()))
        limits = (self.box.textFromValue(limit) for limit in (self.box.minimum(),
                                                              self.box.maximum()))
        self.setToolTip(plain_tip(
            f"{self._about}\nFrom {' to '.join(limits)}{self.box.suffix()}.".strip()))
        self._show_slider()

    def _show_slider(self):
        if self.slider is None:
            return
        low, high = self.box.minimum(), self._slider_high
        value = min(self.box.value(), high)
        if self._log:
            low, high, value = (math.log(max(number, 1e-6)) for number in (low, high, value))
        share = (value - low) / (high - low) if high > low else 0
        with QSignalBlocker(self.slider):
            self.slider.setValue(round(_TICKS * share))

    def _box_changed(self, value):
        self._show_slider()
        self.edited.emit(value)

    def _slider_changed(self, tick):
        low, high, share = self.box.minimum(), self._slider_high, tick / _TICKS
        if self._log:
            low = max(low, 1e-6)
            value = low * (high / low)**share
        else:
            value = low + share * (high - low)
        with QSignalBlocker(self.box):
            self.box.setValue(round(value) if isinstance(self.box, QSpinBox) else value)
        self.edited.emit(self.box.value())
