"""Table I and II from the DE10-Nano's processor: server between registers, memory and client."""

import socket
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from hps_server import HEIGHT, I2C, WIDTH, hps_project, serving
from ncdc_host.client.devices import open_device
from ncdc_host.client.errors import DeviceError
from ncdc_spec.protocols.features import system_word
from ncdc_spec.sensors import mt9p031


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    return hps_project(tmp_path_factory.mktemp("server"))


@pytest.fixture
def running(project):
    with serving(project) as made:
        yield made


@pytest.mark.longer
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


@pytest.mark.longer
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
            connection.write(address, 9)
        assert [connection.read(address) for address in (0x100, 0xEFFF)] == [0, 0]
    changed = {key[0] for key in sent if sent[key] != before.get(key)}
    assert changed == {one.address for one in mt9p031.SENSOR.user_registers}


def test_silent_users_give_their_position_to_a_new_one(running):
    running.server._users._idle_seconds = .3
    connections = [running.connection() for _ in range(running.settings["table"]["users"])]
    assert connections[-1].read(system_word("WIDTH")) == WIDTH
    with pytest.raises(DeviceError):
        running.connection().read(system_word("WIDTH"))
    time.sleep(.35)
    assert connections[-1].read(system_word("WIDTH")) == WIDTH
    assert running.connection().read(system_word("WIDTH")) == WIDTH
    assert connections[-1].read(system_word("WIDTH")) == WIDTH


@pytest.mark.longer
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


def test_more_users_than_connections(running):
    connections = [running.connection() for _ in range(running.settings["table"]["users"])]
    assert connections[-1].read(system_word("WIDTH")) == WIDTH
    with pytest.raises(DeviceError):
        running.connection().read(system_word("WIDTH"))
    for one in connections:
        one.close()


def test_the_program_says_what_is_wrong(project):
    for arguments, said in (((), "0 arguments are given: ADDRESS [UIO]"),
                            (("127.0.0.1", str(project / "none")), "127.0.0.1: [Errno 2]")):
        done = subprocess.run([sys.executable, "ncdc_server.py", *arguments], cwd=project,
                              text=True, capture_output=True)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith(said) and "Traceback" not in done.stderr
