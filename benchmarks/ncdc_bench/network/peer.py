"""A client's work with the simulated system; runs in the client's namespace as a program.

``python -m ncdc_bench.network.peer JSON`` prints a JSON report; see :func:`main`.
"""

import json
import socket
import struct
import sys
import time

import numpy as np

from ncdc_host.client import open_device
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.table_one import TCP_PORT

__all__ = ["main"]

_TIMEOUT_S = 300
# A missing packet is requested again after the time of so many on the simulated wire. Aravis' own
# 20 ms are the time of two, as a second of the device takes six hundred.
_PACKETS = 100
_PACKET_US = 12                 # of the device's clock
_SPEED_S = 0.3                  # in which its speed is measured
_WIDTH_WORD = 0xF001
# Frames after a change: twelve may wait in Aravis' client, some are under way, one is to show it.
_AFTER_CHANGE = 16


def main(task):
    """The report on a ``task``: a dict with

    - do: "gvcp" or "table", to ask ``count`` times at ``address``; "register", to read the
      word at the address ``register`` of its memory; or "pictures": with
    - url: of the device; folder: for pictures; frames: before the changes;
    - changes: (feature, value), or ("lens", file of a descriptor).
    """
    if task["do"] == "pictures":
        return _pictures(task)
    if task["do"] == "register":
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
            asking.settimeout(_TIMEOUT_S)
            return _register(asking, task["address"], task["register"], 1)
    return {"gvcp": _gvcp, "table": _table}[task["do"]](task["address"], task["count"])


def _gvcp(address, count):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        asking.settimeout(_TIMEOUT_S)
        for k in range(count):
            _register(asking, address, gvcp.register("HeartbeatTimeout").address, k + 1)
    return {"commands": count}


def _register(asking, address, register, number):
    """The word at an address of the device's memory, by command ``number``."""
    asking.sendto(gvcp.command_packet(gvcp.READREG, number, struct.pack(">I", register)),
                  (address, gvcp.PORT))
    status, code, answered, word = gvcp.parse_acknowledge(asking.recv(2000))
    if (status, code, answered) != (gvcp.SUCCESS, gvcp.READREG + 1, number):
        raise SystemExit(f"command {number} was answered {status:#x}, {code:#x}, {answered}")
    return int.from_bytes(word, "big")


def _table(address, count):
    with socket.create_connection((address, TCP_PORT), _TIMEOUT_S) as asking:
        for _ in range(count):
            asking.sendall(struct.pack(">BHH", 0x80, _WIDTH_WORD, 0))
            answer = b""
            while len(answer) < 5:
                part = asking.recv(5 - len(answer))
                if not part:
                    raise SystemExit("the connection was closed")
                answer += part
    return {"commands": count}


def _slowness(device):
    """Seconds on the wall that a second of the device's clock takes."""
    def latched():
        device.write_memory(gvcp.register("TimestampControl").address, struct.pack(">I", 2))
        return int.from_bytes(device.read_memory(gvcp.register("TimestampHigh").address, 8), "big")
    begin, first = time.monotonic(), latched()
    time.sleep(_SPEED_S)
    return (time.monotonic() - begin) / (latched() - first) * 1e9


def _pictures(task):
    with open_device(task["url"]) as device:
        if task["url"].startswith("aravis:"):
            device.packet_timeout_us = round(_slowness(device) * _PACKET_US * _PACKETS)
        return _take(task, device)


def _take(task, device):
    frames = []
    with device.stream(task["packet_size"]) as stream:
        def take(count):
            for _ in range(count):
                frame = stream.next(_TIMEOUT_S)
                np.save(f"{task['folder']}/{len(frames)}.npy", frame.pixels)
                frames.append([frame.number, frame.time_ns])
        take(1)
        print("streaming", file=sys.stderr, flush=True)
        take(task["frames"] - 1)
        for name, value in task["changes"]:
            if name == "lens":
                device.load_lens(Descriptor.load(value))
            else:
                device.set(name, value)
            take(_AFTER_CHANGE)
        counted = stream.statistics
    return {"frames": frames, "resent": counted.resent, "lost": counted.lost}


if __name__ == "__main__":
    print(json.dumps(main(json.loads(sys.argv[1]))))
