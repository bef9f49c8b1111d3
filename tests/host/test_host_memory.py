"""Peak memory of the emulated device and of the window, as processes of their own."""

import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from cameras import barrel_descriptor
from devices import loopback_address
from ncdc_host.client import open_device
from peaks import peak_of

DEVICE = 150            # MB, of 640x480 pixels
WINDOW = 400            # MB, with two devices, and theirs
COMMAND = "import sys; from ncdc.cli import main; sys.exit(main(sys.argv[1:]))"
# Runs the command with a window that says when both devices' pictures run.
WINDOWED = """import sys
from PySide6.QtCore import QSettings, QTimer
from ncdc_host.gui import application

class Watched(application.MainWindow):
    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.timer = QTimer(interval=100)
        self.timer.timeout.connect(self.look)
        self.timer.start()

    def look(self):
        tabs = self.open_tabs()
        if len(tabs) == 2 and all(tab.shown and tab.shown.frame.number > 30 for tab in tabs):
            self.timer.stop()
            print("running", flush=True)

QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, sys.argv.pop())
application.MainWindow = Watched
""" + COMMAND


@contextmanager
def process(code, *words):
    """A process of this Python code, whose standard output is read; ended at the end."""
    made = subprocess.Popen([sys.executable, "-c", code, *map(str, words)], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        yield made
    finally:
        made.terminate()
        made.wait(60)


@pytest.mark.longer
def test_an_emulated_device(tmp_path):
    barrel_descriptor((640, 480), (640, 480), hidden_neurons=5).save(tmp_path / "net.toml")
    address = loopback_address()
    with process(COMMAND, "device", "serve", tmp_path / "net.toml", "--address", address,
                 "--tcp-port", 0) as serving:
        port = serving.stdout.readline().partition("TCP port ")[2].partition(",")[0]
        with open_device(f"tcp://{address}:{port}") as device:
            for corrected in (True, False):
                device.set("CorrectionEnable", corrected)
                with device.stream() as frames:
                    for _ in range(10):
                        assert frames.next(20).pixels.shape[:2] == (480, 640)
        assert peak_of(serving.pid) < DEVICE


@pytest.mark.regress
def test_the_window_with_two_devices(tmp_path):
    """In ``make regress`` only: the two devices have addresses that another test may use, too."""
    with process(WINDOWED, "client", "gui", "--demo", tmp_path) as window:
        assert window.stdout.readline() == "running\n"
        [devices] = Path(f"/proc/{window.pid}/task/{window.pid}/children").read_text().split()
        assert peak_of(window.pid) + peak_of(devices) < WINDOW
