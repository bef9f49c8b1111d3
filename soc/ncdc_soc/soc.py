"""The system on a chip in simulation: LiteX around :class:`SocCore`."""

from dataclasses import dataclass

from litedram import modules
from litedram.core import LiteDRAMCore
from litedram.phy.model import SDRAMPHYModel, get_sdram_phy_settings
from litex.build.generic_platform import Pins, Subsignal
from litex.build.sim import SimPlatform
from litex.gen import LiteXModule
from litex.soc.integration.soc import SoCRegion
from litex.soc.integration.soc_core import SoCCore
from litex.soc.interconnect import wishbone
from migen import ClockDomain, Instance, Mux, Signal

from ncdc_soc.core import ADDRESS_BITS, FRAMES_BITS
from ncdc_soc.mac import SLOT_BYTES, Mac, ModelPhy
from ncdc_soc.verilog import litex_verilog

__all__ = ["CLOCK_HZ", "MAP", "SocVerilog", "soc_verilog"]

CLOCK_HZ = 100_000_000

MAP = {"rom": 0x0000_0000, "sram": 0x1000_0000, "ncdc": 0x9000_0000, "ethmac_rx": 0x9010_0000,
       "ethmac_tx": 0x9011_0000, "frames": 0xA000_0000, "csr": 0xF000_0000}
"""Byte addresses of what the processor sees."""

_ROM_BYTES = 0x20000
_SRAM_BYTES = 0x10000
_RX_SLOTS, _TX_SLOTS = 4, 2
_WATCHDOG_DELAY = 1             # clocks from its end to the reset; of 0 its timer makes no sense
_WORD_ADDRESS_BITS = 30         # of the core's ports

_PINS = [
    ("sys_clk", 0, Pins(1)), ("sys_rst", 0, Pins(1)),
    ("serial", 0, *(Subsignal(f"{side}_{name}", Pins(8 if name == "data" else 1))
                    for side in ("source", "sink") for name in ("valid", "ready", "data"))),
    ("eth", 0, *(Subsignal(f"{side}_{name}", Pins(8 if name == "data" else 1))
                 for side in ("source", "sink") for name in ("valid", "ready", "data"))),
    ("sensor", 0, *(Subsignal(name, Pins(12 if name == "data" else 1))
                    for name in ("clock", "frame_valid", "line_valid", "data", "scl", "sda",
                                 "scl_low", "sda_low", "reset_n"))),
]


@dataclass(frozen=True)
class SocVerilog:
    """What is compiled, and what the firmware must know of it.

    Parameters
    ----------
    text : str
        The module ``ncdc_soc``; it instantiates ``ncdc_core`` and ``VexRiscv``.
    processor : str
        Path of the processor's Verilog.
    registers : dict
        Byte address of each of LiteX's registers, by name.
    memories : dict
        First byte and size of each region, by name.
    """
    text: str
    processor: str
    registers: dict
    memories: dict


class _Reset(LiteXModule):
    """Clock and reset; the watchdog drives ``rst``."""

    def __init__(self, platform):
        self.cd_sys = ClockDomain()
        self.rst = Signal()
        self.comb += [self.cd_sys.clk.eq(platform.request("sys_clk")),
                      self.cd_sys.rst.eq(platform.request("sys_rst") | self.rst)]


class _Soc(SoCCore):
    """The processor, its memories and peripherals, the SDRAM, the MAC, and the core."""

    mem_map = {**SoCCore.mem_map, **MAP}

    def __init__(self, platform, core):
        SoCCore.__init__(
            self, platform, CLOCK_HZ, cpu_type="vexriscv", cpu_variant="standard",
            integrated_rom_size=_ROM_BYTES, integrated_rom_init=[0],
            integrated_sram_size=_SRAM_BYTES, uart_name="sim", ident="", with_timer=True)
        self.crg = _Reset(platform)
        self.add_watchdog("watchdog", reset_delay=_WATCHDOG_DELAY)
        self._memory()
        self.ethphy = ModelPhy(platform.request("eth"))
        self.ethmac = Mac(self.ethphy, _RX_SLOTS)
        self.irq.add("ethmac", use_loc_if_exists=True)
        for name, bus, slots in (("rx", self.ethmac.bus_rx, _RX_SLOTS),
                                 ("tx", self.ethmac.bus_tx, _TX_SLOTS)):
            self.bus.add_slave(f"ethmac_{name}", bus, SoCRegion(
                origin=MAP[f"ethmac_{name}"], size=slots * SLOT_BYTES, cached=False))
        self._core(platform, core)

    def _memory(self):
        """64 MB of SDR, 32 bits: what the DE2-115 has half of."""
        module = modules.MT48LC16M16(CLOCK_HZ, "1:1")
        settings = get_sdram_phy_settings("SDR", 32, CLOCK_HZ)
        self.sdrphy = SDRAMPHYModel(module, settings, CLOCK_HZ, verbosity=0)
        self.sdram = LiteDRAMCore(self.sdrphy, module.geom_settings, module.timing_settings,
                                  CLOCK_HZ)

    def _core(self, platform, core):
        """``ncdc_core``: its registers on the processor's bus, its hosts on the SDRAM."""
        bus = wishbone.Interface(data_width=32, adr_width=30)
        self.bus.add_slave("ncdc", bus, SoCRegion(origin=MAP["ncdc"], size=4 << ADDRESS_BITS,
                                                  cached=False))
        window = wishbone.Interface(data_width=32, adr_width=30)
        self.bus.add_slave("frames", window, SoCRegion(origin=MAP["frames"], size=4 << FRAMES_BITS,
                                                       cached=False))
        pins = platform.request("sensor")
        scl_low, sda_low = Signal(), Signal()
        frames, empty = self.ethmac.frames, Signal(2)
        irq = Signal()
        ports = {}
        for k in range(core.ports):
            port = self.sdram.crossbar.get_port()
            address = Signal(_WORD_ADDRESS_BITS)
            self.comb += port.cmd.addr.eq(address)
            ports |= {
                f"o_port{k}__cmd_valid": port.cmd.valid, f"i_port{k}__cmd_ready": port.cmd.ready,
                f"o_port{k}__cmd_we": port.cmd.we, f"o_port{k}__cmd_addr": address,
                f"o_port{k}__wdata_valid": port.wdata.valid,
                f"i_port{k}__wdata_ready": port.wdata.ready,
                f"o_port{k}__wdata_data": port.wdata.data, f"o_port{k}__wdata_we": port.wdata.we,
                f"i_port{k}__rdata_valid": port.rdata.valid,
                f"i_port{k}__rdata_data": port.rdata.data}
            self.comb += port.rdata.ready.eq(1)
        self.specials += Instance(
            "ncdc_core", **ports, i_clk=self.crg.cd_sys.clk, i_rst=self.crg.cd_sys.rst,
            i_bus__adr=bus.adr[:ADDRESS_BITS], i_bus__dat_w=bus.dat_w, i_bus__sel=bus.sel,
            i_bus__cyc=bus.cyc, i_bus__stb=bus.stb, i_bus__we=bus.we, o_bus__dat_r=bus.dat_r,
            o_bus__ack=bus.ack,
            o_bus__err=bus.err, i_frames__adr=window.adr[:FRAMES_BITS],
            i_frames__dat_w=window.dat_w, i_frames__sel=window.sel, i_frames__cyc=window.cyc,
            i_frames__stb=window.stb, i_frames__we=window.we, o_frames__dat_r=window.dat_r,
            o_frames__ack=window.ack, o_frames__err=window.err, i_sensor_clock=pins.clock,
            i_sensor_frame_valid=pins.frame_valid, i_sensor_line_valid=pins.line_valid,
            i_sensor_data=pins.data, i_scl=pins.scl, i_sda=pins.sda, o_scl_low=scl_low,
            o_sda_low=sda_low, o_irq=irq, o_frame_valid=frames.valid, i_frame_ready=frames.ready,
            o_frame_data=frames.data, o_frame_empty=empty, o_frame_last=frames.last)
        self.comb += [pins.scl_low.eq(scl_low), pins.sda_low.eq(sda_low), pins.reset_n.eq(1),
                      frames.last_be.eq(Mux(frames.last, 0b1000 >> empty, 0))]


def soc_verilog(core):
    """:class:`SocVerilog` of the system around a :class:`SocCore`."""
    platform = SimPlatform("SIM", _PINS)
    soc, text = litex_verilog(platform, lambda: _Soc(platform, core), "ncdc_soc")
    processor = next(source[0] for source in platform.sources if "VexRiscv" in source[0])
    registers = {f"{bank}_{csr.name}".upper(): region.origin + 4 * offset
                 for bank, region in soc.csr_regions.items()
                 for offset, csr in _places(region.obj)}
    memories = {name: (region.origin, region.size) for name, region in soc.bus.regions.items()}
    return SocVerilog(text, processor, registers, memories)


def _places(csrs):
    """(word, register) of a bank's registers; one of more than 32 bits takes several."""
    offset = 0
    for csr in csrs if isinstance(csrs, list) else []:
        yield offset, csr
        offset += -(-csr.size // 32)
