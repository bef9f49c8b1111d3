"""The top of a Quartus board: its clocks and pins, and the core of all boards."""

from amaranth import *
from amaranth.lib import io

from ncdc_boards.camera_board.core import LEDS, BoardCore
from ncdc_boards.camera_board.ethernet import join_processor
from ncdc_boards.camera_board.pins import (
    buffer,
    join_buttons,
    join_camera,
    join_leds,
    join_sdram,
    join_uart,
    request,
)
from ncdc_boards.quartus.names import USER
from ncdc_boards.quartus.plls import QuartusClocks
from ncdc_hdl.registers.jtag_bridge import DOMAIN as CHAIN
from ncdc_hdl.video.scan_out import PICTURE

__all__ = ["BUTTONS", "PINS_DOMAIN", "QuartusTop", "RESTART", "clock_out", "user"]

PINS_DOMAIN = "pins"
BUTTONS = {"following": ("button", 0), "previous": ("button", 1), "raw": ("button", 2)}
RESTART = ("button", 3)


def clock_out(m, domain, port, falling=False):
    """Drive a pin with a clock through a DDR register, as late as the pins' registers."""
    m.submodules[f"{domain}_clock"] = pin = io.DDRBuffer("o", port, o_domain=domain)
    m.d.comb += [pin.o[0].eq(not falling), pin.o[1].eq(falling)]


def user(m, picture, lights_in):
    """Picture and LEDs after the user's module."""
    shown, leds = Signal(PICTURE), Signal(LEDS)
    m.submodules.user = Instance(
        USER, i_clk=ClockSignal(), i_pixel_clk=ClockSignal("pixel"),
        i_lights_in=lights_in, o_lights_out=leds,
        **{f"i_{name}_in": picture[name] for name in PICTURE.members},
        **{f"o_{name}_out": shown[name] for name in PICTURE.members})
    return shown, leds


class QuartusTop(Elaboratable):
    """Joins the pins of the board to the core, and its picture to VGA through the user's module.

    Parameters
    ----------
    design : ncdc_boards.camera_board.core.Design
        Design of a :class:`~ncdc_boards.quartus.board.QuartusBoard`.
    """

    def __init__(self, design):
        self.design = design
        self.core = BoardCore(design)

    def elaborate(self, platform):
        m = Module()
        oscillator = buffer(m, platform.request("clk50", 0, dir="-"))
        restart = buffer(m, platform.request(*RESTART, dir="-"))
        m.domains += (ClockDomain(name) for name in self.design.clocks.targets())
        # In the core's reset the controller sends no command to the SDRAM.
        m.domains += ClockDomain(PINS_DOMAIN, reset_less=True)
        m.d.comb += ClockSignal(PINS_DOMAIN).eq(ClockSignal())
        m.submodules.clocks = QuartusClocks(self.design.clocks, oscillator.i, restart.i)
        m.submodules.core = core = self.core
        clock_out(m, "memory", join_sdram(m, platform, core, PINS_DOMAIN))
        clock_out(m, "sensor_reference", join_camera(m, platform, core))
        picture, leds = user(m, core.picture, core.leds)
        self._vga(m, platform, picture)
        join_uart(m, platform, core)
        join_buttons(m, platform, core, BUTTONS)
        join_leds(m, platform, leds)
        self._scan(m, core.scan)
        if self.design.processor:
            join_processor(m, platform, core, self.design.board.ethernet)
        return m

    @staticmethod
    def _scan(m, scan):
        """Connect the core to a virtual TAP, which Quartus adds to the configuring JTAG chain.

        Its virtual instruction has one bit, which is not decoded: 1 is this register.
        """
        m.domains += ClockDomain(CHAIN, reset_less=True)
        m.submodules.virtual_tap = Instance(
            "sld_virtual_jtag", p_sld_auto_instance_index="NO", p_sld_instance_index=0,
            p_sld_ir_width=1, i_ir_out=Const(0, 1), o_tck=ClockSignal(CHAIN), o_tdi=scan.tdi,
            i_tdo=scan.tdo, o_virtual_state_cdr=scan.capture, o_virtual_state_sdr=scan.shift,
            o_virtual_state_udr=scan.update)

    def _vga(self, m, platform, picture):
        """Registers in the cells of the VGA pins."""
        board = self.design.board
        names = ("r", "g", "b", "hs", "vs") + (("clk", "sync_n", "blank_n") * board.dac)
        vga = request(platform, "vga", names)
        pulses = Cat(picture.hsync, picture.vsync)
        if board.dac:
            # The converter takes colours with the rising edge, in the middle of a pixel, and shows
            # them a clock later; the sync pulses bypass it.
            late = Signal(2)
            m.d.pixel += late.eq(pulses)
            pulses = late
            clock_out(m, "pixel", vga.clk, falling=True)
            m.d.comb += buffer(m, vga.sync_n).o.eq(0)
        values = {name: picture[name][-len(getattr(vga, name)):] for name in "rgb"}
        values |= {"hs": pulses[0], "vs": pulses[1]}
        values |= {"blank_n": picture.visible} if board.dac else {}
        for name, value in values.items():
            m.submodules[f"vga_{name}"] = pins = io.FFBuffer("o", getattr(vga, name),
                                                             o_domain="pixel")
            m.d.comb += pins.o.eq(value)
