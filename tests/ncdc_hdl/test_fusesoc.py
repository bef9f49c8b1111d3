"""The FuseSoC core: found, resolved and linted by FuseSoC itself."""

import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_hdl.export.ip.fusesoc import CORE_NAME
from ncdc_sim.tools import environment

USER = """CAPI=2:
name: user:top:user:1.0
filesets:
  rtl:
    files: [user.v]
    file_type: verilogSource-2005
    depend: ["ncdc:ip:ncdc"]
targets:
  lint:
    filesets: [rtl]
    toplevel: user
    flow: lint
    flow_options: {tool: verilator, mode: lint-only, verilator_options: [-Wno-PINMISSING]}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with the generated files in ``core``."""
    path = tmp_path_factory.mktemp("fusesoc")
    barrel_descriptor((20, 16), (24, 18), hidden_neurons=2).save(path / "net.toml")
    assert main(["generate", str(path / "net.toml"), "-o", str(path / "core")]) == 0
    return path


def fusesoc(folder, core, target="lint"):
    """Exit status and output of ``fusesoc run``."""
    done = subprocess.run(
        [Path(sys.executable).parent / "fusesoc", "--cores-root", folder, "run", "--build-root",
         folder / "build", "--target", target, core],
        cwd=folder, env={**environment(), "HOME": str(folder), "XDG_CONFIG_HOME": str(folder)},
        text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.returncode, done.stdout


@pytest.mark.longer
def test_core_names_the_verilog(folder):
    core = yaml.safe_load((folder / "core" / "ncdc.core").read_text().removeprefix("CAPI=2:\n"))
    assert core["name"].startswith(f"{CORE_NAME}:")
    files = [name for file in core["filesets"]["rtl"]["files"] for name in file]
    assert files == ["ncdc.vlt", "ncdc.v"]
    verilog = (folder / "core" / files[1]).read_text()
    for target in core["targets"].values():
        assert f"\nmodule {target['toplevel']}(" in verilog.replace(" (", "(")


@pytest.mark.regress
def test_fusesoc_lints_the_core(folder):
    status, output = fusesoc(folder, CORE_NAME)
    assert status == 0 and "%Warning" not in output, output


@pytest.mark.regress
@pytest.mark.parametrize("port,right", [("irq", True), ("not_there", False)])
def test_another_core_depends_on_it(folder, port, right):
    """A user's core instantiates the module; a port that is not there is an error."""
    (folder / "user.core").write_text(USER)
    (folder / "user.v").write_text(
        "module user(input clk, rst, output irq);\n"
        f"  ncdc core (.clk(clk), .rst(rst), .{port}(irq));\nendmodule\n")
    status, output = fusesoc(folder, "user:top:user")
    assert (status == 0) == right, output
    assert right or port in output
