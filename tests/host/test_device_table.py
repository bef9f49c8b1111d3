"""Table I and II over TCP with an emulated device in this process."""

import random
import socket
import struct
import threading
import time

import numpy as np
import pytest

from devices import SIZE, device, small_lens
from ncdc_host.client.errors import BadValue, DeviceError, DeviceGone, Rejected
from ncdc_host.client.table import Connection, Package, TableDevice, TableStream
from ncdc_model.example import noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_spec.pixel_formats import MONO8, PIXEL_FORMATS
from ncdc_spec.protocols import table_one
from ncdc_spec.protocols.features import FEATURES, system_word
from ncdc_spec.protocols.table_one import MAX_USERS
from ncdc_spec.protocols.table_two import HEADER_BYTES, MrawHeader
from ncdc_spec.sensors import mt9p031

SCRATCH = (0xA1, 0xA2, 0xA3, 0xA4, 0x2B, 0x2C, 0x2D, 0x2E)     # these take any value


@pytest.fixture
def one():
    with device([small_lens(), small_lens(seed=5)]) as served:
        yield served


def connected(one):
    return Connection(one.options.address, one.table.port)


def opened(one, monitor=False):
    return TableDevice(one.options.address, one.table.port, monitor)


def raw_socket(one):
    return socket.create_connection((one.options.address, one.table.port), 5)


def received(user, count):
    data = b""
    while len(data) < count and (part := user.recv(count - len(data))):
        data += part
    return data


def test_commands_byte_by_byte(one):
    with raw_socket(one) as user:
        user.sendall(bytes.fromhex("80 0000 ffff"))
        assert received(user, 5) == bytes.fromhex("80 0000 1801")       # the chip's version
        user.sendall(bytes.fromhex("81 00a1 abcd"))
        assert received(user, 5) == bytes.fromhex("81 00a1 abcd")
        user.sendall(bytes.fromhex("81 0000 1234"))                     # read-only: as read back
        assert received(user, 5) == bytes.fromhex("81 0000 1801")
        user.sendall(bytes.fromhex("82 80 00a1 0000"))                  # 0x82: no answer
        assert received(user, 5) == bytes.fromhex("80 00a1 abcd")
        user.sendall(b"\x42")
        assert received(user, 3) == bytes.fromhex("ff 42")              # and the end


def test_a_picture_byte_by_byte(one):
    golden = correct(small_lens(), noise_picture(*SIZE)).picture
    with raw_socket(one) as user:
        user.sendall(b"\x83")
        width, height, formation = struct.unpack(">IIB", received(user, 9))
        assert (width, height, formation) == (64, 48, 0x10)
        assert int.from_bytes(received(user, 7), "big") == 64 * 48 * 3
        assert received(user, 4) == socket.inet_aton(one.options.address)
        assert int.from_bytes(received(user, 4), "big") == one.table.port
        assert int.from_bytes(received(user, 4), "big") <= one.camera.now_ns() // 1000
        assert received(user, 64 * 48 * 3) == golden[..., ::-1].tobytes()


def test_every_feature_is_set_and_read_back(one):
    with opened(one) as client, opened(one) as other:
        for name in client.names():
            info = client.info(name)
            assert info.value == other.get(name) or name.startswith("Frames")
            values = {"boolean": (True, False), "enumeration": info.choices}.get(
                info.kind, (info.minimum, info.maximum))
            for value in values if info.writable else ():
                if name == "PixelFormat" and value.startswith("Bayer") and value != "BayerRG8":
                    with pytest.raises(Rejected, match="is rejected by tcp"):
                        client.set(name, value)
                    continue
                assert client.set(name, value) == pytest.approx(value) if info.kind == "float" \
                    else client.set(name, value) == value, name
                assert other.get(name) == client.get(name)
            if info.writable:
                client.set(name, info.value)
        assert {f.name for f in FEATURES if f.table} == set(client.names())


@pytest.mark.parametrize("abilities,writable", [
    (table_one.RATE, {"AcquisitionFrameRate"}), (table_one.WINDOW, {"Width", "OffsetY"}),
    (0, set())])
def test_a_client_offers_what_the_device_takes(one, abilities, writable):
    one.registers._abilities = abilities
    with opened(one) as client:
        assert "ReverseX" not in client.names() and "ReverseY" not in client.names()
        assert {name for name in ("Width", "OffsetY", "AcquisitionFrameRate")
                if client.info(name).writable} == writable
        with pytest.raises(DeviceError, match="no feature 'ReverseX'"):
            client.set("ReverseX", True)
        assert client.set("Gain", 2.0) == 2.0
    one.registers._abilities |= table_one.MIRRORS
    with opened(one) as client:
        assert client.set("ReverseX", True)


@pytest.mark.parametrize("name,value,message", [
    ("Width", 65, "Width is 65, the limits are 8 and 64"),
    ("Width", 63, "Width is 63, steps of 2 from 8 on are needed"),
    ("Gain", 0.5, r"Gain is 0\.5, the limits are 1 and 7\.875"),
    ("Gain", "much", "Gain is 'much', a number is needed"),
    ("TestPattern", "Stripes", "TestPattern is 'Stripes', one of Off, Grey"),
    ("LensSelector", 2, "LensSelector is 2, the limits are 0 and 1"),
    ("ReverseX", "perhaps", "ReverseX is 'perhaps', a boolean is needed"),
    ("Gain", "nan", "Gain is nan")])
def test_bad_values_are_named(one, name, value, message):
    with opened(one) as client:
        with pytest.raises(BadValue, match=message):
            client.set(name, value)
        with pytest.raises(DeviceError, match="no feature 'Nonsense'"):
            client.get("Nonsense")
        with pytest.raises(Rejected, match="WidthMax is read-only"):
            client.set("WidthMax", 32)


def test_the_device_checks_by_itself(one):
    with connected(one) as user:
        for address, value in ((0xF001, 66), (0xF001, 9), (0xF002, 6), (0xF008, 2), (0xF003, 0x77),
                               (0xF003, 0x01), (0xF004, 0), (0xF005, 2), (0xF000, 2),
                               (0x01, 0), (0x08, 16), (0x35, 7), (0xA0, 3), (0xF006, 5)):
            before = user.read(address)
            assert user.write(address, value) == before != value, hex(address)


def test_a_window_is_a_part_of_the_picture(one):
    golden = correct(small_lens(), noise_picture(*SIZE)).picture
    with opened(one) as client:
        for name, value in (("Width", 20), ("Height", 10), ("OffsetX", 30), ("OffsetY", 12)):
            client.set(name, value)
        assert client.info("OffsetX").maximum == 44
        with client.stream() as frames:
            frame = frames.next()
        assert np.array_equal(frame.pixels, golden[12:22, 30:50])
        client.set("CorrectionEnable", False)
        assert (client.get("Width"), client.get("OffsetX")) == (64, 0)


class Numbered:
    """A connection whose frames have given numbers, each a pixel of Mono8."""

    def __init__(self, numbers):
        self.numbers, self.number = iter(numbers), None

    def picture(self, timeout):
        self.number = next(self.numbers)
        return Package(MrawHeader(1, 1, MONO8, "127.0.0.1", 0, self.number), bytes(1))

    def read(self, address):
        return {system_word("NUMBER_UPPER"): self.number >> 16, system_word("FRAME_RATE"): 65535,
                system_word("NUMBER_LOWER"): self.number & 0xFFFF}[address]


def test_frames_skipped_after_number_0_count():
    frames = TableStream(None, Numbered([0, 2, 2, 3, 70000]))
    assert [frames.next().number for _ in range(4)] == [0, 2, 3, 70000]
    assert (frames.statistics.frames, frames.statistics.skipped) == (4, 1 + 69996)


def test_frames_have_rising_numbers_and_times(one):
    with opened(one) as client, client.stream() as frames:
        got = [frames.next() for _ in range(10)]
        counted = frames.statistics
    numbers, times = [frame.number for frame in got], [frame.time_ns for frame in got]
    assert numbers == sorted(set(numbers)) and times == sorted(set(times))
    assert counted.frames == 10 and counted.lost == 0
    assert counted.skipped == numbers[-1] - numbers[0] + 1 - 10
    # 100 frames a second: 10 ms from number to number, in whole microseconds.
    assert times[-1] - times[0] == pytest.approx(10_000_000 * (numbers[-1] - numbers[0]), abs=2000)


def test_a_monitor_does_not_write(one):
    with opened(one, monitor=True) as client:
        assert client.access == "monitor" and not client.info("Gain").writable
        with pytest.raises(Rejected, match="this user is a monitor"):
            client.set("Gain", 2)


def test_locked_while_pictures_stream(one):
    one.registers.streaming = True
    with opened(one) as client:
        assert not client.info("Width").writable and client.info("Gain").writable
        with pytest.raises(Rejected, match="Width is locked while pictures stream"):
            client.set("Width", 32)
        assert connected(one).write(0x20, 0x8000) == 0          # mirrored: another raw format
        assert connected(one).write(0x20, 0x0001) == 0
        assert client.set("LensSelector", 1) == 1


def test_one_user_too_many_is_sent_away(one):
    users = [connected(one) for _ in range(MAX_USERS)]
    assert [user.read(0) for user in users] == [0x1801] * MAX_USERS
    with raw_socket(one) as late:
        assert late.recv(1) == b""
    users[0].close()
    until = time.monotonic() + 20
    while True:
        try:
            assert connected(one).read(0) == 0x1801
            break
        except DeviceGone:
            assert time.monotonic() < until
            time.sleep(0.05)


def test_a_user_who_takes_nothing_disturbs_no_other(one):
    with raw_socket(one) as lazy, connected(one) as busy:
        lazy.sendall(b"\x83" * 500)
        for _ in range(20):
            assert busy.picture().header.width == 64
            assert busy.read(0) == 0x1801


def test_a_device_that_goes_is_named(one):
    client = opened(one)
    with client.stream() as frames:
        frames.next()
        one.close()
        with pytest.raises(DeviceGone, match="tcp://127"):
            for _ in range(3):
                frames.next()
        with pytest.raises(DeviceGone):
            client.get("Gain")
    assert client.access == "lost"
    with pytest.raises(DeviceGone, match="no device answers at tcp://127"):
        opened(one)


def test_no_user_writes_what_decides_the_frame(one):
    """Size, position, skipping, clock and resets of the sensor are the device's alone."""
    free = {one.address for one in mt9p031.SENSOR.user_registers}
    with connected(one) as user:
        for address in [*range(0x100), 0x100, 0x0123, 0xEFFF]:
            before = user.read(address)
            assert before != 9
            assert user.write(address, 9) == (9 if address in free else before), address
        assert (user.read(0xF001), user.read(0xF002)) == SIZE


def test_silent_users_give_their_position_to_a_new_one(monkeypatch):
    monkeypatch.setattr(table_one, "IDLE_SECONDS", .3)
    with device() as one:
        users = [connected(one) for _ in range(MAX_USERS)]
        for user in users:
            assert user.read(0xF001) == SIZE[0]
        users[0]._socket.sendall(b"\x80")           # half a request: silent as well
        with pytest.raises(DeviceError):
            connected(one).read(0xF001)             # no user has been silent for long
        time.sleep(.35)
        for user in users[1:]:
            assert user.read(0xF001) == SIZE[0]
        assert connected(one).read(0xF001) == SIZE[0]
        with pytest.raises(DeviceError):
            users[0].read(0xF001)
        assert [user.read(0xF001) for user in users[1:]] == [SIZE[0]] * (MAX_USERS - 1)


class User(threading.Thread):
    """Random commands; notes the first thing that is wrong.

    Each user has a sensor register of its own, whose value it knows; all share the picture's
    settings, and check that each picture is a whole one of one setting.
    """
    def __init__(self, one, number, commands, pictures):
        super().__init__()
        self._connection, self._random = connected(one), random.Random(number)
        self._own = [SCRATCH[number]]
        self._commands, self._pictures, self.wrong = commands, pictures, None

    def run(self):
        known = dict.fromkeys(self._own, None)
        try:
            for _ in range(self._commands):
                self._one(known)
        except Exception as error:          # of any kind: the test reports it
            self.wrong = repr(error)
        self._connection.close()

    def _one(self, known):
        user, draw = self._connection, self._random.random()
        address = self._random.choice(self._own)
        if draw < 0.4:
            known[address] = value = self._random.randrange(1 << 16)
            assert user.write(address, value) == value
        elif draw < 0.9:
            value = user.read(address)
            assert known[address] in (None, value), (address, known[address], value)
        elif draw < 0.96:
            user.write(*self._random.choice(
                [(0xF000, 0), (0xF000, 1), (0xF003, 0x12), (0xF005, 0), (0xF005, 1), (0x35, 8),
                 (0x20, 0), (0x20, 0xC000)]))
        else:
            package = user.picture()
            assert bytes(package.data) in self._pictures[package.header.pixel_format.name]


def every_picture():
    """The bytes that a picture of each format may have, by all settings of :class:`User`."""
    raw = noise_picture(*SIZE)
    with device([small_lens(), small_lens(seed=5)], raw) as one:
        found = {pixel_format.name: set() for pixel_format in PIXEL_FORMATS}
        for mirror in (0, 0xC000):
            one.registers.write(0x20, mirror)
            for lens in (0, 1):
                one.registers.write(0xF005, lens)
                for source in (0, 1):
                    one.registers.write(0xF000, source)
                    for formation in (one.registers.read(0xF003), 0x12 if source else None):
                        if formation is not None:
                            one.registers.write(0xF003, formation)
                        frame = one.camera.newest()
                        found[frame.pixel_format.name].add(bytes(frame.data))
        return found


def users_at_once(commands):
    pictures = every_picture()
    assert len(pictures["BGR8"]) == len(pictures[MONO8.name]) == 4
    with device([small_lens(), small_lens(seed=5)]) as one:
        users = [User(one, number, commands, pictures) for number in range(8)]
        for user in users:
            user.start()
        for user in users:
            user.join()
    assert [user.wrong for user in users] == [None] * 8


def test_eight_users_at_once():
    users_at_once(150)


@pytest.mark.regress
def test_eight_users_at_once_at_length():
    users_at_once(10_000)


class Liar(threading.Thread):
    """A device that answers each request for a picture by the next of ``headers``, and no more."""

    def __init__(self, headers):
        super().__init__(daemon=True)
        self._headers, self._listener = headers, socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]

    def run(self):
        for header in self._headers:
            user, _ = self._listener.accept()
            with user:
                user.recv(1)
                user.sendall(header)
        self._listener.close()


def hostile_headers(count):
    """Headers at random and mutated, sizes up to 2**56."""
    rng = random.Random(4)
    good = MrawHeader(64, 48, MONO8, "127.0.0.1", 4000, 5).pack()
    for k in range(count):
        header = bytearray(rng.randbytes(HEADER_BYTES) if k % 3 == 0 else good)
        if k % 3 == 1:
            header[9:16] = rng.randrange(1 << rng.randrange(57)).to_bytes(7, "big")
        elif k % 3 == 2:
            header[rng.randrange(HEADER_BYTES)] = rng.randrange(256)
        yield bytes(header[:HEADER_BYTES if k % 7 else rng.randrange(HEADER_BYTES)])


def hostile_device(count):
    """The client names what is wrong, whatever the header, and takes no memory for it."""
    headers = list(hostile_headers(count))
    liar = Liar(headers)
    liar.start()
    for _ in headers:
        connection = Connection("127.0.0.1", liar.port)
        with pytest.raises(DeviceError, match="tcp://127.0.0.1"):
            connection.picture(5)
        connection.close()
    liar.join(10)
    assert not liar.is_alive()


def test_a_hostile_device():
    hostile_device(300)


@pytest.mark.regress
def test_a_hostile_device_at_length():
    hostile_device(10_000)




def test_the_old_name_of_rejected_warns():
    with pytest.warns(DeprecationWarning, match="Refused is called Rejected now"):
        from ncdc_host.client import Refused
    assert Refused is Rejected
