"""Sets up the board from Linux on its own processor, as root: python3 ncdc_board.py [UIO]

Frames get places in the memory that the device tree keeps off Linux, the HDMI transmitter and the
sensor are set up over I2C, and from then on the screen shows the straightened picture.
"""

import json
import os
import sys
from mmap import MAP_SHARED, PAGESIZE, PROT_READ, mmap

import ncdc_registers as registers
from ncdc_backends import Mapped
from ncdc_camera import Camera

__all__ = ["Board", "open_board", "release_ports"]

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


def release_ports(word, resets):
    """End the resets of the memory's ports; names of the ports in use that were in reset.

    U-Boot's ``bridge enable`` writes what the board's vendor handed it, which ends the resets of
    some ports only: a picture would stay black without an error.

    Parameters
    ----------
    word : memoryview
        Of 32 bits, one: the register FPGAPORTRST.
    resets : dict
        ``port_resets`` of ``ncdc_board.json``.

    Raises
    ------
    OSError
        If a port in use stays in reset.
    """
    before = word[0]
    word[0] = resets["all"]
    after = word[0]
    held = {value: [name for name, bits in resets["used"].items() if bits & ~value]
            for value in (before, after)}
    if held[after]:
        raise OSError(f"the memory ports {', '.join(held[after])} stay in reset: "
                      f"{resets['address']:#x} reads {after:#06x} after {resets['all']:#06x} was "
                      f"written; load the bitstream in U-Boot, then bridge enable")
    return held[before]


def _open_ports(memory, resets):
    """Call :func:`release_ports` with the register in the file ``memory``; print what it did."""
    page, offset = resets["address"] // PAGESIZE * PAGESIZE, resets["address"] % PAGESIZE
    words = memoryview(mmap(os.open(memory, os.O_RDWR | os.O_SYNC), PAGESIZE, MAP_SHARED,
                            offset=page)).cast("I")
    held = release_ports(words[offset // 4:offset // 4 + 1], resets)
    if held:
        print(f"memory ports {', '.join(held)} were in reset: {resets['all']:#06x} is written to "
              f"{resets['address']:#x}")


def open_board(uio="/dev/uio0", settings="ncdc_board.json", memory="/dev/mem"):
    """The :class:`Board`, and the memory of its frames, mapped: its byte 0 is the first frame's.

    The memory's ports are out of their resets then, see :func:`release_ports`.
    """
    with open(settings, encoding="utf-8") as file:
        settings = json.load(file)
    _open_ports(memory, settings["port_resets"])
    frames = mmap(os.open(memory, os.O_RDONLY | os.O_SYNC), settings["frame_bytes"], MAP_SHARED,
                  PROT_READ, offset=settings["frames"])
    return Board(*Mapped(uio, size=_WORDS), settings), frames


if __name__ == "__main__":
    open_board(*sys.argv[1:2])[0].start()
