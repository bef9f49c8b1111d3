"""An emulated device: both protocols on one state."""

import select
import socket
import threading
import time
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.metadata import version
from ipaddress import IPv4Address

from ncdc_host.device.auto_control import AutoControl
from ncdc_host.device.camera import Camera
from ncdc_host.device.control import ControlAgent, Identity
from ncdc_host.device.corrector_window import CorrectorWindow
from ncdc_host.device.light import MovingScene, Photo
from ncdc_host.device.registers import Registers
from ncdc_host.device.stream import Stream
from ncdc_host.device.table_server import TableServer
from ncdc_model.correction import Correction
from ncdc_spec.eeprom import NO_CHIP
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MONO
from ncdc_spec.protocols.gvcp import DISCOVERY, FORCEIP, PORT, parse_command
from ncdc_spec.protocols.table_one import TCP_PORT
from ncdc_spec.sensors.catalogue import controlled_sensor
from ncdc_spec.view_matrix import PlaneCamera, has_plane

__all__ = ["Announcer", "DeviceOptions", "EmulatedDevice", "lens_corrections"]

_DATAGRAM = 2048        # bytes; a longer one is no GVCP command


@dataclass(frozen=True)
class DeviceOptions:
    """Options of an emulated device.

    Parameters
    ----------
    address : str
        IPv4 address of this machine that the device answers at.
    serial : str
        Up to 15 characters; of the address if empty, as Aravis takes two devices of one number
        for one.
    fps : float
        Frames per second after reset, 0.1 to 120.
    loss, loss_again : float
        Shares of GVSP packets lost on purpose, when sent first and when sent again, 0 to 0.5.
    noise : float
        Read noise, grey levels, 0 to 50.
    tcp_port : int
        Port of Table I; 0: a free one.
    field : str
        Part of the sensor that raw frames show, as of
        :func:`ncdc_spec.sensors.framing.setup_around`; None: the middle, pixel by pixel.
    sensor : str
        Name of its sensor.
    eeprom : int
        What the feature EepromStatus shows, a number among :data:`ncdc_spec.eeprom.STATES`.

    Raises
    ------
    InputError
        If a value is outside its limits, or no device with that sensor is emulated.
    """
    address: str = "127.0.0.1"
    serial: str = ""
    fps: float = 30.0
    loss: float = 0.0
    loss_again: float = 0.0
    noise: float = 1.0
    tcp_port: int = TCP_PORT
    field: str = None
    sensor: str = "mt9p031"
    eeprom: int = NO_CHIP

    def __post_init__(self):
        for name, low, high in (("fps", 0.1, 120), ("loss", 0, 0.5), ("loss_again", 0, 0.5),
                                ("noise", 0, 50)):
            if not low <= getattr(self, name) <= high:
                raise InputError(f"{name} is {getattr(self, name):g}, the limits are {low} and "
                                 f"{high}")
        controlled_sensor(self.sensor)
        try:
            socket.inet_aton(self.address)
            number = int(IPv4Address(self.address))
        except (OSError, ValueError):
            raise InputError(f"the address {self.address!r} is no IPv4 address") from None
        if not self.serial:
            object.__setattr__(self, "serial", f"EMU-{number:08X}")


def lens_corrections(descriptors):
    """The :class:`Correction` of each descriptor, the lenses of a device.

    Raises
    ------
    InputError
        If a side is odd, the sensor grey, or two lenses differ in what a change of lens cannot
        change.
    """
    first = descriptors[0]
    for value in (*first.geometry.corrected, *first.geometry.distorted):
        if value % 2:
            raise InputError(f"a side of the picture has {value} pixels, an emulated device needs "
                             "even sides")
    if first.geometry.mono:
        raise InputError(f"the lens is for a grey sensor ({MONO}), that of an emulated device has "
                         f"a colour filter")
    for k, other in enumerate(descriptors[1:], 2):
        own, needed = (d.geometry.interpolation.name for d in (other, first))
        if own != needed:
            raise InputError(f"lens {k} is for the interpolation {own}, the first one for "
                             f"{needed}")
        if other.geometry != first.geometry:
            raise InputError(f"lens {k} has other sizes, Bayer pattern or fill than the first one")
        if other.nodes != first.nodes:
            raise InputError(f"lens {k} has nodes {other.nodes} pixels apart, the first one "
                             f"{first.nodes}")
    return [Correction(descriptor) for descriptor in descriptors]


def _planes(corrections):
    """Cameras of the lenses' corrected pictures; none if a lens cannot have a view."""
    lenses = [correction.descriptor for correction in corrections]
    if not all(has_plane(lens) and lens.nodes > 1 for lens in lenses):
        return ()
    return [PlaneCamera.of(lens) for lens in lenses]


class EmulatedDevice:
    """A device that is there from construction to :meth:`close`.

    Parameters
    ----------
    corrections : list of Correction
        Result of :func:`lens_corrections`; several devices may share it.
    options : DeviceOptions
    image : ndarray, optional
        Photo that its camera looks at; the built-in scene in motion if absent.

    Attributes
    ----------
    registers : Registers
    camera : Camera
    stream : Stream
    agent : ControlAgent
    table : TableServer

    Raises
    ------
    InputError
        If the address is not this machine's or is in use, or the photo is of another size.
    """
    def __init__(self, corrections, options=DeviceOptions(), image=None):
        self.options = options
        descriptor = corrections[0].descriptor
        light = MovingScene(descriptor) if image is None else Photo(image, descriptor.geometry)
        self.registers = Registers(descriptor.geometry, len(corrections), round(10 * options.fps),
                                   options.field, options.sensor, _planes(corrections))
        self.camera = Camera(light, corrections, self.registers, options.noise)
        self._closed = threading.Event()
        with ExitStack() as opened:
            try:
                self.table = TableServer(self.registers, self.camera, options.address,
                                         options.tcp_port)
                opened.callback(self.table.close)
                self.stream = Stream(self.camera, options.address, options.loss,
                                     options.loss_again,
                                     observe=AutoControl(self.registers).observe)
                opened.callback(self.stream.close)
                self._socket = _udp(options.address)
            except OSError as error:
                raise InputError(f"cannot answer at {options.address}: "
                                 f"{error.strerror}") from error
            opened.pop_all()
        self.agent = ControlAgent(
            Identity(options.address, options.serial, version("ncdc"), eeprom=options.eeprom),
            self.registers,
            self.camera, self.stream, CorrectorWindow(self.registers, self.camera))
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self):
        """Take the device off the network."""
        self._closed.set()
        self._thread.join()
        self.stream.close()
        self.table.close()
        self._socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def answer(self, data, peer):
        """Answer a datagram that ``peer`` sent to this device, or to every device."""
        for answer in self.agent.answers(data, peer):
            self._socket.sendto(answer, peer)

    def _serve(self):
        while not self._closed.is_set():
            ready, _, _ = select.select([self._socket], [], [], 0.1)
            self.agent.tick(time.monotonic())
            if ready:
                _receive(self._socket, self.answer)


class Announcer:
    """Lets the devices of this process answer a discovery that is sent to everybody.

    Without it a device is found by its address alone. Also what is sent to an address of this
    machine without a device arrives here: only discoveries and FORCEIP are answered.
    """
    def __init__(self, devices):
        self._devices = list(devices)
        self._socket = _udp("")
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self):
        """End listening; the devices stay."""
        self._closed.set()
        self._thread.join()
        self._socket.close()

    def _serve(self):
        while not self._closed.is_set():
            ready, _, _ = select.select([self._socket], [], [], 0.1)
            if ready:
                _receive(self._socket, self._answer)

    def _answer(self, data, peer):
        command = parse_command(data)
        if command is not None and command.code in (DISCOVERY, FORCEIP):
            for device in self._devices:
                device.answer(data, peer)


def _receive(one, answer):
    try:
        answer(*one.recvfrom(_DATAGRAM))
    except OSError:
        pass        # a peer that is gone


def _udp(address):
    """A socket on GVCP's port; several devices share it, each at its own address."""
    one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    one.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
    one.bind((address, PORT))
    return one
