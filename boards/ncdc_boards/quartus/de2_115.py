"""Terasic DE2-115: Cyclone IV E, 128 MB of 32-bit SDR SDRAM, VGA, a header, RS-232, Ethernet."""

from functools import partial

from amaranth.build import Attrs, Clock, Connector, Pins, Resource
from amaranth.vendor import AlteraPlatform
from amaranth_boards.resources import (
    ButtonResources,
    LEDResources,
    SDRAMResource,
    UARTResource,
)

from ncdc_boards.camera_board.board import EthernetChip
from ncdc_boards.camera_board.ethernet import rgmii
from ncdc_boards.quartus.board import QuartusBoard
from ncdc_boards.quartus.names import CYCLONE_IV
from ncdc_boards.quartus.plls import CORE_MHZ, clock_plan
from ncdc_boards.quartus.resources import LVTTL, SDRAM_ATTRS, camera, vga_dac
from ncdc_boards.quartus.top import QuartusTop
from ncdc_boards.sdram.chips import IS42S16320D_7, in_parallel

__all__ = ["BOARD", "De2115Platform"]

_CHIPS = in_parallel(IS42S16320D_7, 2)


class De2115Platform(AlteraPlatform):
    """The DE2-115, which amaranth-boards lacks, with a D5M on its header."""
    device = "EP4CE115"
    package = "F29"
    speed = "C7"
    default_clk = "clk50"
    resources = [
        Resource("clk50", 0, Pins("Y2", dir="i"), Clock(50e6), LVTTL),
        *LEDResources(pins="G19 F19 E19 F21 F18 E18 J19 H19", attrs=Attrs(io_standard="2.5 V")),
        *ButtonResources(pins="M23 M21 N21 R24", invert=True, attrs=Attrs(io_standard="2.5 V")),
        UARTResource(0, rx="G12", tx="G9", attrs=LVTTL),
        SDRAMResource(
            0, clk="AE5", cke="AA6", cs_n="T4", we_n="V6", ras_n="U6", cas_n="V7", ba="U7 R4",
            a="R6 V8 U8 P1 V5 W8 W7 AA7 Y5 Y6 R5 AA5 Y7",
            dq="W3 W2 V4 W1 V3 V2 V1 U3 Y3 Y4 AB1 AA3 AB2 AC1 AB3 AC2 "
               "M8 L8 P2 N3 N4 M4 M7 L7 U5 R7 R1 R2 R3 T3 U4 U1",
            dqm="U2 W4 K8 N8", attrs=SDRAM_ATTRS),
        vga_dac(clk="A12", hs="G13", vs="C13", sync="C10", blank="F11",
                r="E12 E11 D10 F12 G10 J12 H8 H10", g="G8 G11 F8 H12 C8 B8 F10 C9",
                b="B10 A10 C11 B11 A11 C12 D11 D12"),
        camera(("gpio", 0)),
        # The first of two sockets; a jumper chooses RGMII, which the firmware also sets.
        rgmii(Attrs(io_standard="2.5 V"), rst="C19", mdc="C20", mdio="B21", tx_clk="A17",
              tx_ctl="A18", tx_data="C18 D19 A19 B19", rx_clk="A15", rx_ctl="C17",
              rx_data="C16 D16 D17 C15"),
    ]
    connectors = [
        Connector("gpio", 0,
                  "AB22 AC15 AB21 Y17 AC21 Y16 AD21 AE16 AD15 AE15 - - AC19 AF16 AD19 AF15 AF24 "
                  "AE21 AF25 AC22 AE22 AF21 AF22 AD22 AG25 AD25 AH25 AE25 - - AG22 AE24 AH22 AF26 "
                  "AE20 AG23 AF20 AH26 AH23 AG26"),
    ]


BOARD = QuartusBoard(
    name="de2-115", title="Terasic DE2-115", device="EP4CE115F29C7", platform=De2115Platform,
    chip=_CHIPS, memory_bytes=_CHIPS.bytes, core_mhz=CORE_MHZ,
    clock_plan=partial(clock_plan, family=CYCLONE_IV, max_mhz=140), top=QuartusTop,
    baud=115_200, multiplier_bits=18,      # RS-232 drivers end at 120 kbit/s
    sources=("litex-boards, terasic_de2_115.py", "verilog-ethernet, example/DE2-115/fpga/fpga.qsf"),
    family=CYCLONE_IV, dac=True, ethernet=EthernetChip(addresses=range(32), delays=False))
