"""One device: its picture, its settings, its lenses, and what there is to say about it."""

import re
from dataclasses import replace

from PySide6.QtCore import QPoint, QTimer, Signal

from ncdc_host.client.device import Rate
from ncdc_host.client.view_state import CORRECTION
from ncdc_host.gui.lens_loader import LensLoader
from ncdc_host.gui.picture_files import PictureFiles
from ncdc_host.gui.plain_text import plain_tip
from ncdc_host.gui.session import Session
from ncdc_host.gui.tab_widgets import TabWidgets
from ncdc_host.gui.view_steering import ViewSteering

__all__ = ["DeviceTab"]

_COMPARING = ("side by side", "wipe")
_TIMEOUT = 3.0          # seconds plus three frames without a picture before a message
_SETTLE = 400           # ms after the last change of a setting until the raw frame is taken anew
_URL = re.compile(r"\b[a-z]+://[^\s,;]*[\w\]/]")       # of a device, in a message
# What the raw frame of a comparison depends on.
_RAW = ("ExposureTime", "Gain", "TestPattern", "ReverseX", "ReverseY")


class DeviceTab(TabWidgets):
    """Shows a :class:`Session`; asks the window for another transport or a closed tab.

    Signals
    -------
    titled(text, tip, state)
        For the tab; state is "open", "watching", "waiting" or "trouble".
    wants(url, monitor)
        Open this URL instead.
    said(text)
        For the status line.
    enabled()
        The result of :meth:`can` may have changed.
    pictured(Shown)
        A picture came.

    Attributes
    ----------
    loader : LensLoader
    files : PictureFiles
    steering : ViewSteering
    """
    titled, wants, said = Signal(str, str, str), Signal(str, bool), Signal(str)
    enabled, pictured = Signal(), Signal(object)

    def __init__(self, url, name="", monitor=False):
        super().__init__()
        self.url, self.name = url, name or url.partition("://")[2]
        self.session = Session(url, monitor)
        self.shown = self.infos = self._corrected = None
        self.mode, self.frozen, self.access, self._state = "after", False, "", ""
        self.loader, self.files = LensLoader(self), PictureFiles(self)
        self.steering, self._counts = ViewSteering(self), None
        self._connect_session()
        self._connect_widgets()
        self._settle = QTimer(self, singleShot=True, interval=_SETTLE)
        self._settle.timeout.connect(self.take_again)
        self._silence = QTimer(self, singleShot=True)
        self._silence.timeout.connect(self._no_picture_came)
        self._rest = QTimer(self, singleShot=True, interval=round(1000 * Rate.SECONDS))
        self._rest.timeout.connect(self._show_no_rate)
        self._wait(f"Connecting to {self.name} …")
        self._enable()
        self.session.start()

    def _connect_session(self):
        s = self.session
        for signal, slot in (
                (s.opened, self._opened), (s.failed, self._failed), (s.lost, self._lost),
                (s.features, self._features), (s.written, self.settings.written),
                (s.rejected, self._rejected), (s.busy, self._busy),
                (s.picture, self._picture), (s.no_pictures, self._no_pictures),
                (s.still, self._still), (s.counted, self._counted)):
            signal.connect(slot)

    def _connect_widgets(self):
        self.settings.changed.connect(self.set_feature)
        self.settings.window_changed.connect(self.session.set_window)
        self.lenses.chosen.connect(lambda number: self.set_feature("LensSelector", number))
        self.bar.mode_chosen.connect(self.set_mode)
        self.bar.again.clicked.connect(self.take_again)
        self.bar.freeze.clicked.connect(self.freeze)
        for button, act in ((self.bar.zoom_in, self.view.zoom_in),
                            (self.bar.zoom_out, self.view.zoom_out), (self.bar.fit, self.view.fit),
                            (self.bar.whole, lambda: self.view.set_scale(1))):
            button.clicked.connect(lambda _=False, act=act: act())
        self.view.scaled.connect(self.bar.show_scale)
        self.view.pointed.connect(self._pointed)

    # States.

    def _become(self, state):
        self._state = state
        self.titled.emit(self.name, self.url, state)
        self._enable()

    def _enable(self):
        ours = self.infos is not None and CORRECTION in self.infos
        control = self._state == "open"
        self.settings.setEnabled(control)
        self.histogram.setEnabled(self.shown is not None)
        self.lenses.setEnabled(control and ours)
        for mode, button in self.bar.modes.items():
            button.setEnabled(mode == self.mode or control and ours)
        for button in (self.bar.save, self.bar.freeze):
            button.setEnabled(self.shown is not None)
        self.bar.show_mode(self.mode, self.mode in _COMPARING and control)
        self.steering.enable(control)
        self.enabled.emit()

    def can(self, action):
        """Whether an action makes sense now: the name of a mode, or of a method of this class, as
        "loader.ask"."""
        if action in self.bar.modes:
            return self.bar.modes[action].isEnabled()
        if action in ("loader.ask", "loader.calibrate", "loader.calibrate_live"):
            return self.lenses.isEnabled()
        if action == "steering.show":
            return self._state == "open" and self.steering.several
        if action.startswith("steering."):
            return self._state == "open" and self.steering.possible
        if action == "take_again":
            return not self.bar.again.isHidden()
        if action == "files.ask_raw":
            return self._state == "open" and CORRECTION in (self.infos or {})
        if action in ("files.ask_picture", "files.copy", "freeze"):
            return self.shown is not None
        return self.view.has_picture

    def _wait(self, text, shade=False):
        self.view.set_text(text, shade)

    def _opened(self, access):
        self.access = access
        self.messages.clear()
        self._wait("Waiting for the first picture …")
        self._become("watching" if access == "monitor" else "open")
        if access == "monitor":
            self.messages.show_message("You watch only: another user has control, and settings "
                                       "cannot be changed.", "info", self._other_ways(False),
                                       lasting=True)
        self._listen()

    def _failed(self, reason, text):
        self.access = ""
        self._show_no_rate()
        self._become("trouble")
        if reason == "held":
            self._wait("Another user has control of this device.")
            self.messages.show_message(
                "Another user has control. You can watch as well, or try again when they "
                "have left.", "warning", self._other_ways(True), lasting=True)
            self.messages.setToolTip(plain_tip(text))
        else:
            self._wait("No picture: the device could not be opened.")
            self.messages.show_message(self._sentence(text), "error",
                                       [("Try again", self.try_again)], lasting=True)

    def _other_ways(self, watch):
        ways = [("Watch only", self.watch)] if watch else []
        ways.append(("Try again", self.try_again) if watch
                    else ("Take control", self.take_control))
        if not self.url.startswith("tcp:"):
            ways.append(("Open over TCP", self.open_over_tcp))
        return ways

    def _lost(self, text):
        self.access = ""
        self._silence.stop()
        self._show_no_rate()
        self._become("waiting")
        self._wait("The device does not answer any more.\nIt is tried again every two seconds.",
                   shade=True)
        self.messages.show_message(self._sentence(text), "warning", lasting=True)

    def try_again(self):
        """Open the device as before."""
        self.messages.clear()
        self._wait(f"Connecting to {self.name} …")
        self.session.open()

    def watch(self):
        """Open it to watch only."""
        self.messages.clear()
        self._wait(f"Connecting to {self.name} …")
        self.session.open(monitor=True)

    def take_control(self):
        """Open it anew, with control if that is free."""
        self.wants.emit(self.url, False)

    def open_over_tcp(self):
        """Open the same device by Table I, where all users are equal."""
        self.wants.emit("tcp://" + self.url.partition("://")[2], False)

    def _no_pictures(self, text):
        self._silence.stop()
        self._show_no_rate()
        self._wait("No pictures to watch: the user who has control does not send them to a group."
                   if self.access == "monitor" else self._sentence(text))

    def _rejected(self, text):
        self.messages.show_message(self._sentence(text), "warning")
        if self.loader.dialog is not None:
            self.loader.dialog.trouble(self._sentence(text))

    def _sentence(self, text):
        """A message of the device or of the way to it, with its name instead of its URL."""
        text = _URL.sub(lambda _: self.name, text)
        if not text.startswith(self.name):
            text = text[:1].upper() + text[1:]
        return text + ("" if text.endswith(".") else ".")

    def _busy(self, text):
        if text:
            self.messages.show_message(text, "info")
        else:
            self.messages.clear()

    # Pictures.

    def _listen(self):
        rate = self.infos.get("AcquisitionFrameRate") if self.infos else None
        self._silence.start(int(1000 * (_TIMEOUT + (3 / rate.value if rate else 0))))

    def _no_picture_came(self):
        reason = self._sentence(self.session.trouble) if self.session.trouble else (
            "If the device goes on to answer, a firewall may keep the pictures away, or packets "
            "are too large for the network.")
        self._wait(f"No picture comes.\n{reason}", shade=self.shown is not None)

    def _picture(self):
        shown = self.session.take()
        if shown is None:
            return
        self._listen()
        self._rest.start()
        self.pictured.emit(shown)
        if self.frozen:
            return
        first, self.shown = self.shown is None, shown
        if self.view.text or self.view.shade:
            self._wait("")
        self.view.show_live(shown.image)
        self.histogram.show_counts(shown.histogram)
        frame = shown.frame
        width, height = shown.image.width(), shown.image.height()
        self.foot.setText(f"{width} × {height}  ·  {frame.pixel_format.name}  ·  picture "
                          f"{frame.number}  ·  {frame.time_ns / 1e9:.3f} s")
        if first:
            self._enable()

    def _pointed(self, pixel, colour):
        self.pixel.setText("" if pixel == QPoint(-1, -1) else
                           f"({pixel.x()}, {pixel.y()})  RGB {colour}")

    def freeze(self, on=None):
        """Keep the picture on the screen, or go on; None: the other one."""
        self.frozen = not self.frozen if on is None else on
        self.bar.freeze.setChecked(self.frozen)

    def set_mode(self, mode):
        """Show "before", "after", "side by side" or "wipe"."""
        if not self.bar.modes[mode].isEnabled():
            return
        self.session.show_corrected(mode != "before")
        self._corrected = mode != "before"
        self._show_mode(mode)
        if mode in _COMPARING:
            self.take_again()

    def _show_mode(self, mode):
        self.mode = mode
        self.view.set_mode(mode)
        self._enable()

    def take_again(self):
        """Take another raw frame to compare with."""
        if self.mode in _COMPARING:
            self.session.take_still("compare")

    def _still(self, still):
        if still.purpose == "compare":
            self.view.show_still(still.shown.image)
        elif still.purpose == "save":
            self.files.raw_taken(still)
        elif still.purpose == "calibrate":
            self.loader.open_dialog(still)

    # Settings.

    def set_feature(self, name, value):
        """Change a feature, as the panel does; returns the change's serial number."""
        serial = self.session.set(name, value)
        self.settings.wait_for(name, serial)
        return serial

    def _features(self, infos):
        before, self.infos = self.infos or {}, infos
        self.settings.show_features(infos)
        self.statistics.show_device(infos)
        if "LensSelector" in infos:
            self.lenses.show_lenses(infos["LensMax"].value + 1, infos["LensSelector"].value)
        if CORRECTION in infos:
            corrected = infos[CORRECTION].value
            # Another user may have changed it.
            if CORRECTION not in before or corrected != before[CORRECTION].value:
                if corrected != self._corrected:
                    self._corrected = corrected
                    self._show_mode("after" if corrected else "before")
        if self.mode in _COMPARING and any(
                name in before and infos[name].value != before[name].value for name in _RAW):
            self._settle.start()
        self._enable()

    def _show_no_rate(self):
        """Show the end of the stream: counters stay, the rate is cleared."""
        self._rest.stop()
        if self._counts is not None:
            self._counted(replace(self._counts, rate=0.0))

    def _counted(self, statistics):
        self._counts = statistics
        frame = self.shown and self.shown.frame
        size = frame.pixels.shape[0] * frame.pixels.shape[1] * frame.pixel_format.pixel_bytes \
            if frame else 0
        self.statistics.show_counts(statistics, size)
        self.rate.setText(f"{statistics.rate:.1f} pictures/s  ·  {statistics.lost} lost")
