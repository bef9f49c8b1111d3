""""Calibrate from this picture": what is asked, how far it is, what came of it."""

import shutil
from pathlib import Path

from PySide6.QtCore import QSize, QSizeF, Qt, Signal
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QSizePolicy,
    QSpinBox,
    QVBoxLayout,
)

from ncdc_host.gui.calibration import Calibration
from ncdc_host.gui.file_names import name_to_open
from ncdc_host.gui.plain_text import PlainLabel, plain_tip
from ncdc_spec.formats import MAX_NEURONS

__all__ = ["TARGETS", "CalibrationDialog"]

TARGETS = ("auto", "dots", "circles:11x7", "acircles:4x11", "chessboard:9x6", "charuco:8x11",
           "aprilgrid:6x6")
_NEURONS = 8
_BAYER = "RGGB"         # of a network for a camera that sends colours
_PICTURE_MIN = 160, 90
_SIZE = 560, 640


class _Picture(QLabel):
    """Shows a picture as large as its space: the dialog is as large as the user wants it."""

    def __init__(self):
        super().__init__(alignment=Qt.AlignmentFlag.AlignCenter)
        self._whole = QPixmap()
        self.setMinimumSize(*_PICTURE_MIN)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)

    def show_picture(self, pixmap):
        """Show another picture."""
        self._whole = pixmap
        self._fit()

    def _fit(self):
        if self._whole.isNull():
            return
        ratio = self.devicePixelRatio()
        scaled = self._whole.scaled(
            (QSizeF(self.size()) * ratio).toSize(), Qt.AspectRatioMode.KeepAspectRatio,
            Qt.TransformationMode.SmoothTransformation)
        scaled.setDevicePixelRatio(ratio)
        self.setPixmap(scaled)

    def resizeEvent(self, event):
        super().resizeEvent(event)
        self._fit()


class CalibrationDialog(QDialog):
    """Makes a lens of one raw frame, or of the pictures of :meth:`use_pictures`.

    Signals ``lens_wanted(path, number)`` when the user wants it loaded as the device's lens of that
    number.

    Parameters
    ----------
    shown : Shown
        The raw frame, as the sensor's pixels lie.
    limits : LensLimits or None
        Lenses that the device can load; None: none over this transport, for the ``reason``.
    lenses : sequence of str
        Names of the device's lenses.
    active : int
        Number of the one that is corrected now.
    """
    lens_wanted, photo_wanted = Signal(str, int), Signal(str, object)

    def __init__(self, shown, limits, lenses, active, reason="", parent=None):
        super().__init__(parent)
        self.setWindowTitle("Calibrate from this picture")
        self._shown, self._limits = shown, limits
        self.lens, self.found, self.result = None, "", ""
        self.job = Calibration(self)
        self.picture = _Picture()
        self.picture.setAccessibleName("Raw frame")
        self._show_frame()
        self.about = PlainLabel(
            "The raw frame that the device sees now. It should show a calibration target that "
            "fills it: a page of dots, a chessboard, circles, ChArUco or an AprilGrid.")
        self.about.setWordWrap(True)
        self.progress = QProgressBar(maximum=1000, textVisible=True)
        self.progress.hide()
        self.state = PlainLabel(wordWrap=True)
        self.state.setMinimumHeight(3 * self.fontMetrics().lineSpacing())
        self.state.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.state.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        column = QVBoxLayout(self)
        for widget in (self.about, self.picture):
            column.addWidget(widget, int(widget is self.picture))
        column.addLayout(self._form(lenses, active, reason))
        for widget in (self.state, self.progress):
            column.addWidget(widget)
        column.addWidget(self._buttons())
        self._connect()
        self.resize(QSize(*_SIZE).boundedTo(self.screen().availableSize()))

    def _form(self, lenses, active, reason):
        form = QFormLayout()
        self.target = QComboBox(editable=True)
        self.target.addItems(TARGETS)
        self.target.setToolTip("auto recognises it; else as ncdc calibrate --target has it, "
                               "as in chessboard:9x6 (inner corners)")
        highest = self._limits.neurons if self._limits else MAX_NEURONS
        self.neurons = QSpinBox(minimum=1, maximum=highest, value=min(_NEURONS, highest))
        self.neurons.setToolTip(plain_tip(
            f"Hidden neurons of the network; this device takes up to {highest}. More model the "
            "lens more closely."))
        form.addRow("&Target", self.target)
        form.addRow("&Neurons", self.neurons)
        self.number = QComboBox()
        for k, name in enumerate(lenses):
            self.number.addItem(name + (" (active)" if k == active else ""))
        self.number.setCurrentIndex(active)
        self.number.setToolTip("Nothing of the device changes before you press the button that "
                               "loads the result.")
        self.file_only = PlainLabel(f"a file only: {reason}", wordWrap=True)
        form.addRow("&Replaces" if self._limits else "Goes into",
                    self.number if self._limits else self.file_only)
        self.previous = QPushButton("an earlier calibration …")
        self.previous.setToolTip("The difference of the lens that is found, in pixels, whatever "
                                 "the view")
        self.previous.clicked.connect(self._ask_previous)
        form.addRow("&Compare with", self.previous)
        return form

    def _buttons(self):
        box = QDialogButtonBox()
        role = QDialogButtonBox.ButtonRole
        self.start = box.addButton("Calibrate and train", role.ActionRole)
        self.start.setDefault(True)
        self.load = box.addButton("Load into the device", role.ActionRole)
        self.load.setVisible(self._limits is not None)
        self.keep = box.addButton("Save lens file …", role.ActionRole)
        for button in (self.load, self.keep):
            button.setEnabled(False)
        self.leave = box.addButton(QDialogButtonBox.StandardButton.Close)
        self.start.clicked.connect(self.run)
        self.load.clicked.connect(self._load)
        self.keep.clicked.connect(self._save)
        self.leave.clicked.connect(self.reject)
        return box

    def _connect(self):
        self.job.step.connect(self._step)
        self.job.progress.connect(self._progress)
        self.job.points_found.connect(self._points)
        self.job.done.connect(self._done)
        self.job.failed.connect(self._failed)

    def use_pictures(self, live):
        """Take the pictures of a :class:`LiveCalibration` in place of the raw frame."""
        live.setParent(self)            # whose folder goes with it
        self.job.photos = live.pictures
        self.about.setText(f"The {len(live.pictures)} pictures of the live calibration. The lens "
                           f"of all is found, then a network is trained.")

    def _ask_previous(self):
        path = name_to_open(self, "Compare with an earlier calibration",
                            "Lens, points or camera files (*.toml *.json *.yaml *.yml)")
        if path:
            self.compare_with(path)

    def compare_with(self, path):
        """Have the result compared with an earlier calibration."""
        self.job.previous = path
        self.previous.setText(Path(path).name)

    def run(self):
        """Have the photo written, then begin (:meth:`photo_written`)."""
        self.lens = None
        self._settable(False)
        self._show_frame()          # no points of an earlier run
        if self.job.photos != [self.job.photo]:
            self._begin()
            return
        self._step("Writing the raw frame")
        self.photo_wanted.emit(str(self.job.photo), self._shown.frame.pixels)

    def photo_written(self, path):
        """The photo is there: calibrate and train."""
        if path == str(self.job.photo) and not self.job.running:
            self._begin()

    def _begin(self):
        limits = self._limits
        fixed = {} if limits is None else {"size": limits.corrected, "fill": limits.fill,
                                           "nodes": limits.nodes,
                                           "interpolation": limits.interpolation}
        self.job.start(self.target.currentText().strip(), self.neurons.value(),
                       self._shown.frame.pixel_format.bayer or _BAYER, **fixed)

    def _load(self):
        self.load.setEnabled(False)
        self.lens_wanted.emit(self.lens, self.number.currentIndex())

    def lens_loaded(self, number):
        """The device has the lens as its lens ``number``."""
        if self.lens is None:
            return
        self.load.setEnabled(True)
        self.state.setText(f"{self.result} It is lens {number} of the device now.")

    def trouble(self, text):
        """Something that was asked of the session did not work."""
        if not self.start.isEnabled() and not self.job.running:
            self._failed(text)
        elif self.lens is not None:
            self.load.setEnabled(True)
            self.state.setText(f"{self.result} It was not loaded: {text}")

    def reject(self):
        self.job.cancel()
        super().reject()

    def _settable(self, on):
        for widget in (self.start, self.target, self.neurons, self.previous):
            widget.setEnabled(on)
        self.progress.setVisible(not on)
        self.leave.setText("Close" if on else "Cancel")
        for button in (self.load, self.keep):
            button.setEnabled(on and self.lens is not None)

    def _step(self, text):
        self.state.setText(f"{text} …")
        self.progress.setRange(0, 0)        # busy, of unknown length

    def _progress(self, share, mse):
        self.progress.setRange(0, 1000)
        self.progress.setValue(round(1000 * share))
        self.state.setText(f"Training {self.neurons.value()} hidden neurons: {100 * share:.0f} %, "
                           f"{mse**0.5:.3f} px rms so far")

    def _points(self, count, target, overlay):
        self._show(QPixmap(overlay))
        self.found = f"{count} points of the target ({target})"

    def _show_frame(self):
        self._show(QPixmap.fromImage(self._shown.image))

    def _show(self, pixmap):
        self.picture.show_picture(pixmap)

    def _done(self, lens, report):
        self.lens = lens
        self._settable(True)
        (self.load if self._limits is not None else self.keep).setDefault(True)
        warnings = "".join(f"\nWarning: {text}." for text in report["warnings"])
        self.result = (
            f"{self.found}; over the whole picture the network errs by an estimated "
            f"{report['mean_px']:.3f} px in the mean, {report['max_px']:.2f} px at most; "
            f"{report['valid_percent']:.1f} % of the picture has a source."
            f"{self._difference(report.get('difference_px'))}{warnings}")
        self.state.setText(self.result)

    def _difference(self, found):
        """A sentence on the difference from the earlier calibration, if there is one."""
        if not found:
            return ""
        return (f" {self.previous.text()} differs by {found['rms']:.3f} px rms, {found['max']:.2f} "
                f"px at most, at ({found['x']:.0f}, {found['y']:.0f}).")

    def _failed(self, text):
        self._settable(True)
        self.state.setText(f"It did not work: {text}")

    def _save(self):
        path, _ = QFileDialog.getSaveFileName(self, "Save lens file", "net.toml",
                                              "Lens files (*.toml)")
        if path:
            self.save_lens(path)

    def save_lens(self, path):
        """Copy the lens file."""
        try:
            shutil.copyfile(self.lens, path)
        except OSError as error:
            self.state.setText(f"{path} cannot be written: {error.strerror}")
