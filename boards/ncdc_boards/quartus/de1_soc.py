"""Terasic DE1-SoC: Cyclone V, 64 MB of 16-bit SDR SDRAM on the FPGA's side, VGA, two headers."""

from functools import partial

from amaranth_boards.de1_soc import DE1SoCPlatform
from amaranth_boards.resources import SDRAMResource

from ncdc_boards.quartus.board import QuartusBoard
from ncdc_boards.quartus.names import CYCLONE_V
from ncdc_boards.quartus.plls import CORE_MHZ, clock_plan
from ncdc_boards.quartus.resources import SDRAM_ATTRS, camera, serial, vga_dac
from ncdc_boards.quartus.top import QuartusTop
from ncdc_boards.sdram.chips import IS42S16320D_7

__all__ = ["BOARD", "De1SocPlatform"]


class De1SocPlatform(DE1SoCPlatform):
    """The DE1-SoC with its memory, its VGA port, a D5M on GPIO 0, a serial port on GPIO 1."""
    resources = [
        *DE1SoCPlatform.resources,
        SDRAMResource(
            0, clk="AH12", cke="AK13", cs_n="AG11", we_n="AA13", ras_n="AE13", cas_n="AF11",
            ba="AF13 AJ12", a="AK14 AH14 AG15 AE14 AB15 AC14 AD14 AF15 AH15 AG13 AG12 AH13 AJ14",
            dq="AK6 AJ7 AK7 AK8 AK9 AG10 AK11 AJ11 AH10 AJ10 AJ9 AH9 AH8 AH7 AJ6 AJ5",
            dqm="AB13 AK12", attrs=SDRAM_ATTRS),
        vga_dac(clk="A11", hs="B11", vs="D11", sync="C10", blank="F10",
                r="A13 C13 E13 B12 C12 D12 E12 F13", g="J9 J10 H12 G10 G11 G12 F11 E11",
                b="B13 G13 H13 F14 H14 F15 G15 J14"),
        camera(("gpio", 0)), serial(("gpio", 1)),
    ]


BOARD = QuartusBoard(
    name="de1-soc", title="Terasic DE1-SoC", device="5CSEMA5F31C6", platform=De1SocPlatform,
    chip=IS42S16320D_7, memory_bytes=IS42S16320D_7.bytes, core_mhz=CORE_MHZ,
    clock_plan=partial(clock_plan, family=CYCLONE_V, max_mhz=140), top=QuartusTop,
    baud=1_000_000, multiplier_bits=27,
    sources=("amaranth-boards, de1_soc.py", "litex-boards, terasic_de1soc.py",
             "set_location_assignments.tcl of the FHNW, with a D5M on GPIO 0"),
    family=CYCLONE_V, dac=True)
