"""Runs :mod:`ncdc_host.gui.calibration_job` and reports its progress by signals."""

import json
import sys
import tempfile
from pathlib import Path

from PySide6.QtCore import QObject, QProcess, Signal

from ncdc_spec.interpolation import DEFAULT

__all__ = ["Calibration"]


class Calibration(QObject):
    """One run, from a raw frame to a lens file in a folder that goes with this object.

    Signals
    -------
    step(text), progress(share, mse)
    points_found(count, target, overlay)
        The overlay is a picture file.
    done(lens, report)
        Path of the descriptor, and its figures.
    failed(sentence)
    """
    step, progress = Signal(str), Signal(float, float)
    points_found, done = Signal(int, str, str), Signal(str, dict)
    failed = Signal(str)

    def __init__(self, parent=None):
        super().__init__(parent)
        self._folder = tempfile.TemporaryDirectory(prefix="ncdc-calibration-")
        self._process, self._error, self._result = None, "", None
        self._rest = b""

    @property
    def photo(self):
        """Path to which the raw frame must be written before :meth:`start`."""
        return Path(self._folder.name) / "photo.raw.png"

    @property
    def running(self):
        """Whether the process runs."""
        return self._process is not None

    def start(self, target, neurons, bayer, size=None, fill=(0, 0, 0), nodes="auto",
              interpolation=DEFAULT.name):
        """Begin; the names are those of ``ncdc calibrate`` and ``ncdc train``."""
        arguments = ["-m", "ncdc_host.gui.calibration_job", self.photo, self._folder.name,
                     f"--target={target}", "--neurons", neurons, "--bayer", bayer,
                     "--fill", *fill, "--nodes", nodes, "--interpolation", interpolation]
        if size is not None:
            arguments += ["--size", *size]
        self._error, self._result, self._rest = "", None, b""
        self._process = QProcess(self)
        self._process.setProgram(sys.executable)
        if sys.platform.startswith("linux"):
            # Without a copy of this process's page tables, which takes tens of milliseconds.
            self._process.setUnixProcessParameters(QProcess.UnixProcessFlag.UseVFork)
        self._process.setArguments([str(argument) for argument in arguments])
        self._process.readyReadStandardOutput.connect(self._read)
        self._process.errorOccurred.connect(self._not_started)
        self._process.finished.connect(self._finished)
        self._process.start()

    def cancel(self):
        """End the process, if it runs; nothing is signalled any more."""
        process, self._process = self._process, None
        if process is not None:
            process.disconnect(self)
            process.kill()
            process.finished.connect(process.deleteLater)

    def _read(self):
        *lines, self._rest = (self._rest
                              + bytes(self._process.readAllStandardOutput())).split(b"\n")
        for line in lines:
            self._understand(json.loads(line))

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

    def _not_started(self, error):
        if error == QProcess.ProcessError.FailedToStart:
            self._process = None
            self.failed.emit(f"{sys.executable} cannot be run")

    def _finished(self, status, how):
        self._read()
        said = bytes(self._process.readAllStandardError()).decode(errors="replace").strip()
        self._process.deleteLater()
        self._process = None
        if self._result is not None and status == 0:
            self.done.emit(*self._result)
        else:
            last = said.splitlines()[-1] if said else f"exit status {status}"
            self.failed.emit(self._error or f"the calibration ended unexpectedly: {last}")
