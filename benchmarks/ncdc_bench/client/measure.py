"""Peers with emulated devices, in a network of their own: one row a case."""

import json
import os
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ncdc_model.correction import correct
from ncdc_model.example import example_camera, scene_photo
from ncdc_model.images import mosaic, write_image
from ncdc_sim.link.namespaces import DEVICES, Network
from ncdc_sim.tools import SimulationError
from ncdc_spec.protocols.gvcp import HEARTBEAT_MS
from ncdc_spec.protocols.table_one import TCP_PORT

__all__ = ["Case", "PEERS", "Served", "case_row", "discovery_rows", "killed_row", "monitor_row",
           "still_photo"]

# The protocol's implementation for each scheme of URLs.
PEERS = {"gige": ("viva-genicam", "GVSP"), "aravis": ("Aravis", "GVSP"),
         "tcp": ("ncdc", "Table I/II")}
_GROUP = "239.192.1.1"


@dataclass(frozen=True)
class Case:
    """One row: a peer, what it sets, and how many frames it takes of how many devices."""
    scheme: str
    devices: int = 1
    frames: int = 0
    loss: float = 0.0
    packet_size: int | None = None
    every_feature: bool = False
    settings: dict = field(default_factory=dict)


class Served:
    """Emulated devices in a network of their own, showing a still photo without noise.

    Parameters
    ----------
    folder : path
        For descriptor, photo and expected pictures.
    descriptor : Descriptor
    count : int
    loss : float
    mtu : int

    Attributes
    ----------
    network : Network
    """
    def __init__(self, folder, descriptor, count=1, loss=0.0, mtu=1500):
        self._folder, self._descriptor = Path(folder), descriptor
        self._raw = still_photo(descriptor.geometry)
        descriptor.save(self._folder / "net.toml")
        write_image(self._folder / "photo.png", self._raw)
        self._options = ["--count", str(count), "--packet-loss", str(loss)]
        self.network = Network(mtu)

    def __enter__(self):
        self.network.__enter__()
        try:
            self._process = self.network.start(
                [str(Path(sys.executable).with_name("ncdc")), "device", "serve",
                 str(self._folder / "net.toml"),
                 "--photo", str(self._folder / "photo.png"), "--noise", "0", "--address",
                 DEVICES[0], "--tcp-port", str(TCP_PORT), *self._options],
                device=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            for line in self._process.stderr:
                if "Ctrl-C" in line:
                    return self
            raise SimulationError("the emulated device does not start")
        except BaseException:
            self.network.__exit__()
            raise

    def __exit__(self, *_):
        self.network.__exit__()

    def expected(self, corrected=True):
        """File of the picture that a device has to send, by the golden model."""
        path = self._folder / f"expected-{int(corrected)}.npy"
        if not path.exists():
            np.save(path, correct(self._descriptor, self._raw).picture if corrected
                    else self._raw)
        return path

    def cpu_seconds(self):
        """CPU time of the devices' process."""
        fields = Path(f"/proc/{self._pid()}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def _pid(self):
        # nsenter replaces itself by the program.
        return self._process.pid

    def task(self, scheme, count=1, **changes):
        """A task for :mod:`ncdc_bench.client.peer`."""
        return {"scheme": scheme, "devices": DEVICES[:count], "frames": 0, "settings": {},
                "expected": None, "packet_size": None, "every_feature": False,
                "multicast": None, "monitor": False, **changes}

    def start(self, task):
        """A peer's process that works on a task."""
        return self.network.start([sys.executable, "-m", "ncdc_bench.client.peer",
                                   json.dumps(task)], stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE)

    def report(self, process, timeout=300):
        """The report of such a process when it has ended."""
        out, error = process.communicate(timeout=timeout)
        if process.returncode:
            raise SimulationError(f"a peer failed: {error.strip().splitlines()[-1:]}")
        return json.loads(out)


def still_photo(geometry):
    """A raw frame of the built-in scene, of a descriptor's distorted size."""
    scene = scene_photo(example_camera())
    rows = np.arange(geometry.distorted_height) * scene.shape[0] // geometry.distorted_height
    columns = np.arange(geometry.distorted_width) * scene.shape[1] // geometry.distorted_width
    grey = scene[rows[:, None], columns]
    return mosaic(np.stack([grey, np.roll(grey, 1, 0), np.roll(grey, 1, 1)], -1), geometry.bayer)


def case_row(served, case):
    """The row of a :class:`Case`."""
    corrected = case.settings.get("CorrectionEnable", 1)
    task = served.task(case.scheme, case.devices, frames=case.frames, settings=case.settings,
                       every_feature=case.every_feature, packet_size=case.packet_size,
                       expected=str(served.expected(bool(corrected))))
    used = served.cpu_seconds()
    reports = served.report(served.start(task))
    total = {key: sum(report[key] for report in reports)
             for key in ("frames", "incomplete", "wrong_pixels", "features",
                         "features_read_back", "resent", "skipped")}
    peer, transport = PEERS[case.scheme]
    rates = [report.get("frames_per_second", 0.0) for report in reports]
    return {"peer": peer, "transport": transport, "devices": case.devices, **total,
            "frames_per_second": min(rates), "loss": case.loss,
            "device_cpu_seconds": served.cpu_seconds() - used,
            "client_cpu_seconds": sum(r.get("client_cpu_seconds", 0.0) for r in reports),
            "settings": case.settings, "packet_size": case.packet_size}


def discovery_rows(served, count):
    """A row for each back end: how many of ``count`` devices it finds by broadcast."""
    found = served.report(served.start(served.task("discover")))
    return [{"peer": PEERS[scheme][0], "transport": "GVCP discovery", "devices": count,
             "found": len(set(found[scheme]) & set(DEVICES[:count]))}
            for scheme in ("gige", "aravis")]


def monitor_row(served, frames, monitors, settings):
    """One controller that streams to a group, and ``monitors`` that watch and try to write."""
    expected = str(served.expected())
    control = _streaming(served, multicast=_GROUP, settings=settings)
    watch = [served.start(served.task("gige", frames=frames, expected=expected, monitor=True,
                                      multicast=_GROUP)) for _ in range(monitors)]
    reports = [served.report(process)[0] for process in watch]
    control.kill()
    control.wait()
    time.sleep(HEARTBEAT_MS / 1000 + 0.5)       # whoever comes next finds control free
    return {"peer": "viva-genicam", "transport": "GVSP multicast", "devices": 1,
            "monitors": monitors, "frames": min(report["frames"] for report in reports),
            "incomplete": sum(report["incomplete"] for report in reports),
            "wrong_pixels": sum(report["wrong_pixels"] for report in reports),
            "writes_rejected": sum(report["rejected"] for report in reports),
            "frames_per_second": min(report["frames_per_second"] for report in reports),
            "loss": 0.0}


def _streaming(served, **changes):
    """A controller that streams until it is killed; it has its first frame already."""
    control = served.start(served.task("gige", frames=100_000, **changes))
    line = ""
    for line in control.stderr:
        if line == "streaming\n":
            return control
    raise SimulationError(f"the controller gets no picture: {line.strip()}")


def killed_row(served):
    """A row on the time until control is free after the controller was killed."""
    control = _streaming(served)
    control.kill()
    control.wait()
    killed = time.monotonic()
    code = _TAKE.format(killed=killed)
    process = served.network.start([sys.executable, "-c", code], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
    out, error = process.communicate(timeout=60)
    if process.returncode:
        raise SimulationError(f"control does not become free: {error.strip()}")
    return {"peer": "viva-genicam", "transport": "GVCP, controller killed", "devices": 1,
            "seconds_until_free": float(out)}


# Opens the device again and again; the clock is the whole machine's.
_TAKE = """
import time
import viva_genicam as viva
found = viva.discover(500)[0]
while time.monotonic() < {killed} + 30:
    try:
        viva.connect_gige(found).close()
        break
    except viva.GenicamError:
        time.sleep(0.02)
else:
    raise SystemExit("still taken after 30 s")
print(time.monotonic() - {killed})
"""
