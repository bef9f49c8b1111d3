"""Sets up the board from Linux on its own processor, as root: python3 ncdc_board.py [UIO]

Frames get places in the memory that the device tree keeps off Linux, the HDMI transmitter and the
sensor are set up over I2C, and from then on the screen shows the straightened picture.
"""

import json
import os
import sys
from mmap import MAP_SHARED, PROT_READ, mmap

import ncdc_registers as registers
from ncdc_backends import Mapped
from ncdc_camera import Camera

__all__ = ["Board", "open_board"]

_STEP = 4096                # of the places of frames
_WORDS = 1 << 17            # bytes of the registers


class Board:
    """The camera of the board, and where its frames lie.

    Parameters
    ----------
    read, write : callable
        As of ``ncdc_camera.Camera``.
    settings : dict
        ``ncdc_board.json``.
    """

    def __init__(self, read, write, settings):
        self.camera, self.settings = Camera(read, write), settings

    def place(self):
        """Give each frame store its buffers; {name of the register: address}.

        Raises
        ------
        MemoryError
            If the memory kept for frames is too small.
        """
        address, places = self.settings["frames"], {}
        for store in ("RAW", "CORRECTED"):
            size = -(-self.camera.get(f"{store}_BYTES") // _STEP) * _STEP
            for name in registers.OFFSET:
                if name.startswith(store) and name.endswith("_BASE"):
                    places[name] = address
                    address += size
        needed = address - self.settings["frames"]
        if needed > self.settings["frame_bytes"]:
            raise MemoryError(f"frames take {needed} bytes, {self.settings['frame_bytes']} are "
                              f"kept for them: a smaller picture fits")
        self.camera.put(**places)
        return places

    def start(self):
        """Stop what runs, set all up, and correct each frame from then on."""
        camera, sensor = self.camera, self.settings["sensor"]
        camera.stop()
        while camera.get("CAMERA_STATUS") & registers.CAMERA_STATUS_ACTIVE:
            pass
        self.place()
        camera.put(**self.settings["registers"])
        transmitter = self.settings["transmitter"]
        for write in transmitter["writes"]:
            camera.write_sensor(transmitter, write["register"], write["value"])
        # The last write lets the sensor send: the camera waits for it.
        camera.set_up(sensor | {"writes": sensor["writes"][:-1]})
        camera.start()
        last = sensor["writes"][-1]
        camera.write_sensor(sensor, last["register"], last["value"])


def open_board(uio="/dev/uio0", settings="ncdc_board.json", memory="/dev/mem"):
    """The :class:`Board`, and the memory of its frames, mapped: its byte 0 is the first frame's."""
    with open(settings, encoding="utf-8") as file:
        settings = json.load(file)
    frames = mmap(os.open(memory, os.O_RDONLY | os.O_SYNC), settings["frame_bytes"], MAP_SHARED,
                  PROT_READ, offset=settings["frames"])
    return Board(*Mapped(uio, size=_WORDS), settings), frames


if __name__ == "__main__":
    open_board(*sys.argv[1:2])[0].start()
