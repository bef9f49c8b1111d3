"""The window moves the view of a device: dragging, wheel, keys, buttons, numbers."""

import math

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest

from devices import SIZE, view_lens
from guis import SECONDS, announced, drag, pixels_of, tab_on, url_of, wheel
from ncdc_host.gui.main_window import MainWindow
from ncdc_model.example import noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_spec.view_matrix import Angles, PlaneCamera

FOCAL = 41.26


@pytest.fixture
def tab(qtbot):
    with announced(descriptors=[view_lens()]) as [one], tab_on(qtbot, url_of(one, "gige")) as tab:
        tab.device = one
        yield tab


def angles(tab):
    return {name: tab.infos[name].value for name in ("Pan", "Tilt", "Roll", "Zoom")}


def until(qtbot, tab, **wanted):
    """Wait until the device and the window have these angles."""
    qtbot.waitUntil(lambda: all(angles(tab)[name] == pytest.approx(value, abs=.011)
                                for name, value in wanted.items()), timeout=SECONDS)


def test_dragging_moves_what_is_under_the_cursor(qtbot, tab):
    tab.bar.steer.click()
    scale, fitted = tab.view.scale, tab.view.fitted
    middle = tab.view.rect().center()
    drag(tab.view, middle, middle + QPoint(round(5 * scale), 0),
         middle + QPoint(round(5 * scale), round(4 * scale)))
    pan, tilt = (math.degrees(math.atan(round(pixels * scale) / scale / FOCAL))
                 for pixels in (5, 4))
    until(qtbot, tab, Pan=-pan, Tilt=tilt, Roll=0, Zoom=1)
    assert tab.view.scale == scale and tab.view.fitted == fitted
    assert tab.settings.looks["Pan"].value == pytest.approx(-pan, abs=.011)
    looking = Angles(**{name.lower(): value for name, value in angles(tab).items()})
    wanted = correct(view_lens(), noise_picture(*SIZE),
                     view=PlaneCamera.of(view_lens()).looking(looking))
    qtbot.waitUntil(lambda: (pixels_of(tab.shown.image) == wanted.picture).all(), timeout=SECONDS)


def test_mirrored_and_rolled_pictures_are_dragged_alike(qtbot, tab):
    tab.set_feature("Roll", 90.0)
    tab.set_feature("ReverseX", True)
    until(qtbot, tab, Roll=90)
    qtbot.waitUntil(lambda: tab.infos["ReverseX"].value, timeout=SECONDS)
    # The view's right is down in the world, and it is shown at the left; its lower side is left.
    tab.steering.drag(QPointF(5, 3))
    until(qtbot, tab, Pan=math.degrees(math.atan(3 / FOCAL)),
          Tilt=math.degrees(math.atan(-5 / FOCAL)))


def test_near_the_zenith_a_drag_turns_farther(qtbot, tab):
    tab.set_feature("Tilt", 60.0)
    until(qtbot, tab, Tilt=60)
    tab.steering.drag(QPointF(4, 0))
    until(qtbot, tab, Pan=-math.degrees(math.atan(4 / FOCAL / .5)), Tilt=60)


def test_wheel_keys_and_reset(qtbot, tab):
    tab.bar.steer.click()
    wheel(tab.view, 3)
    until(qtbot, tab, Zoom=1.331)
    width = tab.shown.image.width()
    for key, name, sign in ((Qt.Key.Key_Right, "Pan", 1), (Qt.Key.Key_Up, "Tilt", 1)):
        QTest.keyClick(tab.view, key)
        until(qtbot, tab, **{name: sign * math.degrees(math.atan(.1 * width / FOCAL / 1.331))})
    for _ in range(40):
        wheel(tab.view, 1)
    until(qtbot, tab, Zoom=8)
    tab.bar.reset.click()
    until(qtbot, tab, Pan=0, Tilt=0, Roll=0, Zoom=1)
    assert tab.messages.text == ""


def test_without_the_button_the_picture_in_the_window_moves(qtbot, tab):
    before = angles(tab)
    wheel(tab.view, 1)
    middle = tab.view.rect().center()
    drag(tab.view, middle, middle + QPoint(30, 10))
    assert not tab.view.fitted and angles(tab) == before
    tab.steering.toggle()
    assert tab.bar.steer.isChecked() and tab.view.steers
    tab.set_mode("before")
    qtbot.waitUntil(lambda: tab.bar.steer.isHidden() and not tab.view.steers, timeout=SECONDS)


def test_devices_without_a_view_have_no_buttons(qtbot):
    with announced() as [one], tab_on(qtbot, url_of(one, "gige")) as tab:
        assert tab.bar.steer.isHidden() and tab.bar.reset.isHidden()
        assert tab.settings.look_group.isHidden() and not tab.can("steering.toggle")


def test_menu_and_keys_of_the_window(qtbot, tab):
    window = MainWindow(None)
    qtbot.addWidget(window)
    names = {name: action for action, name in window.of_tab}
    assert not names["steering.toggle"].isEnabled()
    window.tabs.addTab(tab, "one")
    window._enable()
    names["steering.toggle"].trigger()
    assert tab.view.steers
    tab.set_feature("Pan", 12.0)
    until(qtbot, tab, Pan=12)
    names["steering.reset"].trigger()
    until(qtbot, tab, Pan=0)
    tab.setParent(None)
