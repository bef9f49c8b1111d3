"""The guides into other people's designs: their commands run, and write what the pages say."""

import re
import shlex
import subprocess
from collections import Counter
from pathlib import Path
from textwrap import dedent

import pytest

from cameras import barrel_descriptor
from ncdc.cli import build_open, main
from ncdc.toolchain.bitstream import Clock, Placement
from ncdc_bench.figures.guide_diagrams import DRAWINGS, draw_all
from ncdc_model.example import BAYER, example_camera, scene_photo, target_photo
from ncdc_model.images import demosaic, write_image
from ncdc_sim.tools import environment, tool

DOCS = Path(__file__).resolve().parents[2] / "docs"
HOWTO = DOCS / "howto"
GUIDES = {"guide_platform_designer": (48, 40), "guide_zynq": (48, 40), "guide_verilog": (48, 40),
          "guide_litex": (48, 40)}


def commands(page, name):
    """Command lines of a page that begin with ``name``, in its indented blocks."""
    return re.findall(rf"^    (?:\$ )?{name} (.*)$", page, re.MULTILINE)


def named(page):
    """Files of the page's tables that end like what ``ncdc generate`` writes."""
    cells = re.findall(r"^\| (.*?)\|.*$", page, re.MULTILINE)
    rows = [row for row in re.findall(r"^\|.*$", page, re.MULTILINE)]
    assert cells
    return {file for row in rows for file in re.findall(r"`(\w+\.(?:v|vh|tcl|xml|dtsi|py|c|h))`",
                                                       row)}


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("guide", GUIDES)
def test_the_commands_of_a_guide_write_what_it_names(guide, tmp_path, monkeypatch):
    page = (HOWTO / f"{guide}.md").read_text()
    barrel_descriptor(GUIDES[guide], GUIDES[guide], hidden_neurons=2).save(tmp_path / "net.toml")
    monkeypatch.chdir(tmp_path)
    lines = commands(page, "ncdc")
    assert lines
    for line in lines:
        assert main(shlex.split(line)) == 0, line
    written = {path.name for path in tmp_path.glob("*/*")}
    assert named(page) and named(page) - written == set()


ROS_CAMERA = """\
image_width: 1280
image_height: 720
camera_matrix: {rows: 3, cols: 3, data: [760.0, 0, 646.0, 0, 760.0, 355.0, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.31, 0.10, 0.001, -0.0005, -0.015]}
"""
BOARD_FILES = {"start/board": {"ncdc_ulx3s.bit", "ncdc_ulx3s.v", "ncdc_registers.py"},
               "reference/ulx3s": {"ncdc_ulx3s.bit", "ncdc_ulx3s.v", "ncdc_registers.py"},
               "reference/boards": {"ncdc_user.v", "build.sh", "check_timing.tcl", "PORTS.md",
                          "ncdc_registers.py"},
               "reference/colorlight_i9": {"ncdc_colorlight_i9.bit", "ncdc_colorlight_i9.lpf",
                                           "ncdc_processor_rom.init", "ncdc_registers.py"}}


@pytest.fixture
def without_synthesis(monkeypatch):
    """Without synthesis and place and route, of which tests of their own run small ones."""
    monkeypatch.setattr(build_open, "synthesise_board", lambda *design: {
        "modules": {"top": {"attributes": {"top": "1"}, "cells": {}}}})
    monkeypatch.setattr(build_open, "clock_nets", lambda netlist, cells: {})
    monkeypatch.setattr(build_open, "clock_preferences", lambda nets, targets: "")
    monkeypatch.setattr(build_open, "place_and_route",
                        lambda folder, device, preferences, nets, seed: Placement(
                            seed, (Clock("sync", 62.5, 70.0),), Counter()))
    monkeypatch.setattr(build_open, "pack", lambda folder, seed: b"bits")


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.usefixtures("without_synthesis")
@pytest.mark.parametrize("page", BOARD_FILES)
def test_the_commands_of_a_board_s_page(page, tmp_path, monkeypatch, capsys):
    """From a photo of dots on, without benches, which take an hour here. What ``ncdc plan`` prints
    is what the page says."""
    text = (DOCS / f"{page}.md").read_text()
    write_image(tmp_path / "photo.png", demosaic(target_photo(example_camera()), BAYER))
    (tmp_path / "camera.yaml").write_text(ROS_CAMERA)
    barrel_descriptor((640, 480), (640, 480), hidden_neurons=8).save(tmp_path / "net.toml")
    monkeypatch.chdir(tmp_path)
    lines = [line for line in commands(text, "ncdc") if not line.startswith("bench ")]
    assert len(lines) > 2
    for line in lines:
        assert main(shlex.split(line)) == 0, line
        printed = capsys.readouterr().out.splitlines()
        if line.startswith("plan"):
            [quoted] = re.findall(rf"^    \$ ncdc {line}\n((?:    .*\n)+)", text, re.MULTILINE)
            said = [one for one in dedent(quoted).splitlines() if one != "..."]
            assert said and said == printed[:len(said)]
    assert BOARD_FILES[page] <= {path.name for path in tmp_path.glob("*/*")}


STEP = re.compile(r"^```py(?:thon)?\n(.*?)^```$|^ +ncdc ([^\n]*)$", re.MULTILINE | re.DOTALL)
NETS = ("net", "near", "far", "wide", "tele", "left", "right")      # descriptors of the pages
HOWTOS = ("new_board", "new_sensor", "several_lenses", "remap_tables", "slow_frames")


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.usefixtures("without_synthesis")
@pytest.mark.parametrize("page", HOWTOS)
def test_the_steps_of_a_howto_run(page, tmp_path, monkeypatch):
    """Commands and lines of Python in their order, without servers: these run until ended."""
    monkeypatch.chdir(tmp_path)
    for k, name in enumerate(NETS):
        barrel_descriptor((640, 480), (640, 480), hidden_neurons=2, seed=k).save(f"{name}.toml")
    write_image("distorted.png", demosaic(scene_photo(example_camera()), BAYER))
    names, count = {}, 0
    for code, line in STEP.findall((HOWTO / f"{page}.md").read_text()):
        if code:
            exec(compile(code, page, "exec"), names)
        elif not line.startswith("device serve"):
            assert main(shlex.split(line)) == 0, line
        count += 1
    assert count > 1


@pytest.mark.regress
def test_the_verilog_guide_s_bench_passes(tmp_path, monkeypatch):
    page = (HOWTO / "guide_verilog.md").read_text()
    barrel_descriptor((48, 40), (48, 40), hidden_neurons=2).save(tmp_path / "net.toml")
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(commands(page, "ncdc")[0])) == 0
    [compile_line], [run_line] = commands(page, "iverilog"), commands(page, "vvp")
    folder = {"cwd": tmp_path / "hardware", "env": environment(), "text": True,
              "capture_output": True}
    done = subprocess.run([tool("icarus"), *shlex.split(compile_line)], **folder)
    assert not done.returncode, done.stderr
    done = subprocess.run(["vvp", *shlex.split(run_line)], **folder)
    assert "PASS" in done.stdout and "FAIL" not in done.stdout


@pytest.mark.many_clocks
@pytest.mark.regress
def test_the_litex_guide_s_systems_compare_every_pixel(tmp_path, monkeypatch, capsys):
    from ncdc_sim.system import litex
    barrel_descriptor((48, 40), (48, 40), hidden_neurons=2).save(tmp_path / "net.toml")
    monkeypatch.chdir(tmp_path)
    lines = commands((HOWTO / "guide_litex.md").read_text(), "python -m ncdc_sim.system.litex")
    assert len(lines) == 2
    for line in lines:
        assert litex.main(shlex.split(line)) == 0
        assert "1920 pixels compared, 0 differ" in capsys.readouterr().out


@pytest.mark.regress
def test_the_litex_guide_s_lines_make_a_system(tmp_path, monkeypatch):
    from litex_systems import system_with
    [block] = re.findall(r"^    from ncdc_soc.*?(?=^\S)", (HOWTO / "guide_litex.md").read_text(),
                         re.MULTILINE | re.DOTALL)
    barrel_descriptor((48, 40), (48, 40), hidden_neurons=2).save(tmp_path / "net.toml")
    monkeypatch.chdir(tmp_path)
    text = system_with(dedent(block))
    assert "ncdc ncdc" in text and (tmp_path / "build" / "ncdc.v").is_file()


def test_every_guide_has_its_drawing(tmp_path):
    draw_all(tmp_path)
    for name in DRAWINGS:
        assert (tmp_path / name).stat().st_size > 10_000
        pages = [path.name for path in DOCS.glob("**/*.md")
                 if f"figures/{name}" in path.read_text()]
        assert len(pages) == 1 and (DOCS / "figures" / name).is_file()
