"""Terasic DE2-115: Cyclone IV E, 128 MB of 32-bit SDR SDRAM, VGA, camera header."""

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

__all__ = ["BOARD", "DE2115Platform"]

GPIO = ("AB22 AC15 AB21 Y17 AC21 Y16 AD21 AE16 AD15 AE15 AC19 AF16 AD19 AF15 AF24 AE21 AF25 AC22 "
        "AE22 AF21 AF22 AD22 AG25 AD25 AH25 AE25 AG22 AE24 AH22 AF26 AE20 AG23 AF20 AH26 AH23 "
        "AG26").split()


class DE2115Platform(AlteraPlatform):
    """Pins of the DE2-115 that a corrector uses."""
    device = "EP4CE115"
    package = "F29"
    speed = "C7"
    default_clk = "clk50"
    default_rst = "rst"
    resources = [
        clk50("Y2"),
        reset("M23"),
        sdram(SdramPins(
            clk="AE5", cke="AA6", cs_n="T4", ras_n="U6", cas_n="V7", we_n="V6", ba="U7 R4",
            a="R6 V8 U8 P1 V5 W8 W7 AA7 Y5 Y6 R5 AA5 Y7", dqm="U2 W4 K8 N8",
            dq="W3 W2 V4 W1 V3 V2 V1 U3 Y3 Y4 AB1 AA3 AB2 AC1 AB3 AC2 "
               "M8 L8 P2 N3 N4 M4 M7 L7 U5 R7 R1 R2 R3 T3 U4 U1")),
        vga(clk="A12", hsync="G13", vsync="C13", sync="C10", blank="F11",
            r="E12 E11 D10 F12 G10 J12 H8 H10", g="G8 G11 F8 H12 C8 B8 F10 C9",
            b="B10 A10 C11 B11 A11 C12 D11 D12"),
        d5m(GPIO),
    ]
    connectors = []


BOARD = Board(
    name="de2-115", title="Terasic DE2-115", family="Cyclone IV E", device="EP4CE115F29C7",
    platform=DE2115Platform, pll=Pll(50, 100, -3000), data_width=32, memory="sdram",
    sdram=is42s16320(2),
    multipliers=266, multiplier_bits=18,
    sources=("litex-boards, terasic_de2_115.py", "verilog-ethernet, example/DE2-115/fpga/fpga.qsf"),
    left_to_user=D5M_LEFT_TO_USER)
