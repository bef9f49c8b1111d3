"""The packets of the emulated device's stream, sent together and one by one."""

import socket
import struct
import threading
from ipaddress import IPv4Address

import numpy as np
import pytest

from devices import SIZE, device, small_lens
from guis import url_of
from ncdc_host.client import open_device
from ncdc_host.device.camera import Frame
from ncdc_host.device.datagrams import DatagramSender
from ncdc_host.device.stream import Receiver, Stream
from ncdc_model.example import noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_spec.pixel_formats import BGR8
from ncdc_spec.protocols import gvcp, gvsp
from ncdc_spec.protocols.features import feature
from peers import need


@pytest.fixture
def receiver():
    """A socket of the loopback interface that holds all packets of a small picture."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        found.bind(("127.0.0.1", 0))
        found.settimeout(5)
        yield found


def _received(receiver, packet_size, together=True, loss=0.0):
    """Packets of a picture of 90x70 pixels, and its bytes."""
    data = np.random.default_rng(1).integers(0, 256, (70, 90, 3), dtype=np.uint8)
    frame = Frame(1, 5, BGR8, (90, 70), (0, 0), memoryview(data).cast("B"), None, 0, None)
    stream = Stream(None, "127.0.0.1", loss)
    if not together:
        stream._sender._many = None
    stream.send_frame(frame, Receiver(receiver.getsockname(), packet_size, 0, False),
                      threading.Event())
    stream.close()
    return [receiver.recv(1 << 16) for _ in range(stream.sent - stream.lost)], data


@pytest.mark.parametrize("packet_size", [576, 1500, 9000])
def test_a_picture_is_its_packets_in_order(receiver, packet_size):
    packets, data = _received(receiver, packet_size)
    payload, count = gvsp.payload_packets(data.nbytes, packet_size)
    assert [packet[:8] for packet in packets[1:-1]] == [
        gvsp.header(1, gvsp.PAYLOAD, number) for number in range(1, count + 1)]
    assert b"".join(packet[8:] for packet in packets[1:-1]) == data.tobytes()
    assert {len(packet) for packet in packets[1:-2]} == {payload + 8}
    assert packets[0] == gvsp.leader(1, 5, BGR8, (90, 70))
    assert packets[-1] == gvsp.trailer(1, count + 1, 70)


def test_a_system_without_a_call_for_many_sends_the_same(receiver):
    together, _ = _received(receiver, 576)
    alone, _ = _received(receiver, 576, together=False)
    assert alone == together


@pytest.mark.parametrize("many", [True, False])
def test_packets_that_the_system_rejects_are_lost(receiver, many):
    """UDP carries 65,507 bytes at most."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        sender = DatagramSender(one)
        if not many:
            sender._many = None
        for size, value in ((70_000, 1), (100, 2)):
            sender.send_all(np.full((3, size), value, np.uint8), receiver.getsockname())
    assert [receiver.recv(1 << 17) for _ in range(3)] == 3 * [bytes(100 * [2])]
    with pytest.raises(OSError):
        sender.send_all(np.zeros((3, 100), np.uint8), receiver.getsockname())


def test_packets_get_lost_one_by_one(receiver):
    packets, _ = _received(receiver, 576, loss=.5)
    whole, _ = _received(receiver, 576)
    assert 0 < len(packets) < len(whole) and set(packets) < set(whole)


class User:
    """The controller of a device, which receives pictures at ``receiver``."""

    def __init__(self, one, receiver):
        self._agent, self._receiver = one.agent, receiver
        address, port = receiver.getsockname()
        self._peer = address, 5000
        for name, value in (("ControlPrivilege", 2), ("StreamPort", port),
                            ("StreamAddress", int(IPv4Address(address)))):
            self.write(gvcp.register(name).address, value)

    def write(self, address, value):
        payload = struct.pack(">II", address, value)
        answer = self._agent.handle(gvcp.command_packet(gvcp.WRITEREG, 1, payload), self._peer)
        assert gvcp.parse_acknowledge(answer)[0] == gvcp.SUCCESS

    def set(self, name, value=1):
        self.write(feature(name).address, value)

    def resend(self, block, first, last):
        payload = struct.pack(">HHII", 0, block, first, last)
        assert self._agent.handle(gvcp.command_packet(
            gvcp.PACKETRESEND, 2, payload, answered=False), self._peer) is None

    def picture(self):
        """The packets up to a trailer."""
        packets = [self._receiver.recv(1 << 16)]
        while packets[-1][4] != gvsp.TRAILER:
            packets.append(self._receiver.recv(1 << 16))
        return packets

    def silent(self):
        """Whether nothing more has come: what is sent again is, before the call returns."""
        self._receiver.setblocking(False)
        try:
            return not self._receiver.recv(1 << 16)
        except BlockingIOError:
            return True
        finally:
            self._receiver.settimeout(5)


@pytest.fixture
def user(receiver):
    with device() as one:
        yield User(one, receiver)


@pytest.mark.parametrize("end", ["AcquisitionStart", "AcquisitionStop", "ControlPrivilege"])
def test_a_single_frame_is_kept_after_its_end(user, end):
    user.set("AcquisitionMode", 1)
    user.set("AcquisitionStart")
    sent = user.picture()
    user.resend(1, 0, 0xFFFFFF)
    assert user.picture() == sent
    for block, first, last in ((1, 5, 2), (1, 5000, 6000), (2, 0, 5), (0, 0, 5)):
        user.resend(block, first, last)
    assert user.silent()
    if end == "ControlPrivilege":
        user.write(gvcp.register(end).address, 0)
        user.resend(1, 0, 5)
        assert user.silent()
        return
    user.set(end)
    if end == "AcquisitionStart":
        assert user.picture()[1:-1] == sent[1:-1]       # of another time
    user.resend(1, 2, 2)
    assert user.silent() == (end == "AcquisitionStop")


def test_so_many_frames_are_kept_as_the_page_says(user):
    user.set("TriggerMode")
    user.set("AcquisitionStart")
    sent = []
    for _ in range(4):
        user.set("TriggerSoftware")
        sent.append(user.picture())
    assert gvsp.STORED_BLOCKS == 2
    for block in (1, 2):
        user.resend(block, 0, 3)
    assert user.silent()
    for block in (3, 4):
        user.resend(block, 0, 0xFFFFFF)
        assert user.picture() == sent[block - 1]


@pytest.mark.parametrize("loss", [0, .01])
def test_a_stream_ends_when_nobody_listens(loss):
    """The receiver's machine says so by ICMP; packets may be sent together or one by one."""
    with device(loss=loss) as one:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
            receiver.bind(("127.0.0.1", 0))
            receiver.settimeout(5)
            user = User(one, receiver)
            user.set("AcquisitionStart")
            user.picture()
            assert one.registers.streaming
        one.stream._thread.join(5)
        assert not one.stream._thread.is_alive() and not one.registers.streaming
        sent = one.stream.sent
        for block in range(1, 9):
            user.resend(block, 0, 5)
        assert one.stream.sent == sent
        # A receiver does again, at another port.
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
            receiver.bind(("127.0.0.1", 0))
            receiver.settimeout(5)
            user = User(one, receiver)
            user.set("AcquisitionStart")
            for _ in range(3):
                user.picture()


@pytest.mark.longer
def test_a_single_frame_is_whole_though_packets_get_lost():
    """The last packet among them, which Aravis asks for after a time; viva-genicam does not."""
    need("aravis")
    golden = correct(small_lens(), noise_picture(*SIZE)).picture
    with device(loss=.2) as one, open_device(url_of(one, "aravis")) as client:
        client.set("AcquisitionMode", "SingleFrame")
        for _ in range(5):
            with client.stream() as frames:
                assert np.array_equal(frames.next(5).pixels, golden)
        assert one.stream.resent >= one.stream.lost > 3
