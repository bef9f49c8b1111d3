"""Cores that leave something out: the same pixels, and registers that are not there."""

import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cameras import barrel_descriptor
from drivers import WIDE, compile_c
from ncdc.cli import main
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.drivers import driver_files
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import (
    COUNTERS,
    FIXED_LENS_BIT,
    NO_COUNTERS_BIT,
    NO_FOLLOW_BIT,
    STATUS_DONE,
    VIEW_BIT,
    absent,
    capabilities,
)

CONSOLE = Path(__file__).resolve().parents[1] / "support" / "tcl" / "console.tcl"
NOTHING = Hardware(fixed_lens=True, follow=False, counters=False)


def simulated(hardware, nodes=1, neurons=3):
    """A frame of a rough lens, every register written first and those left out read as zero."""
    d = barrel_descriptor((72, 21), (76, 24), hidden_neurons=neurons, bayer="GBRG",
                          fill=(200, 100, 50))
    d = replace(d, nodes=nodes)
    raw = np.random.default_rng(1).integers(0, 256, d.geometry.distorted[::-1], np.uint8)
    return simulate_correction(d, raw, hardware, memory="hostile", simulator="icarus")


@pytest.mark.longer
@pytest.mark.parametrize("hardware,nodes,neurons", [
    (replace(NOTHING, strip=32), 8, 3),                         # three neurons in four turns
    pytest.param(Hardware(fixed_lens=True, output="stream", lanes=2), 1, 2,
                 marks=pytest.mark.regress),
    pytest.param(Hardware(fixed_lens=True, share=2, hidden="raster", format="BGR8"), 1, 3,
                 marks=pytest.mark.regress),
    pytest.param(Hardware(follow=False, counters=False), 1, 2, marks=pytest.mark.regress)])
def test_pixels_are_the_same(hardware, nodes, neurons):
    result = simulated(hardware, nodes, neurons)
    assert result.differing == [] and result.bytes_outside == 0
    assert result.blank.any() and not result.blank.all()
    assert any(result.counters.values()) == hardware.counters


def test_a_constant_lens_keeps_its_words_out_of_memories():
    shared = Hardware(share=2)
    assert shared.in_memory("output") and not replace(shared, fixed_lens=True).in_memory("output")
    ports = Corrector(WIDE, replace(shared, fixed_lens=True)).registers.signature.members
    assert not {"writes", "valid_table"} & set(ports)


def test_capabilities_name_what_is_absent():
    bits = FIXED_LENS_BIT | NO_FOLLOW_BIT | NO_COUNTERS_BIT
    hardware = NOTHING.made_for(WIDE)
    assert capabilities(hardware, 64, 48)["CAPABILITIES"] & (bits | VIEW_BIT) == bits
    assert not capabilities(Hardware().made_for(WIDE), 64, 48)["CAPABILITIES"] & bits
    table = Corrector(WIDE, NOTHING).registers.table
    gone = absent(table, NOTHING)
    assert {"FOLLOW", "HIDDEN0_BIAS", "VALID_WINDOW", "CLOCKS", "OUTPUT_FORMAT"} <= gone
    assert not {"SOURCE_BASE", "TARGET_LIMIT", "FRAMES", "STATUS", "DIGEST"} & gone
    assert not absent(table, Hardware())


def test_drivers_do_not_name_what_is_absent(tmp_path):
    files = driver_files(Corrector(WIDE, NOTHING), [("wide.toml", WIDE)])
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    compile_c(tmp_path, "-c", "ncdc.c", "ncdc_lenses.c")
    for name in ("ncdc_registers.h", "ncdc_registers.py", "ncdc_console_data.tcl", "ncdc.rdl"):
        # The text of NO_FOLLOW says what it is about.
        text = files[name].replace("NCDC_", " ").replace("there is no `FOLLOW`", "")
        assert not {*COUNTERS, "FOLLOW"} & set(re.findall(r"\w+", text)), name
    assert "VALID_ROWS" not in files["ncdc.rdl"] and "HIDDEN0_BIAS" not in files["ncdc.rdl"]


def test_the_console_corrects_without_counters(tmp_path):
    corrector = Corrector(WIDE, NOTHING)
    for name, text in driver_files(corrector, [("wide.toml", WIDE)]).items():
        (tmp_path / name).write_text(text)
    (tmp_path / "raw").write_bytes(bytes(WIDE.geometry.distorted_width
                                         * WIDE.geometry.distorted_height))
    (tmp_path / "script").write_text("ncdc::connect\nncdc::load wide\n"
                                     "puts [ncdc::correct raw picture.ppm]\nncdc::counters\n")
    values = corrector.registers.constants | {"STATUS": STATUS_DONE}
    words = {0x10000000 + 4 * r.address: values.get(r.name, 0) for r in corrector.registers.table}
    process = subprocess.Popen(["tclsh", CONSOLE, "ncdc_console.tcl", "script"], cwd=tmp_path,
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    said = ""
    with process:
        for line in process.stdout:
            if not line.startswith("ASK "):
                said += line
                continue
            _, kind, at, *more = line.split()
            if kind == "to":
                Path(at).write_bytes(bytes(int(more[1])))
            process.stdin.write(f"{words[int(at)] if kind == 'read' else ''}\n")
            process.stdin.flush()
    assert said == "picture.ppm: {}x{}\n".format(*WIDE.geometry.corrected)


def test_a_fixed_lens_has_no_view():
    with pytest.raises(InputError, match="fixed lens, a view needs registers"):
        Hardware(fixed_lens=True, view=True)


@pytest.mark.parametrize("options,sentence", [
    (["--no-follow", "--system"], "--no-follow and --system are given, only a corrector alone"),
    (["--no-counters", "--board", "faka2"], "--no-counters and --board are given"),
    (["--fixed-lens", "--lens", "NET"], "no other lens can be loaded"),
    (["--fixed-lens", "--view"], "fixed lens, a view needs registers")])
def test_generate_rejects_what_needs_the_missing_part(tmp_path, capsys, options, sentence):
    net = tmp_path / "net.toml"
    replace(barrel_descriptor((40, 24), (50, 34)), nodes=8).save(net)
    options = [str(net) if option == "NET" else option for option in options]
    assert main(["generate", str(net), "-o", str(tmp_path / "out"), *options]) == 2
    said = capsys.readouterr().err
    assert sentence in said and "Traceback" not in said
    assert not (tmp_path / "out").exists()
