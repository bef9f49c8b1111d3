"""Pins of the ULX3S: those of amaranth-boards, and a camera on the header J1, of either kind."""

from amaranth.build import Attrs, Pins, Resource, Subsignal
from amaranth_boards.ulx3s import ULX3S_85F_Platform

from ncdc_boards.ecp5.csi2_camera import csi_camera

__all__ = ["CAMERA_WIRES", "CSI_WIRES", "Ulx3sPlatform"]

CAMERA_WIRES = {
    "d": tuple(f"{pair}{side}" for pair in range(6) for side in "+-"),
    "fval": ("6+",), "lval": ("6-",), "scl": ("7+",), "sda": ("7-",), "xclk": ("8+",),
    "reset_n": ("8-",), "standby": ("9+",), "pixclk": ("12+",)}
"""Wires of the camera: "3+" is GP3 of the header J1, "3-" GN3. GP12 leads to a clock network."""

CSI_WIRES = {"clock": (("12+", "12-"),), "lanes": (("11+", "11-"), ("13+", "13-")),
             "low_power": ("10+", "10-"), "scl": ("7+",), "sda": ("7-",), "reset_n": ("8-",)}
"""Wires of a camera with CSI-2, of pairs P and N. Of J1's pairs only GP11, GP12 and GP13 are at a
side of the device with differential inputs and gearing. They share bank 7, and GP12 alone reaches
its edge clocks."""

_DIRECTIONS = {"scl": "io", "sda": "io", "xclk": "o", "reset_n": "o", "standby": "o"}


def _camera():
    """The camera's wires; sensors of fewer than 12 bits have the upper ones of ``d``."""
    plain = {name: Pins(" ".join(wires), dir=_DIRECTIONS.get(name, "i"), conn=("gpio", 0))
             for name, wires in CAMERA_WIRES.items()}
    attrs = {name: Attrs(PULLMODE="UP") if name in ("scl", "sda") else
             Attrs(PULLMODE="DOWN" if _DIRECTIONS.get(name, "i") == "i" else "NONE")
             for name in plain}
    return Resource("camera", 0, *(Subsignal(name, pins, attrs[name])
                                   for name, pins in plain.items()),
                    Attrs(IO_TYPE="LVCMOS33", DRIVE="4", SLEWRATE="SLOW"))


class Ulx3sPlatform(ULX3S_85F_Platform):
    """The ULX3S with an LFE5U-85F of speed grade 6, and a camera."""
    resources = [*ULX3S_85F_Platform.resources, _camera(),
                 csi_camera(CSI_WIRES, ("gpio", 0))]
    required_tools = ()         # `ncdc build` calls the tools, from their Python packages
