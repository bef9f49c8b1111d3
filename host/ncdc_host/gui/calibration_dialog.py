""""Calibrate from this picture": what is asked, how far it is, what came of it."""

import shutil

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QLabel,
    QProgressBar,
    QSizePolicy,
    QSpinBox,
    QVBoxLayout,
)

from ncdc_host.gui.calibration import Calibration
from ncdc_model.formats import MAX_NEURONS

__all__ = ["CalibrationDialog"]

_TARGETS = ("auto", "dots", "circles:11x7", "acircles:4x11", "chessboard:9x6", "charuco:8x11")
_NEURONS = 8
_PICTURE = 480, 360


class CalibrationDialog(QDialog):
    """Makes a lens of one raw frame; signals ``lens_ready(path)`` to have it loaded.

    Parameters
    ----------
    shown : Shown
        The raw frame, as the sensor's pixels lie.
    limits : LensLimits or None
        What the device can take; None: it takes none over this transport, and why is ``reason``.
    number : int
        Of the lens that the result is to become.
    """
    lens_ready, photo_wanted = Signal(str), Signal(str, object)

    def __init__(self, shown, limits, number, reason="", parent=None):
        super().__init__(parent)
        self.setWindowTitle("Calibrate from this picture")
        self._shown, self._limits, self.lens = shown, limits, None
        self.job = Calibration(self)
        self.picture = QLabel(alignment=Qt.AlignmentFlag.AlignCenter)
        self.picture.setMinimumSize(*_PICTURE)
        self.picture.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.picture.setAccessibleName("Raw frame")
        self._show(QPixmap.fromImage(shown.image))
        text = QLabel("The raw frame that the device sees now. It should show a calibration "
                      "target that fills it: a page of dots, a chessboard, circles or ChArUco.")
        text.setWordWrap(True)
        self.progress = QProgressBar(maximum=1000, textVisible=True)
        self.progress.hide()
        self.state = QLabel(wordWrap=True, textFormat=Qt.TextFormat.PlainText)
        self.state.setMinimumHeight(3 * self.fontMetrics().lineSpacing())
        self.state.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.state.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        column = QVBoxLayout(self)
        for widget in (text, self.picture):
            column.addWidget(widget, int(widget is self.picture))
        column.addLayout(self._form(number, reason))
        for widget in (self.state, self.progress):
            column.addWidget(widget)
        column.addWidget(self._buttons())
        self._connect()
        self.resize(560, 640)

    def _form(self, number, reason):
        form = QFormLayout()
        self.target = QComboBox(editable=True)
        self.target.addItems(_TARGETS)
        self.target.setToolTip("auto recognises it; else as ncdc calibrate --target has it, "
                               "as in chessboard:9x6 (inner corners)")
        highest = self._limits.neurons if self._limits else MAX_NEURONS
        self.neurons = QSpinBox(minimum=1, maximum=highest, value=min(_NEURONS, highest))
        self.neurons.setToolTip(f"Hidden neurons of the network; this device takes up to "
                                f"{highest}. More follow the lens more closely.")
        form.addRow("&Target", self.target)
        form.addRow("&Neurons", self.neurons)
        goes = f"lens {number} of the device, as soon as it is trained" if self._limits else \
            f"a file only: {reason}"
        self.place = QLabel(goes, wordWrap=True)
        form.addRow("Goes into", self.place)
        return form

    def _buttons(self):
        box = QDialogButtonBox()
        role = QDialogButtonBox.ButtonRole
        self.start = box.addButton("Calibrate and train", role.ActionRole)
        self.start.setDefault(True)
        self.keep = box.addButton("Save lens file …", role.ActionRole)
        self.keep.setEnabled(False)
        self.leave = box.addButton(QDialogButtonBox.StandardButton.Close)
        self.start.clicked.connect(self.run)
        self.keep.clicked.connect(self._save)
        self.leave.clicked.connect(self.reject)
        return box

    def _connect(self):
        self.job.step.connect(self._step)
        self.job.progress.connect(self._progress)
        self.job.points_found.connect(self._points)
        self.job.done.connect(self._done)
        self.job.failed.connect(self._failed)

    def run(self):
        """Have the photo written, then begin (:meth:`photo_written`)."""
        self._settable(False)
        self.lens = None
        self._step("Writing the raw frame")
        self.photo_wanted.emit(str(self.job.photo), self._shown.frame.pixels)

    def photo_written(self, path):
        """The photo is there: calibrate and train."""
        if path != str(self.job.photo) or self.job.running:
            return
        limits = self._limits
        fixed = {} if limits is None else {"size": limits.corrected, "fill": limits.fill,
                                           "nodes": limits.nodes,
                                           "interpolation": limits.interpolation}
        self.job.start(self.target.currentText().strip(), self.neurons.value(),
                       self._shown.frame.pixel_format.bayer, **fixed)

    def lens_loaded(self):
        """The device has the lens."""
        self.state.setText(self.state.text() + " The device corrects by it now.")

    def trouble(self, text):
        """Something that was asked of the session did not work."""
        if not self.start.isEnabled() and not self.job.running:
            self._failed(text)
        elif self.lens is not None:
            self.state.setText(f"{self.state.text()} It was not loaded: {text}")

    def reject(self):
        self.job.cancel()
        super().reject()

    def _settable(self, on):
        for widget in (self.start, self.target, self.neurons):
            widget.setEnabled(on)
        self.progress.setVisible(not on)
        self.leave.setText("Close" if on else "Cancel")
        self.keep.setEnabled(on and self.lens is not None)

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

    def _show(self, pixmap):
        self.picture.setPixmap(pixmap.scaled(
            *_PICTURE, Qt.AspectRatioMode.KeepAspectRatio,
            Qt.TransformationMode.SmoothTransformation))

    def _done(self, lens, report):
        self.lens = lens
        self._settable(True)
        warnings = "".join(f"\nWarning: {text}." for text in report["warnings"])
        self.state.setText(
            f"{self.found}; over the whole picture the network errs by an estimated "
            f"{report['mean_px']:.3f} px in the mean, {report['max_px']:.2f} px at most; "
            f"{report['valid_percent']:.1f} % of the picture has a source.{warnings}")
        if self._limits is not None:
            self.lens_ready.emit(lens)

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
