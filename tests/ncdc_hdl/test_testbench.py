"""The stand-alone test bench: it passes in two simulators, and fails where it must."""

import re
import subprocess

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_sim.tools import environment

OPTIONS = {
    "memory": [], "axi": ["--bus", "axi"],
    "stream": ["--to", "stream", "--pixels-per-clock", "2", "--data-width", "64"],
    "axi stream": ["--bus", "axi", "--to", "stream", "--pixels-per-clock", "4", "--data-width",
                   "128"],
    "multiport": ["--fetch", "multiport", "--format", "BGR8"],
}
regress = pytest.mark.regress


@pytest.fixture(scope="module")
def net(tmp_path_factory):
    path = tmp_path_factory.mktemp("bench") / "net.toml"
    barrel_descriptor((24, 14), (32, 20), hidden_neurons=2).save(path)
    return str(path)


def generated(net, folder, *options):
    """Name of the module that is generated in ``folder``, with its test bench."""
    assert main(["generate", net, "-o", str(folder), "--testbench", *options]) == 0
    return "ncdc_axi" if "axi" in options else "ncdc"


def commands(folder, module):
    """The two simulators' lines as the bench itself gives them, in its first comment."""
    lines = (folder / f"{module}_tb.v").read_text().splitlines()[:8]
    return {line.split()[2]: line.partition("$ ")[2] for line in lines
            if line.startswith("//     $ ")}


def run(folder, module, simulator="iverilog"):
    """The line that the bench ends with; a compiler's warning fails."""
    command = commands(folder, module)[simulator]
    if simulator == "verilator":
        # Quicker to compile; its warnings go into a file.
        command = command.replace("--binary", "--binary -CFLAGS -O0 -j 2").replace(
            " && ", " >log 2>&1 && ")
    done = subprocess.run(command, shell=True, cwd=folder, env=environment(), text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300)
    lines = [line for line in done.stdout.splitlines()
             if line.strip() and not line.startswith("- ")]
    assert "warning" not in done.stdout.lower(), done.stdout
    return next(line for line in reversed(lines) if line.startswith(("PASS", "FAIL")))


@pytest.mark.longer
@pytest.mark.parametrize("name,simulator", [
    ("memory", "iverilog"),
    *(pytest.param(name, simulator, marks=regress) for name in OPTIONS
      for simulator in ("iverilog", "verilator"))])
def test_passes(name, simulator, net, tmp_path):
    module = generated(net, tmp_path, *OPTIONS[name])
    assert re.match(r"PASS: .*, 336 pixels, in \d+ clocks$", run(tmp_path, module, simulator))


@pytest.mark.longer
@pytest.mark.parametrize("name", ["memory", *(pytest.param(name, marks=regress)
                                              for name in ("axi", "stream"))])
def test_a_flipped_weight_makes_it_fail(name, net, tmp_path):
    module = generated(net, tmp_path, *OPTIONS[name])
    path = tmp_path / f"{module}.v"
    path.write_text(flipped(path.read_text()))
    assert run(tmp_path, module).startswith("FAIL")


def flipped(verilog):
    """``verilog`` with a bit of a hidden neuron's weight turned over, a twentieth of a pixel."""
    def turned(match):
        return f"{match[1]}{int(match[2], 16) ^ 1 << 12:0{len(match[2])}x};"
    # Where it is declared, and where a reset sets it.
    text, count = re.subn(r"(\bhidden0_weight_x (?:<?=) \d+'h)(\w+);", turned, verilog)
    assert count == 2
    return text


@pytest.mark.longer
def test_another_frame(net, tmp_path):
    """A file replaces the frame; one of another size is rejected, and nothing is written."""
    raw = np.random.default_rng(2).integers(0, 256, (20, 32), np.uint8)
    cv2.imwrite(str(tmp_path / "raw.png"), raw)
    out = tmp_path / "out"
    generated(net, out, str(tmp_path / "raw.png"))
    words = (out / "ncdc_tb_raw.hex").read_text().split()
    assert words[0] == raw[0, 3::-1].tobytes().hex()
    cv2.imwrite(str(tmp_path / "small.png"), raw[:4])
    assert main(["generate", net, "-o", str(tmp_path / "no"), "--testbench",
                 str(tmp_path / "small.png")]) == 2
    assert not (tmp_path / "no").exists()


def test_the_template_is_an_instance(net, tmp_path):
    """With every port once; a compiler takes it as the body of a module."""
    generated(net, tmp_path)
    (tmp_path / "top.v").write_text('module top;\n`include "ncdc_template.vh"\nendmodule\n')
    done = subprocess.run(["iverilog", "-g2005", "-Wall", "-t", "null", "-s", "top", "top.v",
                           "ncdc.v"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and "port" not in done.stderr, done.stderr
