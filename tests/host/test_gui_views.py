"""The window with several views: the one under the cursor moves, and is marked."""

import math
import threading

import pytest
from PySide6.QtCore import QPointF, QRectF

from devices import SIZE, view_lens
from guis import SECONDS, announced, drag, tab_on, url_of, wheel
from ncdc_host.gui.main_window import MainWindow

FOCAL = 41.26
LOWER_LEFT, LOWER_RIGHT = QPointF(5, 40), QPointF(50, 40)


@pytest.fixture(params=["gige", "tcp"])
def tab(request, qtbot):
    with announced(descriptors=[view_lens()]) as [one], \
            tab_on(qtbot, url_of(one, request.param)) as tab:
        tab.device = one
        tab.steering.show("Quad")
        qtbot.waitUntil(lambda: tab.infos["ViewLayout"].value == "Quad", timeout=SECONDS)
        tab.bar.steer.click()
        yield tab


def numbers(tab, k, *names):
    """Angles of a view of the device itself."""
    look = tab.device.registers.settings.looks[k]
    return [getattr(look, name.lower()) for name in names]


def at(view, point):
    """Where a pixel of the picture is in the widget."""
    rect = view.picture_rect()
    return QPointF(rect.left() + point.x() * view.scale,
                   rect.top() + point.y() * view.scale).toPoint()


def test_the_view_under_the_cursor_moves(qtbot, tab):
    start, scale = at(tab.view, LOWER_RIGHT), tab.view.scale
    end = at(tab.view, LOWER_RIGHT + QPointF(4, -6))
    drag(tab.view, start, end)
    # A pixel of a view of half the width turns as far as two of the whole picture.
    pan, tilt = (math.degrees(math.atan(2 * pixels / scale / FOCAL)) for pixels in (
        start.x() - end.x(), end.y() - start.y()))
    qtbot.waitUntil(lambda: numbers(tab, 3, "Pan", "Tilt") == pytest.approx([pan, tilt], abs=.011),
                    timeout=SECONDS)
    tab.steering.magnify(2, LOWER_LEFT)
    tab.steering.magnify(1, LOWER_RIGHT)
    qtbot.waitUntil(lambda: [numbers(tab, k, "Zoom")[0] for k in range(4)] == pytest.approx(
        [1, 1, 1.21, 1.1], abs=.001), timeout=SECONDS)
    assert numbers(tab, 3, "Pan", "Tilt") == pytest.approx([pan, tilt], abs=.011)
    assert numbers(tab, 0, "Pan", "Tilt") == numbers(tab, 2, "Pan", "Tilt") == [0, 0]
    qtbot.waitUntil(lambda: tab.infos["ViewSelector"].value == "View3", timeout=SECONDS)
    tab.bar.reset.click()
    qtbot.waitUntil(lambda: numbers(tab, 3, "Pan", "Zoom") == [0, 1], timeout=SECONDS)
    assert numbers(tab, 2, "Zoom") == [pytest.approx(1.21, abs=.001)]
    assert tab.messages.text == ""


def test_the_selected_view_is_marked(qtbot, tab):
    assert tab.view._outline == QRectF(0, 0, 32, 24)
    tab.set_feature("ReverseX", True)
    qtbot.waitUntil(lambda: tab.view._outline == QRectF(32, 0, 32, 24), timeout=SECONDS)
    # The mirrored picture has the lower right view at the left.
    tab.steering.magnify(1, LOWER_LEFT)
    qtbot.waitUntil(lambda: tab.view._outline == QRectF(0, 24, 32, 24), timeout=SECONDS)
    assert tab.infos["ViewSelector"].value == "View3"
    assert not tab.settings.selector.isHidden() and tab.settings.selector.currentText() == "View 4"
    tab.steering.show("Detail")
    qtbot.waitUntil(lambda: tab.view._outline is None, timeout=SECONDS)     # it has no view 3
    tab.steering.push(QPointF(1, 0))
    qtbot.waitUntil(lambda: numbers(tab, 0, "Pan")[0] < 0, timeout=SECONDS)
    tab.steering.magnify(1, QPointF(5, 44))
    qtbot.waitUntil(lambda: tab.view._outline == QRectF(0, 32, 24, 16), timeout=SECONDS)
    tab.steering.show("Single")
    qtbot.waitUntil(lambda: tab.settings.selector.isHidden(), timeout=SECONDS)
    assert tab.view._outline is None


def test_wheel_and_menu(qtbot, tab):
    window = MainWindow(None)
    qtbot.addWidget(window)
    window.tabs.addTab(tab, "one")
    window._enable()
    entries = [action for action, name in window.of_tab if name == "steering.show"]
    entries[2].trigger()
    qtbot.waitUntil(lambda: tab.infos["ViewLayout"].value == "Detail", timeout=SECONDS)
    wheel(tab.view, 1)                      # in the middle: the overview
    qtbot.waitUntil(lambda: numbers(tab, 0, "Zoom") == [1.1], timeout=SECONDS)
    entries[0].trigger()
    qtbot.waitUntil(lambda: tab.infos["ViewLayout"].value == "Single", timeout=SECONDS)
    assert SIZE == (64, 48) and tab.steering._views.rect(0) == QRectF(0, 0, 64, 48)
    tab.setParent(None)


def test_the_panel_may_select_another_view_meanwhile(qtbot, tab):
    gate = threading.Event()
    tab.session._jobs.put(gate.wait)            # no change is sent before the second one is there
    tab.steering.magnify(1, LOWER_RIGHT)
    tab.set_feature("ViewSelector", "View1")
    gate.set()
    qtbot.waitUntil(lambda: tab.infos["ViewSelector"].value == "View1", timeout=SECONDS)
    tab.steering.magnify(1, LOWER_LEFT)
    qtbot.waitUntil(lambda: numbers(tab, 2, "Zoom") == [pytest.approx(1.1, abs=.001)],
                    timeout=SECONDS)
    assert numbers(tab, 3, "Zoom") == [1]
