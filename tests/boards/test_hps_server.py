"""Table I and II from the DE10-Nano's processor: server between registers, memory and client."""

import json
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from camera_bus import Bus
from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_host.client.devices import open_device
from ncdc_host.client.errors import DeviceError
from ncdc_host.client.table import Connection
from ncdc_model.interface.features import system_word
from ncdc_model.sensors import mt9p031

WIDTH, HEIGHT, PITCH = 64, 24, 72
SIZES = {"RAW": PITCH * HEIGHT, "CORRECTED": 3 * WIDTH * HEIGHT}
I2C = mt9p031.SENSOR.i2c_address


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """Folder of the project, as the command writes it."""
    folder = tmp_path_factory.mktemp("server")
    barrel_descriptor((WIDTH, HEIGHT), (WIDTH, HEIGHT), hidden_neurons=2, bayer="GRBG").save(
        folder / "net.toml")
    assert main(["build", str(folder / "net.toml"), "--board", "de10-nano", "-o",
                 str(folder / "project")]) == 0
    return folder / "project"


class Running:
    """A server on this machine, the registers behind it, and its frames' memory."""

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


@pytest.fixture
def running(project, monkeypatch):
    monkeypatch.syspath_prepend(str(project))
    mine = [path.stem for path in project.glob("ncdc_*.py")]
    for name in mine:
        monkeypatch.delitem(sys.modules, name, raising=False)
    made = Running(project)
    yield made
    made.server.close()
    for name in mine:
        sys.modules.pop(name, None)


def test_the_client_sees_settings_and_pictures(running):
    corrected = running.newest("CORRECTED", 2, 7, clocks=(5 << 32) + 12_345_600)
    raw = running.newest("RAW", 1, 9, clocks=1_000)
    with open_device(running.url) as device, device.stream() as stream:
        assert device.get("Width") == WIDTH and device.get("PixelFormat") == "BGR8"
        frame = stream.next()
        assert np.array_equal(frame.pixels, corrected[..., ::-1])
        device.set("PixelFormat", "BayerGR8")
        assert np.array_equal(stream.next().pixels, raw)
    with running.connection() as connection:
        assert connection.read(system_word("DROPPED_UPPER")) == 1
        assert connection.read(system_word("DROPPED_LOWER")) == 0x2345
        connection.write(system_word("SOURCE"), 1)
        header = connection.picture().header
        assert header.time_us == ((5 << 32) + 12_345_600) // 100 % (1 << 32)
        assert (header.address, header.port) == ("127.0.0.1", running.server.port)
        assert connection.read(system_word("NUMBER_LOWER")) == 7


def test_the_part_of_the_sensor_that_raw_frames_show(running):
    names = ("SENSOR_WIDTH", "SENSOR_HEIGHT", "DECIMATION_X", "DECIMATION_Y", "FIELD_LEFT",
             "FIELD_TOP")
    with running.connection() as connection:
        values = [connection.read(system_word(name)) for name in names]
        assert connection.write(system_word("DECIMATION_X"), 1) == values[2]
    # Of 64x24 by 7, around the middle, as far as the colours allow.
    assert values[:4] == [2592, 1944, 7, 7]
    assert abs(values[4] - (2592 - 7 * WIDTH) / 2) <= 4
    assert abs(values[5] - (1944 - 7 * HEIGHT) / 2) <= 4


def test_what_decides_the_frames_size_is_not_written(running):
    with running.connection() as connection:
        before = connection.read(mt9p031.COLUMN_SIZE)
        assert connection.write(mt9p031.COLUMN_SIZE, 100) == before != 100
        assert connection.write(mt9p031.SHUTTER_LOWER, 777) == 777
        assert running.bus.targets[I2C][bytes([mt9p031.SHUTTER_LOWER])] == (777).to_bytes(2, "big")
        assert connection.write(system_word("WIDTH"), 32) == WIDTH
        del running.bus.targets[I2C]
        assert connection.read(mt9p031.SHUTTER_LOWER) == 0xFFFF


def test_no_user_writes_another_register_of_the_sensor(running):
    """Nor is one asked for that the sensor does not have: the connection stays."""
    sent = running.bus.targets[I2C]
    before = dict(sent)
    with running.connection() as connection:
        for address in [*range(0x100), 0x100, 0x1235, 0xEFFF]:
            connection.write(address, 0x0109)
        assert [connection.read(address) for address in (0x100, 0xEFFF)] == [0, 0]
    changed = {key[0] for key in sent if sent[key] != before.get(key)}
    assert changed == set(mt9p031.SENSOR.user_registers)


def test_silent_users_give_their_position_to_a_new_one(running):
    running.server._users._idle_seconds = .3
    kept = [running.connection() for _ in range(running.settings["table"]["users"])]
    assert kept[-1].read(system_word("WIDTH")) == WIDTH
    with pytest.raises(DeviceError):
        running.connection().read(system_word("WIDTH"))
    time.sleep(.35)
    assert kept[-1].read(system_word("WIDTH")) == WIDTH
    assert running.connection().read(system_word("WIDTH")) == WIDTH
    assert kept[-1].read(system_word("WIDTH")) == WIDTH


def test_a_picture_has_all_that_was_written(running):
    """The frame under way when a setting is written is not the one that comes."""
    running.newest("CORRECTED", 0, 4)
    running.put("RAW_BEGUN", 4)
    with running.connection() as connection, ThreadPoolExecutor() as pool:
        connection.write(mt9p031.GLOBAL_GAIN, 16)
        waiting = pool.submit(connection.picture)
        with pytest.raises(TimeoutError):
            waiting.result(timeout=.2)
        later = running.newest("CORRECTED", 3, 5)
        assert waiting.result(timeout=5).data == later.tobytes()


def test_a_frame_that_was_taken_away_is_not_sent(running):
    picture = running.newest("CORRECTED", 1, 3)
    running.bus.lose = 2
    with running.connection() as connection:
        assert connection.picture().data == picture.tobytes()
    assert running.bus.lose == 0


def test_users_do_not_mix(running):
    picture = running.newest("CORRECTED", 1, 3).tobytes()

    def user(_):
        with running.connection() as connection:
            return [(connection.picture().data == picture, connection.read(0)) for _ in range(5)]
    with ThreadPoolExecutor(8) as pool:
        found = [one for part in pool.map(user, range(8)) for one in part]
    assert found == [(True, mt9p031.CHIP_VERSION_VALUE)] * 40


def test_what_is_no_request_ends_the_connection(running):
    for sent, answer in ((b"\x42", b"\xff\x42"), (b"\x82\x82\x80\x00\x00\x00\x00\x99",
                                                  b"\x80\x00\x00\x18\x01\xff\x99"),
                         (b"\x80\x00", b"")):
        with socket.create_connection(("127.0.0.1", running.server.port)) as user:
            user.sendall(sent)
            user.shutdown(socket.SHUT_WR)
            found = b"".join(iter(lambda: user.recv(100), b""))
        assert found == answer


def test_more_users_than_there_are_places(running):
    kept = [running.connection() for _ in range(running.settings["table"]["users"])]
    assert kept[-1].read(system_word("WIDTH")) == WIDTH
    with pytest.raises(DeviceError):
        running.connection().read(system_word("WIDTH"))
    for one in kept:
        one.close()


def test_the_program_says_what_is_wrong(project):
    for arguments, said in (((), "0 arguments are given: ADDRESS [UIO]"),
                            (("127.0.0.1", str(project / "none")), "127.0.0.1: [Errno 2]")):
        done = subprocess.run([sys.executable, "ncdc_server.py", *arguments], cwd=project,
                              text=True, capture_output=True)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith(said) and "Traceback" not in done.stderr
