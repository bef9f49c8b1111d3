"""`ncdc doctor`: what it says of a machine from which something was taken away."""

import json
import os
import socket
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

from ncdc import capabilities
from ncdc.cli import main
from ncdc_spec.needs import PACKAGE_OF

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def doctor(capsys):
    """(exit status, what is missing by purpose, sentence on stderr)."""
    status = main(["doctor", "--json", "-"])
    out, err = capsys.readouterr()
    report = json.loads(out)
    return status, {one["purpose"]: {(thing["what"], thing["line"]) for thing in one["missing"]}
                    for one in report["capabilities"]}, err


@pytest.fixture
def without(monkeypatch):
    """Function that takes packages away."""
    there = metadata.version

    def take(*names):
        def version(name):
            if name in names:
                raise metadata.PackageNotFoundError(name)
            return there(name)
        monkeypatch.setattr(metadata, "version", version)
    return take


def test_what_each_command_needs_is_there(capsys):
    status, lost, err = doctor(capsys)
    assert status == 0 and not err
    assert lost["correct, sensor, device; client with tcp://"] == set()


def test_a_package_of_the_base(without, capsys):
    without("numpy")
    status, lost, err = doctor(capsys)
    assert status == 1 and err == "ncdc doctor: no command works without numpy\n"
    assert lost["correct, sensor, device; client with tcp://"] == {("numpy", "pip install ncdc")}


def test_a_package_of_a_group_is_named_wherever_it_is_needed(without, capsys):
    without("litex")
    status, lost, err = doctor(capsys)
    assert status == 0 and not err
    assert ("litex", 'pip install "ncdc[litedram]"') in lost["simulate --memory litedram"]
    assert ("litex", 'pip install "ncdc[soc]"') in lost["build --system; soc build"]


def test_programs_and_headers(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    status, lost, _ = doctor(capsys)
    assert status == 0
    assert lost["simulate, demo"] == {(name, f"apt install {name}")
                                      for name in ("g++", "make", "perl")}
    assert ("liblz4-dev", "apt install liblz4-dev") in lost["simulate --fst"]
    assert ("picolibc", "apt install picolibc-riscv64-unknown-elf") in lost[
        "build --system; soc build"]
    assert lost["the console of the generated Tcl driver"] == {("tclsh", "apt install tcl")}


def test_a_program_that_fails_is_no_help(tmp_path, monkeypatch, capsys):
    for name in ("unshare", "nsenter", "ip"):
        (tmp_path / name).write_text("#!/bin/sh\nexit 1\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    lost = doctor(capsys)[1]["soc run: a network of its own"]
    assert "the right to make network namespaces" in {what for what, _ in lost}


def test_a_port_that_another_device_has(monkeypatch, capsys):
    from ncdc_spec.protocols import gvcp
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.2", 0))      # another port than that of the devices of other tests
        port = one.getsockname()[1]
        monkeypatch.setattr(gvcp, "PORT", port)
        [(what, line)] = doctor(capsys)[1]["device serve"]
    assert f"UDP port {port}" in what and "--address" in line


def test_an_old_python(monkeypatch, capsys):
    monkeypatch.setattr(capabilities, "_PYTHON", (9, 1))
    status, _, err = doctor(capsys)
    assert status == 1 and "Python 9.1" in err


def test_for_people(without, monkeypatch, tmp_path, capsys):
    """One line to type for all programs of a purpose."""
    without("pyftdi")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert "missing  simulate, demo\n         g++, make, perl: apt install g++ make perl\n" in out
    assert "missing  client with usb://\n         pyftdi: pip install \"ncdc[usb]\"\n" in out
    assert "ok       client with gige://\n" in out


def test_every_group_has_a_purpose():
    assert {one.extra for one in capabilities.CAPABILITIES} - {None, ""} == set(
        PROJECT["optional-dependencies"])
    assert "PySide6-Essentials" in capabilities.packages_of("gui")
    assert "viva-genicam" in capabilities.packages_of("gui")      # of the group within it
    assert "numpy" in capabilities.packages_of("") and "amaranth" in capabilities.packages_of("soc")
    assert "pytest" not in capabilities.packages_of("")


def test_what_is_typed_is_what_make_setup_types():
    script = (ROOT / ".ci" / "debian").read_text()
    for name in {"g++", "perl", "ccache", "iverilog", "tclsh", "ip", "tshark", "unshare",
                 "riscv64-unknown-elf-gcc"}:
        assert f"need {name} {PACKAGE_OF[name]}\n" in script


def test_it_runs_without_the_packages_of_the_others(tmp_path):
    """Where NumPy cannot be imported, as in a broken environment."""
    (tmp_path / "numpy.py").write_text("raise ImportError('broken')\n")
    done = subprocess.run([sys.executable, "-m", "ncdc", "doctor", "--json", "-"],
                          capture_output=True, text=True,
                          env=os.environ | {"PYTHONPATH": os.pathsep.join(
                              [str(tmp_path), *(path for path in sys.path if path)])})
    assert not done.returncode and json.loads(done.stdout)["capabilities"], done.stderr


def test_the_report_goes_to_a_file_too(tmp_path, capsys):
    assert main(["doctor", "--json", str(tmp_path / "report.json")]) == 0
    assert json.loads((tmp_path / "report.json").read_text())["python"]
    assert "client gui" in capsys.readouterr().out
    assert main(["doctor", "--json", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith(f"ncdc doctor: cannot write {tmp_path}: ")
