"""Looks for devices in a thread, again and again."""

import threading

from PySide6.QtCore import QObject, Signal

from ncdc_host.client import DeviceError, discover

__all__ = ["Discovery"]

_PAUSE = 4.0            # seconds between two broadcasts


class Discovery(QObject):
    """Signals ``found(list of Found)`` after every broadcast, or ``failed(sentence)``.

    Parameters
    ----------
    pause : float
        Seconds between two broadcasts.
    """
    found, failed, looking = Signal(object), Signal(str), Signal()

    def __init__(self, pause=_PAUSE):
        super().__init__()
        self._pause = pause
        self._now, self._end = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self):
        """Begin."""
        self._thread.start()

    def again(self):
        """Look at once."""
        self._now.set()

    def close(self):
        """End, with the broadcast that is under way."""
        self._end.set()
        self._now.set()

    def wait(self, seconds):
        """Wait until it has ended: for the program's end only."""
        if self._thread.is_alive():
            self._thread.join(seconds)

    def _run(self):
        while not self._end.is_set():
            self._now.clear()
            self.looking.emit()
            try:
                found = discover()
            except DeviceError as error:
                self.failed.emit(str(error))
            else:
                self.found.emit(found)
            self._now.wait(self._pause)
