"""Terasic DE10-Nano: Cyclone V SoC with 1 GB of DDR3 on the processor, HDMI, two headers."""

from functools import partial

from amaranth.build import Attrs, Pins, Resource, Subsignal
from amaranth_boards.de10_nano import DE10NanoPlatform

from ncdc_boards.hps_board.board import HpsBoard
from ncdc_boards.quartus.names import CYCLONE_V
from ncdc_boards.quartus.plls import clock_plan
from ncdc_boards.quartus.resources import LVTTL, camera

__all__ = ["BOARD", "De10NanoPlatform"]

_CORE_MHZ = 100
_SSTL, _PAIR = (Attrs(io_standard=name) for name in
                ("SSTL-15 CLASS I", "DIFFERENTIAL 1.5-V SSTL CLASS I"))
_MEMORY_PINS = {
    "a": "C28 B28 E26 D26 J21 J20 C26 B26 F26 F25 A24 B24 D24 C24 G23", "ba": "A27 H25 G25",
    "cke": "L28", "cs_n": "L21", "ras_n": "A25", "cas_n": "A26", "we_n": "E25", "reset_n": "V28",
    "odt": "D28", "dm": "G28 P28 W28 AB28",
    "dq": "J25 J24 E28 D27 J26 K26 G27 F28 K25 L25 J27 J28 M27 M26 M28 N28 "
          "N24 N25 T28 U28 N26 N27 R27 V27 R26 R25 AA28 W26 R24 T24 Y27 AA27"}
_MEMORY_PAIRS = {"ck": "N21", "ck_n": "N20", "dqs": "R17 R19 T19 U19", "dqs_n": "R16 R18 T18 T20"}


def _way(name):
    return "io" if name.startswith("dq") else "o"


# Columns of the transmitter's 24 data inputs: blue is lowest (ADV7513, RGB 4:4:4), red in
# amaranth-boards, which swaps the two.
_HDMI = Resource(
    "hdmi", 0,
    Subsignal("b", Pins("AD12 AE12 W8 Y8 AD11 AD10 AE11 Y5", dir="o")),
    Subsignal("g", Pins("AF10 Y4 AE9 AB4 AE7 AF6 AF8 AF5", dir="o")),
    Subsignal("r", Pins("AE4 AH2 AH4 AH5 AH6 AG6 AF9 AE8", dir="o")),
    Subsignal("clk", Pins("AG5", dir="o")), Subsignal("de", Pins("AD19", dir="o")),
    Subsignal("hs", Pins("T8", dir="o")), Subsignal("vs", Pins("V13", dir="o")),
    Subsignal("scl", Pins("U10", dir="io"), Attrs(WEAK_PULL_UP_RESISTOR="ON")),
    Subsignal("sda", Pins("AA4", dir="io"), Attrs(WEAK_PULL_UP_RESISTOR="ON")),
    LVTTL, Attrs(FAST_OUTPUT_REGISTER="ON"))


class De10NanoPlatform(DE10NanoPlatform):
    """The DE10-Nano with its HDMI transmitter, the processor's memory, and a D5M on GPIO 0."""
    resources = [
        *(one for one in DE10NanoPlatform.resources if one.name != "adv7513"), _HDMI,
        Resource("hps_ddr3", 0,
                 *(Subsignal(name, Pins(pins, dir=_way(name)), _SSTL)
                   for name, pins in _MEMORY_PINS.items()),
                 *(Subsignal(name, Pins(pins, dir=_way(name)), _PAIR)
                   for name, pins in _MEMORY_PAIRS.items()),
                 Subsignal("rzq", Pins("D25", dir="i"), _SSTL)),
        camera(("gpio", 0)),
    ]


# Two DDR3 chips of 16 bits, 400 MHz; as in apache/tvm, vta/hardware/intel, whose system is for this
# board.
_MEMORY = {
    "HPS_PROTOCOL": "DDR3", "MEM_VENDOR": "Other", "MEM_FORMAT": "DISCRETE",
    "MEM_CLK_FREQ": 400.0, "MEM_CLK_FREQ_MAX": 800.0, "MEM_VOLTAGE": "{1.5V DDR3}",
    "MEM_DQ_WIDTH": 32, "MEM_DQ_PER_DQS": 8, "MEM_ROW_ADDR_WIDTH": 15, "MEM_COL_ADDR_WIDTH": 10,
    "MEM_BANKADDR_WIDTH": 3, "MEM_TCL": 7, "MEM_WTCL": 7, "MEM_DRV_STR": "RZQ/6",
    "MEM_RTT_NOM": "RZQ/6", "MEM_RTT_WR": "{Dynamic ODT off}", "MEM_TINIT_US": 500,
    "MEM_TMRD_CK": 4, "MEM_TRAS_NS": 35.0, "MEM_TRCD_NS": 13.75, "MEM_TRP_NS": 13.75,
    "MEM_TREFI_US": 7.8, "MEM_TRFC_NS": 300.0, "MEM_TWR_NS": 15.0, "MEM_TWTR": 4,
    "MEM_TFAW_NS": 37.5, "MEM_TRRD_NS": 7.5, "MEM_TRTP_NS": 7.5, "TIMING_TIS": 175,
    "TIMING_TIH": 250, "TIMING_TDS": 50, "TIMING_TDH": 125, "TIMING_TDQSQ": 120,
    "TIMING_TQSH": 0.38, "TIMING_TDSH": 0.2, "TIMING_TDSS": 0.2, "TIMING_BOARD_MAX_CK_DELAY": 0.6,
    "TIMING_BOARD_MAX_DQS_DELAY": 0.6, "TIMING_BOARD_AC_SKEW": 0.02,
    "TIMING_BOARD_SKEW_WITHIN_DQS": 0.02, "TIMING_BOARD_SKEW_BETWEEN_DQS": 0.02}

BOARD = HpsBoard(
    name="de10-nano", title="Terasic DE10-Nano", family=CYCLONE_V, device="5CSEBA6U23I7",
    platform=De10NanoPlatform, core_mhz=_CORE_MHZ,
    clock_plan=partial(clock_plan, family=CYCLONE_V, max_mhz=165, sdram=False),
    memory=_MEMORY, frames=(0x3800_0000, 0x0800_0000), multiplier_bits=27,
    sources=("amaranth-boards, de10_nano.py", "MiSTer, sys.tcl",
             "apache/tvm, vta/hardware/intel/scripts/soc_system_hw.tcl: the memory's times",
             "pin_assignment_DE0_Nano_SoC.tcl, S. Kashani-Akhavan: the memory's pins, which are "
             "the package's"))
