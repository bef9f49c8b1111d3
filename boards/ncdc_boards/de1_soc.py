"""Terasic DE1-SoC: Cyclone V, 64 MB of 16-bit SDR SDRAM on the FPGA's side, VGA, headers."""

from amaranth.vendor import AlteraPlatform

from ncdc_boards.board import Board, Pll
from ncdc_boards.resources import (
    D5M_LEFT_TO_USER,
    SdramPins,
    clk50,
    d5m,
    is42s16320,
    reset,
    sdram,
    vga,
)

__all__ = ["BOARD", "DE1SoCPlatform"]

GPIO = ("AC18 Y17 AD17 Y18 AK16 AK18 AK19 AJ19 AJ17 AJ16 AH18 AH17 AG16 AE16 AF16 AG17 AA18 AA19 "
        "AE17 AC20 AH19 AJ20 AH20 AK21 AD19 AD20 AE18 AE19 AF20 AF21 AF19 AG21 AF18 AG20 AG18 "
        "AJ21").split()


class DE1SoCPlatform(AlteraPlatform):
    """Pins of the DE1-SoC that a corrector uses."""
    device = "5CSEMA5"
    package = "F31"
    speed = "C6"
    default_clk = "clk50"
    default_rst = "rst"
    resources = [
        clk50("AF14"),
        reset("AA14"),
        sdram(SdramPins(
            clk="AH12", cke="AK13", cs_n="AG11", ras_n="AE13", cas_n="AF11", we_n="AA13",
            ba="AF13 AJ12", a="AK14 AH14 AG15 AE14 AB15 AC14 AD14 AF15 AH15 AG13 AG12 AH13 AJ14",
            dqm="AB13 AK12",
            dq="AK6 AJ7 AK7 AK8 AK9 AG10 AK11 AJ11 AH10 AJ10 AJ9 AH9 AH8 AH7 AJ6 AJ5")),
        vga(clk="A11", hsync="B11", vsync="D11", sync="C10", blank="F10",
            r="A13 C13 E13 B12 C12 D12 E12 F13", g="J9 J10 H12 G10 G11 G12 F11 E11",
            b="B13 G13 H13 F14 H14 F15 G15 J14"),
        d5m(GPIO),
    ]
    connectors = []


BOARD = Board(
    name="de1-soc", title="Terasic DE1-SoC", family="Cyclone V", device="5CSEMA5F31C6",
    platform=DE1SoCPlatform, pll=Pll(50, 100, -3000), data_width=32, memory="sdram",
    sdram=is42s16320(1),        # Platform Designer halves the corrector's 32-bit words
    multipliers=87, multiplier_bits=27,
    sources=("litex-boards, terasic_de1soc.py",
             "assignments by Terasic's System Builder in several public projects (VGA)"),
    left_to_user=D5M_LEFT_TO_USER)
