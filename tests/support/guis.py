"""The client's window in tests: without a screen, on emulated devices of the same process."""

from contextlib import contextmanager

import numpy as np
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from devices import device
from ncdc_host.device.emulated import Announcer
from ncdc_host.gui.device_tab import DeviceTab

__all__ = ["SECONDS", "announced", "drag", "other_transport", "pixels_of", "tab_on", "url_of",
           "wheel"]

SECONDS = 20_000        # ms that anything may take on a busy machine


@contextmanager
def announced(count=1, **options):
    """``count`` emulated devices, announced, so that GVCP finds them."""
    devices = [device(**options) for _ in range(count)]
    announcer = Announcer(devices)
    try:
        yield devices
    finally:
        announcer.close()
        for one in devices:
            one.close()


def url_of(one, scheme):
    """The URL of an emulated device."""
    port = f":{one.table.port}" if scheme == "tcp" else ""
    return f"{scheme}://{one.options.address}{port}"


def other_transport(scheme):
    """How else a device is reached: (scheme, monitor)."""
    return ("tcp", False) if scheme == "gige" else ("gige", True)


@contextmanager
def tab_on(qtbot, url, monitor=False, pictures=True):
    """A :class:`DeviceTab` that is open, and shows pictures."""
    tab = DeviceTab(url, monitor=monitor)
    qtbot.addWidget(tab)
    tab.resize(1000, 700)
    tab.show()
    try:
        if pictures:
            def running():
                # What the tab says instead belongs to the failure.
                assert tab.shown is not None and tab.infos is not None, tab.messages.text
            qtbot.waitUntil(running, timeout=SECONDS)
        yield tab
    finally:
        with qtbot.waitSignal(tab.session.closed, timeout=2 * SECONDS):
            tab.session.close()


def pixels_of(image):
    """RGB uint8 (height, width, 3) of a QImage."""
    image = image.convertToFormat(image.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, :3 * image.width()].reshape(image.height(), image.width(), 3).copy()


def drag(view, *points):
    """Drag from the first point through the others, in pixels of the widget."""
    QTest.mousePress(view, Qt.MouseButton.LeftButton, pos=points[0])
    for point in points[1:]:
        QTest.mouseMove(view, point)
        QApplication.processEvents()
    QTest.mouseRelease(view, Qt.MouseButton.LeftButton, pos=points[-1])


def wheel(view, steps):
    """Turn the wheel in the middle of the widget."""
    at = QPointF(view.rect().center())
    QApplication.sendEvent(view, QWheelEvent(
        at, view.mapToGlobal(at), QPoint(), QPoint(0, 120 * steps), Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False))
