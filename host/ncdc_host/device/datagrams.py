"""Many UDP packets by one call of the system, where it has one (Linux, ``sendmmsg``).

Each packet stays a packet of its own. The kernel's UDP segmentation would be faster, but on a
virtual network the receiver's packet socket gets the whole buffer as one packet. Aravis reads such
sockets, and its pictures had wrong pixels then.
"""

import ctypes
import errno
import os
import socket
import struct

import numpy as np

__all__ = ["DatagramSender"]

# struct iovec, msghdr and mmsghdr of the system.
_PIECE = np.dtype([("base", np.uintp), ("bytes", np.uintp)])
_MESSAGE = np.dtype([("name", np.uintp), ("name_bytes", np.uint32), ("pieces", np.uintp),
                     ("count", np.uintp), ("control", np.uintp), ("control_bytes", np.uintp),
                     ("flags", np.int32)], align=True)
_COUNTED = np.dtype([("message", _MESSAGE), ("sent", np.uint32)], align=True)
# Too large for the line, or no receiver: lost, as on a wire.
_LOST = {errno.EMSGSIZE, errno.ECONNREFUSED, errno.ENETUNREACH, errno.EHOSTUNREACH, errno.ENOBUFS,
         errno.EINVAL, errno.EACCES, errno.EPERM}


class DatagramSender:
    """Sends packets by a UDP socket; what the system rejects is lost.

    Parameters
    ----------
    udp : socket.socket
        Of IPv4, blocking.

    Attributes
    ----------
    unreachable : bool
        Whether the machine of the last address of :meth:`connect` has answered "port unreachable".
    """
    def __init__(self, udp):
        self._socket, self.unreachable = udp, False
        self._many = getattr(ctypes.CDLL(None, use_errno=True), "sendmmsg", None)

    def connect(self, address):
        """Watch ``address`` (IPv4, port) from now on for :attr:`unreachable`."""
        try:
            # The system reports ICMP's "port unreachable" to connected sockets only.
            self._socket.connect(address)
            self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)     # of what was before
        except OSError:
            pass            # no way there: packets are lost, as on a wire
        self.unreachable = False

    def _lose(self, code):
        self.unreachable |= code == errno.ECONNREFUSED

    def send(self, parts, address):
        """Send one packet, the bytes of ``parts`` in a row, to ``address`` (IPv4, port).

        Raises
        ------
        OSError
            If the socket is closed.
        """
        try:
            self._socket.sendmsg(parts, [], 0, address)
        except OSError as error:
            if error.errno not in _LOST:
                raise
            self._lose(error.errno)

    def send_all(self, packets, address):
        """Send ``packets``, a C-contiguous uint8 array (count, bytes of each), in their order.

        Raises
        ------
        OSError
            If the socket is closed.
        """
        if self._many is None:
            for packet in packets:
                self.send([packet], address)
            return
        count, size = packets.shape
        # struct sockaddr_in
        name = np.frombuffer(struct.pack("=H", socket.AF_INET) + struct.pack(">H", address[1])
                             + socket.inet_aton(address[0]) + bytes(8), np.uint8)
        pieces = np.empty(count, _PIECE)
        pieces["base"] = packets.ctypes.data + size * np.arange(count)
        pieces["bytes"] = size
        calls = np.zeros(count, _COUNTED)
        message = calls["message"]
        message["name"], message["name_bytes"] = name.ctypes.data, name.size
        message["pieces"] = pieces.ctypes.data + _PIECE.itemsize * np.arange(count)
        message["count"] = 1
        done = 0
        while done < count:
            sent = self._many(self._socket.fileno(), ctypes.c_void_p(
                calls.ctypes.data + _COUNTED.itemsize * done), count - done, 0)
            if sent > 0:
                done += sent
            elif (code := ctypes.get_errno()) in _LOST:
                self._lose(code)
                done += 1
            elif code != errno.EINTR:
                raise OSError(code, os.strerror(code))
