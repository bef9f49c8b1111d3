"""Table I and II over TCP: several users at once, each request atomic."""

import socket
import threading

from ncdc_host.device.registers import Refused
from ncdc_model.interface.features import system_word
from ncdc_model.interface.table_one import MAX_USERS, MRAW, READ, REQUEST, RESERVED, UNKNOWN, WRITE
from ncdc_model.interface.table_two import MrawHeader

__all__ = ["TableServer"]

_SEND_SECONDS = 10      # a user who takes nothing for so long is disconnected
_NUMBER = (system_word("NUMBER_UPPER"), system_word("NUMBER_LOWER"))


class TableServer:
    """Listens on (``address``, ``port``); :attr:`port` tells which, if 0 was asked for.

    One thread a connection; a connection beyond :data:`MAX_USERS` is closed at once.
    """
    def __init__(self, registers, camera, address, port):
        self._registers, self._camera, self._address = registers, camera, address
        self._socket = socket.create_server((address, port), backlog=MAX_USERS)
        self.port = self._socket.getsockname()[1]
        self._users = set()
        self._lock = threading.Lock()
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self):
        """End listening and every connection."""
        # Closing alone would leave accept() waiting.
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._socket.close()
        with self._lock:
            users = list(self._users)
        for user in users:
            _hang_up(user)

    def _accept(self):
        while True:
            try:
                user, _ = self._socket.accept()
            except OSError:
                return
            with self._lock:
                full = len(self._users) >= MAX_USERS
                if not full:
                    self._users.add(user)
            if full:
                user.close()
                continue
            user.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            threading.Thread(target=self._serve, args=(user,), daemon=True).start()

    def _serve(self, user):
        last = [0]      # number of the frame that this user received last
        try:
            with user, user.makefile("rb") as requests:
                while self._answer(user, requests, last):
                    pass
        except OSError:
            pass
        finally:
            with self._lock:
                self._users.discard(user)

    def _answer(self, user, requests, last):
        """Serve one request; false when the connection is to end."""
        code = requests.read(1)
        if not code:
            return False
        if code[0] in (READ, WRITE):
            rest = requests.read(REQUEST.size - 1)
            if len(rest) < REQUEST.size - 1:
                return False
            _, address, value = REQUEST.unpack(code + rest)
            if code[0] == WRITE:
                value = self._write(address, value)
            elif address in _NUMBER:
                value = last[0] >> (16 if address == _NUMBER[0] else 0) & 0xFFFF
            else:
                value = self._registers.read(address)
            _send(user, REQUEST.pack(code[0], address, value))
        elif code[0] == MRAW:
            frame = self._camera.newest()
            header = MrawHeader(*frame.size, frame.pixel_format, self._address, self.port,
                                frame.time_ns // 1000)
            last[0] = frame.number
            _send(user, header.pack())
            _send(user, frame.data)
        elif code[0] != RESERVED:
            _send(user, bytes([UNKNOWN, code[0]]))
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


def _send(user, data):
    # Reading may wait for ever, sending may not.
    user.settimeout(_SEND_SECONDS)
    user.sendall(data)
    user.settimeout(None)


def _hang_up(user):
    try:
        user.shutdown(socket.SHUT_RDWR)
    except OSError:
        pass
