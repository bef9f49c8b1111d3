"""A Quartus board with a processor and Ethernet: its project, and what is rejected."""

import re
from pathlib import Path

import pytest
from amaranth.back import verilog

from cameras import barrel_descriptor
from constraints import complaints, unlimited
from ncdc.cli import main
from ncdc_boards.camera_board.design import design_of, sensor_for
from ncdc_boards.camera_board.ethernet import MODULE
from ncdc_boards.catalogue import board
from ncdc_boards.quartus.project import project_files
from ncdc_boards.quartus.sdc import FREE, GRAY_COUNTERS, PROCESSOR_GRAY_COUNTERS
from ncdc_hdl.video.modes import mode_named
from ncdc_soc.board import board_processor
from peers import need
from quartus_files import directions, pins_of, recorded
from verilog_crossings import crossings

BOARD = "de2-115"
LOOPS = {"core_loop": 3, "pixel_loop": 1, "ethernet_loop": 2}


def small():
    return barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, strength=.4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """That of the project, without the Verilog of the core."""
    found, sensor = tmp_path_factory.mktemp("ethernet"), sensor_for("mt9p031", small().geometry)
    design = design_of(board(BOARD), [("a", small())], sensor, mode_named("640x480"),
                       processor=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verilog, "_convert_rtlil_text", lambda text, **other: "// none\n")
        for file, text in project_files(design, [f"{MODULE}.v"]).items():
            (found / file).write_text(text)
    return found


def ways(folder):
    """Direction of each port."""
    found = directions(folder, BOARD)
    found |= {port: "input" for port in found if port.startswith("eth_rgmii_0__rx")}
    return found | {"eth_rgmii_0__mdio__io": "inout"}


@pytest.mark.longer
def test_every_port_is_constrained_or_free(folder):
    calls = recorded("sdc", folder / "ncdc_de2_115.sdc")
    assert complaints(calls, ways(folder), FREE, LOOPS) == []
    clocks = {call[call.index("-name") + 1] for call in calls if "clock" in call[0]
              and "-name" in call}
    assert {"eth_rgmii_0__rx_clk__io", "ethernet_pin"} <= clocks


@pytest.mark.longer
def test_each_gray_counter_has_a_limit_and_is_asked_for(folder):
    calls = recorded("sdc", folder / "ncdc_de2_115.sdc")
    assert len(PROCESSOR_GRAY_COUNTERS) == 1
    assert unlimited(calls, PROCESSOR_GRAY_COUNTERS, 8) == []
    script = (folder / "check_timing.tcl").read_text()
    for source, sink in (*GRAY_COUNTERS, *PROCESSOR_GRAY_COUNTERS):
        assert f"{{{source}}} {{{sink}}} " in script


@pytest.mark.parametrize("old,new,said", [
    pytest.param(
        "ethernet_loop|auto_generated|pll1|clk[1]", "ethernet_loop|auto_generated|pll1|clk[2]",
        "comes of output 2 of ethernet_loop, which has 2", marks=pytest.mark.longer),
    pytest.param("eth_rgmii_0__tx_data__io*", "", "eth_rgmii_0__tx_data__io has no delays",
                 marks=pytest.mark.longer),
    ("eth_rgmii_0__mdio__io", "eth_rgmii_0__mdi__io", "eth_rgmii_0__mdio__io has no delays"),
    ("|*multiregimpl*_regs0*}]\n", "|*multiregimpl*}]\n", "are cut"),
])
def test_the_checker_finds_what_is_planted(folder, tmp_path, old, new, said):
    text = (folder / "ncdc_de2_115.sdc").read_text()
    assert old in text
    (tmp_path / "planted.sdc").write_text(text.replace(old, new))
    found = complaints(recorded("sdc", tmp_path / "planted.sdc"), ways(folder), FREE, LOOPS)
    assert any(said in sentence for sentence in found), found


def test_every_pin_has_its_own_port_and_the_sources_are_named(folder):
    pins, calls = pins_of(folder, BOARD)
    assert len(set(pins.values())) == len(pins)
    assert sum(port.startswith("eth_rgmii") for port in pins) == 15
    assert [MODULE + ".v"] in [call[3:4] for call in calls
                               if call[:3] == ["set_global_assignment", "-name", "VERILOG_FILE"]]


@pytest.mark.parametrize("arguments,said", [
    (["--board", "de1-soc", "--system"], "has no Ethernet chip, which --system needs"),
    (["--board", "ulx3s", "--system"], "has no Ethernet chip, which --system needs"),
    (["--board", "de10-nano", "--system"], "has a processor of its own"),
    (["--board", BOARD, "--system", "--address", "10.0.0"], "'10.0.0' is no IPv4 address"),
    (["--board", BOARD, "--system", "--mac", "024e0a4d000c"], "six pairs of hexadecimal digits"),
    (["--board", BOARD, "--system", "--mac", "03:4e:0a:4d:00:0c"], "its first byte is even"),
    (["--board", BOARD, "--system", "--mac", "00:00:00:00:00:00"], "not all bytes are 0"),
    (["--board", BOARD, "--system", "--sensor", "ov5640"], "a device on a network has one of"),
])
def test_what_does_not_fit_is_rejected(tmp_path, capsys, arguments, said):
    small().save(tmp_path / "net.toml")
    assert main(["build", str(tmp_path / "net.toml"), *arguments, "-o", str(tmp_path / "o")]) == 2
    assert said in capsys.readouterr().err and not (tmp_path / "o").exists()


@pytest.mark.longer
def test_the_command_writes_processor_and_firmware(tmp_path, monkeypatch):
    need("riscv64-unknown-elf-gcc")
    monkeypatch.setattr(verilog, "_convert_rtlil_text", lambda text, **other: "// none\n")
    small().save(tmp_path / "net.toml")
    assert main(["build", str(tmp_path / "net.toml"), "--board", BOARD, "--system", "--address",
                 "10.1.2.3", "--mac", "02:4e:0a:4d:00:7f", "-o", str(tmp_path / "o")]) == 0
    text = (tmp_path / "o" / f"{MODULE}.v").read_text()
    memories = re.findall(r'readmemh\("([^"]+)"', text)
    assert len(memories) == 2 and all((tmp_path / "o" / name).read_text() for name in memories)
    words = (tmp_path / "o" / f"{MODULE}_rom.init").read_text().split()
    assert 1000 < len(words) <= 18432
    content = b"".join(int(word, 16).to_bytes(4, "little") for word in words)
    assert bytes.fromhex("024e0a4d007f") in content and b"024E0A4D007F" in content
    settings = (tmp_path / "o" / "ncdc_de2_115.qsf").read_text()
    assert f"VERILOG_FILE {MODULE}.v" in settings and "VERILOG_FILE VexRiscv.v" in settings


def unnamed(found):
    """Crossings that do not end where a false path of the constraints does."""
    return [one for one in found
            if not re.search(r"multiregimpl\d+_regs0|ars_cd_eth_|^eth_[rt]x_rst$", one[2])]


@pytest.mark.longer
def test_every_crossing_of_the_processor_is_one_that_the_constraints_name(tmp_path):
    made = board_processor(board(BOARD), 75_000_000)
    texts = {"processor.v": made.text, "core.v": Path(made.core).read_text()}
    found = crossings(texts, [f"{MODULE}_{name}.init" for name in ("rom", "sram")], MODULE,
                      tmp_path)
    # Three clocks: the core's, which the processor's copies, and those of RGMII.
    assert {"clock_rx", "clock_transmit"} < {clock for _, there, _, here in found
                                             for clock in (there, here)}
    assert len(found) > 10
    assert unnamed(found) == []
    # One synchroniser fewer is seen.
    source = re.search(r"multiregimpl0_regs0 <= (\w+);", made.text)[1]
    text = re.sub(r"= \w*multiregimpl0_regs1;", f"= {source};", made.text)
    assert text != made.text
    assert unnamed(crossings(texts | {"processor.v": text}, [], MODULE, tmp_path))
