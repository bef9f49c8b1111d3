"""Runs :mod:`ncdc_host.gui.calibration_job` and reports its progress by signals."""

import tempfile
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from ncdc_host.gui.job_process import JobProcess
from ncdc_spec.interpolation import DEFAULT

__all__ = ["Calibration"]


class Calibration(QObject):
    """One run, from photos to a lens file in a folder that goes with this object.

    Signals
    -------
    step(text), progress(share, mse)
    points_found(count, target, overlay)
        The overlay is a picture file.
    done(lens, report)
        Path of the descriptor, and its figures.
    failed(sentence)

    Attributes
    ----------
    photos : list of path
        By default :attr:`photo`.
    previous : path or None
        Earlier calibration, with which the lens of the points is compared.
    """
    step, progress = Signal(str), Signal(float, float)
    points_found, done = Signal(int, str, str), Signal(str, dict)
    failed = Signal(str)

    def __init__(self, parent=None):
        super().__init__(parent)
        self._folder = tempfile.TemporaryDirectory(prefix="ncdc-calibration-")
        self._error, self._result = "", None
        self._process = JobProcess("ncdc_host.gui.calibration_job", self)
        self._process.said.connect(self._understand)
        self._process.ended.connect(self._ended)
        self._process.failed.connect(self.failed)
        self.photos, self.previous = [self.photo], None

    @property
    def photo(self):
        """Path to which a raw frame may be written before :meth:`start`."""
        return Path(self._folder.name) / "photo.raw.png"

    @property
    def running(self):
        """Whether the process runs."""
        return self._process.running

    def start(self, target, neurons, bayer, size=None, fill=(0, 0, 0), nodes="auto",
              interpolation=DEFAULT.name):
        """Begin; the names are those of ``ncdc calibrate`` and ``ncdc train``."""
        arguments = [*self.photos, self._folder.name, f"--target={target}", "--neurons", neurons,
                     "--bayer", bayer, "--fill", *fill, "--nodes", nodes,
                     "--interpolation", interpolation]
        if size is not None:
            arguments += ["--size", *size]
        if self.previous is not None:
            arguments += ["--previous", self.previous]
        self._error, self._result = "", None
        self._process.start(arguments)

    def cancel(self):
        """End the process, if it runs; nothing is signalled any more."""
        self._process.cancel()

    def _understand(self, about):
        if "step" in about:
            self.step.emit(about["step"])
        elif "share" in about:
            self.progress.emit(about["share"], about["mse"])
        elif "points" in about:
            self.points_found.emit(about["points"], about["target"], about["overlay"])
        elif "lens" in about:
            self._result = about["lens"], about["report"]
        elif "error" in about:
            self._error = about["error"]

    def _ended(self, status, last):
        if self._result is not None and status == 0:
            self.done.emit(*self._result)
        else:
            self.failed.emit(self._error or f"the calibration ended unexpectedly: {last}")
