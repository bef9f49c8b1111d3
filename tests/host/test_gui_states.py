"""What the window says and offers when a device is not there, is gone, or belongs to another."""

import threading

import pytest
import viva_genicam
from PySide6.QtCore import QSettings, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QPushButton

from devices import device, small_lens
from guis import SECONDS, announced, tab_on, url_of
from ncdc_host.client import DeviceError, Found, open_device
from ncdc_host.device.emulated import Announcer
from ncdc_host.gui import discovery as discovery_module
from ncdc_host.gui.application import check_screen
from ncdc_host.gui.devices_panel import DevicesPanel
from ncdc_host.gui.discovery import Discovery
from ncdc_host.gui.main_window import MainWindow
from ncdc_host.gui.receiver import Receiver
from ncdc_spec.errors import InputError


@pytest.fixture(autouse=True)
def settings(tmp_path):
    """The window keeps its size elsewhere than the user's."""
    QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, str(tmp_path))


def press(tab, name):
    """Press a button of the message."""
    next(button for button in tab.messages.buttons if button.text() == name).click()


# Over GVCP it takes ten seconds: a call waits for a silent device several times.
@pytest.mark.parametrize("scheme", [pytest.param("gige", marks=pytest.mark.regress), "tcp"])
def test_a_device_that_goes_is_found_again(qtbot, scheme):
    lens = [small_lens()]
    one = device(lens)
    options = {"address": one.options.address, "tcp_port": one.table.port}
    announcer = Announcer([one])
    with tab_on(qtbot, url_of(one, scheme)) as tab:
        one.close()
        announcer.close()
        qtbot.waitUntil(lambda: tab.view.shade and "tried again" in tab.view.text,
                        timeout=2 * SECONDS)
        assert tab.messages.text and not tab.settings.isEnabled()
        old = tab.shown
        again = device(lens, **options)
        announcer = Announcer([again])
        qtbot.waitUntil(lambda: tab.settings.isEnabled() and tab.shown is not old
                        and not tab.view.text, timeout=2 * SECONDS)
        assert tab.messages.text == ""
    announcer.close()
    again.close()


def test_the_first_picture_may_come_at_once(qtbot, monkeypatch):
    taken = threading.Event()

    class Prompt(Receiver):
        """Returns from its start only after a picture was there, and was asked for."""
        def start(self):
            arrived = self._arrived
            self._arrived = lambda: (arrived(), taken.set())
            super().start()
            assert taken.wait(SECONDS / 1000)

    monkeypatch.setattr("ncdc_host.gui.session.Receiver", Prompt)
    with announced() as [one], tab_on(qtbot, url_of(one, "tcp"), pictures=False) as tab:
        shown = []
        # In the receiver's thread, before the session's goes on: as early as a picture can come.
        tab.session.picture.disconnect()
        tab.session.picture.connect(lambda: shown.append(tab.session.take()),
                                    Qt.ConnectionType.DirectConnection)
        qtbot.waitUntil(lambda: len(shown) > 2, timeout=SECONDS)
        assert None not in shown


def test_a_device_is_asked_for_more_than_once(monkeypatch):
    answered = iter([False, False])
    monkeypatch.setattr(viva_genicam, "discover", lambda *wait, discover=viva_genicam.discover,
                        **options: discover(*wait, **options) if next(answered, True) else [])
    with announced() as [one], open_device(url_of(one, "gige")) as opened:
        assert opened.access == "control"


def test_no_device_at_the_address(qtbot):
    with tab_on(qtbot, "tcp://127.255.255.250:9", pictures=False) as tab:
        qtbot.waitUntil(lambda: "No device answers" in tab.messages.text, timeout=SECONDS)
        assert [button.text() for button in tab.messages.buttons] == ["Try again"]
        assert not tab.bar.save.isEnabled() and not tab.lenses.isEnabled()


def test_control_held_by_another_user(qtbot):
    with announced() as [one]:
        with open_device(url_of(one, "gige")) as other, \
                tab_on(qtbot, url_of(one, "gige"), pictures=False) as tab:
            qtbot.waitUntil(lambda: "Another user has control" in tab.messages.text,
                            timeout=SECONDS)
            press(tab, "Watch only")
            qtbot.waitUntil(lambda: "You watch only" in tab.messages.text, timeout=SECONDS)
            assert not tab.settings.isEnabled() and not tab.bar.modes["wipe"].isEnabled()
            # Settings are read all the same.
            other.set("Gain", 2.5)
            qtbot.waitUntil(lambda: tab.settings.gain.value == 2.5, timeout=SECONDS)
            assert "does not send them to a group" in tab.view.text
            with qtbot.waitSignal(tab.wants, timeout=SECONDS) as wish:
                press(tab, "Open over TCP")
            assert wish.args == [f"tcp://{one.options.address}", False]
            with qtbot.waitSignal(tab.wants, timeout=SECONDS) as wish:
                press(tab, "Take control")
            assert wish.args == [tab.url, False]


def test_try_again_when_the_other_user_has_left(qtbot):
    with announced() as [one]:
        other = open_device(url_of(one, "gige"))
        with tab_on(qtbot, url_of(one, "gige"), pictures=False) as tab:
            qtbot.waitUntil(lambda: "Another user has control" in tab.messages.text,
                            timeout=SECONDS)
            other.close()
            press(tab, "Try again")
            qtbot.waitUntil(lambda: tab.shown is not None, timeout=SECONDS)
            assert tab.settings.isEnabled() and tab.messages.text == ""


def test_a_closed_tab_gives_control_back(qtbot):
    window = MainWindow()
    qtbot.addWidget(window)
    with announced() as [one]:
        tab = window.open_device(url_of(one, "gige"))
        qtbot.waitUntil(lambda: tab.shown is not None, timeout=SECONDS)
        assert window.open_device(url_of(one, "gige")) is tab
        with qtbot.waitSignal(tab.session.closed, timeout=SECONDS):
            window.close_tab(0)
        assert window.tab is None
        with open_device(url_of(one, "gige")) as other:
            assert other.access == "control"


def test_a_tab_instead_of_another(qtbot):
    window = MainWindow()
    qtbot.addWidget(window)
    with announced() as [one]:
        tab = window.open_device(url_of(one, "gige"), monitor=True)
        with qtbot.waitSignal(tab.session.closed, timeout=SECONDS):
            tab.wants.emit(url_of(one, "tcp"), False)
        assert window.tab.url == url_of(one, "tcp") and window.tabs.count() == 1
        qtbot.waitUntil(lambda: window.tab.shown is not None, timeout=SECONDS)
        window.close()


def test_keys(qtbot):
    window = MainWindow()
    qtbot.addWidget(window)
    window.show()
    window.activateWindow()
    with announced() as [one]:
        tab = window.open_device(url_of(one, "tcp"))
        qtbot.waitUntil(lambda: tab.shown is not None, timeout=SECONDS)
        for key, mode in zip("1243", ("before", "after", "wipe", "side by side")):
            QTest.keyClick(tab.view, key)
            assert tab.mode == mode
        QTest.keyClick(tab.view, "2")
        QTest.keyClick(tab.view, Qt.Key.Key_Space)
        assert tab.frozen and tab.bar.freeze.isChecked()
        QTest.keyClick(tab.view, "0")
        assert tab.view.scale == 1
        # A digit that is typed into a box is no command.
        tab.settings.gain.box.setFocus()
        QTest.keyClick(tab.settings.gain.box, "1")
        assert tab.mode == "after"
        window.close()


def test_the_list_of_devices(qtbot):
    panel = DevicesPanel()
    qtbot.addWidget(panel)
    panel.show_found([])
    assert not panel.empty.isHidden() and not panel.open.isEnabled()
    found = [Found(f"gige://10.0.0.{k}", f"10.0.0.{k}", "", "NCDC", "camera") for k in (2, 3)]
    panel.show_found(found)
    assert panel.empty.isHidden() and panel.list.count() == 2
    panel.list.setCurrentRow(1)
    panel.show_found(found[::-1])
    assert "10.0.0.3" in panel.list.currentItem().text()        # the choice stays
    with qtbot.waitSignal(panel.wants) as wish:
        panel.open.click()
    assert wish.args == ["gige://10.0.0.3", False, "camera .3"]
    ways = panel.ways_of(panel.list.currentItem()).actions()
    with qtbot.waitSignal(panel.wants) as wish:
        next(way for way in ways if "TCP" in way.text()).trigger()
    assert wish.args[0] == "tcp://10.0.0.3"
    panel.show_opened([("tcp://10.0.0.3", "camera .3")])
    assert "open" in panel.list.currentItem().text() and panel.list.count() == 2


def test_a_device_that_is_open_is_listed_although_no_broadcast_finds_it(qtbot):
    panel = DevicesPanel()
    qtbot.addWidget(panel)
    panel.show_found([])
    panel.show_opened([("tcp://10.9.0.3:4000", "behind a router")])
    assert panel.empty.isHidden() and panel.state.text() == "none found"
    assert panel.list.currentItem().text() == "behind a router\n10.9.0.3:4000  ·  open"
    with qtbot.waitSignal(panel.wants) as wish:
        panel.open.click()
    assert wish.args == ["tcp://10.9.0.3:4000", False, ""]      # the tab that there is
    panel.show_found([])
    assert panel.list.count() == 1
    panel.show_opened([])
    assert panel.list.count() == 0 and not panel.empty.isHidden()


def test_discovery_finds_and_fails(qtbot, monkeypatch):
    panel, look = DevicesPanel(), Discovery(pause=0.01)
    qtbot.addWidget(panel)
    look.found.connect(panel.show_found)
    look.failed.connect(panel.show_failed)
    with announced(2) as devices:
        look.start()
        qtbot.waitUntil(lambda: {one.options.address for one in devices} <= {
            panel.list.item(k).text().splitlines()[1] for k in range(panel.list.count())},
            timeout=SECONDS)

    def broken():
        raise DeviceError("the package viva-genicam is missing")
    monkeypatch.setattr(discovery_module, "discover", broken)
    qtbot.waitUntil(lambda: panel.empty.text() == "The package viva-genicam is missing.",
                    timeout=SECONDS)
    look.close()
    look.wait(5)


@pytest.mark.parametrize("environment,library,sentence", [
    ({}, "libxcb-cursor.so.0", "there is no screen"),
    ({"DISPLAY": ":0"}, None, "apt install libxcb-cursor0"),
    ({"DISPLAY": ":0"}, "libxcb-cursor.so.0", None),
    ({"WAYLAND_DISPLAY": "wayland-0"}, None, None),
    ({"QT_QPA_PLATFORM": "offscreen"}, None, None)])
def test_no_screen_is_reported_before_qt_aborts(environment, library, sentence):
    if sentence is None:
        check_screen(environment, "linux", lambda name: library)
        return
    with pytest.raises(InputError, match=sentence):
        check_screen(environment, "linux", lambda name: library)


def test_a_passing_message_does_not_hide_a_lasting_one(qtbot):
    with tab_on(qtbot, "tcp://127.255.255.250:9", pictures=False) as tab:
        qtbot.waitUntil(lambda: tab.messages.lasting, timeout=SECONDS)
        text = tab.messages.text
        tab.session.rejected.emit("something else")
        qtbot.wait(50)
        assert tab.messages.text == text
        assert tab.messages.findChildren(QPushButton)
