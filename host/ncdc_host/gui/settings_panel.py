"""The sensor's settings and the picture's: shutter, exposure, gain, speed, size, format, mirror."""

import math

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QGridLayout,
    QGroupBox,
    QVBoxLayout,
    QWidget,
)

from ncdc_host.client.view_state import CORRECTION, WINDOW
from ncdc_host.gui.careful import Careful
from ncdc_host.gui.number_editor import NumberEditor
from ncdc_host.gui.plain_text import PlainLabel
from ncdc_host.gui.shown_views import LAYOUT, SELECTOR, ShownViews

__all__ = ["SettingsPanel"]

_PATTERNS = {
    "Off": "Off", "GreyHorizontalRamp": "Ramp, left to right",
    "GreyVerticalRamp": "Ramp, top to bottom", "GreyDiagonalRamp": "Ramp, diagonal",
    "HorizontalBars": "Bars, horizontal", "VerticalBars": "Bars, vertical",
    "ColorBar": "Colour bars"}
_FORMATS = {"BGR8": "Colour, 24 bit (BGR8)", "BGRa8": "Colour, 32 bit (BGRa8)",
            "Mono8": "Brightness (Mono8)"}
_AUTO = {"Off": "Off", "Once": "Once, then off", "Continuous": "Always"}
_LAYOUTS = {"Single": "One", "Quad": "Four", "Detail": "Overview and detail"}
_SHARES = {"Whole picture": 1.0, "Three quarters": 0.75, "Half": 0.5, "Quarter": 0.25}
_OTHER = "Other window"
_SLIDER_MAX_MS = 1000   # of the exposure: longer ones are typed
_SLACK = 1e-6           # of a line


class _Box(Careful, QComboBox):
    pass


class SettingsPanel(QWidget):
    """Shows features, and signals what the user changes.

    Values that the device has not answered yet are not overwritten by older ones.

    Signals
    -------
    changed(name, value)
    window_changed(x, y, width, height)
    """
    changed, window_changed = Signal(str, object), Signal(int, int, int, int)

    def __init__(self):
        super().__init__()
        self._infos, self._waiting, self._line_us = {}, {}, 1.0
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._sensor_group())
        column.addWidget(self._picture_group())
        self.look_group = self._look_group()
        column.addWidget(self.look_group)

    def _sensor_group(self):
        group = QGroupBox("Sensor")
        self._sensor_form = form = _form(group)
        self.shutter = NumberEditor("Shutter", unit="lines", about="The exposure as the sensor "
                                    "counts it, in lines of the picture.")
        self.shutter.edited.connect(
            lambda lines: self.changed.emit("ExposureTime", lines * self._line_us))
        self.exposure = NumberEditor("Exposure", 6, "ms", "log")    # the device counts ns
        self.exposure.edited.connect(lambda ms: self._expose(1000 * ms))
        self.gain = NumberEditor("Gain", 3, "×", "linear")
        self.gain.edited.connect(lambda value: self.changed.emit("Gain", value))
        self.speed = NumberEditor("Speed", 1, "frames/s", "log")
        self.speed.edited.connect(
            lambda value: self.changed.emit("AcquisitionFrameRate", value))
        self.pattern = self._combo("TestPattern", "Test pattern")
        self.auto = {name: self._combo(name, label) for name, label in (
            ("ExposureAuto", "Automatic exposure"), ("GainAuto", "Automatic gain"),
            ("BalanceWhiteAuto", "Automatic white balance"))}
        self.auto["BalanceWhiteAuto"].setToolTip("Estimated from corrected pictures; raw frames "
                                                 "have the same gains.")
        for name, widget in (("S&hutter", self.shutter), ("&Exposure", self.exposure),
                             ("&Gain", self.gain), ("S&peed", self.speed),
                             ("&Test pattern", self.pattern),
                             ("A&uto exposure", self.auto["ExposureAuto"]),
                             ("Auto gai&n", self.auto["GainAuto"]),
                             ("&White balance", self.auto["BalanceWhiteAuto"])):
            form.addRow(name, widget)
        return group

    def _picture_group(self):
        group = QGroupBox("Picture")
        form = _form(group)
        self.format = self._combo("PixelFormat", "Format")
        self.size = _Box()
        self.size.setAccessibleName("Size")
        self.size.activated.connect(self._size_chosen)
        form.addRow("For&mat", self.format)
        form.addRow("Si&ze", self.size)
        grid = QGridLayout()
        grid.setContentsMargins(0, 0, 0, 0)
        self.window = {}
        for k, (name, label) in enumerate(zip(WINDOW, ("Width", "Height", "Left", "Top"))):
            editor = self.window[name] = NumberEditor(label)
            editor.box.setMinimumWidth(64)
            editor.edited.connect(lambda value, name=name: self.changed.emit(name, int(value)))
            grid.addWidget(PlainLabel(label), k // 2, 2 * (k % 2))
            grid.addWidget(editor, k // 2, 2 * (k % 2) + 1)
        for column in (1, 3):
            grid.setColumnStretch(column, 1)
        form.addRow(grid)
        self.mirror = {"ReverseX": QCheckBox("Left to right"), "ReverseY": QCheckBox("Upside down")}
        row = QVBoxLayout()
        for name, box in self.mirror.items():
            box.clicked.connect(lambda on, name=name: self.changed.emit(name, on))
            row.addWidget(box)
        form.addRow("Mirror", row)
        return group

    def _look_group(self):
        """What is shown only of a device with a view."""
        group = QGroupBox("View")
        self._look_form = form = _form(group)
        self.layout_box, self.looks = self._combo(LAYOUT, "Views"), {}
        self.selector = self._combo(SELECTOR, "Selected view")
        form.addRow("&Views", self.layout_box)
        form.addRow("Selected", self.selector)
        for name, label in (("Pan", "P&an"), ("Tilt", "T&ilt"), ("Roll", "R&oll"),
                            ("Zoom", "&Zoom")):
            editor = (NumberEditor(name, 3, "×", "log") if name == "Zoom" else
                      NumberEditor(name, 2, "°", "linear"))
            editor.edited.connect(lambda value, name=name: self.changed.emit(name, value))
            self.looks[name] = editor
            form.addRow(label, editor)
        return group

    def _combo(self, feature, label):
        box = _Box()
        box.setAccessibleName(label)
        box.activated.connect(lambda k: self.changed.emit(feature, box.itemData(k)))
        return box

    def _expose(self, exposure_us):
        """Set the shutter's limits: whole lines that the sensor supports."""
        box = self.shutter.box
        lines = min(max(box.minimum(), round(exposure_us / self._line_us)), box.maximum())
        self.changed.emit("ExposureTime", lines * self._line_us)

    # What the device has.

    def wait_for(self, name, serial):
        """Older values of the feature are not shown until :meth:`written` says so."""
        self._waiting[name] = serial

    def written(self, name, serial):
        """The device has answered the change of that serial number; shows what it has now."""
        if self._waiting.get(name) == serial:
            del self._waiting[name]
            self.show_features(self._infos)

    def show_features(self, infos, enabled=None):
        """Show the :class:`FeatureInfo` of every feature by name; ``enabled``: can be changed."""
        self._infos = infos
        if enabled is not None:
            self.setEnabled(enabled)
        if "LineTime" in infos:
            self._line_us = infos["LineTime"].value / 1000
        shown = {name: info for name, info in infos.items() if name not in self._waiting}
        self._show_sensor(shown)
        self._show_picture(shown)
        self._show_looks(shown)

    def _show_looks(self, shown):
        self.look_group.setVisible("Pan" in self._infos)
        several = LAYOUT in self._infos
        count = len(ShownViews(self._infos).areas) if several else 1
        self._look_form.setRowVisible(self.layout_box, several)
        self._look_form.setRowVisible(self.selector, count > 1)
        if info := shown.get(LAYOUT):
            _show_choice(self.layout_box, info.choices, info.value, _LAYOUTS)
        if info := shown.get(SELECTOR):
            _show_choice(self.selector, info.choices[:count], info.value,
                         {name: f"View {k}" for k, name in enumerate(info.choices, 1)})
        for name, editor in self.looks.items():
            if info := shown.get(name):
                editor.show_value(info.value, info.minimum, info.maximum, 0.1)

    def _show_sensor(self, shown):
        for name, box in self.auto.items():
            # A device may have none of it, and Table I has no words for it.
            self._sensor_form.setRowVisible(box, name in self._infos)
            if info := shown.get(name):
                _show_choice(box, info.choices, info.value, _AUTO)
        if info := shown.get("ExposureTime"):
            for editor in (self.shutter, self.exposure):
                editor.setEnabled(info.writable)
            line, lines = self._line_us, round(info.value / self._line_us)
            # A limit is a float: it may lack the last digit of a whole number of lines.
            low, high = math.ceil(info.minimum / line - _SLACK), info.maximum / line + _SLACK
            self.shutter.show_value(lines, max(1, low), high, 1)
            self.exposure.show_value(info.value / 1000, info.minimum / 1000, info.maximum / 1000,
                                     1.0, _SLIDER_MAX_MS)
        for name, editor, step in (("Gain", self.gain, 0.125),
                                   ("AcquisitionFrameRate", self.speed, 1.0)):
            if info := shown.get(name):
                editor.setEnabled(info.writable)
                editor.show_value(info.value, info.minimum, info.maximum, step)
        if info := shown.get("TestPattern"):
            _show_choice(self.pattern, info.choices, info.value, _PATTERNS)

    def _show_picture(self, shown):
        if info := shown.get("PixelFormat"):
            choices = [info.value] if info.value.startswith("Bayer") else \
                [name for name in info.choices if not name.startswith("Bayer")]
            if CORRECTION not in self._infos:
                choices = info.choices
            _show_choice(self.format, choices, info.value, _FORMATS)
        for name in WINDOW:
            if info := shown.get(name):
                self.window[name].show_value(info.value, info.minimum, info.maximum,
                                             info.increment or 1)
        if all(name in shown for name in (*WINDOW, "WidthMax", "HeightMax")):
            self._show_size(*(shown[name].value for name in (*WINDOW, "WidthMax", "HeightMax")))
        for name, box in self.mirror.items():
            box.setVisible(name in self._infos)
            if info := shown.get(name):
                with QSignalBlocker(box):
                    box.setChecked(info.value)

    def _show_size(self, width, height, x, y, *whole):
        self._whole = whole
        sizes = {name: _middle(whole, share) for name, share in _SHARES.items()}
        names = {window: name for name, window in sizes.items()}
        present = names.get((x, y, width, height), _OTHER)
        with QSignalBlocker(self.size):
            self.size.clear()
            for name, (_, _, *size) in sizes.items():
                self.size.addItem(f"{name}, {size[0]} × {size[1]}", name)
            self.size.addItem(f"{_OTHER}, {width} × {height}" if present == _OTHER
                              else f"{_OTHER}: type it below", _OTHER)
            self.size.setCurrentIndex(self.size.findData(present))

    def _size_chosen(self, index):
        name = self.size.itemData(index)
        if name == _OTHER:
            self.window["Width"].box.setFocus(Qt.FocusReason.OtherFocusReason)
            self.show_features(self._infos)
        else:
            self.window_changed.emit(*_middle(self._whole, _SHARES[name]))


def _middle(whole, share):
    """(x, y, width, height) of the middle of the whole picture, even as the colour filter is."""
    size = [int(side * share) // 2 * 2 for side in whole]
    return tuple((side - part) // 4 * 2 for side, part in zip(whole, size)) + tuple(size)


def _show_choice(box, choices, value, names):
    with QSignalBlocker(box):
        if [box.itemData(k) for k in range(box.count())] != list(choices):
            box.clear()
            for choice in choices:
                box.addItem(names.get(choice, choice), choice)
        box.setCurrentIndex(box.findData(value))


def _form(group):
    form = QFormLayout(group)
    form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
    form.setLabelAlignment(Qt.AlignmentFlag.AlignLeft)
    return form
