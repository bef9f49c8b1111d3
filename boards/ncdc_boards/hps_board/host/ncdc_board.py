"""Sets up the board from Linux on its own processor, as root: python3 ncdc_board.py [UIO]

Frames get addresses in memory that the device tree reserves. The program configures the HDMI
transmitter and the sensor over I2C. From then on the screen shows the corrected picture.
"""

import json
import os
import sys
from mmap import MAP_SHARED, PAGESIZE, PROT_READ, mmap

import ncdc_registers as registers
from ncdc_backends import Mapped
from ncdc_camera import CameraSystem

__all__ = ["Board", "open_board", "release_ports"]

_STEP = 4096                # alignment of frames, in bytes
_WORDS = 1 << 17            # size of the registers


class Board:
    """The camera of the board, and the addresses of its frames.

    Parameters
    ----------
    read, write : callable
        As in ``ncdc_camera.CameraSystem``.
    settings : dict
        ``ncdc_board.json``.
    """

    def __init__(self, read, write, settings):
        self.camera, self.settings = CameraSystem(read, write), settings

    def assign_buffers(self):
        """Assign buffers to each frame store; return {name of the register: address}.

        Raises
        ------
        MemoryError
            If the memory reserved for frames is too small.
        """
        address, addresses = self.settings["frames"], {}
        for store in ("RAW", "CORRECTED"):
            size = -(-self.camera.get(f"{store}_BYTES") // _STEP) * _STEP
            for name in registers.OFFSET:
                if name.startswith(store) and name.endswith("_BASE"):
                    addresses[name] = address
                    address += size
        needed = address - self.settings["frames"]
        if needed > self.settings["frame_bytes"]:
            raise MemoryError(f"frames take {needed} bytes, {self.settings['frame_bytes']} are "
                              f"reserved for them: a smaller picture fits")
        self.camera.put(**addresses)
        return addresses

    def start(self):
        """Stop the camera, configure everything, and correct each frame from then on."""
        camera, sensor = self.camera, self.settings["sensor"]
        camera.stop()
        while camera.get("CAMERA_STATUS") & registers.CAMERA_STATUS_ACTIVE:
            pass
        self.assign_buffers()
        camera.put(**self.settings["registers"])
        transmitter = self.settings["transmitter"]
        for write in transmitter["writes"]:
            camera.write_sensor(transmitter, write["register"], write["value"])
        # The last write starts the sensor: the camera must run before it.
        camera.set_up(sensor | {"writes": sensor["writes"][:-1]})
        camera.start()
        last = sensor["writes"][-1]
        camera.write_sensor(sensor, last["register"], last["value"])


def release_ports(word, resets):
    """End the resets of the memory's ports; return names of those in use that were in reset.

    U-Boot's ``bridge enable`` writes a value that the board's vendor set, which ends the resets of
    some ports only. The picture would stay black without an error.

    Parameters
    ----------
    word : memoryview
        One word of 32 bits: the register FPGAPORTRST.
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
    """The :class:`Board`, and the memory of its frames, mapped; byte 0 is the first frame's.

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
