"""Runs :mod:`ncdc_host.gui.live_job`: frames in, states out as signals."""

import json
import tempfile

import numpy as np
from PySide6.QtCore import QObject, Signal

from ncdc_host.gui.job_process import JobProcess

__all__ = ["LiveCalibration"]


class LiveCalibration(QObject):
    """Chooses pictures of a calibration; they lie in a folder that goes with this object.

    Signals
    -------
    ready()
        It can take a frame; see :meth:`offer`.
    looked(object)
        Answer to a frame, a dict as of the job.
    failed(sentence)

    Attributes
    ----------
    pictures : list of str
        Paths of the pictures taken.
    """
    ready, looked, failed = Signal(), Signal(object), Signal(str)

    def __init__(self, parent=None):
        super().__init__(parent)
        self._folder, self._busy, self._error = None, False, ""
        self.pictures = []
        self._process = JobProcess("ncdc_host.gui.live_job", self)
        self._process.said.connect(self._understand)
        self._process.ended.connect(self._ended)
        self._process.failed.connect(self.failed)

    @property
    def running(self):
        """Whether frames are looked at."""
        return self._process.running

    @property
    def waits(self):
        """Whether it can take a frame now."""
        return self.running and not self._busy

    def start(self, target):
        """Begin anew, without pictures; ``target`` as of ``ncdc calibrate``."""
        self._folder = tempfile.TemporaryDirectory(prefix="ncdc-live-")
        self.pictures, self._busy, self._error = [], False, ""
        self._process.start([self._folder.name, f"--target={target}"])
        self.ready.emit()

    def offer(self, pixels, seconds):
        """Send a frame, uint8 (h, w) or (h, w, 3), unless one is looked at; whether it was sent."""
        if not self.waits:
            return False
        self._busy = True
        head = json.dumps({"shape": pixels.shape, "seconds": seconds}).encode()
        self._process.write(head + b"\n" + np.ascontiguousarray(pixels).tobytes())
        return True

    def end(self):
        """Look at no more frames; the pictures stay."""
        self._process.cancel()

    def _understand(self, about):
        if "error" in about:
            self._error = about["error"]
            return
        self._busy = False
        if about["picture"]:
            self.pictures.append(about["picture"])
        self.looked.emit(about)
        if self.waits:
            self.ready.emit()

    def _ended(self, status, last):
        self.failed.emit(self._error or f"the calibration ended unexpectedly: {last}")
