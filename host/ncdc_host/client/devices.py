"""Which devices there are, and opening one by its URL."""

from urllib.parse import urlsplit

from ncdc_host.client.errors import BadUrl
from ncdc_spec.protocols.table_one import TCP_PORT

__all__ = ["SCHEMES", "discover", "open_device"]

SCHEMES = {
    "gige": "GVCP and GVSP over UDP, by viva-genicam",
    "aravis": "the same by Aravis, of the system's own Python",
    "tcp": "Table I and II of the paper over TCP",
    "usb": "the same over USB, through an FT232H, by pyftdi: usb://232h, or usb://SERIAL",
}


def discover(seconds=1.0, interface=None, back_end="gige"):
    """The devices that answer a broadcast on every interface, this machine's own included.

    Parameters
    ----------
    seconds : float
        How long to wait for answers.
    interface : str, optional
        Name or IPv4 address of the only interface to ask on.
    back_end : str
        "gige" or "aravis".

    Returns
    -------
    list of Found
        By address. Table I has no discovery of its own: of a device of ours that is found, the URL
        ``tcp://ADDRESS`` opens the same device over TCP.
    """
    if back_end == "aravis":
        from ncdc_host.client.aravis import discover_aravis
        return discover_aravis(seconds)
    from ncdc_host.client.viva import discover_viva
    return discover_viva(seconds, interface)


def open_device(url, monitor=False):
    """Open the device of a ``url``: SCHEME://ADDRESS[:PORT], a scheme of :data:`SCHEMES`.

    An address alone is taken for ``gige://``. ``monitor``: read and watch only, next to the
    user who has control. Over TCP all users are equal, and this client rejects the writes.

    Raises
    ------
    BadUrl
        If the URL is none.
    DeviceError
        If no device answers, or another user has control.
    """
    scheme, address, port = _parts(url)
    if scheme == "tcp":
        from ncdc_host.client.table import TableDevice
        return TableDevice(address, port or TCP_PORT, monitor)
    if scheme == "usb":
        from ncdc_host.client.usb import UsbDevice, UsbPort, ftdi_url
        return UsbDevice(UsbPort(ftdi_url(address)), monitor)
    if port is not None:
        raise BadUrl(f"the URL {url!r} has a port, which {scheme}:// has not")
    if scheme == "aravis":
        from ncdc_host.client.aravis import AravisDevice
        return AravisDevice(address, monitor)
    from ncdc_host.client.viva import VivaDevice
    return VivaDevice(address, monitor)


def _parts(url):
    try:
        parts = urlsplit(url if "//" in url else f"gige://{url}")
        scheme, address, port = parts.scheme, parts.hostname, parts.port
    except ValueError as error:
        raise BadUrl(f"{url!r} is no URL of a device: {error}") from None
    if scheme not in SCHEMES or not address or parts.path not in ("", "/"):
        raise BadUrl(f"{url!r} is no URL of a device: {', '.join(SCHEMES)} with an address, "
                     "as in tcp://127.0.0.2, is needed")
    return scheme, address, port
