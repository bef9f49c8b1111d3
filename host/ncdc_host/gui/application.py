"""Starts Qt and the window, and the emulated devices of a demonstration."""

import ctypes.util
import gc
import os
import signal
import sys
from html import escape

from PySide6.QtCore import QProcess, QTimer
from PySide6.QtWidgets import QApplication

from ncdc_host.gui.discovery import Discovery
from ncdc_host.gui.main_window import MainWindow
from ncdc_spec.errors import InputError

__all__ = ["Demo", "check_screen", "run", "settle"]


def settle():
    """Keep garbage collection short: what is imported stays, and is not looked through again."""
    gc.collect()
    gc.freeze()


def check_screen(environment=os.environ, platform=sys.platform,
                 find_library=ctypes.util.find_library):
    """Raise :class:`InputError` where Qt would abort: no screen, or a library of X11 missing."""
    if not platform.startswith("linux") or environment.get("QT_QPA_PLATFORM"):
        return
    if environment.get("WAYLAND_DISPLAY"):
        return
    if not environment.get("DISPLAY"):
        raise InputError("there is no screen: neither DISPLAY nor WAYLAND_DISPLAY is set")
    if find_library("xcb-cursor") is None:
        raise InputError("Qt needs a library that is missing: apt install libxcb-cursor0")


class Demo:
    """The process of :mod:`ncdc_host.gui.demo`, whose devices ``window`` opens."""

    def __init__(self, window):
        self._window, self._error = window, ""
        self._process = QProcess(window)
        self._process.setProgram(sys.executable)
        self._process.setArguments(["-m", "ncdc_host.gui.demo"])
        self._process.readyReadStandardOutput.connect(self._read)
        self._process.finished.connect(self._finished)
        self._process.start()
        self._say("Preparing two emulated devices …")

    def _say(self, text):
        self._window.welcome.setText(f"<h2>NCDC</h2><p>{escape(text)}</p>")

    def _read(self):
        while self._process.canReadLine():
            word, _, rest = bytes(self._process.readLine()).decode().strip().partition(" ")
            if word == "step":
                self._say(f"Preparing two emulated devices: {rest} …")
            elif word == "error":
                self._error = rest
            elif word == "ready":
                for url, name in zip(rest.split(), ("emulated: scene", "emulated: dots")):
                    self._window.open_device(url, name=name)
                self._window.tabs.setCurrentIndex(0)

    def _finished(self):
        said = bytes(self._process.readAllStandardError()).decode(errors="replace").split("\n")
        reason = self._error or next(filter(None, reversed(said)), "it has ended")
        self._say(f"The emulated devices are not there: {reason}.")

    def close(self):
        """End the process."""
        self._process.finished.disconnect()
        self._process.closeWriteChannel()
        if not self._process.waitForFinished(3000):
            self._process.kill()
            self._process.waitForFinished(1000)


def run(urls=(), demo=False):
    """Show the window until it is closed; returns the exit status.

    Parameters
    ----------
    urls : sequence of str
        Devices to open.
    demo : bool
        With two emulated devices.

    Raises
    ------
    InputError
        If there is no screen.
    """
    check_screen()
    application = QApplication.instance() or QApplication(["ncdc"])
    application.setOrganizationName("ncdc")
    application.setApplicationName("ncdc-client")
    window = MainWindow(Discovery())
    for url in urls:
        window.open_device(url)
    demonstration = Demo(window) if demo else None
    window.show()
    settle()
    # Python looks at signals only when it runs: Ctrl-C in the terminal closes the window.
    signal.signal(signal.SIGINT, lambda *_: window.close())
    heart = QTimer(interval=200)
    heart.timeout.connect(lambda: None)
    heart.start()
    try:
        return application.exec()
    finally:
        if demonstration is not None:
            demonstration.close()
