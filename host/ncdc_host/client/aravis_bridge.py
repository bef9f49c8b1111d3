"""Runs under the system's Python, which has Debian's Aravis, and serves it to the client's.

Each request is a line of JSON, [name, arguments...]. Each answer is a line of JSON, {"ok": value}
or {"error": text}; one with "bytes" is followed by that many bytes of a picture. The module imports
nothing of this project, which the system's Python does not have.
"""

import json
import sys
import time

__all__ = ["main"]

_RETENTION_US = 3_000_000   # a busy machine may take longer over a frame than Aravis' 0.1 s
_PACKET_TIMEOUT_US = 5_000  # a missing packet is asked for again after so long, if the device
_PER_ANSWER = 20            # answers in a 20th of it
_ANSWERS = 3                # of which the fastest counts
_CONTROL_PRIVILEGE = 0x0A00
_REQUEST_RATIO = 1.0        # of a frame's packets may be asked for again, not a quarter of them
_SOCKET_BYTES = 4 << 20     # what comes while this machine is busy; the kernel may allow less
_BUFFERS = 12               # pictures that may wait for whoever takes them


def main():
    """Serve requests until standard input ends."""
    try:
        import gi
        gi.require_version("Aravis", "0.8")
        from gi.repository import Aravis, GLib
    except (ImportError, ValueError) as error:
        _answer({"error": f"Aravis is missing: {error}"})
        return
    _answer({"ok": "ready"})
    bridge = _Bridge(Aravis)
    for line in sys.stdin:
        name, *arguments = json.loads(line)
        try:
            value = getattr(bridge, name)(*arguments)
            data = b""
            if isinstance(value, tuple):
                value, data = value
            _answer({"ok": value, **({"bytes": len(data)} if data else {})}, data)
        except GLib.Error as error:
            _answer({"error": error.message})
        except LookupError as error:
            _answer({"error": str(error)})


def _answer(value, data=b""):
    sys.stdout.buffer.write(json.dumps(value).encode() + b"\n" + data)
    sys.stdout.buffer.flush()


class _Bridge:
    def __init__(self, aravis):
        self._aravis = aravis
        self._camera = self._device = self._stream = None

    def discover(self):
        a = self._aravis
        a.update_device_list()
        return [[a.get_device_address(k), a.get_device_physical_id(k), a.get_device_vendor(k),
                 a.get_device_model(k), a.get_device_serial_nbr(k)]
                for k in range(a.get_n_devices()) if a.get_device_protocol(k) == "GigEVision"]

    def open(self, address, monitor):
        self._camera = self._aravis.Camera.new(address)
        self._device = self._camera.get_device()
        if monitor:
            self._device.leave_control()
        genicam = self._device.get_genicam()
        found = []
        for category in genicam.get_node("Root").get_features():
            for name in genicam.get_node(category).get_features():
                found.append([name, category, self._kind(name)])
        return found

    def _kind(self, name):
        a, node = self._aravis, self._device.get_feature(name)
        for kind, classes in (("command", [a.GcCommand]), ("boolean", [a.GcBoolean]),
                              ("enumeration", [a.GcEnumeration]), ("text", [a.GcString]),
                              ("integer", [a.GcInteger]), ("float", [a.GcFloat])):
            if any(isinstance(node, one) for one in classes):
                return kind
        return "other"

    def controls(self):
        return self._device.is_controller()

    def get(self, name, kind):
        d = self._device
        read = {"integer": d.get_integer_feature_value, "float": d.get_float_feature_value,
                "boolean": d.get_boolean_feature_value, "text": d.get_string_feature_value,
                "enumeration": d.get_string_feature_value}.get(kind)
        return None if read is None else read(name)

    def info(self, name, kind):
        d, node = self._device, self._device.get_feature(name)
        limits, choices = [None, None, None], []
        if kind == "integer":
            limits = [*d.get_integer_feature_bounds(name), d.get_integer_feature_increment(name)]
        elif kind == "float":
            limits = [*d.get_float_feature_bounds(name), None]
        elif kind == "enumeration":
            choices = list(d.dup_available_enumeration_feature_values_as_strings(name))
        locked = node.is_locked()
        access = node.get_actual_access_mode()
        writable = access in (self._aravis.GcAccessMode.RW, self._aravis.GcAccessMode.WO)
        unit = node.get_unit() or "" if kind in ("integer", "float") else ""
        return [self.get(name, kind), writable and not locked, limits, unit, choices,
                node.get_description() or ""]

    def set(self, name, kind, value):
        d = self._device
        {"integer": d.set_integer_feature_value, "float": d.set_float_feature_value,
         "boolean": d.set_boolean_feature_value, "text": d.set_string_feature_value,
         "enumeration": d.set_string_feature_value}[kind](name, value)
        return self.get(name, kind)

    def execute(self, name):
        self._device.execute_command(name)

    # Word by word: the bindings of Aravis' own calls for memory want a pointer.
    def read_memory(self, address, count):
        return [self._device.read_register(address + k) for k in range(0, count, 4)]

    def write_memory(self, address, words):
        for k, word in enumerate(words):
            self._device.write_register(address + 4 * k, word)

    def start(self, packet_size, packet_timeout_us):
        if packet_size:
            self._camera.gv_set_packet_size(packet_size)
        self._stream = self._camera.create_stream(None, None)
        timeout = packet_timeout_us or self._packet_timeout_us()
        for name, value in (("packet-timeout", timeout),
                            ("frame-retention", max(_RETENTION_US, 4 * timeout)),
                            ("packet-request-ratio", _REQUEST_RATIO),
                            ("socket-buffer-size", _SOCKET_BYTES)):
            self._stream.set_property(name, value)
        for _ in range(_BUFFERS):
            self._stream.push_buffer(self._aravis.Buffer.new_allocate(self._camera.get_payload()))
        self._camera.start_acquisition()

    def _packet_timeout_us(self):
        """Aravis' own, or less if the device answers fast: it keeps a frame until the next but one,
        within which a packet may have to be asked for several times."""
        answers = []
        for _ in range(_ANSWERS):
            begin = time.monotonic()
            self._device.read_register(_CONTROL_PRIVILEGE)
            answers.append(time.monotonic() - begin)
        return min(self._stream.get_property("packet-timeout"),
                   max(_PACKET_TIMEOUT_US, round(_PER_ANSWER * 1e6 * min(answers))))

    def next(self, seconds):
        """A picture, or null; a picture that is not whole is counted by its status alone."""
        buffer = self._stream.timeout_pop_buffer(round(1e6 * seconds))
        if buffer is None:
            return None
        whole = buffer.get_status() == self._aravis.BufferStatus.SUCCESS
        head = [whole, buffer.get_frame_id(), buffer.get_timestamp()]
        data = b""
        if whole:
            width, height = buffer.get_image_width(), buffer.get_image_height()
            head += [buffer.get_image_pixel_format(), width, height]
            data = buffer.get_data()        # what was received, not all of the buffer
        self._stream.push_buffer(buffer)
        return head, data

    def statistics(self):
        """Packets that came at the second try; frames for which no buffer was free."""
        # GvStream hides a method of this name by its own: one counts packets, one buffers.
        packets = self._aravis.GvStream.get_statistics(self._stream)
        buffers = self._aravis.Stream.get_statistics(self._stream)
        return [packets[0], buffers[2]]

    def stop(self):
        if self._stream is not None:
            try:
                self._camera.stop_acquisition()
            finally:
                self._stream = None


if __name__ == "__main__":
    main()
