""""Calibrate live": frames in motion, of which the pictures of a calibration are chosen."""

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QImage
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QProgressBar,
    QVBoxLayout,
)

from ncdc_host.gui.calibration_dialog import TARGETS
from ncdc_host.gui.live_calibration import LiveCalibration
from ncdc_host.gui.live_view import LiveView
from ncdc_host.gui.plain_text import PlainLabel

__all__ = ["LiveDialog"]

_SIZE = 860, 800
_SEEN = {"nothing": "No target is seen.", "moving": "The target moves.",
         "blurred": "The target is blurred.", "waiting": "Hold it still …",
         "known": "A picture of this pose is there already.",
         "wrong": "No lens explains this picture with the others: it is left out.",
         "taken": "Picture {pictures} is taken."}
_HELP = ("Hold a calibration target in front of the camera, still, again and again: pictures are "
         "taken by themselves. Orange parts are not covered yet; the dashed outline is the pose "
         "that would help most.")


class LiveDialog(QDialog):
    """Shows frames that :meth:`show_frame` brings, and takes pictures of them.

    Signals
    -------
    frame_wanted()
        It can look at another frame.
    complete()
        The user goes on with the pictures, ``self.live.pictures``.
    """
    frame_wanted, complete = Signal(), Signal()

    def __init__(self, name, parent=None):
        super().__init__(parent)
        self.setWindowTitle(f"Calibrate live: {name}")
        self.live, self._image, self._pixels = LiveCalibration(self), None, None
        self.view = LiveView()
        self.state = PlainLabel(_HELP, wordWrap=True)
        self.state.setMinimumHeight(3 * self.fontMetrics().lineSpacing())
        self.state.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.target = QComboBox(editable=True)
        self.target.addItems(TARGETS)
        self.target.setToolTip("auto recognises it; else as ncdc calibrate --target has it, as in "
                               "chessboard:9x6 (inner corners). A change begins anew.")
        self.target.textActivated.connect(lambda _: self.begin())
        self.covered = QProgressBar(maximum=100, format="%p % of the frame")
        self.gain = QProgressBar(maximum=100, format="-")
        self.gain.setToolTip("Part of the map's uncertainty that a picture of the present pose "
                             "would take off")
        self.uncertainty = PlainLabel("-")
        form = QFormLayout()
        for text, widget in (("&Target", self.target), ("Covered", self.covered),
                             ("This pose helps", self.gain), ("Uncertainty", self.uncertainty)):
            form.addRow(text, widget)
        column = QVBoxLayout(self)
        column.addWidget(self.view, 1)
        column.addLayout(form)
        column.addWidget(self.state)
        column.addWidget(self._buttons())
        self.live.looked.connect(self._looked)
        self.live.failed.connect(self._failed)
        self.live.ready.connect(self.frame_wanted)
        self.resize(QSize(*_SIZE).boundedTo(self.screen().availableSize()))

    def _buttons(self):
        box = QDialogButtonBox()
        self.go_on = box.addButton("Go on with these pictures …",
                                   QDialogButtonBox.ButtonRole.AcceptRole)
        self.again = box.addButton("Begin anew", QDialogButtonBox.ButtonRole.ResetRole)
        box.addButton(QDialogButtonBox.StandardButton.Cancel)
        self.go_on.setEnabled(False)
        self.go_on.clicked.connect(self._finish)
        self.again.clicked.connect(self.begin)
        box.rejected.connect(self.reject)
        return box

    def begin(self):
        """Begin, without pictures."""
        self.live.end()
        self.go_on.setEnabled(False)
        self.live.start(self.target.currentText().strip())

    def show_frame(self, pixels, seconds, picture):
        """Look at a frame if there is time: ``pixels`` as of the sensor, uint8 (h, w) or
        (h, w, 3), and the RGB ``picture`` to paint."""
        if not self.live.offer(pixels, seconds):
            return
        height, width = picture.shape[:2]
        self._pixels = pixels
        # The copy is Qt's own: the picture's memory is gone after this.
        self._image = QImage(picture.tobytes(), width, height, 3 * width,
                             QImage.Format.Format_RGB888).copy()
        if self.view.image is None:
            self.view.show_frame(self._image)

    @property
    def pixels(self):
        """The last frame that was looked at."""
        return self._pixels

    def source_ended(self, reason):
        """There are no more frames; ``reason``: a sentence, or empty at the end of a film."""
        if self.live.running:
            self.live.end()
            self.again.setEnabled(False)
            self.state.setText(reason or "The film has ended. " + self.state.text())

    def trouble(self, text):
        """Something that was asked of the device did not work."""
        self.state.setText(text)

    def _looked(self, about):
        state = about["state"]
        self.view.show_frame(self._image, about)
        self.covered.setValue(round(100 * state["covered"]))
        gain = state["gain"]
        self.gain.setValue(0 if gain is None else round(100 * gain))
        self.gain.setFormat("-" if gain is None else "%p %")
        if state["uncertainty_px"] is not None:
            self.uncertainty.setText(f"{state['uncertainty_px']:.3f} px rms, by "
                                     f"{state['pictures']} pictures")
        self.go_on.setEnabled(state["pictures"] > 0)
        if state["done"]:
            self.live.end()
            self.state.setText(f"Complete: {state['pictures']} pictures cover the frame, and no "
                               f"further one would help much.")
            self.go_on.setDefault(True)
            return
        text = _SEEN[state["seen"]].format(**state)
        if state["wish"] is not None:
            text += (f"\nWanted: the target at the {state['wish']['text']}; that takes "
                     f"{100 * state['wish']['gain']:.0f} % of the uncertainty off.")
        self.state.setText(text)

    def _failed(self, text):
        self.state.setText(f"It did not work: {text}")

    def _finish(self):
        self.live.end()
        self.complete.emit()
        self.accept()

    def reject(self):
        self.live.end()
        super().reject()
