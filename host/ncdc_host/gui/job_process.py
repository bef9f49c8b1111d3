"""A process of this Python that works for the window, and answers in lines of JSON."""

import json
import sys

from PySide6.QtCore import QObject, QProcess, Signal

__all__ = ["JobProcess"]


class JobProcess(QObject):
    """Runs a module; a job can be ended at once, and does not block the window.

    A job may be started again when it has ended.

    Signals
    -------
    said(object)
        One line of its output, a dict.
    ended(status, sentence)
        Exit status, and the last line of its standard error, or a text on the status.
    failed(sentence)
        It could not be started.
    """
    said, ended, failed = Signal(object), Signal(int, str), Signal(str)

    def __init__(self, module, parent=None):
        super().__init__(parent)
        self._module, self._process, self._rest = module, None, b""

    @property
    def running(self):
        """Whether the process runs."""
        return self._process is not None

    def start(self, arguments):
        """Run the module with ``arguments``, which become texts."""
        self._rest = b""
        self._process = QProcess(self)
        self._process.setProgram(sys.executable)
        if sys.platform.startswith("linux"):
            # Without a copy of this process's page tables, which takes tens of milliseconds.
            self._process.setUnixProcessParameters(QProcess.UnixProcessFlag.UseVFork)
        self._process.setArguments(["-m", self._module, *map(str, arguments)])
        self._process.readyReadStandardOutput.connect(self._read)
        self._process.errorOccurred.connect(self._not_started)
        self._process.finished.connect(self._finished)
        self._process.start()

    def write(self, content):
        """Send bytes to its standard input."""
        self._process.write(content)

    def cancel(self):
        """End the process, if it runs; nothing is signalled any more."""
        process, self._process = self._process, None
        if process is not None:
            for signal in (process.readyReadStandardOutput, process.errorOccurred,
                           process.finished):
                signal.disconnect()
            process.kill()
            process.finished.connect(process.deleteLater)

    def _read(self):
        *lines, self._rest = (self._rest
                              + bytes(self._process.readAllStandardOutput())).split(b"\n")
        for line in lines:
            if self._process is not None:       # an answer may lead to its end
                self.said.emit(json.loads(line))

    def _not_started(self, error):
        if error == QProcess.ProcessError.FailedToStart:
            self._process = None
            self.failed.emit(f"{sys.executable} cannot be run")

    def _finished(self, status, how):
        self._read()
        if self._process is None:
            return
        said = bytes(self._process.readAllStandardError()).decode(errors="replace").strip()
        self._process.deleteLater()
        self._process = None
        self.ended.emit(status, said.splitlines()[-1] if said else f"exit status {status}")
