"""Projects of the Quartus boards: pins, constraints, script, and the file that is the user's."""

import json
import os
import re
import subprocess

import pytest
from amaranth.back import verilog

from cameras import barrel_descriptor
from constraints import complaints, unlimited
from ncdc.cli import main
from ncdc_boards.board import project_name
from ncdc_boards.camera_board.design import design_of, sensor_for
from ncdc_boards.catalogue import board
from ncdc_boards.quartus.project import USER_FILE, project_files
from ncdc_boards.quartus.sdc import FREE, GRAY_COUNTERS
from ncdc_hdl.video.modes import mode_named
from quartus_files import TCL, directions, pins_of, recorded

BOARDS = ("de0-cv", "de1-soc", "de2-115")


def small():
    return barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, strength=.4)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of a DE1-SoC's project, as the command writes it."""
    folder = tmp_path_factory.mktemp("boards")
    small().save(folder / "net.toml")
    assert main(["build", str(folder / "net.toml"), "--board", "de1-soc", "-o",
                 str(folder / "project")]) == 0
    return folder / "project"


@pytest.fixture(scope="module")
def folders(tmp_path_factory, whole):
    """Folder of each board's project; those of two boards without their Verilog."""
    found = {"de1-soc": whole}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verilog, "_convert_rtlil_text", lambda text, **other: "// none\n")
        for name in set(BOARDS) - {"de1-soc"}:
            found[name] = tmp_path_factory.mktemp(name)
            sensor = sensor_for("mt9p031", small().geometry)
            design = design_of(board(name), [("a", small())], sensor, mode_named("640x480"))
            for file, text in project_files(design).items():
                (found[name] / file).write_text(text)
    return found


LOOPS = {"core_loop": 3, "pixel_loop": 1}


@pytest.mark.longer
@pytest.mark.parametrize("name", BOARDS)
def test_every_port_is_constrained_or_free(folders, name):
    folder = folders[name]
    calls = recorded("sdc", folder / f"{project_name(board(name))}.sdc")
    assert complaints(calls, directions(folder, name), FREE, LOOPS) == []
    clocks = {call[call.index("-name") + 1] for call in calls if "clock" in call[0] and
              "-name" in call}
    assert clocks == {"clk50_0__io", "sensor", "sdram_pin", "sensor_reference_pin",
                      "altera_reserved_tck"} | (
        {"vga_pin"} if board(name).dac else set())


@pytest.mark.longer
@pytest.mark.parametrize("old,new,said", [
    ("set_false_path -to [get_ports {led_*}]", "", "led_3__io has no delays and is not named"),
    ("sdram_0__dqm__io* ", "", "sdram_0__dqm__io has no delays"),
    ("sdram_0__dqm__io* ", "sdram_0__dqm__io* sdram_0__clk__io ", "is a clock in a data group"),
    ("-clock sdram_pin -max", "-clock sdram -max", "names the clock sdram, which there is not"),
    ("general[1]", "general[3]", "comes of output 3 of core_loop, which has 3"),
    ("-source [get_pins -compatibility_mode $memory]", "", "sdram_pin has no source"),
    ("camera_0__lval", "camera_0__lvl", "no port is called camera_0__lvl__io*"),
    ("derive_pll_clocks\n", "set_clock_groups -asynchronous\n", "groups of clocks are cut"),
    ("{*altera_std_synchronizer:*|din_s1}]\n", "{*|queue|*}]\n", "paths to *|queue|* are cut"),
    ("*:jtag|request*", "*:jtag|*", "paths from *:jtag|* are cut"),
    ("[get_ports {altera_reserved_tck}]", "", "altera_reserved_tck has no delays"),
    ("set_output_delay -clock vga_pin -min", "#", "vga_0__r__io has no delays"),
])
def test_the_checker_finds_what_is_planted(whole, tmp_path, old, new, said):
    text = (whole / "ncdc_de1_soc.sdc").read_text()
    assert old in text
    (tmp_path / "planted.sdc").write_text(text.replace(old, new))
    calls = recorded("sdc", tmp_path / "planted.sdc")
    found = complaints(calls, directions(whole, "de1-soc"), FREE, LOOPS)
    assert any(said in sentence for sentence in found), found


CORE_NS = 40 / 3        # the core's period, the shortest of those that a queue joins


@pytest.mark.longer
@pytest.mark.parametrize("name", BOARDS)
def test_each_gray_counter_has_a_limit_that_false_paths_do_not_end(folders, name):
    calls = recorded("sdc", folders[name] / f"{project_name(board(name))}.sdc")
    assert len(GRAY_COUNTERS) == 2 and unlimited(calls, GRAY_COUNTERS, CORE_NS) == []
    assert unlimited([call for call in calls if call[0] != "set_net_delay"], GRAY_COUNTERS,
                     CORE_NS) == list(GRAY_COUNTERS)
    assert unlimited(calls, GRAY_COUNTERS, CORE_NS / 2) == list(GRAY_COUNTERS)


@pytest.mark.longer
@pytest.mark.parametrize("name", BOARDS)
def test_every_port_bit_has_its_own_pin(folders, name):
    pins, calls = pins_of(folders[name], name)
    assert len(set(pins.values())) == len(pins), "a pin is used twice"
    settings = [call[2:4] for call in calls if call[0] == "set_global_assignment"]
    for wanted in (["DEVICE", board(name).device], ["VERILOG_FILE", USER_FILE],
                   ["TOP_LEVEL_ENTITY", project_name(board(name))]):
        assert wanted in settings
    table = dict(re.findall(r"^\| `([^`]+)` \| (\w+) \|", (folders[name] / "PORTS.md").read_text(),
                            re.M))
    assert {to: f"PIN_{pin}" for to, pin in table.items()} == pins


@pytest.mark.longer
@pytest.mark.parametrize("name", BOARDS)
def test_no_input_of_a_header_floats(folders, name):
    """Without camera or adaptor. A clock network has no pull-up, and RS-232 has a receiver."""
    pins, calls = pins_of(folders[name], name)
    up = {call[2] for call in calls if call[0] == "set_instance_assignment" and call[1] == "-to"
          and call[3:5] == ["-name", "WEAK_PULL_UP_RESISTOR"]}
    wanted = {pin for pin in pins if pin.startswith(("camera_0__d_", "camera_0__lval",
                                                     "camera_0__fval", "camera_0__s"))
              and "standby" not in pin}
    wanted |= {"uart_0__rx__io"} - ({"uart_0__rx__io"} if name == "de2-115" else set())
    assert len(wanted) >= 16 and wanted - up == set()


@pytest.mark.longer
def test_the_constraints_name_what_the_verilog_has(whole):
    """Loops with so many outputs, registers and synchronisers by their names; and every port of the
    top has a pin."""
    text = (whole / "ncdc_de1_soc.v").read_text()
    for loop, outputs in LOOPS.items():
        cell = re.search(rf"altera_pll #\(([^;]*?)\) {loop} ", text, re.S).group(1)
        assert f".number_of_clocks(32'd{outputs})" in cell
    page = re.search(r"^module \\ncdc_de1_soc\.core\.system\.page .*?^endmodule", text,
                     re.M | re.S).group()
    assert re.search(r"reg \[\d+:0\] values = ", page)
    for name in ("produce_w_gry", "consume_r_gry"):
        assert len(re.findall(rf"^  reg \[\d+:0\] {name} = ", text, re.M)) == 2
    for name in ("produce_cdc", "consume_cdc"):
        assert len(re.findall(rf"\) {name} \(", text)) == 2
    top = re.search(r"^module ncdc_de1_soc\(([^)]*)\)", text, re.M).group(1)
    pins, _ = pins_of(whole, "de1-soc")
    assert {port.strip() for port in top.split(",")} == {bit.partition("[")[0] for bit in pins}


def quartus(folder, tmp_path, slack, clocks, skew="0.2"):
    """What build.sh ends with, with scripts instead of Quartus's programs."""
    tools = tmp_path / "bin"
    tools.mkdir(exist_ok=True)
    for tool in ("map", "fit", "asm", "sta"):
        script = tools / f"quartus_{tool}"
        run = f'exec tclsh "{TCL / "sta.tcl"}" "$2"' if tool == "sta" else "true"
        script.write_text(f"#!/bin/sh\n{run}\n")
        script.chmod(0o755)
    return subprocess.run(["sh", folder / "build.sh"], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, env=os.environ | {
        "PATH": f"{tools}:{os.environ['PATH']}", "SLACK": slack, "CLOCKS": clocks, "SKEW": skew})


@pytest.mark.longer
def test_the_script_fails_on_negative_slack_and_on_skew(whole, tmp_path):
    clocks = "clk50_0__io sensor sdram_pin sensor_reference_pin vga_pin altera_reserved_tck"
    good = quartus(whole, tmp_path, "0.1", clocks)
    assert good.returncode == 0 and "the minimum slack is 0.1 ns" in good.stdout, good.stdout
    bad = quartus(whole, tmp_path, "-0.25", clocks)
    assert bad.returncode and "the design does not meet timing by 0.25 ns" in bad.stdout
    for source, sink in GRAY_COUNTERS:
        assert f"skew from {source} to {sink}: 0.25" in good.stdout
    apart = quartus(whole, tmp_path, "0.1", clocks, skew="10.75")
    assert apart.returncode and re.search(
        r"bits of \*\|produce_w_gry\* arrive 10.75 ns apart, 10.667 at most", apart.stdout)
    lost = quartus(whole, tmp_path, "0.1", clocks.replace(" vga_pin", ""))
    assert lost.returncode and "there is no clock vga_pin" in lost.stdout


@pytest.mark.longer
def test_the_users_file_is_never_written_again(whole, capsys):
    before = {path.name: path.read_bytes() for path in whole.iterdir()}
    (whole / USER_FILE).write_text("mine")
    (whole / "build.sh").write_text("changed")
    assert main(["build", str(whole.parent / "net.toml"), "--board", "de1-soc", "-o",
                 str(whole)]) == 0
    assert f"{USER_FILE}: yours, left as it is" in capsys.readouterr().out
    assert (whole / USER_FILE).read_text() == "mine"
    (whole / USER_FILE).write_bytes(before[USER_FILE])
    assert {path.name: path.read_bytes() for path in whole.iterdir()} == before


def test_colour_adds_its_registers(tmp_path, monkeypatch):
    monkeypatch.setattr(verilog, "_convert_rtlil_text", lambda text, **other: "// none\n")
    small().save(tmp_path / "net.toml")
    for options in ([], ["--colour"]):
        output = tmp_path / f"project{len(options)}"
        assert main(["build", str(tmp_path / "net.toml"), "--board", "de1-soc", "-o", str(output),
                     *options]) == 0
        assert ("GAIN_RED" in (output / "ncdc_registers.py").read_text()) == bool(options)


@pytest.mark.parametrize("size,options,said", [
    ((64, 24), ["--board", "de10-nano", "--colour"], "--colour is not supported on the de10-nano"),
    ((1024, 768), ["--board", "de1-soc"], "needs 99 % of the clocks of the memory of de1-soc"),
    ((1920, 1080), ["--board", "de2-115"], "pixel clock of 148.3 MHz, the board's converter takes "
     "140 MHz at most"),
    ((64, 24), ["--board", "de1-soc", "--pixel-clock-mhz", "96"], "after it: 64 MHz fit"),
    ((64, 24), ["--board", "faka2"], "faka2 has no design of ours"),
    ((64, 24), ["--board", "none"], "board is 'none', one of colorlight-i9, de0-cv, "
     "de1-soc, de10-nano, de2-115, faka2, ulx3s is needed"),
])
def test_what_does_not_fit_is_rejected_in_a_sentence(tmp_path, capsys, size, options, said):
    barrel_descriptor(size, (64, 24), hidden_neurons=2).save(tmp_path / "net.toml")
    output = tmp_path / "out"
    assert main(["build", str(tmp_path / "net.toml"), "-o", str(output), *options]) == 2
    assert said in the_sentence(capsys) and not output.exists()


def the_sentence(capsys):
    """What a command said last, after its progress."""
    *before, last = capsys.readouterr().err.splitlines()
    assert all(line.startswith("planning:") for line in before), before
    return last


@pytest.mark.parametrize("size,options,said", [
    ((1024, 768), ["--board", "de1-soc"], "needs 99 % of the clocks of the memory of de1-soc"),
    pytest.param((1280, 1024), ["--board", "de2-115"], "1280x1024, and can have 59 %: "
                 "pictures of the modes 640x480, 800x600, 1024x768, 1280x720, 1280x720@20 fit",
                 marks=pytest.mark.longer),
    ((64, 24), ["--board", "de0-cv", "--mode", "1280x720"], "takes 65 MHz at most: a smaller"),
    ((1024, 760), ["--board", "de2-115", "--mode", "1280x720"], "does not hold it: 1024x768 does"),
    ((64, 24), ["--board", "de1-soc", "--pixels-per-clock", "2"], "120 MB/s: 1 fits"),
    ((64, 24), ["--board", "de2-115", "--min-fps", "2000"], "2000 are asked for: the sensor sends"),
    ((64, 24), ["--board", "de1-soc", "--to", "stream"], "the board has its own"),
    ((64, 24), ["--mode", "640x480"], "--board NAME is needed"),
    ((64, 24), ["--system"], "--system is of a board: --board NAME is needed"),
    ((64, 24), ["--board", "de0-cv", "--system"], "has no Ethernet chip, which --system needs"),
])
def test_plan_rejects_in_a_sentence(tmp_path, capsys, size, options, said):
    barrel_descriptor(size, (64, 24), hidden_neurons=2).save(tmp_path / "net.toml")
    assert main(["plan", str(tmp_path / "net.toml"), *options]) == 2
    assert said in the_sentence(capsys)


def test_plan_lists_what_a_board_carries(tmp_path, capsys):
    small().save(tmp_path / "net.toml")
    assert main(["plan", str(tmp_path / "net.toml"), "--board", "de2-115", "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["mode"] == "640x480" and report["memory_mb_per_second"] == 225
    assert report["memory_bytes"] < report["memory_bytes_there"] == 128 << 20
    assert report["corrected_frames_per_second"] == report["sensor_frames_per_second"] > 90


@pytest.mark.longer
def test_plan_counts_what_a_processor_sends(tmp_path, capsys):
    barrel_descriptor((1024, 768), (1024, 768), hidden_neurons=2).save(tmp_path / "net.toml")
    options = ["plan", str(tmp_path / "net.toml"), "--board", "de2-115", "--json", "-"]
    assert main([*options, "--system"]) == 0
    report = json.loads(capsys.readouterr().out)
    left = (report["memory_mb_per_second"] - report["screen_mb_per_second"]
            - 1024 * 768e-6 * report["sensor_frames_per_second"])
    # 1.3 bytes of a raw pixel, 3 that are written, 3 that are sent.
    assert report["corrected_frames_per_second"] == pytest.approx(left / (7.3 * 1024 * 768e-6))
    assert main(options) == 0
    assert (json.loads(capsys.readouterr().out)["corrected_frames_per_second"]
            > 1.4 * report["corrected_frames_per_second"])
