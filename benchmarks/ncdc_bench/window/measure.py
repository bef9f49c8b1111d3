"""Uses the window as a person does, without a screen, and times every event of Qt's thread."""

import os
import subprocess
import sys
import time
from dataclasses import dataclass, field

__all__ = ["Stopwatch", "measure"]

LIMIT_MS = 50.0         # an event that takes longer is felt
_SIZE = 1360, 880
_LAID_OUT = 10          # looks at events, after which a text that has changed has its space


@dataclass
class Stopwatch:
    """Times of events: wall time, and processor time of the thread, milliseconds."""
    wall: list = field(default_factory=list)
    cpu: list = field(default_factory=list)
    slowest: str = ""       # by processor time: the wall's is whatever else the machine did
    _max_cpu: float = 0.0

    def add(self, wall, cpu, name):
        """Count an event."""
        if cpu > self._max_cpu:
            self._max_cpu, self.slowest = cpu, name
        self.wall.append(wall)
        self.cpu.append(cpu)

    def row(self, what):
        """A row of the report."""
        return {"window": what, "events": len(self.wall), "slowest_event": self.slowest,
                "event_max_ms": round(max(self.wall), 2),
                "event_cpu_max_ms": round(max(self.cpu), 2),
                "events_over_50_ms": sum(value > LIMIT_MS for value in self.wall),
                "events_over_50_ms_cpu": sum(value > LIMIT_MS for value in self.cpu)}


def _application(watch):
    """A QApplication that adds what each event takes to ``watch[0]``."""
    from PySide6.QtWidgets import QApplication

    class Timed(QApplication):
        def notify(self, receiver, event):
            wall, cpu = time.perf_counter(), time.thread_time()
            try:
                return super().notify(receiver, event)
            finally:
                watch[0].add(1000 * (time.perf_counter() - wall),
                             1000 * (time.thread_time() - cpu),
                             f"{type(receiver).__name__} {event.type().name}")
    return Timed(["ncdc"])


class _User:
    """A simulated user of the window; each step is timed by a stopwatch of its own."""

    def __init__(self, application, window, watch, folder):
        self._application, self._window, self._watch = application, window, watch
        self._folder, self.rows = folder, []

    def until(self, condition, seconds=120):
        """Serve events until ``condition()``."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError("the window does not come to an end")
            self._application.processEvents()
            time.sleep(0.002)

    def step(self, what, seconds, act=lambda: None, picture=None):
        """Do something, go on for ``seconds``, note what events took."""
        self._watch[0] = Stopwatch()
        end = time.monotonic() + seconds
        act()
        self.until(lambda: time.monotonic() > end)
        self.rows.append(self._watch[0].row(what))
        if picture and self._folder:
            for _ in range(_LAID_OUT):
                self._application.processEvents()
            widget = picture() if callable(picture) else self._window
            name = what.replace(" ", "-")
            widget.grab().save(str(self._folder / f"window-{name}.png"))


def measure(urls, folder=None, seconds=4.0, step=lambda text: None):
    """Rows of what events take while two devices show pictures, and what is done meanwhile.

    Parameters
    ----------
    urls : (str, str)
        Devices; the second one sees a calibration target.
    folder : Path, optional
        For screenshots.
    seconds : float
        Duration of each step.
    """
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PySide6.QtCore import QSettings

    from ncdc_host.gui.application import settle
    from ncdc_host.gui.discovery import Discovery
    from ncdc_host.gui.main_window import MainWindow
    watch = [Stopwatch()]
    application = _application(watch)
    application.setApplicationName("ncdc-bench")
    QSettings().clear()
    window = MainWindow(Discovery())
    window.resize(*_SIZE)
    window.show()
    settle()
    user = _User(application, window, watch, folder)
    user.step("empty", 1.0, picture=True)
    tabs = [window.open_device(url, name=name)
            for url, name in zip(urls, ("hall camera", "bench camera"))]
    user.until(lambda: all(tab.shown for tab in tabs))
    window.tabs.setCurrentIndex(0)
    try:
        _use(user, window, tabs, seconds, step)
    finally:
        window.close()
        for tab in tabs:
            user.until(lambda: not tab.session._thread.is_alive())
    return user.rows


def _use(user, window, tabs, seconds, step):
    first, second = tabs
    for mode in ("after", "before", "side by side", "wipe"):
        step(mode)
        user.step(mode, seconds, lambda: first.set_mode(mode), picture=True)
    step("settings")
    user.step("settings", seconds, lambda: _drag(user, first))
    step("resize and zoom")
    user.step("resize and zoom", seconds, lambda: _resize(user, window, first))
    window.resize(*_SIZE)
    first.view.fit()
    step("calibrate")
    window.tabs.setCurrentIndex(1)
    second.loader.calibrate()
    user.until(lambda: second.loader.dialog is not None)
    done = []
    second.loader.dialog.job.done.connect(lambda *_: done.append(True))
    second.loader.dialog.job.failed.connect(done.append)
    user.step("calibration begins", 1.0)
    second.loader.dialog.run()
    loaded = []
    second.session.lens_loaded.connect(lambda *_: loaded.append(True))

    def finish():
        user.until(lambda: done, 600)
        if done[0] is True:
            second.loader.dialog.load.click()
            user.until(lambda: loaded)
    user.step("calibrate", 0, finish, picture=lambda: second.loader.dialog)
    second.loader.dialog.reject()
    user.step("calibrated", 2.0, picture=True)


def _drag(user, tab):
    for tick in range(100, 400, 4):
        tab.settings.gain.slider.setValue(tick)
        user._application.processEvents()
        time.sleep(0.01)
    tab.settings.gain.slider.setValue(0)
    tab.settings.window_changed.emit(0, 0, 320, 240)
    tab.settings.window_changed.emit(0, 0, tab.infos["WidthMax"].value,
                                     tab.infos["HeightMax"].value)


def _resize(user, window, tab):
    for k in range(30):
        window.resize(_SIZE[0] - 8 * k, _SIZE[1] - 4 * k)
        tab.view.zoom(1.1)
        user._application.processEvents()
        time.sleep(0.01)


def serve():
    """The process of two emulated devices, and their URLs; it ends with its standard input."""
    process = subprocess.Popen([sys.executable, "-m", "ncdc_host.gui.demo"],
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    for line in process.stdout:
        word, *rest = line.split()
        if word == "ready":
            return process, rest
    raise RuntimeError("the emulated devices are not there")
