"""Waveforms: read back, with the signals that a run must have moved."""

import re
import shutil
import subprocess

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_model.images import write_image
from ncdc_sim import waves as waves_module
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.tools import SimulationError
from ncdc_sim.waves import Waves
from ncdc_spec.errors import InputError
from ncdc_spec.registers.register_map import COUNTERS

regress = pytest.mark.regress

D = barrel_descriptor((16, 12), (16, 12), hidden_neurons=2)
RAW = np.random.default_rng(1).integers(0, 256, (12, 16), dtype=np.uint8)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    D.save("net.toml")
    write_image("raw.png", RAW)
    return tmp_path


def changes(vcd, name):
    """(Time in ps, digits) of each change of the first signal of a name in a VCD's text."""
    unit = re.search(r"\$timescale\s+1(ps|ns)", vcd)[1]
    code = re.search(rf"\$var \w+ +\d+ (\S+) {name}(?: \[[\d:]+\])? \$end", vcd)[1]
    found, now = [], 0
    for line in vcd.partition("$enddefinitions")[2].splitlines():
        if line.startswith("#"):
            now = int(line[1:]) * {"ps": 1, "ns": 1000}[unit]
        elif line[:1] in "01xz" and line[1:] == code:
            found.append((now, line[0]))
        elif line[:1] == "b" and line.split()[1] == code:
            found.append((now, line.split()[0][1:]))
    return found


def check(vcd, clocks):
    """The clock has a period of 10 ns, for as long as the frame takes; the interrupt comes once."""
    edges = [at for at, value in changes(vcd, "clk") if value == "1"]
    assert set(np.diff(edges)) == {10_000} and len(edges) > clocks
    assert [value for _, value in changes(vcd, "irq")][-2:] == ["0", "1"]
    assert sum(value == "1" for _, value in changes(vcd, "irq")) == 1


def check_file(path, kind, clocks):
    """GTKWave's program unpacks an FST, if it is here; else its header shows it."""
    if kind == "vcd":
        check(path.read_text(), clocks)
    elif shutil.which("fst2vcd"):
        done = subprocess.run(["fst2vcd", path], capture_output=True, text=True, check=True)
        check(done.stdout, clocks)
    else:
        content = path.read_bytes()
        # A header's block, of 329 bytes; times in it from the first to the last change.
        assert content[:9] == bytes([0]) + (329).to_bytes(8, "big")
        begin, end = (int.from_bytes(content[at:at + 8], "big") for at in (9, 17))
        assert begin == 0 and end > 10 * clocks and len(content) > 10_000


@pytest.mark.longer
@pytest.mark.parametrize("simulator,kind", [
    ("icarus", "vcd"), ("icarus", "fst"), pytest.param("verilator", "vcd", marks=regress),
    pytest.param("verilator", "fst", marks=regress)])
def test_waveforms_of_a_frame(tmp_path, simulator, kind):
    path = tmp_path / f"waves.{kind}"
    run = simulate_correction(D, RAW, simulator=simulator, waves=Waves(path, kind))
    assert run.differing == []
    check_file(path, kind, run.counters["CLOCKS"])
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.longer
def test_a_run_that_fails_leaves_its_waveforms(tmp_path):
    path = tmp_path / "waves.vcd"
    with pytest.raises(SimulationError, match="simulation failed"):
        simulate_correction(D, RAW, simulator="icarus", waves=Waves(path), clock_limit=500)
    assert 500 <= len(changes(path.read_text(), "clk")) // 2 < 600


@pytest.mark.longer
def test_the_command_writes_them(folder, capsys):
    assert main("simulate net.toml raw.png -o out.png --simulator icarus --vcd waves.vcd".split()) \
        == 0
    check((folder / "waves.vcd").read_text(), len(COUNTERS))


@pytest.mark.parametrize("options,message", [
    ("--vcd a.vcd --fst a.fst", "waveforms go to a.vcd or to a.fst: a run writes one format"),
    ("--vcd net.toml/a.vcd", "cannot write net.toml/a.vcd"),
    ("--fst out.png", "would replace the output out.png"),
    ("--vcd raw.png", "would replace the input raw.png")])
def test_rejected(folder, options, message, capsys):
    before = sorted(folder.iterdir())
    assert main(f"simulate net.toml raw.png -o out.png {options}".split()) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1
    assert sorted(folder.iterdir()) == before


def test_a_format_that_there_is_not(tmp_path):
    with pytest.raises(InputError, match="is 'saif', one of vcd, fst is needed"):
        Waves(tmp_path / "waves.saif", "saif")


@pytest.mark.longer
def test_verilator_without_what_fst_needs(folder, monkeypatch, capsys):
    monkeypatch.setattr(waves_module, "_FST_HEADERS", ("lz5.h",))
    assert main("simulate net.toml raw.png -o out.png --fst waves.fst".split()) == 2
    assert "Verilator packs FST with lz5.h, which" in capsys.readouterr().err
    assert not (folder / "waves.fst").exists()
