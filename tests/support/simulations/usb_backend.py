"""A backend of PyUSB with one FT232H, whose other side is a simulated system."""

from array import array
from types import SimpleNamespace

from usb.backend import IBackend
from usb.core import USBError

__all__ = ["SimulatedUsb"]

_PACKET = 512               # bytes of a packet of high speed, two of them the chip's status
_STATUS = b"\x01\x60"       # modem status, and that the transmitter is empty
_SET_BITMODE, _GET_LATENCY, _POLL_STATUS = 0x0B, 0x0A, 0x05     # requests of FTDI's chips
_SYNC_FIFO = 0x40
_VENDOR, _PRODUCT, _RELEASE = 0x0403, 0x6014, 0x0900            # of an FT232H


class SimulatedUsb(IBackend):
    """Answers the requests of a driver of FTDI's chips, and hands bytes to a :class:`LiveSystem`.

    Time goes by in the simulation only during reads: a read that finds nothing waits for
    the time of the latency timer.

    Parameters
    ----------
    live : LiveSystem
    step : int
        Clocks of the system for which a read waits at a time.

    Attributes
    ----------
    mode : int
        Bit mode that the host has chosen.
    """

    def __init__(self, live, step=20_000):
        self.live, self.step = live, step
        self.mode = 0
        self._taken = 0             # bytes that the host has taken

    def enumerate_devices(self):
        return iter([self])

    def get_device_descriptor(self, dev):
        return SimpleNamespace(
            bLength=18, bDescriptorType=1, bcdUSB=0x0200, bDeviceClass=0, bDeviceSubClass=0,
            bDeviceProtocol=0, bMaxPacketSize0=64, idVendor=_VENDOR, idProduct=_PRODUCT,
            bcdDevice=_RELEASE, iManufacturer=0, iProduct=0, iSerialNumber=0, bNumConfigurations=1,
            address=1, bus=1, port_number=1, port_numbers=(1,), speed=3)

    def get_configuration_descriptor(self, dev, config):
        return SimpleNamespace(
            bLength=9, bDescriptorType=2, wTotalLength=32, bNumInterfaces=1,
            bConfigurationValue=1, iConfiguration=0, bmAttributes=0x80, bMaxPower=45,
            extra_descriptors=[])

    def get_interface_descriptor(self, dev, intf, alt, config):
        if alt:
            raise IndexError
        return SimpleNamespace(
            bLength=9, bDescriptorType=4, bInterfaceNumber=0, bAlternateSetting=0,
            bNumEndpoints=2, bInterfaceClass=255, bInterfaceSubClass=255, bInterfaceProtocol=255,
            iInterface=0, extra_descriptors=[])

    def get_endpoint_descriptor(self, dev, ep, intf, alt, config):
        return SimpleNamespace(
            bLength=7, bDescriptorType=5, bEndpointAddress=(0x81, 0x02)[ep], bmAttributes=2,
            wMaxPacketSize=_PACKET, bInterval=0, bRefresh=0, bSynchAddress=0,
            extra_descriptors=[])

    def open_device(self, dev):
        return self

    def close_device(self, dev_handle):
        pass

    def set_configuration(self, dev_handle, config_value):
        pass

    def get_configuration(self, dev_handle):
        return 1

    def claim_interface(self, dev_handle, intf):
        pass

    def release_interface(self, dev_handle, intf):
        pass

    def is_kernel_driver_active(self, dev_handle, intf):
        return False

    def ctrl_transfer(self, dev_handle, bmRequestType, bRequest, wValue, wIndex, data, timeout):
        if bmRequestType & 0x80:
            answer = {_GET_LATENCY: b"\x02", _POLL_STATUS: _STATUS}.get(bRequest, bytes(len(data)))
            data[:] = array("B", answer[:len(data)])
            return len(data)
        if bRequest == _SET_BITMODE:
            self.mode = wValue >> 8
        return len(data)

    def bulk_write(self, dev_handle, ep, intf, data, timeout):
        if self.mode != _SYNC_FIFO:
            raise USBError("the FIFO is not in its synchronous mode")
        self.live.usb_send(bytes(data))
        return len(data)

    def bulk_read(self, dev_handle, ep, intf, buff, timeout):
        if self.mode == _SYNC_FIFO:
            self.live.wait(self.step)
        path, count = self.live.usb_got()
        packets = -(-len(buff) // _PACKET)
        take = min(count - self._taken, len(buff) - 2 * packets)
        with path.open("rb") as file:
            file.seek(self._taken)
            data = file.read(take)
        self._taken += len(data)
        size = _PACKET - 2
        whole = b"".join(_STATUS + data[k:k + size] for k in range(0, max(1, len(data)), size))
        buff[:len(whole)] = array("B", whole)
        return len(whole)
