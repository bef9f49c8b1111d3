"""Devices over GVCP and GVSP, by Aravis: the second back end, in a process of its own.

Debian has Aravis for the system's Python alone, so that the bridge runs there.
"""

import json
import select
import struct
import subprocess
import threading
import time
from pathlib import Path

from ncdc_host.client.device import FeatureInfo, FrameStream, Rate, Statistics, as_kind
from ncdc_host.client.errors import DeviceError, DeviceGone, NoFrame, Rejected
from ncdc_host.client.found import Found
from ncdc_host.client.frame import Frame, gvsp_format
from ncdc_host.client.genicam_device import GenicamDevice

__all__ = ["AravisDevice", "discover_aravis"]

_PYTHON = "/usr/bin/python3"
_BRIDGE = Path(__file__).with_name("aravis_bridge.py")
# Seconds that an answer of Aravis may take. At some XML it never ends; a simulated device is slow.
_SECONDS = {"open": 300.0}
_SECONDS_ELSE = 60.0
_SLICE = 0.05           # seconds that a wait for a picture keeps other calls waiting


class _Bridge:
    """The process; its calls raise :class:`DeviceError`."""

    def __init__(self):
        self._lock = threading.Lock()
        try:
            self._process = subprocess.Popen([_PYTHON, "-I", str(_BRIDGE)], stdin=subprocess.PIPE,
                                             stdout=subprocess.PIPE)
            self._answer()
        except OSError as error:
            raise DeviceError(f"{_PYTHON} cannot be run: {error.strerror}") from error
        except DeviceError as error:
            self.close()
            raise DeviceError(f"{error}; aravis:// needs Debian's gir1.2-aravis-0.8 and "
                              "python3-gi") from error

    def call(self, name, *arguments):
        """The answer's value; with the bytes after it if there are any."""
        with self._lock:
            try:
                self._process.stdin.write(json.dumps([name, *arguments]).encode() + b"\n")
                self._process.stdin.flush()
            except (OSError, ValueError) as error:
                raise DeviceGone("the process of Aravis has ended") from error
            return self._answer(_SECONDS.get(name, _SECONDS_ELSE))

    def _answer(self, seconds=_SECONDS_ELSE):
        # One answer to each request: nothing of it is in the buffer already.
        if not select.select([self._process.stdout], [], [], seconds)[0]:
            self._process.kill()
            raise DeviceGone(f"Aravis has not answered for {seconds:g} seconds: its process "
                             "is ended")
        line = self._process.stdout.readline()
        if not line:
            raise DeviceGone("the process of Aravis has ended")
        answer = json.loads(line)
        if "error" in answer:
            raise Rejected(answer["error"])
        if "bytes" in answer:
            return answer["ok"], self._process.stdout.read(answer["bytes"])
        return answer["ok"]

    def close(self):
        self._process.stdin.close()
        try:
            self._process.wait(3)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()


def discover_aravis(seconds):
    """:func:`ncdc_host.client.devices.discover` by Aravis, which waits as long as it likes."""
    bridge = _Bridge()
    try:
        return sorted((Found(f"aravis://{address}", address, *rest)
                       for address, *rest in bridge.call("discover")),
                      key=lambda found: tuple(map(int, found.address.split("."))))
    finally:
        bridge.close()


class AravisDevice(GenicamDevice):
    """See :class:`Device`.

    Attributes
    ----------
    packet_timeout_us : int or None
        Without a packet for so long, one that is missing is asked for again; None: 5 ms to 20 ms,
        by how fast the device answers. For streams that begin from now on, of a device slower than
        the clock on the wall.
    """

    def __init__(self, address, monitor=False):
        self.url = f"aravis://{address}"
        self._monitor, self._closed, self._stream = monitor, False, None
        self.packet_timeout_us = None
        self._bridge = _Bridge()
        try:
            found = self._bridge.call("open", address, monitor)
            if not monitor and not self._bridge.call("controls"):
                raise Rejected(f"{address} cannot be opened: another user has control")
        except Rejected as error:
            self._bridge.close()
            if "not found" in str(error).lower() or "can't connect" in str(error).lower():
                raise DeviceGone(f"no device answers at {address}") from error
            raise
        self._kinds = {name: kind for name, _, kind in found if kind != "other"}
        self._categories = {name: category for name, category, _ in found}

    @property
    def access(self):
        if self._closed:
            return "lost"
        if self._monitor:
            return "monitor"
        return "control" if self._bridge.call("controls") else "lost"

    def info(self, name):
        kind = self._kind(name)
        value, writable, limits, unit, choices, text = self._bridge.call("info", name, kind)
        low, high, step = limits
        return FeatureInfo(name, kind, value, writable and not self._monitor, low, high, step, unit,
                           tuple(choices), text, self._categories[name])

    def get(self, name):
        return self._bridge.call("get", name, self._kind(name))

    def set(self, name, value):
        info = self.info(name)
        if not info.writable:
            raise Rejected(f"{name} cannot be written now: it is read-only or locked, or this user "
                          "has no control")
        try:
            return self._bridge.call("set", name, info.kind, as_kind(info, value))
        except Rejected as error:
            raise Rejected(f"{name} is rejected: {error}") from error

    def execute(self, name):
        self._kind(name)
        self._bridge.call("execute", name)

    def stream(self, packet_size=None, multicast=None):
        if multicast is not None or self._monitor:
            raise DeviceError("aravis:// has no multicast and no stream for a monitor: use gige://")
        self._bridge.call("start", packet_size, self.packet_timeout_us)
        return AravisStream(self, self._bridge)

    def read_memory(self, address, count):
        words = self._bridge.call("read_memory", address, count)
        return b"".join(word.to_bytes(4, "big") for word in words)

    def write_memory(self, address, data):
        self._bridge.call("write_memory", address, list(struct.unpack(f">{len(data) // 4}I", data)))

    def close(self):
        if not self._closed:
            self._closed = True
            self._bridge.close()


class AravisStream(FrameStream):
    """See :class:`FrameStream`."""

    def __init__(self, device, bridge):
        self._device, self._bridge = device, bridge
        self._rate, self._frames, self._broken = Rate(), 0, 0
        self._resent = self._untaken = 0
        self._first = self._last = None
        self._closed = False

    def _take(self, timeout):
        until = time.monotonic() + timeout
        while True:
            left = until - time.monotonic()
            if left <= 0:
                if self._device.access == "lost":
                    raise DeviceGone(f"{self._device.url} does not answer any more")
                raise NoFrame(f"no picture within {timeout:.3g} s")
            got = self._bridge.call("next", min(left, _SLICE))
            if got is None:
                continue
            if isinstance(got[0], bool):        # not whole: no bytes after it
                self._broken += 1
                continue
            (_, number, time_ns, code, width, height), data = got
            made = Frame.of_bytes(data, (width, height), gvsp_format(code), number, time_ns)
            self._frames += 1
            self._first, self._last = self._first or number, number
            self._rate.count()
            return made

    @property
    def statistics(self):
        if not self._closed:
            self._resent, self._untaken = self._bridge.call("statistics")
        missed = 0 if self._last is None else self._last - self._first + 1 - self._frames
        lost = max(missed - self._untaken, self._broken + self.malformed)
        return Statistics(self._frames, lost, self._untaken, self._resent, self._rate.value)

    def close(self):
        if not self._closed:
            self.statistics
            self._closed = True
            if not self._device._closed:
                self._bridge.call("stop")
