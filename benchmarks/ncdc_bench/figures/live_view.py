"""The figures of ``docs/howto/live_view.md``: angles, a shaking camera, the window.

    QT_QPA_PLATFORM=offscreen python -m ncdc_bench.figures.live_view docs/figures

Half a minute.
"""

import sys
from pathlib import Path

import cv2
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Arc

from ncdc_bench.figures.box_drawing import write_figure
from ncdc_bench.view.shaking import Shake, ShakingCamera
from ncdc_bench.view.steadiness import trained_lens
from ncdc_host.device.emulated import DeviceOptions, EmulatedDevice, lens_corrections
from ncdc_model.example import example_camera, scene_at, scene_photo
from ncdc_model.example.render import ideal_samples
from ncdc_model.stabilise.stabiliser import Stabiliser
from ncdc_model.view_map import view_map
from ncdc_spec.view_matrix import PlaneCamera

__all__ = ["angles_figure", "draw"]

_LINE, _VIEW, _GREY = "#30507a", "#c04020", "#777777"
_TURN = 25              # degrees, of the drawing
# Title, name of the axis to the right, name of the one upwards, angle, its sign on the paper.
_PANELS = (("from above", "x: right", "z: forward", "pan", -1),
           ("from the right", "z: forward", "-y: up", "tilt", 1),
           ("from the back", "x: right", "-y: up", "roll", -1))
_FRAMES, _READOUT, _FPS = 12, 0.016, 30.0
_CROP = np.s_[120:360, 160:480]         # of the corrected picture
_QUALITY = 86           # of JPEG
_ADDRESS = "127.0.0.77"
# Of the window: layout of its views, and the angles of each.
_WINDOWS = {
    "window-view.jpg": ("Single", ({"Pan": -17.0, "Tilt": 8.0, "Roll": 5.0, "Zoom": 1.6},)),
    "window-views.jpg": ("Quad", ({"Pan": -17.0, "Tilt": 8.0, "Zoom": 1.6},
                                  {"Pan": 20.0, "Tilt": 6.0, "Zoom": 1.8},
                                  {"Zoom": 3.0}, {"Zoom": 1.0})),
    "window-detail.jpg": ("Detail", ({}, {"Pan": -12.0, "Tilt": 5.0, "Zoom": 3.0}))}
_TIMEOUT = 30           # s


def angles_figure():
    """The :class:`Figure` of the angles' signs, each seen along the axis that it turns about."""
    figure = Figure(figsize=(10, 3.7))
    for axes, (title, right, up, name, sign) in zip(figure.subplots(1, 3), _PANELS):
        below = .06 if name == "roll" else -.14
        for (x, y), text, position in (((1, 0), right, (1.06, below)), ((0, 1), up, (-.05, 1.1))):
            axes.annotate("", (x, y), (0, 0), arrowprops={"arrowstyle": "-|>", "color": _LINE,
                                                          "linewidth": 1.6})
            axes.text(*position, text, color=_LINE, ha="right" if x else "left", fontsize=10)
        # The camera looks along z; of a roll its right side shows the turn.
        ahead = 90 if name == "pan" else 0
        turn = np.radians(ahead + sign * _TURN)
        axes.annotate("", (np.cos(turn), np.sin(turn)), (0, 0), arrowprops={
            "arrowstyle": "-|>", "color": _VIEW, "linewidth": 2.2})
        first, last = sorted((ahead, ahead + sign * _TURN))
        axes.add_patch(Arc((0, 0), 1.3, 1.3, theta1=first, theta2=last, color=_VIEW, linewidth=1.6))
        axes.text(1.08 * np.cos(turn), 1.08 * np.sin(turn), f"{name} > 0", color=_VIEW, ha="left",
                  va="center", fontsize=10)
        axes.set_title(title, fontsize=11, color=_GREY)
        axes.set_xlim(-.2, 1.4)
        axes.set_ylim(-.55, 1.25)
        axes.set_aspect("equal")
        axes.set_axis_off()
    return figure


def _shaking(folder, camera, lens):
    """The mean of some pictures: without stabilisation, a matrix per frame, one per row."""
    shaking = ShakingCamera(camera, Shake(), _READOUT)
    plane = PlaneCamera.of(lens)
    stabiliser = Stabiliser(shaking.shake.gyroscope(-1, 2), plane, plane, np.eye(3), camera.size[1],
                            _READOUT)
    samples, sums = ideal_samples(camera), [0, 0, 0]
    for k in range(_FRAMES):
        raw = np.clip(shaking.frame(k / _FPS, samples, scene_at), 0, 255).astype(np.uint8)
        rows = stabiliser.matrices(k / _FPS)
        for part, matrix in enumerate((np.eye(3), rows[len(rows) // 2], rows)):
            *maps, _ = view_map(lens, plane.size, matrix)
            sums[part] = sums[part] + cv2.remap(raw, *maps, cv2.INTER_LINEAR)[_CROP].astype(float)
    gap = np.full((sums[0].shape[0], 8, 3), 255.0)
    without, frame, row = (part / _FRAMES for part in sums)
    picture = np.hstack([without, gap, frame, gap, row]).astype(np.uint8)
    cv2.imwrite(str(folder / "view-shaking.jpg"), picture[..., ::-1],
                [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])


def _windows(folder, camera, lens):
    """The window, with the views of an emulated device moved."""
    import time

    from PySide6.QtWidgets import QApplication

    from ncdc_host.gui.main_window import MainWindow
    application = QApplication.instance() or QApplication(["ncdc"])

    def until(condition):
        end = time.monotonic() + _TIMEOUT
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError("the window does not come to an end")
            application.processEvents()
            time.sleep(.01)
    options = DeviceOptions(_ADDRESS, noise=0.5, fps=10, tcp_port=0)
    with EmulatedDevice(lens_corrections([lens]), options, scene_photo(camera)):
        window = MainWindow(None)
        window.panels["devices"].setChecked(False)
        window.resize(1180, 760)
        window.show()
        tab = window.open_device(f"gige://{_ADDRESS}", name="hall camera")
        until(lambda: tab.shown and tab.infos)
        tab.bar.steer.click()

        def reached(name, value):
            found = tab.infos[name].value
            return found == value if isinstance(value, str) else abs(found - value) < .01

        def choose(**values):
            for name, value in values.items():
                tab.set_feature(name, value)
            until(lambda: all(reached(*pair) for pair in values.items()))
        for name, (layout, looks) in _WINDOWS.items():
            choose(ViewLayout=layout)
            for k, angles in enumerate(looks):
                choose(ViewSelector=f"View{k}")
                choose(**{"Pan": 0.0, "Tilt": 0.0, "Roll": 0.0, "Zoom": 1.0, **angles})
            number = tab.shown.frame.number
            until(lambda number=number: tab.shown.frame.number > number + 3)
            tab.panel.ensureWidgetVisible(tab.settings.look_group)
            for _ in range(10):
                application.processEvents()
            window.grab().save(str(folder / name), quality=_QUALITY)
        window.close()
        until(lambda: not tab.session._thread.is_alive())


def draw(folder):
    """Write the figures into a folder."""
    folder = Path(folder)
    write_figure(str(folder / "view-angles.svg"), angles_figure())
    camera = example_camera()
    lens = trained_lens(camera)
    _shaking(folder, camera, lens)
    _windows(folder, camera, lens)


if __name__ == "__main__":
    draw(sys.argv[1])
