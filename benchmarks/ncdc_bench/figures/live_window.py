"""The figure of the window's live calibration: a chessboard moved before a street.

    QT_QPA_PLATFORM=offscreen python -m ncdc_bench.figures.live_window
"""

import sys
from pathlib import Path

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from ncdc_bench.photos.targets import Bank, Pose
from ncdc_host.gui.live_dialog import LiveDialog

_ROOT = Path(__file__).resolve().parents[3]
_FIGURE = _ROOT / "docs/figures/window-live.jpg"
_POSES = (Pose(step=.17, turn=2, tilts=(0, 0)), Pose((-.6, -.35), .16, -4, (20, 15)),
          Pose((.65, -.3), .16, 5, (15, -25)), Pose((-.55, .35), .16, 3, (-25, 20)))
_SECONDS = 0.25         # from frame to frame
_STILL = 3              # frames of a pose
_TIMEOUT = 600_000     # ms until the figure is given up


def main():
    """Draw it; the exit status."""
    application = QApplication.instance() or QApplication(["ncdc"])
    bank = Bank(_ROOT / "tests/data", 0.625)
    images = [bank.render(("chessboard", 9, 6, pose), view=0.6, clutter=True, seed=number).image
              for number, pose in enumerate(_POSES)]
    frames = [image for image in images for _ in range(_STILL)][:-1]
    dialog, count = LiveDialog("camera:0"), 0

    def show():
        nonlocal count
        if count == len(frames):
            dialog.grab().save(str(_FIGURE), quality=88)
            dialog.reject()
            application.exit(0)
            return
        dialog.show_frame(frames[count], _SECONDS * count, frames[count])
        count += 1
    dialog.frame_wanted.connect(show)
    dialog.live.failed.connect(lambda text: application.exit(1))
    QTimer.singleShot(_TIMEOUT, lambda: application.exit(1))
    dialog.show()
    dialog.begin()
    return application.exec()


if __name__ == "__main__":
    sys.exit(main())
