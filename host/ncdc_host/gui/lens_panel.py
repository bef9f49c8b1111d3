"""The lenses of a device: which one is active, and how it gets another one."""

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QGroupBox, QListWidget, QPushButton, QVBoxLayout

__all__ = ["LensPanel"]

_ROWS = 4               # that are seen at a time


class LensPanel(QGroupBox):
    """Signals ``chosen(number)``; its buttons ask for a lens file, or for a calibration."""
    chosen = Signal(int)

    def __init__(self):
        super().__init__("Lenses")
        self.list = QListWidget()
        self.list.setAccessibleName("Lenses")
        self.list.setToolTip("The lens that the device corrects. A change takes effect with the "
                             "next frame; the pictures go on.")
        self.list.currentRowChanged.connect(self._row_changed)
        self.load = QPushButton("&Load lens file …")
        self.load.setToolTip("A descriptor of ncdc train replaces the lens above.")
        self.calibrate = QPushButton("&Calibrate from this picture …")
        self.calibrate.setToolTip("Find the calibration target in a raw frame, train a network, "
                                  "and load it into the device.")
        column = QVBoxLayout(self)
        for widget in (self.list, self.load, self.calibrate):
            column.addWidget(widget)
        self.names = {}

    @property
    def active(self):
        """Number of the lens that is chosen."""
        return max(0, self.list.currentRow())

    def texts(self):
        """Names of the lenses: list of str."""
        return [self.list.item(k).text() for k in range(self.list.count())]

    def show_lenses(self, count, active):
        """Show ``count`` lenses, of which the device corrects ``active``."""
        with QSignalBlocker(self.list):
            while self.list.count() > count:
                self.list.takeItem(self.list.count() - 1)
            while self.list.count() < count:
                self.list.addItem("")
            for k in range(count):
                name = self.names.get(k)
                self.list.item(k).setText(f"Lens {k}" + (f": {name}" if name else ""))
            self.list.setCurrentRow(active)
        rows = min(max(count, 1), _ROWS)
        self.list.setFixedHeight(rows * max(18, self.list.sizeHintForRow(0))
                                 + 2 * self.list.frameWidth())

    def name_lens(self, number, name):
        """Show what was loaded as lens ``number``."""
        self.names[number] = name
        self.show_lenses(self.list.count(), self.active)

    def _row_changed(self, row):
        if row >= 0:
            self.chosen.emit(row)
