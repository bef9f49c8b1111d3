"""Resources that amaranth-boards lacks."""

from amaranth.build import Attrs, Pins, Resource, Subsignal

__all__ = ["CAMERA_PINS", "LVTTL", "SDRAM_ATTRS", "camera", "serial", "vga_dac"]

LVTTL = Attrs(io_standard="3.3-V LVTTL")
SDRAM_ATTRS = Attrs(io_standard="3.3-V LVTTL", FAST_OUTPUT_REGISTER="ON",
                    FAST_OUTPUT_ENABLE_REGISTER="ON", FAST_INPUT_REGISTER="ON",
                    CURRENT_STRENGTH_NEW="MAXIMUM CURRENT")
CAMERA_PINS = {
    "d": (16, 15, 14, 13, 10, 9, 8, 7, 6, 5, 4, 2), "pixclk": (1,), "xclk": (19,),
    "reset_n": (20,), "standby": (22,), "lval": (24,), "fval": (25,), "sda": (26,), "scl": (27,)}
"""Pins of the 40-pin header, D0 first; Terasic, TRDB-D5M Hardware Specification. "standby" is the
D5M's TRIGGER, which is also held low."""
_DIRECTIONS = {"scl": "io", "sda": "io", "xclk": "o", "reset_n": "o", "standby": "o"}


_UP = Attrs(WEAK_PULL_UP_RESISTOR="ON")


def camera(conn):
    """The camera module TRDB-D5M on the 40-pin header ``conn``, (name, number).

    Without a camera its inputs are high, so that no frame begins. The pixel clock's pin may be
    on a clock network, which has no pull-up.
    """
    up = {name: [_UP] for name in ("scl", "sda", "d", "lval", "fval")}
    return Resource("camera", 0, *(
        Subsignal(name, Pins(" ".join(map(str, numbers)), dir=_DIRECTIONS.get(name, "i"),
                             conn=conn), *up.get(name, []))
        for name, numbers in CAMERA_PINS.items()), LVTTL)


def serial(conn):
    """A serial port's adaptor of 3.3 V on pins 1 (its TX) and 2 (its RX) of a header. Without one
    the line is high, as when nothing is sent."""
    return Resource("uart", 0, Subsignal("rx", Pins("1", dir="i", conn=conn), _UP),
                    Subsignal("tx", Pins("2", dir="o", conn=conn)), LVTTL)


def vga_dac(*, clk, hs, vs, sync, blank, r, g, b):
    """VGA through a converter ADV7123 of 8 bits per colour; lowest bit first."""
    parts = {"clk": clk, "hs": hs, "vs": vs, "sync_n": sync, "blank_n": blank, "r": r, "g": g,
             "b": b}
    return Resource("vga", 0, *(Subsignal(name, Pins(pins, dir="o"))
                                for name, pins in parts.items()),
                    LVTTL, Attrs(FAST_OUTPUT_REGISTER="ON"))
