"""``ncdc soc``: bad input is one sentence that names value and limit."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_model.example import noise_picture
from ncdc_model.images import write_image
from ncdc_sim.link.namespaces import TapNetwork
from ncdc_sim.tools import SimulationError


@pytest.mark.parametrize("options, sentence", [
    (["--packet-loss", "1.5"], "the packet loss is 1.5, the limits are 0 and 1"),
    (["--exposure-us", "0"], "the exposure is 0 us, the limits are 1 and 1e+06"),
    ([], "cannot read"),
])
def test_bad_input(tmp_path, capsys, options, sentence):
    barrel_descriptor().save(tmp_path / "net.toml")
    with pytest.raises(SystemExit) as end:
        raise SystemExit(main(["soc", "run", "--sim", str(tmp_path / "net.toml"), "--photo",
                               str(tmp_path / "none.png"), *options]))
    said = capsys.readouterr().err
    assert end.value.code == 2 and sentence in said and said.count("\n") == 1


def test_an_eeprom_that_is_too_large(tmp_path, capsys):
    barrel_descriptor().save(tmp_path / "net.toml")
    write_image(str(tmp_path / "raw.png"), noise_picture(48, 40))
    (tmp_path / "a.bin").write_bytes(bytes(8193))
    assert main(["soc", "run", "--sim", str(tmp_path / "net.toml"), "--photo",
                 str(tmp_path / "raw.png"), "--eeprom", str(tmp_path / "a.bin")]) == 2
    said = capsys.readouterr().err
    assert said.endswith("a.bin: the image has 8193 bytes, the EEPROM of the simulation has 8192\n")


def test_a_view_needs_nodes(tmp_path, capsys):
    barrel_descriptor().save(tmp_path / "net.toml")
    assert main(["soc", "build", "--sim", str(tmp_path / "net.toml"), "--view"]) == 2
    said = capsys.readouterr().err
    assert "a view needs nodes" in said and said.count("\n") == 1


@pytest.mark.parametrize("option", ["--views", "--view-rows"])
def test_the_firmware_has_one_view_alone(tmp_path, capsys, option):
    with pytest.raises(SystemExit) as end:
        main(["soc", "build", "--sim", str(tmp_path / "net.toml"), "--view", option, "4"])
    assert end.value.code == 2
    assert f"unrecognized arguments: {option} 4" in capsys.readouterr().err


_RUN = """
import sys
from argparse import Namespace
from pathlib import Path
import ncdc.cli.soc as soc
from ncdc_spec.descriptor import Descriptor
from ncdc_soc.firmware import Identity
class Model:
    identity = Identity()
    def fill(self, folder, eeprom):
        pass
    def command(self, *plusargs):
        return ["sh", "-c", "echo $$ > " + sys.argv[2] + "; exec sleep 100"]
soc._model = lambda *_: Model()
descriptor = Descriptor.load(sys.argv[1] + "/net.toml")
args = Namespace(image=sys.argv[1] + "/raw.png", raw=None, bits=None, packet_loss=0,
                 output=None, eeprom=None)
sys.exit(soc._run(args, descriptor))
"""


@pytest.mark.parametrize("number", [
    pytest.param(signal.SIGTERM, marks=pytest.mark.longer), signal.SIGKILL],
    ids=["SIGTERM", "SIGKILL"])
def test_nothing_is_left_over(tmp_path, number):
    """Neither the simulation nor its network; after SIGKILL the network ends at least."""
    network()
    lens = barrel_descriptor()
    lens.save(tmp_path / "net.toml")
    write_image(tmp_path / "raw.png", noise_picture(*lens.geometry.distorted))
    script = tmp_path / "run.py"
    script.write_text(_RUN)
    run = subprocess.Popen([sys.executable, str(script), str(tmp_path), str(tmp_path / "pid")],
                           stderr=subprocess.PIPE, text=True,
                           env={**os.environ, "PYTHONPATH": ":".join(sys.path)})
    said = "".join(run.stderr.readline() for _ in range(3))
    holder = int(re.search(r"-t (\d+)", said)[1])
    wait(lambda: (tmp_path / "pid").exists() and (tmp_path / "pid").read_text().strip())
    simulation = int((tmp_path / "pid").read_text())
    assert alive(holder) and alive(simulation)
    try:
        run.send_signal(number)
        assert run.wait(20) == (0 if number == signal.SIGTERM else -signal.SIGKILL)
        wait(lambda: not alive(holder))
        if number == signal.SIGTERM:
            wait(lambda: not alive(simulation))
    finally:
        if alive(simulation):
            os.kill(simulation, signal.SIGKILL)


def alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
    except OSError:
        return False


def wait(there):
    until = time.monotonic() + 10
    while not there():
        assert time.monotonic() < until
        time.sleep(.02)


def network():
    """Skip where the kernel allows no namespaces of one's own."""
    try:
        with TapNetwork():
            pass
    except SimulationError as error:
        pytest.skip(str(error))
