"""What a discovery tells of a device."""

from dataclasses import dataclass

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
        Empty if the back end does not tell.
    """
    url: str
    address: str
    mac: str
    vendor: str
    model: str
    serial: str = ""
