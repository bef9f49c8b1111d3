"""What a client does with the simulated system; runs in the client's namespace as a program.

``python -m ncdc.bench.network.peer JSON`` prints a JSON report; see :func:`main`.
"""

import json
import socket
import struct
import sys

import numpy as np

from ncdc_host.client import open_device
from ncdc_model.descriptor import Descriptor
from ncdc_model.interface import gvcp
from ncdc_model.interface.table_one import TCP_PORT

__all__ = ["main"]

_PATIENCE_S = 300
_WIDTH_WORD = 0xF001
# Frames after a change: twelve may wait in Aravis' client, some are under way, one is to show it.
_AFTER_CHANGE = 16


def main(task):
    """The report on a ``task``: a dict with

    - do: "gvcp" or "table", to ask ``count`` times at ``address``; or "pictures": with
    - url: of the device; folder: for pictures; frames: before the changes;
    - changes: (feature, value), or ("lens", file of a descriptor).
    """
    if task["do"] == "pictures":
        return _pictures(task)
    return {"gvcp": _gvcp, "table": _table}[task["do"]](task["address"], task["count"])


def _gvcp(address, count):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        asking.settimeout(_PATIENCE_S)
        for k in range(count):
            place = gvcp.place("HeartbeatTimeout").address
            asking.sendto(struct.pack(">BBHHHI", 0x42, 1, 0x80, 4, k + 1, place), (address, 3956))
            status, code, _, number = struct.unpack(">HHHH", asking.recv(2000)[:8])
            if (status, code, number) != (0, 0x81, k + 1):
                raise SystemExit(f"command {k + 1} was answered {status:#x}, {code:#x}, {number}")
    return {"commands": count}


def _table(address, count):
    with socket.create_connection((address, TCP_PORT), _PATIENCE_S) as asking:
        for _ in range(count):
            asking.sendall(struct.pack(">BHH", 0x80, _WIDTH_WORD, 0))
            answer = b""
            while len(answer) < 5:
                part = asking.recv(5 - len(answer))
                if not part:
                    raise SystemExit("the connection was closed")
                answer += part
    return {"commands": count}


def _pictures(task):
    frames = []
    with open_device(task["url"]) as device, device.stream(task["packet_size"]) as stream:
        def take(count):
            for _ in range(count):
                frame = stream.next(_PATIENCE_S)
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
