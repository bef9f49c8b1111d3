"""Devices over TCP by the paper's Table I and II: this project's own code."""

import socket
import threading
import time
from dataclasses import dataclass
from fractions import Fraction

from ncdc_host.client.device import Device, FeatureInfo, FrameStream, Rate, Statistics, as_kind
from ncdc_host.client.errors import DeviceError, DeviceGone, NoFrame, Rejected
from ncdc_host.client.frame import Frame
from ncdc_spec.errors import InputError
from ncdc_spec.protocols.features import FEATURES, features_of, features_with, system_word
from ncdc_spec.protocols.table_one import MRAW, READ, REQUEST, UNKNOWN, WRITE
from ncdc_spec.protocols.table_two import HEADER_BYTES, MrawHeader
from ncdc_spec.sensors.catalogue import sensor_at

__all__ = ["Connection", "Package", "TableDevice"]

_SECONDS = 5.0          # that an answer may take
_UNKNOWN_TENTHS = 1000  # of frames per second, when asked of a device that does not say
_NUMBER = (system_word("NUMBER_UPPER"), system_word("NUMBER_LOWER"))


@dataclass(frozen=True)
class Package:
    """An MRAW package: its header and the bytes of the picture."""
    header: MrawHeader
    data: bytearray


class Connection:
    """One TCP connection that speaks Table I; requests of several threads do not mix.

    Raises
    ------
    DeviceGone
        If no device answers there.
    """
    def __init__(self, address, port, timeout=_SECONDS, transport=None):
        self.name = f"tcp://{address}:{port}"
        self._lock = threading.Lock()
        self._timeout = timeout
        if transport is not None:       # of a subclass, which sends and receives itself
            self._socket = transport
            return
        try:
            self._socket = socket.create_connection((address, port), timeout)
        except OSError as error:
            raise DeviceGone(f"no device answers at {self.name}: "
                             f"{error.strerror or error}") from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def close(self):
        """End the connection."""
        self._socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def read(self, address):
        """The 16-bit word at ``address``."""
        return self._exchange(READ, address, 0)

    def write(self, address, value):
        """Write a 16-bit word, and return it as read back."""
        return self._exchange(WRITE, address, value)

    def picture(self, timeout=_SECONDS):
        """The newest complete frame, a :class:`Package`.

        Raises
        ------
        NoFrame
            If it did not come in ``timeout`` seconds; the connection is of no use any more.
        DeviceError
            If the header breaks a rule of Table II; likewise.
        """
        with self._lock:
            until = time.monotonic() + timeout
            self._send(bytes([MRAW]))
            first = self._receive(1, until)
            if first[0] == UNKNOWN:
                raise DeviceError(f"{self.name} does not know the command 0x{MRAW:02X}")
            try:
                header = MrawHeader.unpack(bytes(first + self._receive(HEADER_BYTES - 1, until)))
            except InputError as error:
                self.close()
                raise DeviceError(f"{self.name}: {error}") from error
            return Package(header, self._receive(header.size, until))

    def _exchange(self, code, address, value):
        with self._lock:
            self._send(REQUEST.pack(code, address, value))
            answer = self._receive(REQUEST.size, time.monotonic() + self._timeout)
        answered, echoed, value = REQUEST.unpack(answer)
        if (answered, echoed) != (code, address):
            self.close()
            raise DeviceError(f"{self.name} answered 0x{answered:02X} 0x{echoed:04X} to "
                              f"0x{code:02X} 0x{address:04X}")
        return value

    def _send(self, data):
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise DeviceGone(f"{self.name} does not answer any more: "
                             f"{error.strerror or error}") from error

    def _receive(self, count, until):
        data = bytearray(count)
        view, have = memoryview(data), 0
        while have < count:
            try:
                self._socket.settimeout(max(0.001, until - time.monotonic()))
                got = self._socket.recv_into(view[have:])
            except TimeoutError as error:
                self.close()
                raise NoFrame(f"{self.name} sent {have} of {count} bytes in time") from error
            except OSError as error:
                raise DeviceGone(f"{self.name} does not answer any more: "
                                 f"{error.strerror or error}") from error
            if not got:
                raise DeviceGone(f"{self.name} has closed the connection")
            have += got
        return data


class TableDevice(Device):
    """See :class:`Device`; settings and pictures have a connection each, so that neither waits."""

    def __init__(self, address, port, monitor=False):
        self._endpoint = address, port
        self._open(f"tcp://{address}:{port}", Connection(address, port), monitor)

    def _open(self, url, connection, monitor):
        """Ask whether there is a device at all."""
        self.url, self._connection, self._monitor = url, connection, monitor
        self._gone = False
        self._lock = threading.RLock()      # of what takes several words
        try:
            version = self._connection.read(system_word("WIDTH_MAX"))
            sensor = sensor_at(self._connection.read(system_word("SENSOR_ADDRESS")))
            abilities = self._connection.read(system_word("ABILITIES"))
        except NoFrame:
            version = 0
        if not version:
            self._connection.close()
            raise DeviceError(f"{self.url} does not answer as a device does")
        # Over USB, and of an earlier version, a device does not say which sensor it has.
        features = features_of(sensor) if sensor and sensor.controls else FEATURES
        self._features = {one.name: one for one in features_with(features, abilities)
                          if one.parts and not one.lacking}

    @property
    def access(self):
        if self._gone:
            return "lost"
        return "monitor" if self._monitor else "control"

    def names(self):
        return list(self._features)

    def _word(self, call, *values):
        try:
            return call(*values)
        except NoFrame as error:
            self._gone = True
            raise DeviceGone(f"{self.url} does not answer any more") from error
        except DeviceError:
            self._gone = True
            raise

    def _register(self, one):
        """The feature's register, from its words."""
        return one.register(lambda address: self._word(self._connection.read, address))

    def _scale(self, one):
        factor = self._register(self._known(one.scale_from)) if one.scale_from else 1
        return Fraction(factor * one.scale[0], one.scale[1])

    def _value(self, one):
        register = self._register(one)
        if one.kind == "float":
            return float(register * self._scale(one))
        if one.kind == "boolean":
            return bool(register)
        if one.kind == "enumeration":
            return next((choice.name for choice in one.choices if choice.value == register), "")
        return register

    def _known(self, name):
        if name not in self._features:
            raise DeviceError(f"{self.url} has no feature {name!r}")
        return self._features[name]

    def get(self, name):
        with self._lock:
            return self._value(self._known(name))

    def info(self, name):
        one = self._known(name)
        with self._lock:
            value = self._value(one)
            locked = one.locked and self._word(self._connection.read, system_word("STREAMING"))
            low = high = step = None
            if one.kind in ("integer", "float"):
                scale = self._scale(one) if one.kind == "float" else 1
                low, high, step = (
                    float(number * scale) if one.kind == "float" else number
                    for number in (one.low, min(one.high, self._highest(one)), one.step))
        writable = one.access == "rw" and not locked and self.access == "control"
        choices = tuple(choice.name for choice in one.choices if one.kind == "enumeration")
        return FeatureInfo(one.name, one.kind, value, writable, low, high, step, one.unit,
                           choices, one.text, one.category)

    def _highest(self, one):
        values = [self._register(self._known(name)) for name in one.high_from]
        return values[0] - sum(values[1:]) if values else one.high

    def set(self, name, value):
        with self._lock:
            one, info = self._known(name), self.info(name)
            if not info.writable:
                raise Rejected(_why_not(one, info, self.access))
            value = as_kind(info, value)
            words = []
            for part, number in one.writes(self._as_register(one, value)):
                # Bits of the word that are not the feature's stay as they are.
                whole = part.width == 16
                word = 0 if whole else self._word(self._connection.read, part.address)
                word = part.placed(word, number)
                words.append((word, self._word(self._connection.write, part.address, word)))
            if any(sent != answered for sent, answered in words):
                raise Rejected(f"{name} is rejected by {self.url}: {value} was written, "
                               f"{self._value(one)} is read back")
            return self._value(one)

    def _as_register(self, one, value):
        if one.kind == "float":
            register = round(Fraction(value) / self._scale(one))
            return min(max(register, one.low), one.high)
        if one.kind == "enumeration":
            return next(choice.value for choice in one.choices if choice.name == value)
        return int(value)

    def execute(self, name):
        raise DeviceError(f"{self.url} has no command {name!r}: Table I has none")

    def stream(self, packet_size=None, multicast=None):
        if multicast is not None:
            raise DeviceError("Table I has no multicast")
        return TableStream(self, Connection(*self._endpoint))

    def close(self):
        self._connection.close()


def _why_not(one, info, access):
    if access != "control":
        return f"{one.name} is rejected: this user is a monitor"
    if one.access != "rw":
        return f"{one.name} is read-only"
    return f"{one.name} is locked while pictures stream over GVSP"


class TableStream(FrameStream):
    """Asks for the newest frame again and again, at the device's frame rate."""

    def __init__(self, device, connection):
        self._device, self._connection = device, connection
        self._rate, self._frames, self._skipped = Rate(), 0, 0
        self._number, self._due = None, 0.0     # of the last frame; when to ask again
        self._time_us = self._last_us = None

    def _take(self, timeout):
        until = time.monotonic() + timeout
        while True:
            time.sleep(max(0, min(self._due, until) - time.monotonic()))
            left = until - time.monotonic()
            if left <= 0:
                raise NoFrame(f"{self._device.url} made no new picture within {timeout:.3g} s")
            package = self._connection.picture(left)
            upper, lower = map(self._connection.read, _NUMBER)
            number = upper << 16 | lower
            # Over USB a device does not say how many frames per second it has.
            tenths = self._connection.read(system_word("FRAME_RATE")) or _UNKNOWN_TENTHS
            if number == self._number:
                self._due = time.monotonic() + 1 / tenths       # seen already: a bit too early
                continue
            self._due = time.monotonic() + 9 / tenths           # nine tenths of a frame's time
            if self._number is not None:
                self._skipped += max(0, number - self._number - 1)
            self._number, self._frames = number, self._frames + 1
            self._rate.count()
            return Frame.of_bytes(package.data, (package.header.width, package.header.height),
                                  package.header.pixel_format, number,
                                  1000 * self._unwrapped(package.header.time_us))

    def _unwrapped(self, time_us):
        """Microseconds since reset, of a counter of 32 bits that is followed."""
        if self._last_us is None:
            self._time_us = time_us
        else:
            self._time_us += (time_us - self._last_us) % (1 << 32)
        self._last_us = time_us
        return self._time_us

    @property
    def statistics(self):
        return Statistics(self._frames, 0, self._skipped, 0, self._rate.value)

    def close(self):
        self._connection.close()
