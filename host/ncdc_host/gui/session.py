"""A tab's work with its device, in a thread that reports by signals and uses no widget."""

import queue
import threading
from contextlib import contextmanager
from dataclasses import astuple, dataclass
from functools import partial

from PySide6.QtCore import QObject, Signal

from ncdc_host.client import DeviceError, DeviceGone, Rejected, Statistics, open_device
from ncdc_host.client.view_state import (
    CORRECTION,
    has_correction,
    read_view,
    show_whole,
    write_view,
)
from ncdc_host.gui.receiver import Receiver
from ncdc_host.gui.shown import Shown
from ncdc_model.images import write_image
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError

__all__ = ["Session", "SHOWN", "Still"]

_POLL = 0.5             # seconds between two looks at what other users have changed
_RETRY = 2.0            # between two tries to reach a device that is gone

# The features that the window shows.
SHOWN = ("WidthMax", "HeightMax", "Width", "Height", "OffsetX", "OffsetY", "PixelFormat",
         "ReverseX", "ReverseY", "TestPattern", "AcquisitionFrameRate", "LineTime",
         "ExposureAuto", "GainAuto", "BalanceWhiteAuto",
         "ExposureTime", "Gain", "CorrectionEnable", "LensSelector", "LensMax", "FramesDropped",
         "FramesTorn", "Pan", "Tilt", "Roll", "Zoom", "ViewFocal", "ViewLayout", "ViewSelector")


@dataclass(frozen=True)
class Still:
    """A whole raw frame that was taken between two pictures of the stream.

    Parameters
    ----------
    shown : Shown
    purpose : str
        Purpose that was given to :meth:`Session.take_still`.
    limits : LensLimits or None
        Requirements on a lens made of it; None if the transport takes no lens.
    reason : str
        Why not.
    """
    shown: Shown
    purpose: str
    limits: object = None
    reason: str = ""


class Session(QObject):
    """A device from :meth:`start` to :meth:`close`, whatever happens to it in between.

    Each method returns at once; a signal reports the result.

    Parameters
    ----------
    url : str
    monitor : bool
        Watch only.

    Signals
    -------
    opened(access), failed(reason, sentence)
        Result of opening; the reason is "held": another user has control, "gone": no answer, or
        "other". After "gone" nothing is tried any more, until :meth:`open`.
    lost(sentence)
        The device does not answer any more; it is tried again until it does, then ``opened``.
    features(dict)
        The :class:`FeatureInfo` of every feature of :data:`SHOWN` that the device has, by name,
        whenever one has changed.
    written(name, serial)
        The :meth:`set` that returned that serial number is done, whether it succeeded or not.
    rejected(sentence)
        Something did not work.
    busy(sentence)
        Something takes long; empty when it is over.
    picture()
        :meth:`take` has a new one.
    no_pictures(sentence)
        There will be none, and why.
    saved(path), still(Still), counted(Statistics), lens_loaded(number, name), closed()
    """
    opened, failed, lost = Signal(str), Signal(str, str), Signal(str)
    features, written = Signal(object), Signal(str, int)
    rejected, saved, busy = Signal(str), Signal(str), Signal(str)
    picture, no_pictures = Signal(), Signal(str)
    still, counted, lens_loaded = Signal(object), Signal(object), Signal(int, str)
    closed = Signal()

    def __init__(self, url, monitor=False):
        super().__init__()
        self.url, self.monitor = url, monitor
        self._device = self._receiver = None
        self._lost, self._view = False, None
        self._features, self._before = {}, Statistics(0, 0, 0, 0, 0.0)
        self._jobs, self._serial = queue.Queue(), 0
        self._wanted, self._lock = {}, threading.Lock()
        self._thread = threading.Thread(target=self._run, daemon=True)

    # Called by widgets.

    def start(self):
        """Begin to open the device, after the signals are connected."""
        self._jobs.put(self._open)
        self._thread.start()

    def open(self, monitor=None):
        """Try again to open the device, perhaps as another kind of user."""
        if monitor is not None:
            self.monitor = monitor
        self._jobs.put(self._open)

    def set(self, name, value):
        """Write a feature; of several values that wait for their turn, only the last is sent."""
        with self._lock:
            self._serial += 1
            waits = name in self._wanted
            self._wanted[name] = self._serial, value
        if not waits:
            self._jobs.put(partial(self._write, name))
        return self._serial

    def set_window(self, x, y, width, height):
        """Make these columns and rows of the whole picture the picture."""
        self._jobs.put(partial(self._set_window, dict(
            OffsetX=x, OffsetY=y, Width=width, Height=height)))

    def show_corrected(self, corrected):
        """Have the device send corrected pictures, or raw frames."""
        self._jobs.put(partial(self._show_corrected, corrected))

    def take_still(self, purpose, mirrored=True):
        """Take a whole raw frame, then go on as before; see :class:`Still`."""
        self._jobs.put(partial(self._take_still, purpose, mirrored))

    def stream_sensor(self, on):
        """Send whole raw frames as the sensor's pixels lie, or again what was sent before."""
        self._jobs.put(partial(self._stream_sensor, on))

    def load_lens(self, path, name, number):
        """Make the descriptor file ``path`` lens ``number`` of the device, and the active one."""
        self._jobs.put(partial(self._load_lens, path, name, number))

    def save(self, path, pixels):
        """Write an image file."""
        self._jobs.put(partial(self._save, path, pixels))

    def take(self):
        """The newest picture that was not taken yet, a :class:`Shown`, or None."""
        receiver = self._receiver
        return None if receiver is None else receiver.take()

    @property
    def trouble(self):
        """A sentence on the last picture if it was malformed, else empty."""
        receiver = self._receiver
        return "" if receiver is None else receiver.trouble

    def close(self):
        """Give control back and end; ``closed`` is emitted then."""
        self._jobs.put(None)

    def wait(self, seconds):
        """Wait until it has ended: for the program's end only."""
        self._thread.join(seconds)

    # The thread.

    def _run(self):
        while True:
            try:
                job = self._jobs.get(timeout=_RETRY if self._lost else _POLL)
            except queue.Empty:
                job = self._open if self._lost else self._poll
            if job is None:
                break
            try:
                job()
            except DeviceGone as error:
                self._lose(error)
            except (DeviceError, InputError) as error:
                self.rejected.emit(str(error))
        self._release()
        self.closed.emit()

    def _open(self):
        if self._device is not None:
            return
        try:
            device = open_device(self.url, self.monitor)
        except DeviceGone as error:
            if not self._lost:
                self.failed.emit("gone", str(error))
            return
        except (DeviceError, InputError) as error:
            self._lost = False
            self.failed.emit("held" if isinstance(error, Rejected) else "other", str(error))
            return
        self._device, self._lost, self._features = device, False, {}
        self._refresh()
        self.opened.emit(device.access)
        self._start()

    def _lose(self, error):
        if self._device is None:
            return
        self._lost = True
        self.lost.emit(str(error))
        self._release()         # which waits for the timeout: the device does not answer

    def _release(self):
        device, self._device = self._device, None
        if device is None:
            return
        for end in (self._stop, device.close):
            try:
                end()
            except DeviceError:
                pass        # the device is gone, and what there was to end with it

    def _poll(self):
        if self._device is None:
            return
        if self._device.access == "lost":
            raise DeviceGone(f"{self.url} does not answer any more, or has taken control away")
        self._refresh()
        if self._receiver is not None:
            self.counted.emit(_sum(self._before, self._receiver.statistics))

    def _refresh(self):
        names = set(self._device.names())
        found = {name: self._device.info(name) for name in SHOWN if name in names}
        if found != self._features:
            self._features = found
            self.features.emit(found)

    # Pictures.

    def _start(self):
        try:
            stream = self._device.stream()
        except DeviceGone:
            raise
        except DeviceError as error:
            self.no_pictures.emit(str(error))
            return
        self._receiver = Receiver(stream, self.picture.emit, self._stream_failed)
        self._receiver.start()

    def _stop(self):
        receiver, self._receiver = self._receiver, None
        if receiver is not None:
            receiver.end()
            self._before = _sum(self._before, receiver.statistics)

    def _stream_failed(self, error):
        def end():
            if isinstance(error, DeviceGone):
                raise error
            self._stop()
            self.no_pictures.emit(str(error))
        self._jobs.put(end)

    @contextmanager
    def _paused(self):
        """Without a stream: what is locked while pictures stream can be set."""
        streamed = self._receiver is not None
        self._stop()
        try:
            yield
        finally:
            if streamed and self._device is not None:
                self._start()

    # Settings.

    def _write(self, name):
        with self._lock:
            serial, value = self._wanted.pop(name)
        try:
            if self._device is not None:
                with self._unlocked(name):
                    self._device.set(name, value)
        finally:
            if self._device is not None:
                # Sent even if nothing changed: the window may show a value that was rejected.
                self._features = {}
                self._refresh()
            self.written.emit(name, serial)

    @contextmanager
    def _unlocked(self, name):
        locked = not self._device.info(name).writable and self._device.access == "control"
        if locked and self._receiver is not None:
            with self._paused():
                yield
        else:
            yield

    def _set_window(self, window):
        if self._device is None:
            return
        try:
            with self._unlocked("Width"):
                write_view(self._device, read_view(self._device) | window)
        finally:
            self._refresh()

    def _show_corrected(self, corrected):
        if self._device is None or self._device.get(CORRECTION) == corrected:
            return
        with self._unlocked(CORRECTION):
            self._device.set(CORRECTION, corrected)
        self._refresh()

    def _take_still(self, purpose, mirrored):
        if self._device is None:
            raise DeviceError(f"{self.url} is not open: it sends no raw frame")
        if not has_correction(self._device):
            raise DeviceError(f"{self.url} sends no raw frames")
        view = read_view(self._device)
        seconds = 5 + 2 / max(0.1, self._device.get("AcquisitionFrameRate"))
        with self._paused():
            try:
                show_whole(self._device, False, mirrored)
                with self._device.stream() as frames:
                    frame = frames.next(seconds)
            finally:
                write_view(self._device, view)
        try:
            limits, reason = self._device.lens_limits(), ""
        except DeviceGone:
            raise
        except DeviceError as error:
            limits, reason = None, str(error)
        self.still.emit(Still(Shown.of(frame), purpose, limits, reason))

    def _stream_sensor(self, on):
        if self._device is None or on == (self._view is not None):
            return
        if not has_correction(self._device):
            raise DeviceError(f"{self.url} sends no raw frames")
        with self._paused():
            if on:
                self._view = read_view(self._device)
                show_whole(self._device, False, mirrored=False)
            else:
                view, self._view = self._view, None
                write_view(self._device, view)
        self._refresh()

    def _load_lens(self, path, name, number):
        if self._device is None:
            raise DeviceError(f"{self.url} is not open: {name} is not loaded")
        descriptor = Descriptor.load(path)
        self.busy.emit(f"Loading {name} into lens {number} …")
        try:
            self._device.set("LensSelector", number)
            self._device.load_lens(descriptor)
        finally:
            self.busy.emit("")
            self._refresh()
        self.lens_loaded.emit(number, name)

    def _save(self, path, pixels):
        write_image(path, pixels)
        self.saved.emit(str(path))


def _sum(before, now):
    """Both counted, with the rate of ``now``."""
    *counts, _ = (a + b for a, b in zip(astuple(before), astuple(now)))
    return Statistics(*counts, now.rate)
