"""What an emulated device takes of this machine's memory, as a process of its own."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from cameras import barrel_descriptor
from devices import loopback_address
from ncdc_host.client.devices import open_device

_SERVE = "import sys; from ncdc.cli import main; sys.exit(main(sys.argv[1:]))"


def peak_mb(process):
    status = Path(f"/proc/{process.pid}/status").read_text()
    return int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024


@pytest.mark.longer
def test_a_device_of_640x480_takes_at_most_150_megabytes(tmp_path):
    """While it streams the scene in motion, whose pictures are stored; settings and view change."""
    replace(barrel_descriptor((640, 480), (640, 480), 8), nodes=8,
            provenance={"frame": [250.0, 320.0, 240.0]}).save(tmp_path / "net.toml")
    address = loopback_address()
    served = subprocess.Popen(
        [sys.executable, "-c", _SERVE, "device", "serve", str(tmp_path / "net.toml"), "--address",
         address, "--tcp-port", "0", "--fps", "60"], stdout=subprocess.PIPE, text=True,
        env={"PYTHONPATH": ":".join(sys.path), "PATH": "/usr/bin:/bin"})
    try:
        assert address in served.stdout.readline()
        with open_device(f"gige://{address}") as device, device.stream() as frames:
            for exposure in (10_000, 8_000, 5_000, 3_000):
                device.set("ExposureTime", exposure)
                for k in range(36):
                    if exposure < 4_000:
                        device.set("Pan", k)
                    frames.next()
        assert 50 < peak_mb(served) <= 150
    finally:
        served.terminate()
        assert served.wait(10) == 0
