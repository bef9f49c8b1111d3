"""The system on a chip in simulation: a :class:`Processor` and LiteDRAM around :class:`SocCore`."""

from amaranth.hdl import Shape
from amaranth.lib.wiring import Out
from litedram import modules
from litedram.core import LiteDRAMCore
from litedram.phy.model import SDRAMPHYModel, get_sdram_phy_settings
from litex.build.generic_platform import Pins, Subsignal
from litex.build.sim import SimPlatform
from litex.gen import LiteXModule
from migen import ClockDomain, Instance, Signal

from ncdc_soc.mac import ModelPhy
from ncdc_soc.native import native_port
from ncdc_soc.processor import Processor, described
from ncdc_soc.turns import long_turns
from ncdc_soc.verilog import litex_verilog

__all__ = ["CLOCK_HZ", "soc_verilog"]

CLOCK_HZ = 100_000_000

_MEMORY_BYTES = (0x20000, 0x10000)     # of ROM and SRAM

_PINS = [
    ("sys_clk", 0, Pins(1)), ("sys_rst", 0, Pins(1)),
    ("serial", 0, *(Subsignal(f"{side}_{name}", Pins(8 if name == "data" else 1))
                    for side in ("source", "sink") for name in ("valid", "ready", "data"))),
    ("eth", 0, *(Subsignal(f"{side}_{name}", Pins(8 if name == "data" else 1))
                 for side in ("source", "sink") for name in ("valid", "ready", "data"))),
]


def _sensor_pins(core):
    """The sensor's pins, at which the names of the core's begin with ``sensor_``."""
    pins = {name.removeprefix("sensor_"): Shape.cast(member.shape).width
            for name, member in core.pins.items()}
    return "sensor", 0, *(Subsignal(name, Pins(width))
                          for name, width in (pins | {"reset_n": 1}).items())


class _Reset(LiteXModule):
    """Clock and reset; the watchdog drives ``rst``."""

    def __init__(self, platform):
        self.cd_sys = ClockDomain()
        self.rst = Signal()
        self.comb += [self.cd_sys.clk.eq(platform.request("sys_clk")),
                      self.cd_sys.rst.eq(platform.request("sys_rst") | self.rst)]


class _Soc(Processor):
    """The processor, the SDRAM, and the core."""

    def __init__(self, platform, core):
        super().__init__(platform, CLOCK_HZ, ModelPhy(platform.request("eth")),
                         memory_bytes=_MEMORY_BYTES, uart="sim", clocks=_Reset(platform))
        self._memory()
        self._core(platform, core)

    def _memory(self):
        """64 MB of SDR, 32 bits: what the DE2-115 has half of."""
        module = modules.MT48LC16M16(CLOCK_HZ, "1:1")
        settings = get_sdram_phy_settings("SDR", 32, CLOCK_HZ)
        self.sdrphy = SDRAMPHYModel(module, settings, CLOCK_HZ, verbosity=0)
        self.sdram = LiteDRAMCore(self.sdrphy, module.geom_settings, module.timing_settings,
                                  CLOCK_HZ, controller_settings=long_turns())

    def _core(self, platform, core):
        """``ncdc_core``: the processor's, and its hosts on the SDRAM."""
        pins = platform.request("sensor")
        ports = {f"{'i' if driven else 'o'}_{name}": signal
                 for name, (signal, driven) in self.port.items()}
        for k in range(core.ports):
            ports |= native_port(self, self.sdram.crossbar.get_port(), f"port{k}__")
        for name, member in core.pins.items():
            direction = "o" if member.flow is Out else "i"
            ports[f"{direction}_{name}"] = getattr(pins, name.removeprefix("sensor_"))
        self.specials += Instance("ncdc_core", **ports, i_clk=self.crg.cd_sys.clk,
                                  i_rst=self.crg.cd_sys.rst)
        self.comb += pins.reset_n.eq(1)


def soc_verilog(core):
    """:class:`~ncdc_soc.processor.ProcessorVerilog` of the module ``ncdc_soc``, the system around a
    :class:`SocCore`; it instantiates ``ncdc_core`` too."""
    platform = SimPlatform("SIM", [*_PINS, _sensor_pins(core)])
    soc, text = litex_verilog(platform, lambda: _Soc(platform, core), "ncdc_soc")
    return described(soc, platform, text)
