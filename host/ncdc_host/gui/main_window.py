"""The window: devices at the left, a tab for each that is open."""

from operator import attrgetter

from PySide6.QtCore import QSettings, QSize, Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import (
    QInputDialog,
    QLabel,
    QMainWindow,
    QSplitter,
    QStackedWidget,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from ncdc_host.gui.about import about_box
from ncdc_host.gui.device_tab import DeviceTab
from ncdc_host.gui.devices_panel import DevicesPanel
from ncdc_host.gui.live_source import LiveSource
from ncdc_host.gui.picture_view import MODES
from ncdc_host.gui.plain_text import plain_tip

__all__ = ["MainWindow"]

_SIZE = 1280, 820
_DEVICES = 200          # width of the list of devices
# Width, in pixels of the desktop's scale, from which on there is space for each panel by itself.
_WIDE = {"devices": 1040, "settings": 860}
# Of the device's views: menu entry and key.
_LAYOUTS = {"Single": ("&One view", "Ctrl+1"), "Quad": ("Fo&ur views", "Ctrl+2"),
            "Detail": ("Overview and &detail", "Ctrl+3")}
_END = 3.0              # seconds that devices may take to give control back at the end
_MARKS = {"open": "", "watching": " (watching)", "waiting": " …", "trouble": " !"}
_WELCOME = """<h2>NCDC</h2>
<p>Open a device of the list: a double click, or Enter.</p>
<p>No camera yet? <code>ncdc client gui --demo</code> brings two emulated ones.</p>"""


class MainWindow(QMainWindow):
    """Opens devices in tabs.

    Parameters
    ----------
    discovery : Discovery, optional
        None: the list stays empty.
    """
    def __init__(self, discovery=None):
        super().__init__()
        self.setWindowTitle("NCDC")
        self._wide = None           # widths of _WIDE that the window has reached
        self.resize(QSize(*_SIZE).boundedTo(self.screen().availableSize()))
        self.discovery, self._ending = discovery, []
        self.devices, self.tabs = DevicesPanel(), QTabWidget(tabsClosable=True, movable=True,
                                                             documentMode=True)
        self.welcome = QLabel(_WELCOME, alignment=Qt.AlignmentFlag.AlignCenter, wordWrap=True)
        self.middle = QStackedWidget()
        empty = QWidget()
        QVBoxLayout(empty).addWidget(self.welcome)
        self.middle.addWidget(empty)
        self.middle.addWidget(self.tabs)
        splitter = QSplitter()
        splitter.addWidget(self.devices)
        splitter.addWidget(self.middle)
        splitter.setStretchFactor(1, 1)
        splitter.setSizes([_DEVICES, _SIZE[0] - _DEVICES])
        splitter.setCollapsible(1, False)
        self.setCentralWidget(splitter)
        self.devices.wants.connect(self.open_device)
        self.tabs.tabCloseRequested.connect(self.close_tab)
        self.tabs.currentChanged.connect(self._enable)
        self._make_menus()
        self.statusBar().setSizeGripEnabled(True)
        if discovery is None:
            self.devices.state.clear()
        else:
            discovery.found.connect(self.devices.show_found)
            discovery.failed.connect(self.devices.show_failed)
            discovery.looking.connect(self.devices.show_looking)
            self.devices.look.connect(discovery.again)
            discovery.start()
        geometry = QSettings().value("geometry")
        if geometry is not None:
            self.restoreGeometry(geometry)
        self._enable()

    # Menus.

    def _make_menus(self):
        bar = self.menuBar()
        self.of_tab = []            # (action, what DeviceTab.can is asked; "" of any tab)
        menu = bar.addMenu("&Device")
        self._add(menu, "&Look for devices", "F5", self.devices.look.emit)
        self._add(menu, "&Add address …", "Ctrl+O", self.devices.ask_address)
        menu.addSeparator()
        self._add_of_tab(menu, "Load &lens file …", "Ctrl+L", "loader.ask")
        self._add_of_tab(menu, "&Calibrate from this picture …", "Ctrl+K", "loader.calibrate")
        self._add_of_tab(menu, "Calibrate li&ve …", "Ctrl+Shift+K", "loader.calibrate_live")
        self._add(menu, "Calibrate a camera of this &PC or a film …", "Ctrl+Shift+P",
                  self.ask_source)
        menu.addSeparator()
        self.of_tab.append((self._add(menu, "&Close tab", QKeySequence.StandardKey.Close,
                                      lambda: self.close_tab(self.tabs.currentIndex())), ""))
        self._add(menu, "&Quit", QKeySequence.StandardKey.Quit, self.close)
        menu = bar.addMenu("&Picture")
        self._add_of_tab(menu, "&Save picture …", QKeySequence.StandardKey.Save,
                         "files.ask_picture")
        self._add_of_tab(menu, "Save &raw frame …", "Ctrl+Shift+S", "files.ask_raw")
        self._add_of_tab(menu, "&Copy", QKeySequence.StandardKey.Copy, "files.copy")
        menu.addSeparator()
        self._add_of_tab(menu, "&Freeze", "Space", "freeze")
        self._add_of_tab(menu, "Take ra&w frame again", "R", "take_again")
        menu = bar.addMenu("&View")
        for k, mode in enumerate(MODES, 1):
            self.of_tab.append((self._add(menu, f"&{k} {mode.capitalize()}", str(k),
                                          lambda mode=mode: self.tab.set_mode(mode)), mode))
        menu.addSeparator()
        for text, key, act in (
                ("&Larger", "+", lambda: self.tab.view.zoom_in()),
                ("&Smaller", "-", lambda: self.tab.view.zoom_out()),
                ("As large as the &window", "F", lambda: self.tab.view.fit()),
                ("1:&1", "0", lambda: self.tab.view.set_scale(1))):
            self.of_tab.append((self._add(menu, text, key, act), "zoom"))
        menu.addSeparator()
        self._add_of_tab(menu, "&Move the device's view", "V", "steering.toggle")
        self._add_of_tab(menu, "&Reset the device's view", "Home", "steering.reset")
        for layout, (text, key) in _LAYOUTS.items():
            self.of_tab.append((self._add(menu, text, key, lambda layout=layout:
                                          self.tab.steering.show(layout)), "steering.show"))
        menu.addSeparator()
        self.panels = {}
        for name, text, key in (("devices", "&Devices", "F8"), ("settings", "S&ettings", "F9")):
            action = self.panels[name] = QAction(text, self, checkable=True, checked=True)
            action.setShortcut(QKeySequence(key))
            action.toggled.connect(self._show_panels)
            menu.addAction(action)
        self._add(menu, "F&ull screen", "F11", self._full_screen)
        self._add(menu, "&Next tab", QKeySequence.StandardKey.NextChild, self._next_tab)
        menu = bar.addMenu("&Help")
        self._add(menu, "&About NCDC", "F1", self.about)

    def _add(self, menu, text, key, act):
        action = QAction(text, self)
        action.setShortcut(QKeySequence(key))
        action.triggered.connect(lambda _=False: act())
        menu.addAction(action)
        return action

    def _add_of_tab(self, menu, text, key, name):
        act = attrgetter(name)
        self.of_tab.append((self._add(menu, text, key, lambda: act(self.tab)()), name))

    def _enable(self, *_):
        for action, asked in self.of_tab:
            action.setEnabled(self.tab is not None and (not asked or self.tab.can(asked)))
        self.middle.setCurrentIndex(int(self.tabs.count() > 0))
        self._show_panels()
        self.devices.show_opened((tab.url, tab.name) for tab in self.open_tabs())
        self.setWindowTitle(f"{self.tab.name} - NCDC" if self.tab is not None else "NCDC")

    def _next_tab(self):
        if self.tabs.count():
            self.tabs.setCurrentIndex((self.tabs.currentIndex() + 1) % self.tabs.count())

    def _full_screen(self):
        self.setWindowState(self.windowState() ^ Qt.WindowState.WindowFullScreen)

    def about(self):
        """Show the versions of the program and its parts; returns the box."""
        box = about_box(self)
        box.open()
        return box

    def ask_source(self):
        """Ask for a camera of this PC or a film, and calibrate it live."""
        name, fine = QInputDialog.getText(
            self, "Calibrate live", "camera:0 is the first camera of this PC; or the path of a "
            "film:", text="camera:0")
        if fine and name.strip():
            self.calibrate_source(name.strip())

    def calibrate_source(self, name):
        """Calibrate a camera of this PC or a film live; returns the :class:`LiveSource`."""
        self.live = LiveSource(name, self)
        return self.live

    # Panels at the sides.

    def _show_panels(self, *_):
        # Without a device there is nothing else to do than to choose one.
        self.devices.setVisible(self.panels["devices"].isChecked() or not self.tabs.count())
        for tab in self.open_tabs():
            tab.panel.setVisible(self.panels["settings"].isChecked())

    def resizeEvent(self, event):
        """Hide panels if the window becomes too narrow, show them if it becomes wide again.

        In between, the user's own choice stays.
        """
        super().resizeEvent(event)
        wide = {name: self.width() >= width for name, width in _WIDE.items()}
        for name, is_wide in wide.items():
            if self._wide is None or is_wide != self._wide[name]:
                self.panels[name].setChecked(is_wide)
        self._wide = wide

    # Tabs.

    @property
    def tab(self):
        """The :class:`DeviceTab` in front, or None."""
        return self.tabs.currentWidget()

    def open_tabs(self):
        """All of them."""
        return [self.tabs.widget(k) for k in range(self.tabs.count())]

    def open_device(self, url, monitor=False, name=""):
        """A tab for the device of ``url``: the one there is, or a new one."""
        for tab in self.open_tabs():
            if tab.url == url and tab.session.monitor == monitor:
                self.tabs.setCurrentWidget(tab)
                return tab
        tab = DeviceTab(url, name, monitor)
        tab.titled.connect(self._titled)
        tab.wants.connect(self._instead)
        tab.said.connect(self._say)
        tab.enabled.connect(self._enable)
        tab.panel.setVisible(self.panels["settings"].isChecked())
        self.tabs.setCurrentIndex(self.tabs.addTab(tab, tab.name))
        self.tabs.setTabToolTip(self.tabs.indexOf(tab), plain_tip(url))
        self._enable()
        return tab

    def close_tab(self, index):
        """Close a tab; its device is given back in the background."""
        tab = self.tabs.widget(index)
        if tab is None:
            return
        self.tabs.removeTab(index)
        self._end(tab)
        self._enable()

    def _end(self, tab):
        self._ending.append(tab)
        tab.session.closed.connect(self._ended)
        tab.loader.close_dialog()
        tab.hide()
        tab.session.close()

    def _ended(self):
        session = self.sender()
        for tab in [tab for tab in self._ending if tab.session is session]:
            self._ending.remove(tab)
            tab.deleteLater()

    def _instead(self, url, monitor):
        tab = self.sender()
        name = tab.name
        self.close_tab(self.tabs.indexOf(tab))
        self.open_device(url, monitor, name)

    def _titled(self, name, tip, state):
        index = self.tabs.indexOf(self.sender())
        if index >= 0:
            scheme = tip.partition("://")[0]
            how = "" if scheme == "gige" else f" ({scheme})"
            self.tabs.setTabText(index, name + how + _MARKS[state])
            self._enable()

    def _say(self, text):
        self.statusBar().showMessage(text, 8000)

    def closeEvent(self, event):
        QSettings().setValue("geometry", self.saveGeometry())
        self.hide()
        if self.discovery is not None:
            self.discovery.close()
        while self.tabs.count():
            self.close_tab(0)
        # The window is gone from the screen: devices may take a moment to give control back.
        for tab in self._ending:
            tab.session.wait(_END)
        if self.discovery is not None:
            self.discovery.wait(_END)
        event.accept()
