"""A device as a discovery reports it."""

from dataclasses import dataclass

from ncdc_host.client.errors import printable

__all__ = ["Found"]


@dataclass(frozen=True)
class Found:
    """A device that answered a discovery.

    Parameters
    ----------
    url : str
        To open it by.
    address : str
        Its IPv4 address.
    mac, vendor, model : str
    serial : str
        Empty if the back end does not report it.

    Texts of the device have escapes for what would change a terminal.
    """
    url: str
    address: str
    mac: str
    vendor: str
    model: str
    serial: str = ""

    def __post_init__(self):
        for name in ("mac", "vendor", "model", "serial"):
            object.__setattr__(self, name, printable(getattr(self, name)))
