"""Each output of each command, given a path where no file can be put."""

import os
import stat

import numpy as np
import pytest

from cases import cases
from lenses import GEOMETRY, known_network, lens
from ncdc.cli import COMMANDS, main
from ncdc_model.images import write_image
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.geometry import ValidRows


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Descriptor.quantise(known_network(), GEOMETRY, ValidRows.everything(320, 240)).save("net.toml")
    write_image("frame.png", np.zeros((240, 320), np.uint8))
    lens().framed().save("camera.toml")
    os.mkfifo("pipe.png")
    os.mkdir("folder.png")
    return tmp_path


INPUTS = {"calibrate": ["frame.png"], "train": ["camera.toml", "--neurons", "2"],
          "evaluate": ["net.toml", "--reference", "camera.toml"],
          "report": ["net.toml"],
          "correct": ["net.toml", "frame.png"], "simulate": ["net.toml", "frame.png"],
          "export": ["net.toml"], "plan": ["net.toml"], "generate": ["net.toml"],
          "build": ["net.toml", "--board", "ulx3s"],
          "demo": [], "bench": ["accuracy"]}
FILES = "calibrate", "train", "report", "correct", "simulate", "export"
FOLDERS = "demo", "generate", "build", "bench"
NETWORK = "client", "device", "soc"     # they need one: tests/host and tests/soc try them
OTHERS = ("sensor", "doctor", "target",  # their one file: test_sensor_command, test_doctor, ...
          "lot", "eeprom",                # their folders, pages and files: test_lot, test_eeprom
          "completion")                   # none


def test_every_command_is_here():
    assert {*INPUTS, *NETWORK, *OTHERS} == set(COMMANDS)


@pytest.mark.parametrize("command", FILES)
@pytest.mark.parametrize("output,reason", [
    ("pipe.png", "it is no regular file"), ("/dev/null", "it is no regular file"),
    ("folder.png", "it is a folder"), ("net.toml/x.png", "net.toml: Not a directory")])
def test_an_output_is_a_file(folder, capsys, command, output, reason):
    assert main([command, *INPUTS[command], "-o", output]) == 2
    said = capsys.readouterr().err
    assert reason in said and said.count("\n") == 1
    assert stat.S_ISFIFO(os.stat("pipe.png").st_mode) and stat.S_ISCHR(os.stat("/dev/null").st_mode)


@pytest.mark.parametrize("command", cases(FOLDERS, longer=["generate"]))
def test_a_folder_is_no_file(folder, capsys, command):
    for output in ("pipe.png", "net.toml"):
        assert main([command, *INPUTS[command], "-o", output]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert stat.S_ISFIFO(os.stat("pipe.png").st_mode)


@pytest.mark.parametrize("bench", ["tansig", "throughput"])
def test_plots_are_no_file(folder, capsys, bench):
    assert main(["bench", bench, "--plots", "net.toml"]) == 2
    assert "net.toml: Not a directory" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["evaluate", "plan", "correct"])
def test_a_report_may_go_to_a_device(folder, capsys, command):
    more = ["-o", "out.png"] if command == "correct" else []
    assert main([command, *INPUTS[command], *more, "--json", "/dev/null"]) == 0
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    capsys.readouterr()
    for path, reason in (("/dev/full", "No space left on device"),
                         ("pipe.png", "it has no reader")):
        assert main([command, *INPUTS[command], *more, "--json", path]) == 2
        assert f"cannot write {path}: {reason}\n" in capsys.readouterr().err
