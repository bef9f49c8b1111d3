"""A small LiteX system around :class:`ncdc_soc.module.NCDC`: the example that is simulated."""

from dataclasses import dataclass

from litedram import modules
from litedram.frontend.dma import LiteDRAMDMAWriter
from litedram.phy.model import SDRAMPHYModel, get_sdram_phy_settings
from litex.build.generic_platform import Pins, Subsignal
from litex.build.sim import SimPlatform
from litex.gen import LiteXModule
from litex.soc.integration.soc_core import SoCCore
from litex.soc.interconnect import wishbone
from migen import Cat, ClockDomain

from ncdc_soc.module import NCDC
from ncdc_soc.turns import long_turns
from ncdc_soc.verilog import litex_verilog

__all__ = ["CLOCK_HZ", "MAIN_RAM", "REGISTERS", "ModuleSoc", "ModuleSocVerilog",
           "module_soc_verilog"]

CLOCK_HZ = 100_000_000
MAIN_RAM = 0x4000_0000
REGISTERS = 0x9000_0000
"""Byte addresses of what the bus reaches: memory, the corrector."""

_ROM_BYTES = 0x1000
_HOST = {"adr": 30, "dat_w": 32, "sel": 4, "cyc": 1, "stb": 1, "we": 1, "dat_r": 32, "ack": 1,
         "err": 1}
_VIDEO = {"valid": 1, "ready": 1, "first": 1, "last": 1, "de": 1, "hsync": 1, "vsync": 1, "r": 8,
          "g": 8, "b": 8}
_PINS = [("sys_clk", 0, Pins(1)), ("sys_rst", 0, Pins(1)), ("frame_irq", 0, Pins(1)),
         ("host", 0, *(Subsignal(name, Pins(bits)) for name, bits in _HOST.items())),
         ("video", 0, *(Subsignal(name, Pins(bits)) for name, bits in _VIDEO.items()))]


class _Clock(LiteXModule):
    def __init__(self, platform):
        self.cd_sys = ClockDomain()
        self.comb += [self.cd_sys.clk.eq(platform.request("sys_clk")),
                      self.cd_sys.rst.eq(platform.request("sys_rst"))]


class ModuleSoc(SoCCore):
    """Memory, the corrector, and a bus master at the pins, as a bridge to a PC would be.

    With ``cpu`` also a processor, whose program is in a ROM at 0.

    Parameters
    ----------
    platform : SimPlatform
    net : Descriptor or path
    hardware : Hardware or None
        Hardware of :class:`NCDC`.
    cpu : str or None
        LiteX's name of the processor.
    folder : path
        For the corrector's Verilog.
    record : bool
        Whether LiteDRAM's DMA writes the video into memory, four bytes a pixel, blue first; else it
        is at the pins.
    """

    mem_map = {**SoCCore.mem_map, "rom": 0, "sram": 0x1000_0000, "main_ram": MAIN_RAM,
               "csr": 0xF000_0000}

    def __init__(self, platform, net, hardware, cpu, folder, record=False):
        SoCCore.__init__(
            self, platform, CLOCK_HZ, cpu_type=cpu, ident="", with_uart=False, with_timer=False,
            integrated_rom_size=_ROM_BYTES if cpu else 0, integrated_rom_init=[0] if cpu else [],
            integrated_sram_size=0x1000 if cpu else 0)
        self.crg = _Clock(platform)
        module = modules.MT48LC16M16(CLOCK_HZ, "1:1")
        self.sdrphy = SDRAMPHYModel(module, get_sdram_phy_settings("SDR", 32, CLOCK_HZ), CLOCK_HZ)
        # A cache before the memory would not see what the corrector writes.
        self.add_sdram("sdram", phy=self.sdrphy, module=module, l2_cache_size=0,
                       controller_settings=long_turns())
        self.ncdc = NCDC(platform, net, self.sdram.crossbar, hardware, folder=folder)
        self.bus.add_slave("ncdc", self.ncdc.bus, self.ncdc.region(REGISTERS))
        if self.irq.enabled:
            self.irq.add("ncdc", use_loc_if_exists=True)
        self._pins(platform, self._record() if record else self.ncdc.source)

    def _record(self):
        source = self.ncdc.source
        self.writer = writer = LiteDRAMDMAWriter(
            self.sdram.crossbar.get_port(mode="write", data_width=32), with_csr=True)
        self.comb += [writer.sink.valid.eq(source.valid), source.ready.eq(writer.sink.ready),
                      writer.sink.data.eq(Cat(source.b, source.g, source.r))]

    def _pins(self, platform, source):
        host, pins = wishbone.Interface(data_width=32, adr_width=30), platform.request("host")
        self.bus.add_master("host", host)
        self.comb += [getattr(host, name).eq(getattr(pins, name))
                      for name in ("adr", "dat_w", "sel", "cyc", "stb", "we")]
        self.comb += [getattr(pins, name).eq(getattr(host, name))
                      for name in ("dat_r", "ack", "err")]
        self.comb += platform.request("frame_irq").eq(self.ncdc.ev.irq)
        video = platform.request("video")
        if source is not None:
            self.comb += source.ready.eq(video.ready)
            self.comb += [getattr(video, name).eq(getattr(source, name))
                          for name in _VIDEO if name != "ready"]


@dataclass(frozen=True)
class ModuleSocVerilog:
    """Verilog of the system, and the addresses of its registers.

    Parameters
    ----------
    text : str
        The module ``ncdc_litex``.
    sources : tuple of str
        Paths of the Verilog that it instantiates: the corrector, the processor if there is one.
    registers : dict
        Byte address of each of LiteX's registers, by name.
    """
    text: str
    sources: tuple
    registers: dict


def module_soc_verilog(net, hardware, cpu, folder, record=False):
    """:class:`ModuleSocVerilog` of a :class:`ModuleSoc`, whose parameters these are."""
    platform = SimPlatform("SIM", _PINS)
    soc, text = litex_verilog(
        platform, lambda: ModuleSoc(platform, net, hardware, cpu, folder, record),
        "ncdc_litex")
    registers = {f"{bank}_{csr.name}": region.origin + 4 * offset
                 for bank, region in soc.csr_regions.items() if isinstance(region.obj, list)
                 for offset, csr in enumerate(region.obj)}
    return ModuleSocVerilog(text, tuple(source[0] for source in platform.sources), registers)
