"""Receives the pictures of a stream in a thread, and keeps the newest for whoever paints."""

import threading
import time

from ncdc_host.client import DeviceError, NoFrame
from ncdc_host.gui.shown import Shown

__all__ = ["Receiver"]

_COUNT = 0.25           # seconds between two looks at the statistics
_WAIT = 0.5             # seconds after which the thread looks whether it is to end


class Receiver:
    """Takes every frame of ``stream``; makes one ready to be painted only if the last was taken.

    So a slow screen costs pictures on the screen, but never memory, and none in the statistics.

    Parameters
    ----------
    stream : FrameStream
        Closed by :meth:`end`.
    arrived : callable
        Called, in the thread, when :meth:`take` has a new picture.
    failed : callable
        Called once, in the thread, with the :class:`DeviceError` that ends it.

    Attributes
    ----------
    statistics : Statistics
        Counters of the stream, a quarter of a second old at most.
    """
    def __init__(self, stream, arrived, failed):
        self._stream, self._arrived, self._failed = stream, arrived, failed
        self._lock, self._shown = threading.Lock(), None
        # A stream may not be asked in one thread while another one waits for its next picture.
        self.statistics, self._counted = stream.statistics, 0.0
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    @property
    def trouble(self):
        """A sentence on the last picture if it was malformed, else empty."""
        return self._stream.trouble

    def start(self):
        """Begin to receive; the callback must be able to take pictures from this object."""
        self._thread.start()

    def take(self):
        """The newest :class:`Shown`, or None if there is none that was not taken already."""
        with self._lock:
            shown, self._shown = self._shown, None
            return shown

    def end(self):
        """End the stream; waits for a call that is under way, half a second at most."""
        self._end.set()
        self._thread.join(2 * _WAIT)
        self.statistics = self._stream.statistics
        self._stream.close()

    def _next(self):
        try:
            return self._stream.next(_WAIT)
        finally:
            if time.monotonic() - self._counted > _COUNT:
                self._counted, self.statistics = time.monotonic(), self._stream.statistics

    def _run(self):
        while not self._end.is_set():
            try:
                frame = self._next()
            except NoFrame:
                continue
            except DeviceError as error:
                if not self._end.is_set():
                    self._failed(error)
                return
            with self._lock:
                busy = self._shown is not None
            if busy:
                continue
            shown = Shown.of(frame)
            with self._lock:
                self._shown = shown
            if not self._end.is_set():
                self._arrived()
