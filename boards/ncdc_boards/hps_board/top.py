"""The top of a board with a hard processor: its clocks and pins, and the processor's system."""

from amaranth import *
from amaranth.lib import io

from ncdc_boards.camera_board.pins import buffer, join_camera, join_leds, request
from ncdc_boards.hps_board.core import HpsCore
from ncdc_boards.hps_board.ports import AGENT, BURST_BITS, HOST, MEMORY_PINS, PORTS, SYSTEM
from ncdc_boards.quartus.plls import QuartusClocks
from ncdc_boards.quartus.top import clock_out, user

__all__ = ["HDMI", "HpsTop"]

HDMI = ("clk", "de", "hs", "vs", "r", "g", "b", "scl", "sda")


class HpsTop(Elaboratable):
    """Joins the core to the pins of the board and to the processor; its picture goes through the
    user's module to the HDMI transmitter.

    Parameters
    ----------
    design : ncdc_boards.hps_board.core.HpsDesign
    """

    def __init__(self, design):
        self.design = design
        self.core = HpsCore(design)

    def elaborate(self, platform):
        m = Module()
        oscillator = buffer(m, platform.request("clk50", 0, dir="-"))
        hps_reset_n = Signal()
        m.domains += (ClockDomain(name) for name in self.design.clocks.targets())
        m.submodules.clocks = QuartusClocks(self.design.clocks, oscillator.i, ~hps_reset_n)
        m.submodules.core = self.core
        clock_out(m, "sensor_reference", join_camera(m, platform, self.core))
        picture, leds = user(m, self.core.picture, self.core.leds)
        self._hdmi(m, platform, picture)
        join_leds(m, platform, leds)
        m.submodules.processor = Instance(
            SYSTEM, i_clk_clk=ClockSignal(), i_reset_reset_n=~ResetSignal(),
            o_hps_reset_reset_n=hps_reset_n, i_irq_irq=Cat(self.core.irq, C(0, 31)),
            **self._memory_pins(platform), **self._ports(m), **self._registers(m))
        return m

    @staticmethod
    def _memory_pins(platform):
        """The processor's memory, at its dedicated pins."""
        pins = request(platform, "hps_ddr3", (*MEMORY_PINS, "rzq"))
        ways = {name: "io" if name.startswith("dq") else "o" for name in MEMORY_PINS}
        return {f"{way}_memory_mem_{name}": getattr(pins, name).io for name, way in ways.items()} \
            | {"i_memory_oct_rzqin": pins.rzq.io}

    def _ports(self, m):
        """The ports to the memory, whose agents have more signals than a host of one direction."""
        found = {}
        for prefix, (width, _) in PORTS.items():
            bus = getattr(self.core, prefix)
            idle = {"read": C(0, 1), "write": C(0, 1), "debugaccess": C(0, 1),
                    "writedata": C(0, width), "byteenable": C(2 ** (width // 8) - 1, width // 8)}
            for name, way in AGENT.items():
                if hasattr(bus, name):
                    value = getattr(bus, name)
                elif way == "i":
                    value = idle[name]
                else:
                    value = Signal(width if name == "readdata" else 1, name=f"{prefix}_{name}")
                if name == "burstcount":
                    value = Cat(value, C(0, BURST_BITS - len(value)))
                found[f"{way}_{prefix}_{name}"] = value
        return found

    def _registers(self, m):
        """The lightweight bridge's host: words with byte addresses; one access at a time."""
        csr = self.core.csr
        address = Signal(len(csr.address) + 2, name="csr_byte_address")
        m.d.comb += csr.address.eq(address[2:])
        widths = {"burstcount": 1, "byteenable": 4, "debugaccess": 1}
        found = {f"{way}_csr_{name}": Signal(widths[name], name=f"csr_{name}") if name in widths
                 else getattr(csr, name) for name, way in HOST.items() if name != "address"}
        return found | {"o_csr_address": address}

    def _hdmi(self, m, platform, picture):
        """The transmitter takes a pixel with the rising edge, in the middle of it."""
        hdmi = request(platform, "hdmi", HDMI)
        clock_out(m, "pixel", hdmi.clk, falling=True)
        for name, value in (("de", picture.visible), ("hs", picture.hsync), ("vs", picture.vsync),
                            ("r", picture.r), ("g", picture.g), ("b", picture.b)):
            m.submodules[f"hdmi_{name}"] = pins = io.FFBuffer("o", getattr(hdmi, name),
                                                              o_domain="pixel")
            m.d.comb += pins.o.eq(value)
        for name in ("scl", "sda"):
            line = buffer(m, getattr(hdmi, name))
            m.d.comb += [line.o.eq(0), line.oe.eq(getattr(self.core, f"{name}_low")),
                         getattr(self.core, f"hdmi_{name}").eq(line.i)]
