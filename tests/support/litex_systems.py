"""A LiteX system of a user's, to which lines of a page are added."""

from litedram import modules
from litedram.phy.model import SDRAMPHYModel, get_sdram_phy_settings
from litex.build.generic_platform import Pins
from litex.build.sim import SimPlatform
from litex.gen import LiteXModule
from litex.soc.integration.soc_core import SoCCore
from migen import ClockDomain

__all__ = ["system_with"]

_CLOCK_HZ = 100_000_000


class _Clock(LiteXModule):
    def __init__(self, platform):
        self.cd_sys = ClockDomain()
        self.comb += self.cd_sys.clk.eq(platform.request("sys_clk"))


class _System(SoCCore):
    def __init__(self, platform, lines):
        SoCCore.__init__(self, platform, _CLOCK_HZ, cpu_type="vexriscv", with_uart=False,
                         integrated_rom_size=0x1000, integrated_rom_init=[0])
        self.crg = _Clock(platform)
        module = modules.MT48LC16M16(_CLOCK_HZ, "1:1")
        self.sdrphy = SDRAMPHYModel(module, get_sdram_phy_settings("SDR", 32, _CLOCK_HZ), _CLOCK_HZ)
        assert lines.count("self.add_sdram(...,") == 1
        exec(lines.replace("...", "'sdram', phy=self.sdrphy, module=module"),
             {"self": self, "platform": platform, "module": module})


def system_with(lines):
    """Verilog of a LiteX system with a processor, and ``lines`` of Python at the end of its
    ``__init__``. They add its SDRAM, the user's own arguments as "..."."""
    platform = SimPlatform("SIM", [("sys_clk", 0, Pins(1))])
    soc = _System(platform, lines)
    soc.finalize()
    assert "ncdc" in soc.irq.locs and "ncdc" in soc.bus.regions
    return platform.get_verilog(soc, name="users").main_source
