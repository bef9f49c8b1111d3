"""One device in one window, over Ethernet and over USB at once."""

import select
import socket

import numpy as np
import pytest
from pyftdi.usbtools import UsbTools
from PySide6.QtCore import QSettings

from guis import SECONDS, announced, pixels_of, url_of
from ncdc_host.gui.main_window import MainWindow
from simulations.usb_backend import SimulatedUsb

STEP = 1        # that the chip's latency timer waits for, in ``Cable.wait``'s units


class Cable:
    """What the modelled FT232H is joined to: the Table I and II of an emulated device.

    Parameters
    ----------
    one : EmulatedDevice
    path : Path
        Where what the device has sent is stored, as :class:`SimulatedUsb` reads it.
    """

    def __init__(self, one, path):
        self._socket = socket.create_connection((one.options.address, one.table.port))
        self._path, self._count = path, 0
        path.write_bytes(b"")

    def usb_send(self, data):
        self._socket.sendall(data)

    def wait(self, steps):
        if select.select([self._socket], [], [], .002 * steps)[0]:
            data = self._socket.recv(1 << 16)
            with self._path.open("ab") as file:
                file.write(data)
            self._count += len(data)

    def usb_got(self):
        return self._path, self._count

    def close(self):
        self._socket.close()


@pytest.fixture
def joined(tmp_path, monkeypatch):
    """An emulated device, announced, and joined to the FT232H that pyftdi finds."""
    QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, str(tmp_path))
    with announced(fps=10.0) as [one]:
        cable = Cable(one, tmp_path / "sent")
        backend = SimulatedUsb(cable, STEP)
        monkeypatch.setattr(UsbTools, "_load_backend", classmethod(lambda cls: backend))
        monkeypatch.setattr(UsbTools, "UsbDevices", {})
        yield one
        cable.close()


def shown(tab):
    assert tab.shown is not None and tab.infos is not None, tab.messages.text


def test_both_show_the_same_device(joined, qtbot):
    window = MainWindow()
    qtbot.addWidget(window)
    window.resize(1100, 760)
    window.show()
    for url in (url_of(joined, "gige"), "usb://232h"):
        window.open_device(url)
    ethernet, usb = window.open_tabs()
    for tab in (ethernet, usb):
        qtbot.waitUntil(lambda tab=tab: shown(tab), timeout=SECONDS)

    # A setting made over Ethernet is read over USB, and both see what it does.
    before = pixels_of(usb.shown.image)
    ethernet.set_feature("ExposureTime", 2000.0)
    qtbot.waitUntil(lambda: abs(usb.infos["ExposureTime"].value - 2000) < 100, timeout=SECONDS)
    qtbot.waitUntil(lambda: not np.array_equal(pixels_of(usb.shown.image), before)
                    and np.array_equal(pixels_of(usb.shown.image),
                                       pixels_of(ethernet.shown.image)), timeout=SECONDS)
    assert usb.messages.text == "" and ethernet.messages.text == ""
    window.close()
    qtbot.waitUntil(lambda: not window.isVisible(), timeout=2 * SECONDS)
