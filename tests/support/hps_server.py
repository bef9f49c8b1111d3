"""The DE10-Nano's server on this machine: its project, its registers, its frames."""

import json
import sys
import threading
from contextlib import contextmanager

import numpy as np

from camera_bus import Bus
from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_host.client.table import Connection
from ncdc_spec.sensors import mt9p031

__all__ = ["HEIGHT", "I2C", "PITCH", "SIZES", "WIDTH", "Running", "hps_descriptor", "hps_project",
           "serving"]

WIDTH, HEIGHT, PITCH = 64, 24, 72
SIZES = {"RAW": PITCH * HEIGHT, "CORRECTED": 3 * WIDTH * HEIGHT}
I2C = mt9p031.SENSOR.i2c_address


def hps_descriptor():
    """Descriptor of the lens of the pictures that the server gives."""
    return barrel_descriptor((WIDTH, HEIGHT), (WIDTH, HEIGHT), hidden_neurons=2, bayer="GRBG")


def hps_project(folder):
    """Folder of the project, as the command writes it below ``folder``."""
    hps_descriptor().save(folder / "net.toml")
    assert main(["build", str(folder / "net.toml"), "--board", "de10-nano", "-o",
                 str(folder / "project")]) == 0
    return folder / "project"


class Running:
    """A server on this machine, its registers, and its frames' memory."""

    def __init__(self, project):
        import ncdc_board
        import ncdc_registers
        import ncdc_server
        settings = json.loads((project / "ncdc_board.json").read_text())
        identity = {bytes([register]): value.to_bytes(2, "big")
                    for register, value in settings["sensor"]["chip_id"]}
        self.bus = Bus(ncdc_registers, {I2C: identity, settings["transmitter"]["i2c_address"]: {}})
        for name, value in {"RAW_BYTES": SIZES["RAW"], "CORRECTED_BYTES": SIZES["CORRECTED"],
                            "RAW_PITCH": PITCH, "CORRECTED_WIDTH": WIDTH, "WINDOW_WIDTH": WIDTH,
                            "CORRECTED_HEIGHT": HEIGHT, "WINDOW_HEIGHT": HEIGHT,
                            "FRAMES_MISSED": 0x12345}.items():
            self.put(name, value)
        board = ncdc_board.Board(self.bus.read, self.bus.write, settings)
        board.start()
        rng = np.random.default_rng(1)
        self.memory = bytearray(rng.integers(0, 256, 1 << 16, np.uint8).tobytes())
        self.settings, self.server = settings, ncdc_server.TableServer(
            board, self.memory, "127.0.0.1", 0)
        self.url = f"tcp://127.0.0.1:{self.server.port}"
        threading.Thread(target=self.server.serve, daemon=True).start()

    def put(self, name, value):
        self.bus.words[self.bus.names.OFFSET[name]] = value

    def newest(self, store, buffer, number, clocks=0):
        """Let the next claim get this frame; its picture."""
        at = self.bus.words[self.bus.names.OFFSET[f"{store}{buffer}_BASE"]]
        first = at - self.settings["frames"]
        self.put(f"{store}{buffer}_TIME_LOW", clocks & 0xFFFFFFFF)
        self.put(f"{store}{buffer}_TIME_HIGH", clocks >> 32)
        self.bus.newest[store] = (buffer, number)
        part = np.frombuffer(bytes(self.memory[first:first + SIZES[store]]), np.uint8)
        if store == "RAW":
            return part.reshape(HEIGHT, PITCH)[:, :WIDTH]
        return part.reshape(HEIGHT, WIDTH, 3)

    def connection(self):
        return Connection("127.0.0.1", self.server.port)


@contextmanager
def serving(project):
    """A :class:`Running`, with the project's own modules; they are forgotten after it."""
    mine = [path.stem for path in project.glob("ncdc_*.py")]
    for name in mine:
        sys.modules.pop(name, None)
    sys.path.insert(0, str(project))
    try:
        made = Running(project)
        yield made
        made.server.close()
    finally:
        sys.path.remove(str(project))
        for name in mine:
            sys.modules.pop(name, None)
