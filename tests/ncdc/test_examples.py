"""The programs in ``examples``: each runs as its first lines say, in a process of its own."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from cameras import barrel_descriptor
from devices import device, small_lens
from ncdc_model.images import read_image
from ncdc_spec.descriptor import Descriptor

FOLDER = Path(__file__).resolve().parents[2] / "examples"
LINES = 80


def run(folder, name, *arguments):
    """Standard output of an example that ends with status 0."""
    done = subprocess.run([sys.executable, FOLDER / name, *map(str, arguments)], cwd=folder,
                          capture_output=True, text=True)
    assert not done.returncode, f"{done.stdout}\n{done.stderr}"
    return done.stdout


def test_each_is_short_and_is_run_here():
    programs = {path.name: path.read_text() for path in FOLDER.glob("*.py")}
    assert programs.keys() == {"own_lens.py", "own_bus.py", "own_client.py", "own_board.py"}
    assert all(len(text.splitlines()) <= LINES for text in programs.values())
    assert all(f"examples/{name}" in text for name, text in programs.items())


@pytest.fixture(scope="module")
def lens(tmp_path_factory):
    """(what it printed, the descriptor's file) of the lens."""
    folder = tmp_path_factory.mktemp("lens")
    return run(folder, "own_lens.py", "net.toml", "48x32"), folder / "net.toml"


@pytest.mark.longer
def test_a_lens(lens):
    assert float(re.search(r"([\d.]+) px at most", lens[0])[1]) < 0.05
    assert Descriptor.load(lens[1]).geometry.corrected == (48, 32)


@pytest.mark.longer
def test_a_bus(lens, tmp_path):
    assert run(tmp_path, "own_bus.py", lens[1]) == "1536 pixels compared, 0 differ\n"


def test_a_client(tmp_path):
    with device([small_lens()]) as served:
        url = f"tcp://{served.options.address}:{served.table.port}"
        said = run(tmp_path, "own_client.py", url, "picture.png")
    assert read_image(tmp_path / "picture.png").shape[:2] == (48, 64)
    assert 105 <= float(re.search(r"mean ([\d.]+)$", said)[1]) <= 115


def test_a_client_without_a_device(tmp_path):
    done = subprocess.run([sys.executable, FOLDER / "own_client.py", "tcp://127.0.0.1:9", "a.png"],
                          cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count("\n") == 1


@pytest.mark.longer
def test_a_board(tmp_path):
    barrel_descriptor((64, 48), (64, 48)).save(tmp_path / "net.toml")
    said = run(tmp_path, "own_board.py", "net.toml", "project")
    assert "corrected frames a second" in said
    [settings] = tmp_path.glob("project/*.qsf")
    pins = dict(re.findall(r'-to "(\S+)" (PIN_\w+)', settings.read_text()))
    # Pins 1 and 2 of GPIO 0, as Terasic's manual of the DE0-CV lists them.
    assert (pins["uart_0__rx__io"], pins["uart_0__tx__io"]) == ("PIN_N16", "PIN_B16")
