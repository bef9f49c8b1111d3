"""Pins of the Quartus boards, ours and amaranth-boards', compared with other projects' pins."""

import re
from pathlib import Path

import pytest

from ncdc_boards.catalogue import board
from ncdc_boards.quartus.resources import CAMERA_PINS

BOARDS = ("de0-cv", "de1-soc", "de2-115")
PINS = Path(__file__).parents[1] / "data" / "pins"

# Our resources' signals, by the names of Terasic's manuals.
NAMES = {
    "clk50": "CLOCK_50", "uart.rx": "UART_RXD", "uart.tx": "UART_TXD",
    **{f"button{k}": f"KEY[{k}]" for k in range(4)}, **{f"led{k}": f"LEDR[{k}]" for k in range(8)},
    **{f"sdram.{ours}": f"DRAM_{theirs}" for ours, theirs in (
        ("clk", "CLK"), ("clk_en", "CKE"), ("cs", "CS_N"), ("we", "WE_N"), ("ras", "RAS_N"),
        ("cas", "CAS_N"), ("ba", "BA"), ("a", "ADDR"), ("dq", "DQ"), ("dqm", "DQM"))},
    **{f"vga.{ours}": f"VGA_{theirs}" for ours, theirs in (
        ("clk", "CLK"), ("hs", "HS"), ("vs", "VS"), ("sync_n", "SYNC_N"), ("blank_n", "BLANK_N"),
        ("r", "R"), ("g", "G"), ("b", "B"))},
    **{f"camera.{ours}": f"D5M_{theirs}" for ours, theirs in (
        ("pixclk", "PIXLCLK"), ("xclk", "XCLKIN"), ("reset_n", "RESET_N"), ("standby", "TRIGGER"),
        ("lval", "LVAL"), ("fval", "FVAL"), ("sda", "SDATA"), ("scl", "SCLK"), ("d", "D"))},
    **{f"eth_rgmii.{ours}": f"ENET0_{theirs}" for ours, theirs in (
        ("tx_clk", "GTX_CLK"), ("tx_ctl", "TX_EN"), ("tx_data", "TX_DATA"), ("rx_clk", "RX_CLK"),
        ("rx_ctl", "RX_DV"), ("rx_data", "RX_DATA"), ("rst", "RST_N"), ("mdc", "MDC"),
        ("mdio", "MDIO"))}}


def theirs(name):
    """{signal: pin} of another project for a board."""
    lines = (PINS / f"{name}.txt").read_text().splitlines()
    return dict(line.split() for line in lines if not line.startswith("#"))


def ours(name):
    """{signal: [pins]} of all that the top of a board may ask for."""
    platform, found = board(name).platform(), {}
    for (resource, number), what in platform.resources.items():
        single = hasattr(what.ios[0], "names")
        for part in [what] if single else what.ios:
            key = f"{resource}.{part.name}" if not single else \
                resource if resource == "clk50" else f"{resource}{number}"
            if not (resource == "clk50" and number):
                found[key] = part.ios[0].map_names(platform._conn_pins, part)
    return found


def header(gpio):
    """Pin of a 40-pin header: number of the signal GPIO[k]."""
    return gpio + 1 + 2 * (gpio >= 10) + 2 * (gpio >= 26)


def compared(name):
    """[(our signal, our pins, theirs)] of everything that the top has."""
    other, mine, found = theirs(name), ours(name), []
    for key, pins in mine.items():
        if key not in NAMES:
            continue
        signal = NAMES[key]
        if signal.startswith("D5M") and "D5M_LVAL" not in other:
            # A header without a camera: the camera's pins on it, which are those of other boards.
            gpio = {header(k): other[f"GPIO_0[{k}]"] for k in range(36)}
            expected = [gpio[pin] for pin in CAMERA_PINS[key.partition(".")[2]]]
        elif signal.startswith("UART") and signal not in other:
            expected = [other[f"GPIO_1[{signal == 'UART_TXD':d}]"]]
        else:
            expected = [other[signal if len(pins) == 1 else f"{signal}[{k}]"]
                        for k in range(len(pins))]
        found.append((key, pins, expected))
    return found


@pytest.mark.parametrize("name", BOARDS)
def test_a_pin_is_where_others_have_it(name):
    rows = compared(name)
    assert [(key, pins) for key, pins, expected in rows if pins != expected] == []
    # Everything that the top asks for is there: sdram, vga, camera, uart, buttons, LEDs, clock.
    kinds = {re.split(r"[.\d]", key)[0] for key, *_ in rows}
    assert kinds == {"clk", "uart", "button", "led", "sdram", "vga", "camera"} | (
        {"eth_rgmii"} if board(name).ethernet else set())
    assert sum(len(pins) for _, pins, _ in rows) == {"de2-115": 136, "de1-soc": 103,
                                                     "de0-cv": 88}[name]


@pytest.mark.parametrize("name", BOARDS)
def test_no_pin_is_used_twice(name):
    pins = [pin for _, pins, _ in compared(name) for pin in pins]
    assert len(set(pins)) == len(pins)


def test_a_wrong_pin_is_found():
    rows = {key: (pins, expected) for key, pins, expected in compared("de1-soc")}
    pins, expected = rows["sdram.dq"]
    assert pins == expected != pins[::-1]
