"""Gives settings and pictures to a network, as root: python3 ncdc_server.py ADDRESS [UIO]

It configures the board, and then serves Table I and II over TCP, the protocols of ``ncdc client``
(URL tcp://ADDRESS). It needs only Python and the files next to it.
"""

import socket
import sys
import threading
import time

import ncdc_table_users
from ncdc_board import open_board
from ncdc_camera import CameraError

__all__ = ["TableServer"]

_READER = 1                 # reader of the frame stores; 0 is left to other programs
_FRAME_SECONDS = 10         # without a frame for so long, the client is disconnected
_LOOK_SECONDS = .002        # period of polling for a frame
_NUMBERS = 1 << 32          # frame numbers are modulo this


class TableServer(ncdc_table_users.TableServer):
    """Table I and II of a board.

    Parameters
    ----------
    board : ncdc_board.Board
        A board that has been started.
    frames : buffer
        The memory of its frames, from the address of the first one on.
    address : str
    port : int, optional
        By default that of Table I.

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
        super().__init__(address, self.table["port"] if port is None else port, self.table,
                         self._device)

    def read(self, user, address):
        """The word of an address."""
        if address < self.table["page"]:
            if address >> self.sensor["pointer_bits"]:
                return 0            # the sensor has no such register
            try:
                return self.camera.read_sensor(self.sensor, address)
            except CameraError:
                return self.table["silent"]
        name = self._names.get(address, "")
        whole, _, half = name.rpartition("_")
        if half in ("UPPER", "LOWER"):
            return self._long(whole, user.frame) >> (16 if half == "UPPER" else 0) & 0xFFFF
        width, height = self._size()
        # The others are 0: offsets, lenses, whether GVSP streams, what can be written, a view.
        return {"SOURCE": int(self._corrected), "WIDTH": width, "WIDTH_MAX": width,
                "HEIGHT": height, "HEIGHT_MAX": height, "FORMAT": self._formation(),
                "FRAME_RATE": round(10 * self.sensor["frames_per_second"]),
                **self.settings["field"]}.get(name, 0)

    def _long(self, name, last):
        """A number of two words."""
        registers = {"DROPPED": "FRAMES_MISSED", "TORN": "RAW_TAKEN"}
        if name in registers:
            return self.camera.get(registers[name])
        line_ns = round(1e9 * self.sensor["line_clocks"] / self.sensor["pixel_clock_hz"])
        return {"LINE_TIME": line_ns, "NUMBER": last}.get(name, 0)

    def write(self, address, value):
        """Write a word, if it can be written: what is read back says whether it was."""
        name = self._names.get(address)
        if name == "SOURCE" and value in (0, 1):
            self._corrected = bool(value)
        elif name == "FORMAT" and value in self.formats.values():
            self._corrected = value == self.formats["corrected"]
        elif self._user_writes(address, value):
            try:
                self.camera.write_sensor(self.sensor, address, value)
            except CameraError:
                return
            self._first = self.camera.get("RAW_BEGUN") + 1

    def _user_writes(self, address, value):
        """Whether users may write this to the sensor's register."""
        if value >> self.sensor["value_bits"]:
            return False
        return any(one["address"] == address
                   and any(low <= value & one["mask"] <= high for low, high in one["ranges"])
                   for one in self.sensor["user_registers"])

    def _size(self):
        """Width and height of the pictures."""
        what = "CORRECTED" if self._corrected else "WINDOW"
        return self.camera.get(f"{what}_WIDTH"), self.camera.get(f"{what}_HEIGHT")

    def _formation(self):
        """Pixel format code of Table II."""
        return self.formats["corrected" if self._corrected else "raw"]

    def package(self, user):
        """Table II of the newest frame that has all that was written; None if there is none for
        long."""
        until = time.monotonic() + _FRAME_SECONDS
        while time.monotonic() < until:
            with self._device:
                found = self._frame()
            if found is not None:
                break
            time.sleep(_LOOK_SECONDS)
        else:
            return None
        (width, height, formation), data, user.frame, clocks = found
        address, port = user.socket.getsockname()[:2]
        micros = clocks * 1_000_000 // self.settings["clock_hz"]
        return ncdc_table_users.mraw_header((
            width, height, formation, len(data), int.from_bytes(socket.inet_aton(address), "big"),
            port, micros % _NUMBERS)) + data,

    def _frame(self):
        """(width, height, formation), bytes, number and time of the newest frame; None if none is
        there, or if it was overwritten while it was read."""
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


def main(arguments):
    """Set the board up, and serve until the process is ended; return the exit status."""
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
