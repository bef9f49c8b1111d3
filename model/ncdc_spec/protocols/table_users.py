"""Table I over TCP: users at once, how long each may take, and the answers.

Needs nothing but Python: the project of a board with Linux has a copy of this file.
"""

import socket
import threading
import time

__all__ = ["TableServer", "User", "Users", "mraw_header"]

_REST = 4                   # bytes of a long request after its code: address and value
_SEND_SECONDS = 10          # a user that takes no whole answer in this time is disconnected
_MRAW_BYTES = 4, 4, 1, 7, 4, 4, 4       # of the fields of Table II


def mraw_header(values):
    """Bytes of the header of Table II, from the values of its fields in their order."""
    return b"".join(value.to_bytes(count, "big") for value, count in zip(values, _MRAW_BYTES))


class User:
    """One connection.

    Parameters
    ----------
    connection : socket

    Attributes
    ----------
    requests : file
        Bytes that the user sends.
    frame : int
        Number of the frame that the user received last.
    heard : float
        Time of the last whole request.
    busy : bool
        Whether a request is being answered.
    """
    def __init__(self, connection):
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket, self.requests = connection, connection.makefile("rb")
        self.frame, self.heard, self.busy = 0, time.monotonic(), False

    def send(self, data):
        """Send ``data``; raises :class:`OSError` if the user does not take it in time."""
        self.socket.settimeout(_SEND_SECONDS)
        self.socket.sendall(data)
        self.socket.settimeout(None)        # waiting for a request has no limit

    def hang_up(self):
        """End the connection; whatever waits for it ends as well."""
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass


class Users:
    """Serves the users of a listening socket, a thread each.

    If all positions are taken, a new user gets that of the user that has been silent longest, at
    least ``idle_seconds``; otherwise the new connection is closed.

    Parameters
    ----------
    listener : socket
    limit : int
        Connections at once.
    idle_seconds : float
    long_codes : set of int
        Codes that four more bytes follow.
    answer : callable
        ``answer(user, code, rest)`` answers the request of the byte ``code`` and those that follow
        it; false ends the connection.
    """
    def __init__(self, listener, limit, idle_seconds, long_codes, answer):
        self._listener, self._limit, self._answer = listener, limit, answer
        self._idle_seconds, self._long_codes = idle_seconds, long_codes
        self._users, self._lock = set(), threading.Lock()

    def serve(self):
        """Serve until :meth:`close`."""
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            with self._lock:
                user = self._admit(connection)
            if user is None:
                connection.close()
            else:
                threading.Thread(target=self._serve, args=(user,), daemon=True).start()

    def close(self):
        """End listening and every connection."""
        try:
            self._listener.shutdown(socket.SHUT_RDWR)   # closing alone leaves accept() waiting
        except OSError:
            pass
        self._listener.close()
        with self._lock:
            users = list(self._users)
        for user in users:
            user.hang_up()

    def _admit(self, connection):
        if len(self._users) >= self._limit:
            silent = [user for user in self._users if not user.busy and
                      time.monotonic() - user.heard >= self._idle_seconds]
            if not silent:
                return None
            oldest = min(silent, key=lambda user: user.heard)
            self._users.discard(oldest)
            oldest.hang_up()
        try:
            user = User(connection)
        except OSError:
            return None         # the user has gone already
        self._users.add(user)
        return user

    def _serve(self, user):
        try:
            with user.socket, user.requests:
                going_on = True
                while going_on and (code := user.requests.read(1)):
                    count = _REST if code[0] in self._long_codes else 0
                    rest = user.requests.read(count)
                    if len(rest) < count:
                        break
                    user.busy = True
                    going_on = self._answer(user, code[0], rest)
                    user.busy, user.heard = False, time.monotonic()
        except OSError:
            pass
        finally:
            with self._lock:
                self._users.discard(user)


class TableServer:
    """Listens on (``address``, ``port``), and answers by three methods of a subclass: ``read``,
    ``write`` and ``package``.

    Parameters
    ----------
    address : str
    port : int
        0 for any free one; :attr:`port` is the one in use.
    table : dict
        "users" at once, "idle_seconds" of the oldest that gives way, "codes" by the names READ,
        WRITE, RESERVED and MRAW, and the code "unknown".
    lock : context manager
        Held while a word is written and read.

    Raises
    ------
    OSError
        If there is no such address, or the port is taken.
    """

    def __init__(self, address, port, table, lock):
        listener = socket.create_server((address, port), backlog=table["users"])
        self.port = listener.getsockname()[1]
        self._codes = {code: name for name, code in table["codes"].items()}
        self._unknown, self._lock = table["unknown"], lock
        self._users = Users(listener, table["users"], table["idle_seconds"],
                            {table["codes"]["READ"], table["codes"]["WRITE"]}, self._answer)

    def read(self, user, address):
        """The word at ``address``."""
        raise NotImplementedError

    def write(self, address, value):
        """Write a word, if it can be written; the answer holds what is read back."""
        raise NotImplementedError

    def package(self, user):
        """The parts of the newest picture's package, with ``user.frame`` set; None ends the
        connection."""
        raise NotImplementedError

    def serve(self):
        """Serve until :meth:`close`."""
        self._users.serve()

    def close(self):
        """End listening and every connection."""
        self._users.close()

    def _answer(self, user, code, rest):
        """Answer one request; false when the connection is to end."""
        name = self._codes.get(code)
        if name in ("READ", "WRITE"):
            address, value = (int.from_bytes(rest[k:k + 2], "big") for k in (0, 2))
            with self._lock:
                if name == "WRITE":
                    self.write(address, value)
                value = self.read(user, address)
            user.send(bytes([code]) + rest[:2] + value.to_bytes(2, "big"))
        elif name == "MRAW":
            package = self.package(user)
            for part in package or ():
                user.send(part)
            return package is not None
        elif name != "RESERVED":
            user.send(bytes([self._unknown, code]))
            return False
        return True
