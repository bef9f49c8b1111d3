"""The top of a Colorlight i9: its clocks and pins, and the core of all boards."""

from amaranth import *

from ncdc_boards.camera_board.core import BoardCore
from ncdc_boards.camera_board.ethernet import join_processor
from ncdc_boards.camera_board.pins import buffer, join_camera, join_leds, join_sdram, join_uart
from ncdc_boards.colorlight_i9.clocks import DOMAINS, ColorlightI9Clocks
from ncdc_boards.ecp5.cells import clock_out, delayed
from ncdc_boards.ecp5.csi2_camera import join_csi_camera

__all__ = ["ColorlightI9Top"]


class ColorlightI9Top(Elaboratable):
    """Joins the pins of the board to the core and to the processor.

    Parameters
    ----------
    design : ncdc_boards.camera_board.core.Design
        With a processor, without a screen.
    """

    def __init__(self, design):
        self.design = design
        self.core = BoardCore(design)

    def elaborate(self, platform):
        m = Module()
        oscillator = buffer(m, platform.request("clk25", dir="-"))
        m.domains += (ClockDomain(name) for name in DOMAINS)
        m.submodules.clocks = clocks = ColorlightI9Clocks(self.design.clocks, oscillator.i)
        m.submodules.core = core = self.core
        clock_out(m, "memory", join_sdram(m, platform, core))
        if self.design.link:
            join_csi_camera(m, platform, core, self.design)
        else:
            clock_out(m, "sensor_reference", join_camera(m, platform, core))
        join_uart(m, platform, core)
        # The only LED: frames are corrected.
        ready, configured = core.leds[:2]
        join_leds(m, platform, ready & configured)
        join_processor(m, platform, core, self.design.board.ethernet, reset=clocks.reset,
                       received=delayed)
        return m
