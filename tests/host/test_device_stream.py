"""The packets of the emulated device's stream, sent together and one by one."""

import socket
import threading

import numpy as np
import pytest

from ncdc_host.device.camera import Frame
from ncdc_host.device.datagrams import DatagramSender
from ncdc_host.device.stream import Receiver, Stream
from ncdc_spec.pixel_formats import BGR8
from ncdc_spec.protocols import gvsp


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
