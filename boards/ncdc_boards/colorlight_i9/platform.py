"""Pins of the Colorlight i9 (version 7.2) on its extension board, with a camera on header P2."""

from amaranth.build import Attrs, Clock, Connector, Pins, Resource, Subsignal
from amaranth.vendor import LatticeECP5Platform
from amaranth_boards.resources import LEDResources, SDRAMResource, UARTResource

from ncdc_boards.camera_board.ethernet import rgmii
from ncdc_boards.ecp5.csi2_camera import csi_camera

__all__ = ["CAMERA_WIRES", "CSI_WIRES", "ColorlightI9Platform"]

CAMERA_WIRES = {
    "d": (11, 12, 9, 10, 7, 8, 13, 14, 17, 18, 23, 24), "fval": (26,), "lval": (27,), "scl": (28,),
    "sda": (29,), "xclk": (30,), "reset_n": (5,), "pixclk": (25,)}
"""Pins of the header P2 for the camera, D0 first; 25 leads to a clock network. Pins that stop a
sensor (TRIGGER, PWDN) are wired to ground."""

CSI_WIRES = {"clock": (("30", "27"),), "lanes": (("28", "26"), ("13", "18")),
             "low_power": ("25", "17"), "scl": ("9",), "sda": ("10",), "reset_n": ("5",)}
"""Pins of P2 for a camera with CSI-2, of pairs P and N. P2 has four pairs of the device's right
side: these, and 23 with 12. Of them 30 with 27 alone reaches the edge clocks."""

_DIRECTIONS = {"scl": "io", "sda": "io", "xclk": "o", "reset_n": "o"}
_LVCMOS = Attrs(IO_TYPE="LVCMOS33")
_FAST = Attrs(IO_TYPE="LVCMOS33", SLEWRATE="FAST")


def _camera():
    """The camera's wires; sensors of fewer than 12 bits have the upper ones of ``d``."""
    parts = []
    for name, numbers in CAMERA_WIRES.items():
        way = _DIRECTIONS.get(name, "i")
        pull = "UP" if name in ("scl", "sda") else "DOWN" if way == "i" else "NONE"
        parts.append(Subsignal(
            name, Pins(" ".join(map(str, numbers)), dir=way, conn=("p", 2)),
            Attrs(PULLMODE=pull)))
    return Resource("camera", 0, *parts, Attrs(IO_TYPE="LVCMOS33", DRIVE="4", SLEWRATE="SLOW"))


class ColorlightI9Platform(LatticeECP5Platform):
    """The Colorlight i9, which amaranth-boards lacks, and a camera.

    CKE, CS and DQM of the SDRAM are wired to constant levels on the module.
    """
    device = "LFE5U-45F"
    package = "BG381"
    speed = "6"
    default_clk = "clk25"
    required_tools = ()         # `ncdc build` calls the tools, from their Python packages
    resources = [
        Resource("clk25", 0, Pins("P3", dir="i"), Clock(25e6), _LVCMOS),
        *LEDResources(pins="L2", invert=True, attrs=_LVCMOS),
        UARTResource(0, rx="H18", tx="J17", attrs=_LVCMOS),
        SDRAMResource(
            0, clk="B9", we_n="A10", ras_n="B10", cas_n="A9", ba="B11 C8",
            a="B13 C14 A16 A17 B16 B15 A14 A13 A12 A11 B12",
            dq="B6 A5 A6 A7 C7 B8 B5 A8 D8 D7 E8 D6 C6 D5 E7 C5 "
               "C10 D9 E11 D11 C11 D12 E9 C12 E14 C15 E13 D15 E12 B17 D14 D13", attrs=_FAST),
        # One of two chips: its management registers are at address 0.
        rgmii(_FAST, rst="P4", mdc="N5", mdio="P5", tx_clk="G1", tx_ctl="K1", tx_data="G2 H1 J1 J3",
              rx_clk="H2", rx_ctl="P2", rx_data="K2 L1 N1 P1"),
        _camera(), csi_camera(CSI_WIRES, ("p", 2)),
    ]
    connectors = [
        Connector("p", 2, "- - - - K18 L2 T18 C18 R17 R18 M17 P17 U18 T17 - - P18 U17 - - - - "
                          "N18 N17 L20 M18 K20 L18 G20 J20"),
    ]
