"""The client's window on the system in simulation: the picture of ``docs/reference/soc.md``.

    python -m ncdc_bench.figures.soc_window net.toml photo.png docs/figures/soc-window.jpg

``photo.png``: a colour picture as the camera sees it. Takes some three minutes.
"""

import json
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

from ncdc_model.images import mosaic
from ncdc_sim.system.soc import ADDRESS, SocModel, SocRun
from ncdc_sim.tools import SimulationError
from ncdc_spec.descriptor import Descriptor

__all__ = ["window_on"]

_EXPOSURE_US = 1000.0
_TIMEOUT_S = 600
# Runs on the clients' side, without a screen.
_WINDOW = """
import json, os, sys, time
os.environ["QT_QPA_PLATFORM"] = "offscreen"
import numpy as np
from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QApplication
from ncdc_host.gui.main_window import MainWindow
url, folder, timeout = sys.argv[1], sys.argv[2], float(sys.argv[3])
QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, folder)
application = QApplication(["ncdc"])
window = MainWindow()
window.resize(1100, 760)
window.show()
window.open_device(url)
[tab] = window.open_tabs()
def wait(there):
    end = time.monotonic() + timeout
    while not there():
        application.processEvents()
        if time.monotonic() > end:
            sys.exit("the window shows no picture: " + tab.messages.text)
        time.sleep(.02)
wait(lambda: tab.shown is not None and tab.infos is not None)
first = tab.shown
wait(lambda: tab.shown is not first)
for _ in range(20):
    application.processEvents()
image = tab.shown.image.convertToFormat(tab.shown.image.Format.Format_RGB888)
rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
np.save(folder + "/shown.npy", rows[:, :3 * image.width()].reshape(image.height(), -1, 3))
window.grab().save(folder + "/window.png")
print(json.dumps(tab.messages.text))
window.close()
wait(lambda: not window.isVisible())
"""


def window_on(run, folder, scheme="aravis"):
    """Open the client's window on a :class:`SocRun`, until it has shown two pictures.

    Writes ``window.png``, the window, and ``shown.npy``, the last picture in it, (height, width,
    3), red first, into an existing ``folder``. Returns the window's message, or "".

    Raises
    ------
    SimulationError
        If it shows no picture.
    """
    done = run.network.run([sys.executable, "-c", _WINDOW, f"{scheme}://{ADDRESS}", str(folder),
                            str(_TIMEOUT_S)], timeout=3 * _TIMEOUT_S)
    if done.returncode:
        raise SimulationError(done.stderr[-2000:])
    return json.loads(done.stdout.splitlines()[-1])


def _main(net, photo, output):
    descriptor = Descriptor.load(net)
    raw = mosaic(cv2.imread(photo)[:, :, ::-1].copy(), descriptor.geometry.bayer)
    model = SocModel(descriptor, raw, _EXPOSURE_US)
    with tempfile.TemporaryDirectory() as folder, SocRun(model) as run:
        said = window_on(run, folder)
        shown = np.load(Path(folder) / "shown.npy")
        different = (shown != model.golden().picture).any(axis=-1).sum()
        print(f"{different} pixels of the picture in the window differ; it says {said!r}")
        cv2.imwrite(output, cv2.imread(f"{folder}/window.png"), [cv2.IMWRITE_JPEG_QUALITY, 90])


if __name__ == "__main__":
    _main(*sys.argv[1:4])
