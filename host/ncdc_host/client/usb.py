"""Devices over USB through an FT232H: Table I and II, and registers, by pyftdi."""

import time

from ncdc_host.client.errors import DeviceError, DeviceGone, NoFrame, NotInstalled
from ncdc_host.client.table import Connection, TableDevice, TableStream
from ncdc_spec.needs import pip_line

__all__ = ["UsbConnection", "UsbDevice", "UsbPort", "ftdi_url"]

_SECONDS = 5.0              # that an answer may take
_CHUNK = 64 * 1024          # bytes of a transfer
_LATENCY_MS = 2             # after which the chip sends a packet that is not full


class UsbPort:
    """The bytes of an FT232H in 245 synchronous FIFO mode; a file for the driver's ``Serial``.

    Parameters
    ----------
    url : str, optional
        URL of pyftdi, "ftdi://ftdi:232h/1" if absent.
    device : usb.core.Device, optional
        Instead of ``url``.
    timeout : float
        Seconds after which :meth:`read` returns fewer bytes.

    Raises
    ------
    DeviceGone
        If there is no such chip.
    NotInstalled
        If pyftdi is missing.
    """

    def __init__(self, url=None, device=None, timeout=_SECONDS):
        try:
            from pyftdi.ftdi import Ftdi, FtdiError
            from pyftdi.usbtools import UsbToolsError
        except ImportError as error:
            raise NotInstalled("pyftdi is not installed, which usb:// needs: "
                               f"{pip_line('usb')}") from error
        self.name, self.timeout = url or "ftdi://ftdi:232h/1", timeout
        self._error = FtdiError
        self._ftdi = Ftdi()
        try:
            if device is None:
                self._ftdi.open_from_url(self.name)
            else:
                self._ftdi.open_from_device(device)
            self._ftdi.set_bitmode(0xFF, Ftdi.BitMode.RESET)
            self._ftdi.set_bitmode(0xFF, Ftdi.BitMode.SYNCFF)
            self._ftdi.set_latency_timer(_LATENCY_MS)
            self._ftdi.read_data_set_chunksize(_CHUNK)
            self._ftdi.write_data_set_chunksize(_CHUNK)
        except (FtdiError, UsbToolsError, OSError, ValueError) as error:
            raise DeviceGone(f"no FT232H answers at {self.name}: {error}") from error

    def read(self, size):
        """So many bytes, or fewer if none comes for :attr:`timeout` seconds."""
        data, until = bytearray(), time.monotonic() + self.timeout
        while len(data) < size and time.monotonic() < until:
            try:
                more = self._ftdi.read_data_bytes(size - len(data), attempt=1)
            except self._error as error:
                raise DeviceGone(f"{self.name} does not answer any more: {error}") from error
            if more:
                data += more
                until = time.monotonic() + self.timeout
        return bytes(data)

    def write(self, data):
        """Send bytes."""
        try:
            self._ftdi.write_data(data)
        except self._error as error:
            raise DeviceGone(f"{self.name} does not answer any more: {error}") from error

    def close(self):
        """Give the chip back."""
        self._ftdi.close()


class UsbConnection(Connection):
    """Table I and II over a :class:`UsbPort`; members as of :class:`Connection`.

    Parameters
    ----------
    port : UsbPort
    """

    def __init__(self, port, timeout=_SECONDS):
        super().__init__(None, None, timeout, transport=port)
        self.name = port.name

    def _send(self, data):
        self._socket.write(data)

    def _receive(self, count, until):
        self._socket.timeout = max(.001, until - time.monotonic())
        data = self._socket.read(count)
        if len(data) < count:
            raise NoFrame(f"{self.name} sent {len(data)} of {count} bytes in time")
        return bytearray(data)


class UsbDevice(TableDevice):
    """See :class:`TableDevice`: settings and pictures share the one connection there is, so that a
    setting waits for the end of a picture. Of the settings only the source of the pictures can be
    written.

    Parameters
    ----------
    port : UsbPort
    monitor : bool
    """

    def __init__(self, port, monitor=False):
        self._open(port.name.replace("ftdi://ftdi:", "usb://").removesuffix("/1"),
                   UsbConnection(port), monitor)

    def stream(self, packet_size=None, multicast=None):
        if multicast is not None:
            raise DeviceError("USB has no multicast")
        return _UsbStream(self, self._connection)


class _UsbStream(TableStream):
    """Pictures over a connection that stays open after them."""

    def close(self):
        pass


def ftdi_url(address):
    """pyftdi's URL of the chip of an address: "232h", the first FT232H, or a serial number."""
    chip = "232h" if address == "232h" else f"232h:{address}"
    return f"ftdi://ftdi:{chip}/1"
