"""Pins of the ULX3S, from amaranth-boards, compared with litex-boards and the board's own file."""

import re
from pathlib import Path

import pytest

import ncdc_boards.camera_board.pins as pins
import ncdc_boards.ecp5.csi2_camera as csi2_camera
import ncdc_boards.ulx3s.top as top
from litex_pins import litex_pins
from ncdc_boards.ulx3s.platform import CAMERA_WIRES, Ulx3sPlatform

litex = pytest.importorskip("litex_boards.platforms.radiona_ulx3s")

# Resource, number and signal of litex-boards for ours; its "gpdi" and "wifi_gpio0" are those of
# boards from version 2 on, where the latter is the ESP32's enable.
LITEX = {
    "clk25": ("clk25", 0, None), "uart.rx": ("serial", 0, "rx"), "uart.tx": ("serial", 0, "tx"),
    "button_down": ("user_btn", 4, None), "button_fire": ("user_btn", 1, None),
    "button_left": ("user_btn", 5, None),
    "button_right": ("user_btn", 6, None), "hdmi.clk": ("gpdi", 0, "clk_p"),
    "hdmi.d0": ("gpdi", 0, "data0_p"), "hdmi.d1": ("gpdi", 0, "data1_p"),
    "hdmi.d2": ("gpdi", 0, "data2_p"), "sdram.clk": ("sdram_clock", 0, None),
    "esp32.en": ("wifi_gpio0", 0, None),
    **{f"led{k}": ("user_led", k, None) for k in range(8)},
    **{f"sdram.{ours}": ("sdram", 0, theirs) for ours, theirs in (
        ("we", "we_n"), ("ras", "ras_n"), ("cas", "cas_n"), ("cs", "cs_n"), ("clk_en", "cke"),
        ("ba", "ba"), ("a", "a"), ("dq", "dq"), ("dqm", "dm"))}}

# Of the header J1, of which litex-boards has four pairs: ulx3s_v20.lpf of github.com/emard/ulx3s,
# its gp and gn, in the order GP0, GN0, GP1, ...
J1 = ("B11 C11 A10 A11 A9 B10 B9 C10 A7 A8 C8 B8 C6 C7 A6 B6 A4 A5 A2 B1 C4 B4 F4 E3 G3 F3 H4 "
      "G5").split()


def theirs(*signal):
    """Pins of a signal of litex-boards."""
    return litex_pins(litex._io_common + litex._io_2_0, *signal)


@pytest.fixture(scope="module")
def sites():
    """Sites of our platform, by names as those above."""
    platform, found = Ulx3sPlatform(), {}
    for (name, number), resource in platform.resources.items():
        for part in resource.ios:
            signal = f".{part.name}" if hasattr(part, "ios") else ""
            pins = part.ios[0] if signal else part
            pins = getattr(pins, "p", pins)
            names = list(pins.map_names(platform._conn_pins, resource))
            key = f"led{number}" if name == "led" else f"{name}{signal}"
            if number == 0 or name == "led":
                found[key] = names
            if key == "hdmi.d":
                found |= {f"{key}{k}": [site] for k, site in enumerate(names)}
    return found


@pytest.mark.parametrize("name", LITEX)
def test_a_pin_is_where_others_have_it(name, sites):
    assert sites[name] == theirs(*LITEX[name])


def test_the_cameras_wires_are_those_of_the_header(sites):
    seen = []
    for name, wires in CAMERA_WIRES.items():
        expected = [J1[2 * int(wire[:-1]) + (wire[-1] == "-")] for wire in wires]
        assert sites[f"camera.{name}"] == expected
        seen += expected
    assert len(seen) == len(set(seen)) == 20
    for k in range(2):                      # that litex-boards has as well
        assert J1[2 * k:2 * k + 2] == theirs("gpio", k, "p") + theirs("gpio", k, "n")


def test_every_resource_that_the_top_asks_for_is_compared():
    text = "".join(Path(module.__file__).read_text() for module in (top, pins, csi2_camera))
    asked = set(re.findall(r'request\((?:platform, )?"(\w+)"', text))
    asked |= set(re.findall(r'"(button_\w+)"', text))
    compared = {"led" if name.startswith("led") else name.partition(".")[0] for name in LITEX}
    assert asked == compared | {"camera", "csi_camera"} and len(asked) == 12


def test_a_wrong_pin_is_found(sites):
    assert sites["uart.rx"] != theirs("serial", 0, "tx")
    assert sites["sdram.dq"] != theirs("sdram", 0, "dq")[::-1]
