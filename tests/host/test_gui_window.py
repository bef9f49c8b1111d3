"""The window as a whole: how large it is, what can be done in it, its colours, its versions."""

from contextlib import contextmanager
from importlib.metadata import version

import numpy as np
import pytest
from PySide6.QtCore import QSettings, Qt, qVersion
from PySide6.QtGui import QColor, QPalette, QPixmap
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QToolButton

from devices import SIZE
from guis import SECONDS, announced, pixels_of, tab_on, url_of
from ncdc_host.gui import device_tab, file_names
from ncdc_host.gui.colours import contrast
from ncdc_host.gui.device_tab import DeviceTab
from ncdc_host.gui.histogram_view import HistogramView
from ncdc_host.gui.main_window import MainWindow
from ncdc_host.gui.message_bar import MessageBar
from ncdc_host.gui.picture_view import MODES

NO_DEVICE = "tcp://127.255.255.250:9"
# Laptops of 1280x800 and 1366x768 pixels, and such ones at a scale of 2.
SCREENS = (1280, 800), (1366, 768), (640, 400), (683, 384)
FRAME = 40              # pixels of a desktop's own bar and the window's title
READABLE = 4.5          # contrast of text


@pytest.fixture(autouse=True)
def settings(tmp_path):
    """The window keeps its size elsewhere than the user's."""
    QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, str(tmp_path))


@contextmanager
def window_on(qtbot, *urls, size=(1280, 800)):
    """A :class:`MainWindow` of this size with a tab for each URL."""
    window = MainWindow()
    qtbot.addWidget(window)
    window.resize(*size)
    window.show()
    for url in urls:
        window.open_device(url)
    try:
        yield window
    finally:
        window.close()


def action(window, name):
    """The menu's action whose text begins so, without its mark of a key."""
    [found] = [one for menu in window.menuBar().actions() for one in menu.menu().actions()
               if one.text().replace("&", "").startswith(name)]
    return found


@pytest.mark.parametrize("size", SCREENS)
def test_it_fits_a_laptop_and_does_not_grow(qtbot, size):
    with announced() as [one], window_on(qtbot, url_of(one, "tcp"), NO_DEVICE, size=size) as window:
        tab, dead = window.open_tabs()
        qtbot.waitUntil(lambda: tab.shown is not None and dead.messages.text != "",
                        timeout=SECONDS)
        dead._failed("held", "another user has control")        # the message with most buttons
        for shown in (dead, tab):
            window.tabs.setCurrentWidget(shown)
            for mode in MODES:
                shown.set_mode(mode)
                qtbot.wait(20)
                assert window.size().toTuple() == size
                least = window.minimumSizeHint()
                assert least.width() <= size[0] and least.height() <= size[1] - FRAME
        assert tab.mode == MODES[-1] and tab.view.height() > size[1] / 2


@pytest.mark.parametrize("width", [1280, 640])
def test_every_button_of_the_bar_is_seen(qtbot, width):
    with announced() as [one], window_on(qtbot, url_of(one, "tcp"), size=(width, 400)) as window:
        qtbot.waitUntil(lambda: window.tab.shown is not None, timeout=SECONDS)
        window.tab.set_mode("wipe")
        qtbot.wait(50)
        bar = window.tab.bar
        buttons = [one for one in bar.findChildren(QToolButton) if one.isVisible()]
        assert len(buttons) == len(MODES) + 7 and bar.again in buttons
        for button in buttons:
            rect = button.rect().translated(button.mapTo(bar, button.rect().topLeft()))
            assert bar.rect().contains(rect) and button.width() >= button.sizeHint().width()


def test_panels_leave_a_narrow_window_and_come_back(qtbot):
    with window_on(qtbot, NO_DEVICE) as window:
        panels = window.devices, window.tab.panel
        assert all(panel.isVisible() for panel in panels)
        window.resize(900, 600)
        qtbot.waitUntil(lambda: [panel.isVisible() for panel in panels] == [False, True])
        action(window, "Devices").trigger()                 # the user's choice stays
        window.resize(920, 600)
        qtbot.wait(20)
        assert window.devices.isVisible()
        action(window, "Devices").trigger()
        window.resize(640, 400)
        qtbot.waitUntil(lambda: not window.tab.panel.isVisible())
        action(window, "Settings").trigger()
        assert window.tab.panel.isVisible()
        window.resize(1280, 800)
        qtbot.waitUntil(lambda: all(panel.isVisible() for panel in panels))
        window.resize(640, 400)
        window.close_tab(0)                                 # nothing else than the list is left
        assert window.devices.isVisible()


def test_nothing_is_zoomed_where_there_is_no_picture(qtbot):
    with tab_on(qtbot, NO_DEVICE, pictures=False) as tab:
        qtbot.waitUntil(lambda: "No device answers" in tab.messages.text, timeout=SECONDS)
        bar, view = tab.bar, tab.view
        for act in (view.zoom_in, view.zoom_out, view.fit, lambda: view.set_scale(1)):
            act()
            assert bar.scale.text() == "–" and view.fitted
        assert not any(button.isEnabled() for button in (bar.zoom_in, bar.zoom_out, bar.fit,
                                                         bar.whole))


OF_DEVICES = ("Load lens file", "Calibrate from", "Save picture", "Save raw frame", "Copy",
              "Freeze", "1 Before", "2 After", "Larger", "As large as", "1:1")


def test_a_device_that_is_not_there_offers_nothing(qtbot, monkeypatch):
    monkeypatch.setattr(file_names.QFileDialog, "getOpenFileName",
                        lambda *_: pytest.fail("a file is asked for"))
    with window_on(qtbot, NO_DEVICE) as window:
        qtbot.waitUntil(lambda: window.tab.messages.text != "", timeout=SECONDS)
        enabled = {name: action(window, name).isEnabled() for name in OF_DEVICES}
        assert not any(value for name, value in enabled.items() if name != "2 After")
        assert action(window, "Close tab").isEnabled()
        QTest.keyClick(window, Qt.Key.Key_L, Qt.KeyboardModifier.ControlModifier)
        qtbot.wait(20)


def test_a_device_that_is_there_offers_all(qtbot):
    with announced() as [one], window_on(qtbot, url_of(one, "tcp")) as window:
        tab = window.tab
        qtbot.waitUntil(lambda: tab.shown is not None and tab.infos is not None, timeout=SECONDS)
        assert all(action(window, name).isEnabled() for name in OF_DEVICES)
        assert not action(window, "Take raw frame again").isEnabled()
        tab.set_mode("wipe")
        assert action(window, "Take raw frame again").isEnabled()
        one.close()
        qtbot.waitUntil(lambda: tab._state == "waiting", timeout=2 * SECONDS)
        asked = {name: action(window, name).isEnabled() for name in OF_DEVICES}
        assert not asked["Load lens file"] and not asked["Calibrate from"]
        assert asked["Save picture"] and asked["Larger"]        # of the last picture


def test_a_lens_for_a_device_that_has_gone_is_not_dropped_silently(qtbot, tmp_path):
    """The device may go while a file is chosen."""
    with tab_on(qtbot, NO_DEVICE, pictures=False) as tab:
        with qtbot.waitSignal(tab.session.rejected, timeout=SECONDS) as rejected:
            tab.loader.load(tmp_path / "net.toml", 0)
        assert "net.toml is not loaded" in rejected.args[0]


def test_the_rate_of_a_stream_that_ends_is_zero(qtbot):
    with announced(fps=20.0) as [one], tab_on(qtbot, url_of(one, "tcp")) as tab:
        qtbot.waitUntil(lambda: tab.rate.text() != "" and tab._counts.rate > 1, timeout=SECONDS)
        assert not tab.rate.text().startswith("0.0")
        lost = tab.statistics.values["frames"].text()
        one.close()
        qtbot.waitUntil(lambda: tab._state == "waiting", timeout=2 * SECONDS)
        assert tab.rate.text().startswith("0.0 pictures/s")
        assert tab.statistics.values["rate"].text() == "0.0 pictures/s"
        assert tab.statistics.values["data"].text() == "0.0 MB/s" and lost


def test_the_rate_falls_while_the_device_still_seems_to_be_there(qtbot):
    """Over GVCP it takes seconds until a device that has gone is noticed."""
    with announced(fps=20.0) as [one], tab_on(qtbot, url_of(one, "tcp")) as tab:
        qtbot.waitUntil(lambda: tab._counts is not None and tab._counts.rate > 1, timeout=SECONDS)
        tab.session.counted.disconnect()
        tab.session.picture.disconnect()
        qtbot.waitUntil(lambda: tab.rate.text().startswith("0.0 pictures/s"), timeout=SECONDS)
        assert tab._state == "open"


@pytest.mark.parametrize("name,text,said", [
    ("hall camera", "gige://10.0.0.5 does not answer any more", "hall camera does not answer any "
     "more."), ("", "no device answers at gige://10.0.0.5: timed out",
                "No device answers at 10.0.0.5: timed out."),
    ("hall camera", "Gain is rejected by gige://10.0.0.5", "Gain is rejected by hall camera.")])
def test_messages_name_the_device_and_not_its_url(qtbot, monkeypatch, name, text, said):
    monkeypatch.setattr(device_tab.Session, "start", lambda self: None)
    tab = DeviceTab("gige://10.0.0.5", name)
    qtbot.addWidget(tab)
    assert "://" not in tab.view.text
    tab.session.rejected.emit(text)
    assert tab.messages.text == said


# Colours.


@pytest.fixture(params=["light", "dark"])
def theme(request, qapp):
    """The palette of a light desktop, or of a dark one, until the test is over."""
    before = QApplication.palette()
    ground, text = ("#efefef", "#000000") if request.param == "light" else ("#323232", "#f0f0f0")
    palette = QPalette(QColor(ground), QColor(ground))
    for role in ("WindowText", "Text", "ButtonText"):
        palette.setColor(getattr(QPalette.ColorRole, role), QColor(text))
    QApplication.setPalette(palette)
    yield request.param
    QApplication.setPalette(before)


def colours_in(widget):
    """(ground, ink): the colour that most pixels of ``widget`` have, and the one that stands out
    most from it."""
    pixels = pixels_of(widget.grab().toImage()).reshape(-1, 3)
    colours, counts = {}, {}
    for pixel in map(tuple, pixels.tolist()):
        colours.setdefault(pixel, QColor(*pixel))
        counts[pixel] = counts.get(pixel, 0) + 1
    ground = colours[max(counts, key=counts.get)]
    return ground, max(colours.values(), key=lambda one: contrast(ground, one))


@pytest.mark.parametrize("kind", ["error", "warning", "info"])
def test_messages_are_readable_in_both_themes(qtbot, theme, kind):
    bar = MessageBar()
    qtbot.addWidget(bar)
    bar.resize(500, 40)
    bar.show_message("No device answers", kind)
    for label in (bar.findChildren(QLabel)[1], bar.findChildren(QToolButton)[0]):
        ground, ink = colours_in(label)
        assert contrast(ground, ink) >= READABLE
    # A dark paper among a dark window, a light one in a light one.
    assert (ground.lightness() < 128) == (theme == "dark")


def test_the_histogram_is_readable_in_both_themes(qtbot, theme):
    view = HistogramView()
    qtbot.addWidget(view)
    view.resize(240, 96)
    view.show_counts(np.full((3, 256), 5))
    line = view.fontMetrics().height()
    below = view.grab(view.rect().adjusted(0, 96 - line, 0, 0)).toImage()
    label = QLabel()
    label.setPixmap(QPixmap.fromImage(below))
    qtbot.addWidget(label)
    ground, ink = colours_in(label)
    assert contrast(ground, ink) >= READABLE


def test_a_message_follows_a_theme_that_changes(qtbot):
    bar = MessageBar()
    qtbot.addWidget(bar)
    bar.show_message("No device answers", "error")
    light = colours_in(bar)[0].lightness()
    before = QApplication.palette()
    dark = QPalette(QColor("#323232"), QColor("#323232"))
    dark.setColor(QPalette.ColorRole.WindowText, QColor("#f0f0f0"))
    QApplication.setPalette(dark)
    try:
        qtbot.waitUntil(lambda: colours_in(bar)[0].lightness() < 128 < light, timeout=SECONDS)
    finally:
        QApplication.setPalette(before)


def test_about_has_the_versions_of_the_parts(qtbot):
    with window_on(qtbot) as window:
        box = window.about()
        text = box.text()
        for part in (f"NCDC {version('ncdc')}", f"Qt: {qVersion()}",
                     f"viva-genicam: {version('viva-genicam')}", f"numpy: {version('numpy')}",
                     "Python: ", "System: "):
            assert part in text
        assert box.textInteractionFlags() & Qt.TextInteractionFlag.TextSelectableByMouse
        box.close()


def test_the_first_size_is_no_larger_than_the_screen(qtbot):
    window = MainWindow()
    qtbot.addWidget(window)
    screen = window.screen().availableSize()
    assert window.width() <= screen.width() and window.height() <= screen.height()
    assert SIZE[0] < window.width()
