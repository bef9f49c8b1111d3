"""Resources that the boards have in common."""

from dataclasses import asdict, dataclass

from amaranth.build import Attrs, Clock, Pins, PinsN, Resource, Subsignal

from ncdc_boards.board import Sdram

__all__ = ["D5M_LEFT_TO_USER", "LVTTL", "SdramPins", "clk50", "d5m", "is42s16320", "reset", "sdram",
           "vga"]

LVTTL = Attrs(IO_STANDARD="3.3-V LVTTL")
# Terasic TRDB-D5M: number of the GPIO signal on the 40-pin header; D11 first.
_D5M_DATA = (1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13)
# Of a board with :func:`d5m`.
D5M_LEFT_TO_USER = {"d5m_0__*": "the camera's pins are assigned and hold it in reset; its capture "
                                "into the memory is the user's"}


def clk50(pin):
    """The 50 MHz oscillator."""
    return Resource("clk50", 0, Pins(pin, dir="i"), Clock(50e6), LVTTL)


def reset(pin):
    """A push button, low while pressed."""
    return Resource("rst", 0, PinsN(pin, dir="i"), LVTTL)


@dataclass(frozen=True)
class SdramPins:
    """Where an SDR SDRAM is: pin names as blank-separated text, lowest bit first."""
    clk: str
    cke: str
    cs_n: str
    ras_n: str
    cas_n: str
    we_n: str
    ba: str
    a: str
    dqm: str
    dq: str


def sdram(pins):
    """SDR SDRAM at its :class:`SdramPins`."""
    return Resource("sdram", 0, *(Subsignal(name, Pins(names, dir="io" if name == "dq" else "o"))
                                  for name, names in asdict(pins).items()),
                    Attrs(IO_STANDARD="3.3-V LVTTL", FAST_OUTPUT_REGISTER="ON",
                          CURRENT_STRENGTH_NEW="MAXIMUM CURRENT"))


def is42s16320(chips):
    """So many IS42S16320 side by side, -7 grade: 64 MB and 16 bits each."""
    return Sdram(data_width=16 * chips, rows=13, columns=10, banks=4, cas_latency=3, t_ac=5.4,
                 t_rcd=15.0, t_rfc=60.0, t_rp=15.0, t_wr=14.0, refresh_us=7.8125)


def vga(*, clk, hsync, vsync, sync, blank, r, g, b):
    """VGA through a DAC of 8 bits per colour (ADV7123); lowest bit first."""
    parts = {"clk": clk, "hsync": hsync, "vsync": vsync, "sync_n": sync, "blank_n": blank,
             "r": r, "g": g, "b": b}
    return Resource("vga", 0, *(Subsignal(name, Pins(pins, dir="o"))
                                for name, pins in parts.items()), LVTTL)


def d5m(gpio):
    """The camera module TRDB-D5M on a 40-pin header whose signals GPIO[0..35] are ``gpio``."""
    def pins(*numbers):
        return " ".join(gpio[k] for k in numbers)
    return Resource("d5m", 0,
                    Subsignal("pixclk", Pins(pins(0), dir="i")),
                    Subsignal("d", Pins(pins(*reversed(_D5M_DATA)), dir="i")),
                    Subsignal("xclkin", Pins(pins(16), dir="o")),
                    Subsignal("reset_n", Pins(pins(17), dir="o")),
                    Subsignal("trigger", Pins(pins(19), dir="o")),
                    Subsignal("strobe", Pins(pins(20), dir="i")),
                    Subsignal("lval", Pins(pins(21), dir="i")),
                    Subsignal("fval", Pins(pins(22), dir="i")),
                    Subsignal("sdata", Pins(pins(23), dir="io")),
                    Subsignal("sclk", Pins(pins(24), dir="o")), LVTTL)
