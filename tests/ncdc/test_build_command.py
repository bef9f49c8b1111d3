"""``ncdc build``: what it rejects, and its flow on a design that is quick to place and route."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from amaranth.back import rtlil
from amaranth.hdl import ClockDomain, ClockSignal, Const, Elaboratable, Instance, Module, Signal
from amaranth.lib import io

from cameras import barrel_descriptor
from ncdc import cli
from ncdc.cli.build_open import _check_clocks
from ncdc.toolchain.bitstream import (
    Clock,
    Placement,
    clock_nets,
    clock_preferences,
    pack,
    place_and_route,
    placement_of,
    synthesise_board,
    used_cells,
)
from ncdc.toolchain.ecp5_device import check_blocks
from ncdc_boards.camera_board.budget import check_memory
from ncdc_boards.camera_board.design import design_of, hardware_for, sensor_for
from ncdc_boards.ulx3s.board import BOARD
from ncdc_boards.ulx3s.clocks import clock_plan
from ncdc_boards.ulx3s.platform import Ulx3sPlatform
from ncdc_hdl.backend.cache.layouts import banks_for
from ncdc_hdl.backend.cache.tiles import Tiles
from ncdc_hdl.video.modes import MODES, mode_named
from ncdc_model.golden.network import frame_coordinates
from ncdc_model.raw_lens import raw_lens, raw_map
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.errors import InputError
from ncdc_spec.frames import BGRX8
from ncdc_spec.interpolation import FAST


def rejected(capsys, *arguments):
    """The sentence with which the command ends."""
    assert cli.main(["build", *map(str, arguments)]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1 and lines[0].startswith("ncdc build: ")
    return lines[0]


@pytest.fixture
def net(tmp_path):
    path = tmp_path / "net.toml"
    barrel_descriptor((64, 48), (64, 48)).save(path)
    return path


@pytest.mark.parametrize("size,options,said", [
    ((64, 48), ["--mode", "100x100"], "'100x100', one of 640x480, 800x600"),
    ((64, 48), ["--seeds", "0"], "seeds is 0, 1 to 20"),
    ((64, 48), ["--sensor", "none"], "the sensor is 'none', known are mt9p031"),
    ((648, 480), ["--mode", "640x480"], "648x480 pixels, the mode 640x480 does not hold it: "
     "800x600 does"),
    ((64, 48), ["--sensor", "pattern", "--field", "full", "--pixel-clock-mhz", "20"],
     "field and pixel_clock_hz of the sensor pattern cannot be set: it has no registers"),
    ((64, 48), ["--sensor", "pattern", "--board", "de0-cv"], "not supported on the de0-cv"),
    ((64, 48), ["--synthesize-only", "--board", "de0-cv"], "de0-cv is synthesised by Quartus"),
    ((64, 48), ["--board", "faka2"], "faka2 has no design of ours, .* generate --board faka2"),
    ((1024, 768), [], "1024x768 has a pixel clock of 65.00 MHz, .* takes 50 MHz at most"),
])
def test_what_does_not_fit_is_rejected_in_a_sentence(size, options, said, tmp_path, capsys):
    path = tmp_path / "net.toml"
    barrel_descriptor(size, (64, 48)).save(path)
    output = tmp_path / "out"
    assert re.search(said, rejected(capsys, path, *options, "-o", output))
    assert not output.exists()


def test_lenses_of_other_sizes_are_rejected(net, tmp_path, capsys):
    other = tmp_path / "other.toml"
    barrel_descriptor((64, 40), (64, 48)).save(other)
    assert "corrected picture has 64x40" in rejected(capsys, net, other)


def test_a_missed_clock_is_named():
    good, bad = Clock("pixel", 25.0, 80.0), Clock("core", 75.0, 60.0)
    assert bad.slack == pytest.approx(-.25)
    _check_clocks(Placement(1, (good,), {}), 3)
    with pytest.raises(InputError, match="core reaches 60.0 of 75.0 MHz in the best of 3"):
        _check_clocks(Placement(1, (good, bad), {}), 3)


@pytest.mark.parametrize("cells,said", [
    ({"DP16KD": 109}, "needs 109 block RAMs, the LFE5U-45F-6BG381C has 108"),
    ({"MULT18X18D": 73}, "needs 73 multipliers, the LFE5U-45F-6BG381C has 72")])
def test_blocks_that_the_device_does_not_have_are_named(cells, said):
    device = "LFE5U-45F-6BG381C"
    check_blocks(device, {"DP16KD": 108, "MULT18X18D": 72, "LUT4": 40_000})
    with pytest.raises(InputError, match=said):
        check_blocks(device, cells)


@pytest.mark.longer
def test_what_memory_cannot_carry_is_rejected():
    """A screen whose lines come late while others wait; a camera so fast that it leaves nothing for
    corrected frames."""
    large = barrel_descriptor((800, 600), (800, 600), hidden_neurons=2)
    sensor = sensor_for("mt9p031", large.geometry)
    with pytest.raises(InputError, match="needs 73 % .* can have 53 %: .* 640x480, 1280x720@20"):
        design_of(BOARD, [("a", large)], sensor, mode_named("800x600"))
    small = barrel_descriptor((640, 480), (640, 480), hidden_neurons=2)
    with pytest.raises(InputError, match="needs 64 % "):
        design_of(BOARD, [("a", small)], sensor_for("mt9p031", small.geometry), MODES[0],
                  hardware=replace(hardware_for(BOARD), format=BGRX8.name))
    fine = barrel_descriptor((640, 480), (1280, 960), hidden_neurons=2)
    sensor = sensor_for("mt9p031", fine.geometry, pixel_clock_hz=75_000_000)
    with pytest.raises(InputError, match="the memory carries 100 MB/s"):
        check_memory(design_of(BOARD, [("a", fine)], sensor, MODES[0]), sensor[0])
    sensor = sensor_for("mt9p031", small.geometry)
    budget = check_memory(design_of(BOARD, [("a", small)], sensor, MODES[0]), sensor[0])
    assert 20 < budget.corrected_per_second < budget.frames_per_second < 35
    wide = barrel_descriptor((640, 480), (2400, 1800), hidden_neurons=8)
    sensor = sensor_for("mt9p031", wide.geometry)
    budget = check_memory(design_of(BOARD, [("a", wide)], sensor, MODES[0]), sensor[0])
    assert budget.corrected_per_second <= budget.frames_per_second < 6


def test_the_raw_lens_follows_its_inputs():
    """To a tenth of a pixel with eight neurons; with one for y, over a sensor's whole height, to
    some."""
    for size, raw, neurons, limit in (((640, 480), (640, 480), 8, .1),
                                      ((64, 48), (1280, 960), 3, 6)):
        descriptor = barrel_descriptor(size, raw, hidden_neurons=neurons)
        lens = raw_lens(descriptor)
        scale = 2.0**-lens.formats.coordinate.f_bits
        v, u = np.indices(size[::-1])
        for axis, wanted in zip(frame_coordinates(lens), raw_map(descriptor.geometry)(u, v)):
            assert abs(axis * scale - wanted).max() < limit
        assert lens.valid.spans.any()


@pytest.mark.parametrize("mode", [*MODES[:2], mode_named("1280x720@20")],
                         ids=lambda mode: mode.name)
def test_clocks_are_within_the_data_sheets_limits(mode):
    plan = clock_plan(mode)
    for loop in (plan.core, plan.video):
        assert 400 <= loop.oscillator_mhz <= 800
        assert 10 <= loop.input_mhz / loop.reference <= 400
        assert max(loop.outputs_mhz) <= 400
    assert plan.pixel_mhz == pytest.approx(mode.pixel_mhz, rel=.005)
    assert plan.video.outputs_mhz[0] == pytest.approx(5 * plan.pixel_mhz)


class Blinker(Elaboratable):
    """A counter on an LED, on a clock after a gate."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.clock = clock = io.Buffer("i", platform.request("clk25", dir="-"))
        gated = Signal()
        m.submodules.gate = Instance("DCCA", i_CLKI=clock.i, i_CE=Const(1), o_CLKO=gated)
        m.domains.sync = ClockDomain(reset_less=True)
        m.d.comb += ClockSignal().eq(gated)
        count = Signal(12)
        m.submodules.led = led = io.Buffer("o", platform.request("led", 0, dir="-"))
        m.d.sync += count.eq(count + 1)
        m.d.comb += led.o.eq(count[-1])
        return m


@pytest.mark.longer
def test_the_flow_on_a_small_design(tmp_path):
    """Synthesis, place and route, bitstream; the clock is known by our name, with its target."""
    plan = Ulx3sPlatform().prepare(Blinker(), "blinker")
    files = {name: text if isinstance(text, str) else text.decode()
             for name, text in plan.files.items()}
    netlist = synthesise_board(files["blinker.il"], "blinker", tmp_path)
    nets = clock_nets(netlist, {"core": ("gate", "CLKO")})
    # Not the 25 MHz that follow from the pin: what we ask is heard.
    preferences = files["blinker.lpf"] + clock_preferences(nets, {"core": 50.0})
    placement = place_and_route(tmp_path, BOARD.device, preferences, nets, 1)
    assert [(clock.name, clock.target_mhz) for clock in placement.clocks] == [("core", 50)]
    assert placement.slack > .5
    report = json.loads((tmp_path / "1.json").read_text())
    assert placement_of(1, report, {}).clocks[0].name != "core"
    bits = pack(tmp_path, 1)
    # Lattice's bitstreams have this word before the first command.
    assert b"\xff\xff\xbd\xb3" in bits and b"LFE5U-85F" in bits[:200]


@pytest.mark.longer
def test_shared_tiles_are_block_rams(tmp_path):
    """Also without Verilog between Amaranth and Yosys, which then knows no reads that may be
    undefined."""
    tiles = Tiles(CacheOptions.of_bytes(8192), banks_for(32, 1, FAST, shared=True), "shared")
    cells = used_cells(synthesise_board(rtlil.convert(tiles, name="top"), "top", tmp_path))
    assert cells["DP16KD"] == 4 and cells["TRELLIS_FF"] < 400


@pytest.mark.regress
def test_synthesis_alone_ends_with_the_netlist(net, tmp_path):
    """Of the board without a camera: no bitstream, no pin of a camera, each clock constrained."""
    output, report = tmp_path / "out", tmp_path / "report.json"
    assert cli.main(["build", str(net), "--sensor", "pattern", "--synthesize-only",
                     "-o", str(output), "--json", str(report)]) == 0
    written = json.loads(report.read_text())
    assert written["files"][0] == str(output / "ncdc_ulx3s.json")
    assert sorted(written["files"]) == sorted(map(str, output.iterdir()))
    netlist = json.loads((output / "ncdc_ulx3s.json").read_text())
    top = netlist["modules"]["ncdc_ulx3s"]
    assert any("hdmi" in port for port in top["ports"])
    assert not any("camera" in port for port in top["ports"])
    assert written["cells"]["LUT4"] == sum(cell["type"] == "LUT4" for cell in top["cells"].values())
    targets = clock_plan(MODES[0]).targets()
    assert {clock["name"]: clock["target_mhz"] for clock in written["clocks"]} == targets
    preferences = (output / "ncdc_ulx3s.lpf").read_text()
    assert all(f"{mhz * 1e6:.0f} HZ" in preferences for mhz in targets.values())
