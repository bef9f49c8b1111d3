"""The Colorlight i9: pins as two other projects have them, clocks, what is rejected."""

import re
from pathlib import Path

import pytest

from cameras import barrel_descriptor
from litex_pins import litex_pins
from ncdc.cli import main
from ncdc_boards.colorlight_i9.clocks import clock_plan
from ncdc_boards.colorlight_i9.platform import CAMERA_WIRES, ColorlightI9Platform
from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import DIRECTIONAL

litex = pytest.importorskip("litex_boards.platforms.colorlight_i5")

NAME = "colorlight-i9"
PINS = Path(__file__).parents[1] / "data" / "pins" / f"{NAME}.txt"
# Our signals: (resource, number, signal) of litex-boards, name in the other project's table.
NAMES = {
    "clk25": (("clk25", 0, None), "CLK"), "led": (("user_led_n", 0, None), "LED"),
    "uart.rx": (("serial", 0, "rx"), None), "uart.tx": (("serial", 0, "tx"), None),
    "sdram.clk": (("sdram_clock", 0, None), "SDRAM_CLK"),
    **{f"sdram.{ours}": (("sdram", 0, theirs), f"SDRAM_{table}") for ours, theirs, table in (
        ("we", "we_n", "WE"), ("ras", "ras_n", "RAS"), ("cas", "cas_n", "CAS"), ("ba", "ba", "BA"),
        ("a", "a", "A"), ("dq", "dq", "DQ"))},
    "eth_rgmii.tx_clk": (("eth_clocks", 0, "tx"), "ETH_GTXCLK"),
    "eth_rgmii.rx_clk": (("eth_clocks", 0, "rx"), "ETH_RXC"),
    **{f"eth_rgmii.{ours}": (("eth", 0, theirs), f"ETH_{table}") for ours, theirs, table in (
        ("rst", "rst_n", "RESET"), ("mdc", "mdc", "MDC"), ("mdio", "mdio", "MDIO"),
        ("tx_ctl", "tx_ctl", "TX_EN"), ("tx_data", "tx_data", "TXD"),
        ("rx_ctl", "rx_ctl", "RX_DV"), ("rx_data", "rx_data", "RXD"))}}
# Of the header P2, the pins of litex-boards' two connectors there, in their order.
PMODS = {"pmodc": (12, 10, 8, 6, 11, 9, 7, 5), "pmodd": (30, 28, 26, 24, 29, 27, 25, 23)}


def table():
    """{name: pin} of the other project."""
    lines = PINS.read_text().splitlines()
    return dict(line.split() for line in lines if not line.startswith("#"))


@pytest.fixture(scope="module")
def ours():
    """{signal: pins} of all that the top asks for."""
    platform, found = ColorlightI9Platform(), {}
    for (name, _), resource in platform.resources.items():
        if name == "csi_camera":        # at the same pins: tests/boards/test_ecp5_csi2.py
            continue
        for part in resource.ios:
            parts = [(name, part)] if hasattr(part, "names") else \
                [(f"{name}.{part.name}", part.ios[0])]
            for key, pins in parts:
                found[key] = pins.map_names(platform._conn_pins, resource)
    return found


def test_every_pin_is_where_two_others_have_it(ours):
    other = table()
    assert ours.keys() == NAMES.keys() | {f"camera.{name}" for name in CAMERA_WIRES}
    for name, (theirs, row) in NAMES.items():
        # Whoever writes whole words may number DQ as he likes; litex-boards does.
        as_litex = sorted if name == "sdram.dq" else list
        assert as_litex(ours[name]) == as_litex(litex_pins(litex._io_v7_2, *theirs)), name
        if row:
            assert ours[name] == [other[row]] if row in other else [
                other[f"{row}[{k}]"] for k in range(len(ours[name]))], name
    assert other["SDRAM_CKE"] == "VCC" and other["SDRAM_CS"] == "GND"
    assert {other[f"SDRAM_DQM[{k}]"] for k in range(4)} == {"GND"}


def test_the_cameras_wires_are_those_of_the_header(ours):
    other, seen = table(), []
    connectors = dict((name, pins.split()) for name, pins in litex._connectors_v7_2)
    shared = {number: pin for name, numbers in PMODS.items()
              for number, pin in zip(numbers, connectors[name], strict=True)}
    for name, numbers in CAMERA_WIRES.items():
        assert ours[f"camera.{name}"] == [other[f"P2[{number}]"] for number in numbers]
        assert all(other[f"P2[{number}]"] == shared.get(number, other[f"P2[{number}]"])
                   for number in numbers)
        seen += numbers
    assert len(set(seen)) == len(seen) == 19 and sum(number in shared for number in seen) == 15


def test_no_pin_is_used_twice(ours):
    pins = [pin for some in ours.values() for pin in some]
    assert len(set(pins)) == len(pins) == 87


def test_the_loop_makes_each_clock():
    plan = clock_plan(None)
    core = 250 / 7
    assert plan.targets() == {"sync": core, "memory": core, "sensor_reference": 25, "ethernet": 125}
    # Nanoseconds by which the clock at the SDRAM's pin is late.
    assert plan.loop.oscillator_mhz == 500 and 2 * plan.loop.phases[1] == 24
    assert 2 * clock_plan(None, 62.5).loop.phases[1] == 12
    with pytest.raises(InputError, match="60 MHz, a whole part of 500 MHz is needed"):
        clock_plan(None, 60)


def rejected(capsys, *arguments):
    """The sentence with which the command ends."""
    assert main(["build", *map(str, arguments), "--board", NAME]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    return lines[0]


@pytest.mark.parametrize("sizes,options,said", [
    ([(64, 24)], ["--mode", "640x480"], "the board colorlight-i9 has no screen"),
    ([(64, 24)], ["--sensor", "ov5640"], "a device on a network has one of mt9p031"),
    ([(64, 24), (64, 24)], [], "2 descriptors are given, the board colorlight-i9 has no buttons"),
    ([(62, 24)], [], "a row of the corrected picture has 186 bytes, .* 4 at once: 60 or 64 pixels"),
    ([(64, 24, 2000, 1500)], [], "the frames take .* MB, the colorlight-i9 has 8.4 MB"),
])
def test_what_does_not_fit_is_rejected(tmp_path, capsys, sizes, options, said):
    paths = [tmp_path / f"{k}.toml" for k in range(len(sizes))]
    for path, size in zip(paths, sizes):
        barrel_descriptor(size[:2], size[-2:], hidden_neurons=2).save(path)
    output = tmp_path / "out"
    assert re.search(said, rejected(capsys, *paths, *options, "-o", output))
    assert not output.exists()


def test_an_interpolation_without_space_is_rejected(tmp_path, capsys):
    path = tmp_path / "net.toml"
    barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, interpolation=DIRECTIONAL).save(path)
    assert "has space for fast and gradient: ncdc train --interpolation gradient" in rejected(
        capsys, path, "-o", tmp_path / "out")
