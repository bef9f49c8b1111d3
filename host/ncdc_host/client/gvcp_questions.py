"""Questions to the device at one address, by GVCP: who it is, and what its XML says."""

import re
import socket
import struct
import time

from ncdc_host.client.errors import DeviceError, DeviceGone
from ncdc_host.client.xml_check import XML_BYTES_MAX
from ncdc_spec.protocols import gvcp

__all__ = ["Questions"]

_TRIES = 3
_DATAGRAM = 2048
_BLOCK = 512            # bytes of memory that are read at a time
_URL = re.compile(r"local:(?:///)?([^;]*);(?:0x)?([0-9a-f]+);(?:0x)?([0-9a-f]+)", re.IGNORECASE)


class Questions:
    """A socket that asks one device, as a context; no broadcast, so that routers let it through.

    Parameters
    ----------
    address : str
    seconds : float
        To wait for each of three tries.

    Attributes
    ----------
    address : str
        IPv4 address of the device.
    own_address : str
        IPv4 address of this machine that the device sees.

    Raises
    ------
    DeviceGone
        If there is no such address, or no way to it.
    """
    def __init__(self, address, seconds=1.0):
        self._seconds, self._number = seconds, 0
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            # Connected, it receives from that device alone.
            self._socket.connect((address, gvcp.PORT))
        except OSError as error:
            self._socket.close()
            raise DeviceGone(f"no device answers at {address}: "
                             f"{error.strerror or error}") from error
        self.address = self._socket.getpeername()[0]
        self.own_address = self._socket.getsockname()[0]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._socket.close()

    def ask(self, code, payload=b""):
        """The payload of the answer to a command.

        Raises
        ------
        DeviceGone
            If no device answers.
        DeviceError
            If the answer is another status than success.
        """
        self._number = self._number % 0xFFFF + 1
        packet = gvcp.command_packet(code, self._number, payload)
        for _ in range(_TRIES):
            answer = self._answer(packet)
            if answer is None:
                continue
            status, code_answered, _, rest = answer
            if code_answered == code + 1 and status == gvcp.SUCCESS:
                return rest
            raise DeviceError(f"{self.address} answers the command 0x{code:04X} by the status "
                              f"0x{status:04X}")
        raise DeviceGone(f"no device answers at {self.address}")

    def _answer(self, packet):
        """The answer to the present number; None if it does not come in time."""
        until = time.monotonic() + self._seconds
        try:
            self._socket.send(packet)
            while (left := until - time.monotonic()) > 0:
                self._socket.settimeout(left)
                answer = gvcp.parse_acknowledge(self._socket.recv(_DATAGRAM))
                if answer is None or answer[2] != self._number:
                    continue
                if answer[1] != gvcp.PENDING_ACK:
                    return answer
                until = time.monotonic() + gvcp.PENDING_MS / 1000
        except TimeoutError:
            pass
        except OSError:             # no device listens there now: perhaps later
            time.sleep(max(0, min(0.1, until - time.monotonic())))
        return None

    def discovery(self):
        """The bytes of a discovery acknowledge."""
        found = self.ask(gvcp.DISCOVERY)
        if len(found) < gvcp.DISCOVERY_BYTES:
            raise DeviceError(f"{self.address} answers a discovery by {len(found)} bytes, "
                              f"{gvcp.DISCOVERY_BYTES} are needed")
        return found

    def memory(self, address, count):
        """``count`` bytes of the device's memory from ``address`` on."""
        data = bytearray()
        while len(data) < count:
            size = min(_BLOCK, -(-(count - len(data)) // 4) * 4)
            part = self.ask(gvcp.READMEM, struct.pack(">IHH", address + len(data), 0, size))[4:]
            if len(part) != size:
                raise DeviceError(f"{self.address} answers {len(part)} bytes of memory where "
                                  f"{size} were asked for")
            data += part
        return bytes(data[:count])

    def xml(self):
        """The bytes of the device's XML, perhaps packed.

        Raises
        ------
        DeviceError
            If it is not in the device's memory, or has more than 16 MB.
        """
        url = gvcp.register("FirstUrl")
        text = self.memory(url.address, url.length).partition(b"\0")[0].decode("latin-1")
        match = _URL.match(text)
        if match is None:
            raise DeviceError(f"the XML of {self.address} is not in its memory but at {text!r}")
        address, count = int(match[2], 16), int(match[3], 16)
        if count > XML_BYTES_MAX or address + count > 1 << 32:
            raise DeviceError(f"the XML of {self.address} has {count} bytes, {XML_BYTES_MAX} is "
                              "the limit")
        return self.memory(address, count)
