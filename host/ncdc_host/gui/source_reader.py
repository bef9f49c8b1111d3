"""Frames of a camera of the PC or of a film for the window, read in a thread."""

import threading

from PySide6.QtCore import QObject, Signal

from ncdc_host.client.errors import DeviceError
from ncdc_host.sources import frames_of
from ncdc_spec.errors import InputError

__all__ = ["SourceReader"]

_WAIT = 0.5             # seconds after which the thread looks whether it is to end


class SourceReader(QObject):
    """Reads a frame of the source ``name`` each time it is asked for one.

    Signals
    -------
    frame(object, float)
        Pixels, uint8 (h, w) or (h, w, 3) RGB, and their time in seconds.
    ended(sentence)
        There are no more; the sentence says why, and is empty at the end of a film.
    """
    frame, ended = Signal(object, float), Signal(str)

    def __init__(self, name, parent=None):
        super().__init__(parent)
        self.name = name
        self._wanted, self._stopped = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self):
        """Open the source, after the signals are connected."""
        self._thread.start()

    def ask(self):
        """Have the next frame read."""
        self._wanted.set()

    def stop(self):
        """Close the source; waits for a frame that is being read, two seconds at most."""
        self._stopped.set()
        self._wanted.set()
        if self._thread.is_alive():
            self._thread.join(4 * _WAIT)

    def _run(self):
        reason = ""
        try:
            with frames_of(self.name) as frames:
                while not self._stopped.is_set():
                    if not self._wanted.wait(_WAIT) or self._stopped.is_set():
                        continue
                    self._wanted.clear()
                    found = next(frames, None)
                    if found is None:
                        break
                    self.frame.emit(*found)
        except (DeviceError, InputError, ModuleNotFoundError) as error:
            reason = str(error)
        if not self._stopped.is_set():
            self.ended.emit(reason)
