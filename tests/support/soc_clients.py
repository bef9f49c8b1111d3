"""Clients of the whole system in simulation, by Debian's Aravis, and the frames that they took."""

import json
import sys

import numpy as np

from ncdc_sim.system.soc import ADDRESS

__all__ = ["OPEN", "SIZE", "matches", "peer"]

SIZE = (64, 48)


def peer(run, script, folder, *arguments):
    """Run a ``script`` on the clients' side: what it prints as its last line, in JSON."""
    done = run.network.run([sys.executable, "-c", script, f"aravis://{ADDRESS}", str(folder),
                            *map(json.dumps, arguments)], timeout=900)
    assert not done.returncode, done.stderr + run.screen
    return json.loads(done.stdout.splitlines()[-1])


# Begins a script: the device, and what takes a frame of its stream into the folder.
OPEN = """
import json, sys
import numpy as np
from ncdc_host.client.devices import open_device
url, folder, *arguments = sys.argv[1:]
arguments = [json.loads(text) for text in arguments]
device = open_device(url)
taken = []
def take(stream):
    frame = stream.next(300)
    np.save(f"{folder}/{len(taken)}.npy", frame.pixels)
    taken.append(frame.number)
"""


def matches(folder, count, goldens):
    """For each frame the number of the golden picture that it equals; None: of none."""
    return [next((k for k, golden in enumerate(goldens)
                  if np.array_equal(np.load(f"{folder}/{number}.npy"), golden)), None)
            for number in range(count)]
