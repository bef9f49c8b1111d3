"""Terasic DE0-CV: Cyclone V, 64 MB of 16-bit SDR SDRAM, VGA through resistors, two headers."""

from functools import partial

from amaranth.build import Pins, Resource
from amaranth_boards.de0_cv import DE0CVPlatform

from ncdc_boards.quartus.board import QuartusBoard
from ncdc_boards.quartus.names import CYCLONE_V
from ncdc_boards.quartus.plls import CORE_MHZ, clock_plan
from ncdc_boards.quartus.resources import LVTTL, SDRAM_ATTRS, camera, serial
from ncdc_boards.quartus.top import QuartusTop
from ncdc_boards.sdram.chips import IS42S16320D_7

__all__ = ["BOARD", "De0CvPlatform"]


def _changed(resource):
    """amaranth-boards' resource, but LEDs that are lit by a high pin, as in the board's
    manual (theirs are inverted), and registers in the SDRAM's pins."""
    if resource.name == "led":
        return Resource("led", resource.number, Pins(*resource.ios[0].names, dir="o"), LVTTL)
    if resource.name == "sdram":
        return Resource("sdram", 0, *resource.ios, SDRAM_ATTRS)
    return resource


class De0CvPlatform(DE0CVPlatform):
    """The DE0-CV with a D5M on GPIO 0 (J1) and a serial port on GPIO 1 (J2)."""
    resources = [
        *map(_changed, DE0CVPlatform.resources),
        camera(("j", 1)), serial(("j", 2)),
    ]


BOARD = QuartusBoard(
    name="de0-cv", title="Terasic DE0-CV", device="5CEBA4F23C7", platform=De0CvPlatform,
    chip=IS42S16320D_7, memory_bytes=IS42S16320D_7.bytes, core_mhz=CORE_MHZ,
    clock_plan=partial(clock_plan, family=CYCLONE_V, max_mhz=65), top=QuartusTop,
    baud=1_000_000, multiplier_bits=27,
    sources=("amaranth-boards, de0_cv.py", "assignments by Terasic's System Builder"),
    family=CYCLONE_V, dac=False)
