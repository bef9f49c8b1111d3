"""Table I and II over TCP: several users at once, each request atomic."""

import socket
import threading

from ncdc_host.device.registers import Refused
from ncdc_spec.protocols import table_one
from ncdc_spec.protocols.features import system_word
from ncdc_spec.protocols.table_one import MRAW, READ, REQUEST, RESERVED, UNKNOWN, WRITE
from ncdc_spec.protocols.table_two import MrawHeader
from ncdc_spec.protocols.table_users import Users

__all__ = ["TableServer"]

_NUMBER = (system_word("NUMBER_UPPER"), system_word("NUMBER_LOWER"))


class TableServer:
    """Listens on (``address``, ``port``); :attr:`port` is the one in use, if 0 was asked for."""
    def __init__(self, registers, camera, address, port):
        self._registers, self._camera, self._address = registers, camera, address
        listener = socket.create_server((address, port), backlog=table_one.MAX_USERS)
        self.port = listener.getsockname()[1]
        self._users = Users(listener, table_one.MAX_USERS, table_one.IDLE_SECONDS,
                            {READ, WRITE}, self._answer)
        threading.Thread(target=self._users.serve, daemon=True).start()

    def close(self):
        """End listening and every connection."""
        self._users.close()

    def _answer(self, user, code, rest):
        """Answer one request; false when the connection is to end."""
        if code in (READ, WRITE):
            _, address, value = REQUEST.unpack(bytes([code]) + rest)
            if code == WRITE:
                value = self._write(address, value)
            elif address in _NUMBER:
                value = user.frame >> (16 if address == _NUMBER[0] else 0) & 0xFFFF
            else:
                value = self._registers.read(address)
            user.send(REQUEST.pack(code, address, value))
        elif code == MRAW:
            frame = self._camera.newest()
            header = MrawHeader(*frame.size, frame.pixel_format, self._address, self.port,
                                frame.time_ns // 1000)
            user.frame = frame.number
            user.send(header.pack())
            user.send(frame.data)
        elif code != RESERVED:
            user.send(bytes([UNKNOWN, code]))
            return False
        return True

    def _write(self, address, value):
        """Write, and the word as read back."""
        with self._registers.lock:
            try:
                self._registers.write(address, value)
            except Refused:
                pass        # the answer says so: it differs from the request
            return self._registers.read(address)
