"""Devices over GVCP and GVSP, by the package viva-genicam."""

import random
import socket
import threading
import time

from ncdc_host.client.device import FeatureInfo, FrameStream, Rate, Statistics, as_kind
from ncdc_host.client.errors import DeviceError, DeviceGone, NoFrame, NotInstalled, Rejected
from ncdc_host.client.found import Found
from ncdc_host.client.frame import Frame, gvsp_format
from ncdc_host.client.genicam_device import GenicamDevice
from ncdc_host.client.gvcp_questions import Questions
from ncdc_host.client.xml_check import check_xml
from ncdc_spec.needs import pip_line
from ncdc_spec.protocols import gvcp

__all__ = ["VivaDevice", "discover_viva"]

_KINDS = {"Integer": "integer", "Float": "float", "Boolean": "boolean", "Command": "command",
          "Enumeration": "enumeration", "StringReg": "text"}
_BLOCKS = 0xFFFF        # block numbers run from 1 to this and begin again
# viva-genicam's messages if no device answers, or the machine has no listener.
_SILENT = ("timeout", "timed out", "os error")
_ITSELF = "127.0.0.1"   # where viva-genicam asks for a device that was found
_INTRODUCED_MS = 100    # that it listens there
_TRIES = 15
_INTRODUCING = threading.Lock()


def _viva():
    try:
        import viva_genicam
    except ImportError:
        raise NotInstalled("viva-genicam is not installed, which gige:// needs: "
                           f"{pip_line('client')}") from None
    return viva_genicam


def discover_viva(seconds, interface=None):
    """:func:`ncdc_host.client.devices.discover` by viva-genicam."""
    viva = _viva()
    try:
        found = viva.discover(round(1000 * seconds), interface, all=interface is None)
    except viva.GenicamError as error:
        raise DeviceError(f"discovery failed: {_sentence(error)}") from error
    return [Found(f"gige://{one.ip}", one.ip, one.mac.lower(), one.manufacturer or "",
                  one.model or "")
            for one in sorted(found, key=lambda one: tuple(map(int, one.ip.split("."))))]


def _sentence(error):
    return str(error).strip().rstrip(".").replace("\n", " ")


def _introduced(viva, address, acknowledge):
    """viva-genicam's own description of a device whose discovery ``acknowledge`` is known.

    It describes only devices that answer a broadcast, and a broadcast passes no router. Here this
    machine answers its own broadcast with the device's bytes. If several clients do so at once,
    one receives all broadcasts and the others try again.
    """
    # A device behind a router that translates addresses has another address itself.
    at = gvcp.register("IpAddress").address
    acknowledge = acknowledge[:at] + socket.inet_aton(address) + acknowledge[at + 4:]
    for _ in range(_TRIES):
        with _INTRODUCING:
            found = _broadcast(viva, address, acknowledge)
        if found is not None:
            return found
        time.sleep(random.uniform(0, 2 * _INTRODUCED_MS / 1000))
    raise DeviceGone(f"viva-genicam does not find the device at {address}")


def _broadcast(viva, address, acknowledge):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            one.bind((_ITSELF, gvcp.PORT))
        except OSError as error:
            raise DeviceError(f"UDP port {gvcp.PORT} of this machine cannot be used: "
                              f"{error.strerror}") from error
        answering = threading.Thread(target=_answer_itself, args=(one, acknowledge), daemon=True)
        answering.start()
        found = viva.discover(_INTRODUCED_MS, _ITSELF, all=True)
        answering.join()
    return next((each for each in found if each.ip == address), None)


def _answer_itself(one, acknowledge):
    until = time.monotonic() + _INTRODUCED_MS / 1000
    try:
        while (left := until - time.monotonic()) > 0:
            one.settimeout(left)
            data, peer = one.recvfrom(2048)
            command = gvcp.parse_command(data)
            if (command is not None and command.code == gvcp.DISCOVERY
                    and peer[0].startswith("127.")):
                one.sendto(gvcp.acknowledge(command, gvcp.SUCCESS, acknowledge), peer)
    except OSError:
        pass            # the time is over


class VivaDevice(GenicamDevice):
    """See :class:`Device`."""

    def __init__(self, address, monitor=False, seconds=1.0):
        self._viva = viva = _viva()
        self.url = f"gige://{address}"
        with Questions(address, seconds) as questions:
            acknowledge = questions.discovery()
            # viva-genicam crashes at some XML, and this process with it.
            checked = check_xml(questions.xml())
            address, interface = questions.address, questions.own_address
        try:
            found = _introduced(viva, address, acknowledge)
            self._camera = viva.connect_gige(found, interface, monitor)
        except viva.GenicamError as error:
            raise Rejected(f"{address} cannot be opened, perhaps another user has control: "
                          f"{_sentence(error)}") from error
        self._check_parsed(checked)
        self._lock = threading.RLock()
        self._categories = {name: category
                            for category, names in self._camera.categories().items()
                            for name in names}
        self._kinds = {node.name: _KINDS[node.kind] for node in self._camera.all_node_info()
                       if node.kind in _KINDS and node.name in self._categories}

    def _check_parsed(self, checked):
        """Close the camera and raise :class:`DeviceError` if viva-genicam has read XML that is not
        ``checked`` and would crash it: a device may show another one at every read."""
        parsed = self._camera.xml.encode()
        if parsed == checked:
            return
        try:
            check_xml(parsed)
        except DeviceError:
            self._camera.close()
            raise

    def _call(self, name, call):
        """``call()`` with what goes wrong as a :class:`DeviceError` that names the feature."""
        viva = self._viva
        try:
            with self._lock:
                return call()
        except viva.GenicamError as error:
            # A silent device is a TransportError of some calls, and a GenApiError of features.
            text = _sentence(error)
            if any(sign in text.lower() for sign in _SILENT):
                raise DeviceGone(f"{self.url} does not answer any more: {text}") from error
            raise Rejected(f"{name} is rejected: {text}") from error

    @property
    def access(self):
        state = self._camera.control_state.value
        return {"Held": "control", "Monitor": "monitor"}.get(state, "lost")

    def info(self, name):
        kind = self._kind(name)
        state = self._call(name, lambda: self._camera.feature_state(name))
        node = self._call(name, lambda: self._camera.node_info(name))
        limits = state.range
        whole = int if kind == "integer" else float
        low, high, step = (None if limits is None or value is None else whole(value) for value in
                           (limits and limits.min, limits and limits.max, limits and limits.inc))
        return FeatureInfo(name, kind, state.value,
                           state.access in ("RW", "WO") and self.access == "control", low, high,
                           step, state.unit or "", tuple(state.enum_entries or ()),
                           node.description or "", self._categories[name])

    def get(self, name):
        self._kind(name)
        return self._call(name, lambda: self._camera.feature_state(name)).value

    def set(self, name, value):
        info = self.info(name)
        if not info.writable:
            raise Rejected(_why_not(info, self.access))
        value = as_kind(info, value)
        camera = self._camera
        write = {"integer": camera.set_integer, "float": camera.set_float,
                 "boolean": camera.set_bool, "enumeration": camera.set_enum,
                 "text": camera.set_string}.get(info.kind)
        if write is None:
            raise Rejected(f"{name} is a command: execute it")
        self._call(name, lambda: write(name, value))
        return self.get(name)

    def execute(self, name):
        self._kind(name)
        self._call(name, lambda: self._camera.execute(name))

    def stream(self, packet_size=None, multicast=None):
        monitor = self.access == "monitor"
        native = self._call("the stream", lambda: self._camera.stream(
            packet_size=None if monitor else packet_size,
            multicast=None if monitor else multicast, monitor=monitor))
        return VivaStream(self, native, self._viva)

    def read_memory(self, address, count):
        return self._call("memory", lambda: self._camera.read_register(address, count))

    def write_memory(self, address, data):
        self._call("memory", lambda: self._camera.write_register(address, data))

    def close(self):
        self._camera.close()


def _why_not(info, access):
    if access == "monitor":
        return f"{info.name} is rejected: this user is a monitor, another one has control"
    if access == "lost":
        return f"{info.name} is rejected: control is lost"
    return (f"{info.name} cannot be written now: it is read-only, automatic, or locked "
            "while pictures stream")


class VivaStream(FrameStream):
    """See :class:`FrameStream`."""

    def __init__(self, device, native, viva):
        self._device, self._native, self._viva = device, native, viva
        self._rate, self._block, self._number, self._final = Rate(), 0, 0, None
        # A monitor joins in the middle of a frame, which is not lost: None until it has one.
        self._before = None if device.access == "monitor" else 0
        device._call("the stream", native.__enter__)

    def _take(self, timeout):
        viva = self._viva
        try:
            frame = self._native.next_frame(max(1, round(1000 * timeout)))
        except viva.GenicamError as error:
            if self._device.access == "lost":
                raise DeviceGone(f"{self._device.url} does not answer any more") from error
            raise NoFrame(f"no picture within {timeout:.3g} s: {_sentence(error)}") from error
        if frame is None:
            raise DeviceGone(f"the stream of {self._device.url} has ended")
        number = self._number + ((frame.block_id - self._block) % _BLOCKS or _BLOCKS)
        made = Frame.of_bytes(frame.payload(), (frame.width, frame.height),
                              gvsp_format(frame.pixel_format_code), number, frame.ts_dev or 0)
        self._number, self._block = number, frame.block_id
        self._rate.count()
        if self._before is None:
            self._before = _lost(self._native.stats())
        return made

    @property
    def statistics(self):
        counted = self._final or self._native.stats()
        return Statistics(counted.frames_complete - self.malformed,
                          _lost(counted) - (self._before or 0) + self.malformed,
                          counted.frames_backpressure, counted.resend_recovered,
                          self._rate.value)

    def close(self):
        if self._final is None:
            self._final = self._native.stats()
            try:
                self._native.__exit__(None, None, None)
            except self._viva.GenicamError:
                pass        # the device is gone, and the stream with it


def _lost(counted):
    return counted.frames_incomplete + counted.frames_missed
