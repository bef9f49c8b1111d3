"""The devices that answer, and a way to those that do not."""

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import (
    QHBoxLayout,
    QInputDialog,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QMenu,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from ncdc_host.client import Found
from ncdc_host.gui.plain_text import PlainLabel, plain_tip

__all__ = ["DevicesPanel"]

_URL = Qt.ItemDataRole.UserRole
_FOUND = Qt.ItemDataRole.UserRole + 1
_EMPTY = ("No device answers yet.\n\nIs it switched on, and in the same network as this computer? "
          "A device behind a router does not hear the broadcast: add its address below.")


class DevicesPanel(QWidget):
    """Signals ``wants(url, monitor, name)``: a device is to be opened."""
    wants, look = Signal(str, bool, str), Signal()

    def __init__(self):
        super().__init__()
        title = QLabel("<b>Devices</b>")
        self.state = PlainLabel("looking …")
        head = QHBoxLayout()
        head.addWidget(title)
        head.addStretch(1)
        head.addWidget(self.state)
        self.list = QListWidget()
        self.list.setAccessibleName("Devices that answer")
        self.list.setAlternatingRowColors(True)
        self.list.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.list.itemActivated.connect(self._activated)
        self.list.currentItemChanged.connect(self._enable)
        self.list.customContextMenuRequested.connect(self._menu)
        self.empty = PlainLabel(_EMPTY, wordWrap=True)
        QVBoxLayout(self.list.viewport()).addWidget(self.empty)
        self.empty.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.open = QPushButton("Open")
        self.open.setToolTip("Open the device that is chosen (Enter); the arrow has other ways")
        self.open.clicked.connect(lambda: self._activated(self.list.currentItem()))
        self.ways = QPushButton("Open as …")
        self.ways.clicked.connect(self._show_ways)
        again = QPushButton("Look again")
        again.setToolTip("Ask all networks for devices now (F5); it happens by itself as well")
        again.clicked.connect(self.look)
        add = QPushButton("Add address …")
        add.setToolTip("Open a device by its address (Ctrl+O)")
        add.clicked.connect(self.ask_address)
        column = QVBoxLayout(self)
        column.addLayout(head)
        column.addWidget(self.list, 1)
        for pair in ((self.open, self.ways), (again, add)):
            row = QHBoxLayout()
            for button in pair:
                row.addWidget(button)
            column.addLayout(row)
        self._found, self._opened = [], {}
        self._enable()

    def show_found(self, found):
        """Show the :class:`Found` devices; the one that was chosen stays so."""
        self._found = list(found)
        self.state.setText(f"{len(found)} found" if found else "none found")
        self._list()

    def _list(self):
        """Show the devices that were found, and those that are open all the same."""
        chosen = self.list.currentItem() and self.list.currentItem().data(_URL)
        known = {one.address for one in self._found}
        others = [Found(url, address, "", "", name) for address, (url, name) in
                  self._opened.items() if address.partition(":")[0] not in known]
        self.list.clear()
        for one in (*self._found, *others):
            item = QListWidgetItem(self._text(one))
            item.setData(_URL, one.url)
            item.setData(_FOUND, one)
            item.setSizeHint(QSize(0, 2 * self.fontMetrics().height() + 12))
            item.setToolTip(plain_tip("\n".join(filter(None, (
                one.vendor, one.model, one.serial, one.mac, one.url)))))
            self.list.addItem(item)
            if one.url == chosen:
                self.list.setCurrentItem(item)
        if self.list.count() and self.list.currentItem() is None:
            self.list.setCurrentRow(0)
        self._say(_EMPTY, not self.list.count())
        self._enable()

    def show_failed(self, text):
        """Discovery does not work at all."""
        self._found = []
        self._list()
        self._say(text[:1].upper() + text[1:] + ".", not self.list.count())
        self.state.setText("")

    def show_looking(self):
        """A broadcast is under way."""
        self.state.setText("looking …")

    def show_opened(self, opened):
        """Mark the devices that are open; those that no broadcast finds are listed for it.

        ``opened``: pairs of URL and name.
        """
        opened = {url.partition("://")[2]: (url, name) for url, name in opened}
        if opened != self._opened:
            self._opened = opened
            self._list()

    def ask_address(self):
        """Ask for a URL, and open it."""
        url, fine = QInputDialog.getText(
            self, "Add address", "Address of the device, as in 192.168.1.20; in front of it\n"
            "gige:// for GVCP and GVSP (default), tcp:// for Table I and II,\n"
            "aravis:// for GVCP and GVSP by Debian's Aravis:")
        if fine and url.strip():
            self.wants.emit(url.strip() if "://" in url else f"gige://{url.strip()}", False, "")

    def _text(self, one):
        mark = "  ·  open" if one.address in self._opened else ""
        name = " ".join(filter(None, (one.model, one.serial))) or "Device"
        return f"{name}\n{one.address}{mark}"

    def _say(self, text, seen):
        self.empty.setText(text)
        self.empty.setVisible(seen)

    def _enable(self, *_):
        for button in (self.open, self.ways):
            button.setEnabled(self.list.currentItem() is not None)

    def _activated(self, item):
        if item is not None:
            self._want(item, "gige", False)

    def _want(self, item, scheme, monitor):
        found = item.data(_FOUND)
        if found.address in self._opened and found not in self._found:
            self.wants.emit(found.url, monitor, "")         # the tab that it has already
            return
        name = " ".join(filter(None, (found.model, found.serial)))
        last = found.address.rpartition(".")[2]
        self.wants.emit(f"{scheme}://{found.address}", monitor, f"{name} .{last}")

    def ways_of(self, item):
        """A menu of the ways to open the device of ``item``."""
        menu = QMenu(self)
        for text, scheme, monitor in (
                ("Control it: GVCP and GVSP", "gige", False),
                ("Watch only, with another user in control", "gige", True),
                ("Table I and II over TCP: all users are equal", "tcp", False),
                ("GVCP and GVSP by Aravis", "aravis", False)):
            menu.addAction(text, lambda s=scheme, m=monitor: self._want(item, s, m))
        return menu

    def _menu(self, point):
        item = self.list.itemAt(point)
        if item is not None:
            self.ways_of(item).popup(self.list.viewport().mapToGlobal(point))

    def _show_ways(self):
        item = self.list.currentItem()
        self.ways_of(item).popup(self.ways.mapToGlobal(self.ways.rect().bottomLeft()))
