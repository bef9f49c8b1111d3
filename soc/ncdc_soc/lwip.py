"""lwIP, the TCP/IP stack of the firmware: Debian's source of it, fetched once and checked."""

import hashlib
import io
import os
import tarfile
import tempfile
import urllib.request
from pathlib import Path

from ncdc_spec.errors import InputError

__all__ = ["FILES", "lwip_source"]

_URL = "http://deb.debian.org/debian/pool/main/l/lwip/lwip_2.1.3+dfsg1.orig.tar.xz"
_SHA256 = "0a8276d09fc4e97bbba2f953d74af2388fc2195ea156be9d7589e297a68fde24"
_TOP = "lwip-2.1.3"
_SECONDS = 60

FILES = tuple(f"core/{name}.c" for name in (
    "init", "def", "inet_chksum", "ip", "mem", "memp", "netif", "pbuf", "sys", "tcp", "tcp_in",
    "tcp_out", "timeouts", "udp", "ipv4/autoip", "ipv4/dhcp", "ipv4/etharp", "ipv4/icmp",
    "ipv4/ip4", "ipv4/ip4_addr")) + ("netif/ethernet.c",)
"""Files of ``src`` that are compiled."""


def lwip_source():
    """Folder ``src`` of lwIP, from ``NCDC_LWIP`` or fetched into the user's cache.

    Raises
    ------
    InputError
        If it cannot be had, or is another one.
    """
    if os.environ.get("NCDC_LWIP"):
        return Path(os.environ["NCDC_LWIP"])
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ncdc-lwip"
    folder = cache / _SHA256[:16] / _TOP / "src"
    if not folder.is_dir():
        _fetch(cache, folder.parents[1])
    return folder


def _fetch(cache, folder):
    try:
        with urllib.request.urlopen(_URL, timeout=_SECONDS) as answer:
            data = answer.read()
        if hashlib.sha256(data).hexdigest() != _SHA256:
            raise InputError(f"{_URL} is not the file that was expected: its SHA-256 differs")
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=cache) as made:
            with tarfile.open(fileobj=io.BytesIO(data)) as archive:
                archive.extractall(f"{made}/all", filter="data")
            try:
                os.rename(f"{made}/all", folder)
            except OSError:             # another process has been faster
                if not folder.is_dir():
                    raise
    except OSError as error:
        raise InputError(f"lwIP cannot be fetched from {_URL}: {error}; NCDC_LWIP may name its "
                         "folder src") from error


if __name__ == "__main__":
    print(lwip_source())
