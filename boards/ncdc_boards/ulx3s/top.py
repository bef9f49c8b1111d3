"""The top of a ULX3S: its clocks and pins, and the core of all boards."""

from amaranth import *

from ncdc_boards.camera_board.core import BoardCore
from ncdc_boards.camera_board.pattern import join_pattern
from ncdc_boards.camera_board.pins import (
    buffer,
    join_buttons,
    join_camera,
    join_leds,
    join_sdram,
    join_uart,
    request,
)
from ncdc_boards.ecp5.cells import clock_out
from ncdc_boards.ecp5.csi2_camera import join_csi_camera
from ncdc_boards.ulx3s.clocks import DOMAINS, Ulx3sClocks
from ncdc_hdl.video.dvi import Dvi

__all__ = ["Ulx3sTop"]

_BUTTONS = {"following": ("button_right", 0), "previous": ("button_left", 0),
            "raw": ("button_fire", 0), "again": ("button_down", 0)}


class Ulx3sTop(Elaboratable):
    """Joins the pins of the board to the core, and its picture to the GPDI connector.

    Parameters
    ----------
    design : ncdc_boards.camera_board.core.Design
    """

    def __init__(self, design):
        self.design = design
        self.core = BoardCore(design)

    def elaborate(self, platform):
        m = Module()
        oscillator = buffer(m, platform.request("clk25", dir="-"))
        m.domains += (ClockDomain(name) for name in DOMAINS)
        m.submodules.clocks = Ulx3sClocks(self.design.clocks, oscillator.i)
        m.submodules.core = core = self.core
        m.submodules.dvi = dvi = Dvi()
        m.d.comb += dvi.picture.eq(core.picture)
        clock_out(m, "memory", join_sdram(m, platform, core))
        if self.design.pattern:
            join_pattern(m, core, self.design.pattern, "sensor_reference")
        elif self.design.link:
            join_csi_camera(m, platform, core, self.design)
        else:
            clock_out(m, "sensor_reference", join_camera(m, platform, core))
        self._gpdi(m, platform, dvi)
        join_uart(m, platform, core, ("rx", "tx", "rts", "dtr"))
        join_buttons(m, platform, core, _BUTTONS)
        join_leds(m, platform, core.leds)
        # The ESP32 shares wires with the camera: it stays in reset.
        esp32 = request(platform, "esp32", ("en", "tx", "rx", "gpio0", "gpio5", "gpio16",
                                            "gpio17"))
        m.d.comb += buffer(m, esp32.en).o.eq(0)
        return m

    @staticmethod
    def _gpdi(m, platform, dvi):
        """The lanes at the connector's pins."""
        lanes = request(platform, "hdmi", ("cec", "clk", "d", "eth", "scl", "sda"))
        for name, port, pairs in (("d", lanes.d, dvi.pairs[:3]), ("clk", lanes.clk,
                                                                 dvi.pairs[3:])):
            pins = Signal(len(pairs), name=f"gpdi_{name}")
            for k, pair in enumerate(pairs):
                m.submodules[f"gpdi_{name}{k}"] = Instance(
                    "ODDRX1F", i_SCLK=ClockSignal("shift"), i_RST=Const(0), i_D0=pair[0],
                    i_D1=pair[1], o_Q=pins[k])
            m.d.comb += buffer(m, port).o.eq(pins)
