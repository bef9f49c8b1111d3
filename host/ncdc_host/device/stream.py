"""Pictures as GVSP packets, to one receiver or a multicast group; lost packets once more."""

import random
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from ncdc_host.device.datagrams import DatagramSender
from ncdc_spec.protocols import gvsp

__all__ = ["Receiver", "Stream"]

_LINE_NS_PER_BYTE = 8           # of Gigabit Ethernet, whose pace the packets keep
_LINE_OVERHEAD = 38             # bytes of a packet on the line without IP: header, FCS, gap
_TRIGGER_SECONDS = 0.05         # from look to look whether a stream that waits has ended
_BATCH = 16                     # packets between two looks at the clock


@dataclass(frozen=True)
class Receiver:
    """Destination and size of the packets.

    Parameters
    ----------
    address : (str, int)
        IPv4 address, or group, and UDP port.
    packet_size : int
        Bytes with IP and UDP header.
    delay_ns : int
        Between two packets.
    fragment : bool
        Whether the network may cut packets into pieces.
    """
    address: tuple
    packet_size: int
    delay_ns: int
    fragment: bool


class Stream:
    """The stream channel of a device.

    Parameters
    ----------
    camera : Camera
    address : str
        IPv4 address that the packets come from.
    loss : float
        Share of the packets that get lost on purpose when they are sent the first time.
    loss_again : float
        Share of those that are sent again because a receiver asked for them.
    seed : int
        Seed of the random choice of those packets.
    observe : callable
        Called as ``observe(frame)`` with each :class:`~ncdc_host.device.camera.Frame` before it is
        sent.

    Attributes
    ----------
    port : int
        UDP port that the packets come from.
    sent, lost, resent : int
        Packets since the device began. ``sent``: all that were tried. ``lost``: those dropped on
        purpose. ``resent``: those of ``sent`` that a receiver asked for.
    """
    def __init__(self, camera, address, loss=0.0, loss_again=0.0, seed=1,
                 observe=lambda frame: None):
        self._camera, self._random = camera, random.Random(seed)
        self._observe = observe
        self._loss, self._loss_again = loss, loss_again
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4 << 20)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF,
                                socket.inet_aton(address))
        self._socket.bind((address, 0))
        self.port = self._socket.getsockname()[1]
        self.sent = self.lost = self.resent = 0
        self._sender = DatagramSender(self._socket)
        self._blocks = {}               # number: (frame, payload bytes, packets)
        self._block = 0
        self._receiver = None
        self._stop, self._thread, self._triggers = None, None, None
        self._lock = threading.Lock()   # of the blocks and of the random generator

    def start(self, receiver, single=False, done=lambda: None, triggered=False):
        """Send every frame from now on, or the next one only, and call ``done`` with its end.

        The stream ends as well, with ``done``, when the receiver's port is unreachable.

        ``triggered``: each one waits for :meth:`trigger`.
        """
        self.stop()
        self._sender.connect(receiver.address)
        self._triggers = threading.Event() if triggered else None
        self._receiver, self._block = receiver, 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(self._stop, single, done),
                                        daemon=True)
        self._thread.start()

    def trigger(self):
        """Let a stream that waits for it send one frame."""
        if self._triggers is not None:
            self._triggers.set()

    def stop(self):
        """End the stream: the frame under way is cut off, and none is sent again."""
        if self._thread is not None:
            self._stop.set()
            if self._thread is not threading.current_thread():
                self._thread.join()
            self._thread = None
        self._forget()

    def _forget(self):
        with self._lock:
            self._blocks.clear()

    def close(self):
        """End the stream for good."""
        self.stop()
        self._socket.close()

    def fire_test(self, receiver):
        """Send one packet of the full size, by which the receiver tests the path."""
        self._set_fragment(receiver.fragment)
        self._sender.send([bytes(receiver.packet_size - 28)], receiver.address)

    def resend(self, block, first, last):
        """Send packets ``first`` to ``last`` of a block again, as far as they are still there.

        They are until :meth:`start` or :meth:`stop`, also after the one frame of a single one.
        """
        with self._lock:
            cached, receiver = self._blocks.get(block), self._receiver
        if cached is None:
            return
        frame, payload, packets = cached
        count = 0
        for packet in range(first, min(last, packets + 1) + 1):
            self._send(self._packet(block, frame, payload, packets, packet), receiver,
                       self._loss_again)
            count += 1
            if self._sender.unreachable:
                self._forget()
                break
        self.resent += count

    def _run(self, stop, single, done):
        receiver, triggers = self._receiver, self._triggers
        self._set_fragment(receiver.fragment)
        number, following = 0, None
        with ThreadPoolExecutor(1) as maker:
            while not stop.is_set():
                if triggers is not None and not triggers.wait(_TRIGGER_SECONDS):
                    continue
                frame = (following.result() if following else
                         self._camera.following(number, stop, triggers is not None))
                if frame is None:
                    break
                number = frame.number
                self._observe(frame)
                if triggers is None and not single:
                    # The next frame is made while this one is on the line.
                    following = maker.submit(self._camera.following, number, stop)
                if triggers is not None:
                    triggers.clear()        # a receiver may trigger again at the last packet
                self.send_frame(frame, receiver, stop, done if single else None)
                if self._sender.unreachable:
                    done()
                    self._forget()
                if single or self._sender.unreachable:
                    break

    def send_frame(self, frame, receiver, stop, done=None):
        """Send a frame to a receiver at the pace of the line, until the Event ``stop`` is set.

        ``done`` is called before the last packet: who has that may begin the next stream.
        """
        self._block = self._block % 0xFFFF + 1
        payload, packets = gvsp.payload_packets(len(frame.data), receiver.packet_size)
        with self._lock:
            self._blocks[self._block] = frame, payload, packets
            while len(self._blocks) > gvsp.STORED_BLOCKS:
                del self._blocks[next(iter(self._blocks))]
        pace = max(receiver.delay_ns,
                   (receiver.packet_size + _LINE_OVERHEAD) * _LINE_NS_PER_BYTE)
        # Packets get lost one by one, and only equal ones can be sent together.
        full = None if self._loss else gvsp.full_packets(self._block, frame.data, payload)
        begin, packet = time.monotonic_ns(), 0
        while packet < packets + 2:
            early = begin + packet * pace - time.monotonic_ns()
            if early > 0:
                time.sleep(early / 1e9)
            if stop.is_set() or self._sender.unreachable:
                return
            count = 0 if full is None or not packet else len(full[packet - 1:packet - 1 + _BATCH])
            if count > 1:
                self.sent += count
                self._sender.send_all(full[packet - 1:packet - 1 + count], receiver.address)
            else:
                count = min(_BATCH if full is None else 1, packets + 2 - packet)
                for number in range(packet, packet + count):
                    if number > packets and done is not None:
                        done()
                    self._send(self._packet(self._block, frame, payload, packets, number),
                               receiver, self._loss)
            packet += count

    def _packet(self, block, frame, payload, packets, packet):
        """The parts of packet number ``packet`` of a block."""
        if packet == 0:
            return [gvsp.leader(block, frame.time_ns, frame.pixel_format, frame.size,
                                frame.offset)]
        if packet > packets:
            return [gvsp.trailer(block, packets + 1, frame.size[1])]
        return [gvsp.header(block, gvsp.PAYLOAD, packet),
                frame.data[(packet - 1) * payload:packet * payload]]

    def _send(self, parts, receiver, loss):
        self.sent += 1
        if loss:
            with self._lock:
                lost = self._random.random() < loss
            if lost:
                self.lost += 1
                return
        self._sender.send(parts, receiver.address)

    def _set_fragment(self, fragment):
        # IP_MTU_DISCOVER: IP_PMTUDISC_DONT (0) lets packets be cut, IP_PMTUDISC_DO (2) does not.
        self._socket.setsockopt(socket.IPPROTO_IP, 10, 0 if fragment else 2)
