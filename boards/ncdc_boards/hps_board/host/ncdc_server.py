"""Gives settings and pictures to a network, as root: python3 ncdc_server.py ADDRESS [UIO]

It speaks Table I and II over TCP, the protocols of ``ncdc client`` (URL tcp://ADDRESS), needs
nothing but Python and the files beside it, and sets the board up first.
"""

import socket
import sys
import threading
import time

from ncdc_board import open_board
from ncdc_camera import CameraError

__all__ = ["TableServer"]

_READER = 1                 # of the frame stores; 0 is left to other programs
_SEND_SECONDS = 10          # a user who takes nothing for so long is disconnected
_FRAME_SECONDS = 10         # so long without a frame, and whoever asked is disconnected
_LOOK_SECONDS = .002        # from look to look for a frame
_NUMBERS = 1 << 32          # of frames: they are counted modulo this


class TableServer:
    """Listens on (``address``, ``port``); :attr:`port` tells which, if 0 was asked for.

    One thread a connection; a connection beyond the largest number is closed at once.

    Parameters
    ----------
    board : ncdc_board.Board
        Which has been started.
    frames : buffer
        The memory of its frames, from the first one's place on.
    address : str
    port : int, optional
        That of Table I if absent.

    Raises
    ------
    OSError
        If there is no such address, or the port is taken.
    """

    def __init__(self, board, frames, address, port=None):
        self.camera, self.frames, self.settings = board.camera, frames, board.settings
        self.table = board.settings["table"]
        self.sensor, self.formats = board.settings["sensor"], board.settings["formats"]
        self._names = {code: name for name, code in self.table["words"].items()}
        self._corrected = True
        self._first = self.camera.get("RAW_BEGUN") + 1      # frame that has all that was written
        self._device = threading.Lock()                     # of the camera's registers
        self._users, self._lock = set(), threading.Lock()
        self._socket = socket.create_server((address, self.table["port"] if port is None else port))
        self.port = self._socket.getsockname()[1]

    def serve(self):
        """Serve until :meth:`close`."""
        while True:
            try:
                user, _ = self._socket.accept()
            except OSError:
                return
            with self._lock:
                full = len(self._users) >= self.table["users"]
                if not full:
                    self._users.add(user)
            if full:
                user.close()
                continue
            user.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            threading.Thread(target=self._serve, args=(user,), daemon=True).start()

    def close(self):
        """End listening and every connection."""
        with self._lock:
            every = [self._socket, *self._users]
        for one in every:
            try:
                one.shutdown(socket.SHUT_RDWR)      # closing alone would leave accept() waiting
            except OSError:
                pass
        self._socket.close()

    def _serve(self, user):
        last = [0]          # number of the frame that this user received last
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
        name = self.table["codes"].get(str(code[0]))
        if name in ("READ", "WRITE"):
            rest = requests.read(4)
            if len(rest) < 4:
                return False
            address, value = (int.from_bytes(rest[k:k + 2], "big") for k in (0, 2))
            with self._device:
                if name == "WRITE":
                    self._write(address, value)
                value = self._read(address, last[0])
            _send(user, code + rest[:2] + value.to_bytes(2, "big"))
        elif name == "MRAW":
            package, last[0] = self._package(*user.getsockname()[:2])
            if package is None:
                return False
            _send(user, package)
        elif name != "RESERVED":
            _send(user, bytes([self.table["unknown"]]) + code)
            return False
        return True

    def _read(self, address, last):
        """The word of an address; ``last``: number of the user's last frame."""
        if address < self.table["page"]:
            try:
                return self.camera.read_sensor(self.sensor, address)
            except CameraError:
                return self.table["silent"]
        name = self._names.get(address, "")
        whole, _, half = name.rpartition("_")
        if half in ("UPPER", "LOWER"):
            return self._long(whole, last) >> (16 if half == "UPPER" else 0) & 0xFFFF
        width, height = self._size()
        # The others are 0: offsets, number of the lens, of the last lens, whether GVSP streams.
        return {"SOURCE": int(self._corrected), "WIDTH": width, "WIDTH_MAX": width,
                "HEIGHT": height, "HEIGHT_MAX": height, "FORMAT": self._formation(),
                "FRAME_RATE": round(10 * self.sensor["frames_per_second"])}.get(name, 0)

    def _long(self, name, last):
        """A number of two words."""
        registers = {"DROPPED": "FRAMES_MISSED", "TORN": "RAW_TAKEN"}
        if name in registers:
            return self.camera.get(registers[name])
        line_ns = round(1e9 * self.sensor["line_clocks"] / self.sensor["pixel_clock_hz"])
        return {"LINE_TIME": line_ns, "NUMBER": last}[name]

    def _write(self, address, value):
        """Write a word, if it can be written: what is read back says whether it was."""
        name = self._names.get(address)
        if name == "SOURCE" and value in (0, 1):
            self._corrected = bool(value)
        elif name == "FORMAT" and value in self.formats.values():
            self._corrected = value == self.formats["corrected"]
        elif address < self.table["page"] and address not in self.sensor["own"] \
                and address >> self.sensor["pointer_bits"] == 0 \
                and value >> self.sensor["value_bits"] == 0:
            try:
                self.camera.write_sensor(self.sensor, address, value)
            except CameraError:
                return
            self._first = self.camera.get("RAW_BEGUN") + 1

    def _size(self):
        """Width and height of the pictures."""
        what = "CORRECTED" if self._corrected else "WINDOW"
        return self.camera.get(f"{what}_WIDTH"), self.camera.get(f"{what}_HEIGHT")

    def _formation(self):
        """Of Table II."""
        return self.formats["corrected" if self._corrected else "raw"]

    def _package(self, address, port):
        """Table II of the newest frame that has all that was written, and the frame's number; None
        if there is none for long."""
        until = time.monotonic() + _FRAME_SECONDS
        while time.monotonic() < until:
            with self._device:
                found = self._frame()
            if found is not None:
                break
            time.sleep(_LOOK_SECONDS)
        else:
            return None, 0
        (width, height, formation), data, number, clocks = found
        micros = clocks * 1_000_000 // self.settings["clock_hz"]
        header = [(width, 4), (height, 4), (formation, 1), (len(data), 7),
                  (int.from_bytes(socket.inet_aton(address), "big"), 4), (port, 4),
                  (micros % _NUMBERS, 4)]
        return b"".join(value.to_bytes(size, "big") for value, size in header) + data, number

    def _frame(self):
        """(width, height, formation), bytes, number and time of the newest frame; None if none is
        there or it was lost while it was read."""
        camera, corrected = self.camera, self._corrected
        frame = camera.claim(_READER, corrected=corrected)
        if frame is None:
            return None
        try:
            if (frame.number - self._first) % _NUMBERS >= _NUMBERS // 2:
                return None
            width, height = self._size()
            row = width * (self.settings["pixel_bytes"] if corrected else 1)
            pitch = row if corrected else camera.get("RAW_PITCH")
            first = frame.base - self.settings["frames"]
            data = b"".join(self.frames[at:at + row]
                            for at in range(first, first + pitch * height, pitch)) \
                if pitch != row else bytes(self.frames[first:first + row * height])
            if camera.lost(_READER):
                return None
            return (width, height, self._formation()), data, frame.number, frame.time
        finally:
            camera.release(_READER)


def _send(user, data):
    # Reading may wait for ever, sending may not.
    user.settimeout(_SEND_SECONDS)
    user.sendall(data)
    user.settimeout(None)


def main(arguments):
    """Set the board up, and serve until the process is ended; the exit status."""
    if not 1 <= len(arguments) <= 2:
        print(f"{len(arguments)} arguments are given: ADDRESS [UIO]", file=sys.stderr)
        return 2
    address, *uio = arguments
    try:
        board, frames = open_board(*uio)
        server = TableServer(board, frames, address)
        board.start()
    except (OSError, CameraError, MemoryError) as error:
        print(f"{address}: {error}", file=sys.stderr)
        return 2
    print(f"tcp://{address}:{server.port}", flush=True)
    server.serve()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
