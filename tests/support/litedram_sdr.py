"""Prints Verilog of LiteDRAM's controller and its PHY for SDR memories, with one port.

Run as a program of its own: what it imports warns. Arguments: LiteDRAM's name of the chip, MHz.
LiteDRAM leaves the initialisation to software; here a counter gives its commands.
"""

import sys

from litedram import modules
from litedram.core.controller import LiteDRAMController
from litedram.core.crossbar import LiteDRAMCrossbar
from litedram.phy.gensdrphy import GENSDRPHY
from litex.gen.fhdl import verilog
from migen import Case, ClockDomain, If, Module, Record, Signal

# Clock: RAS, CAS, WE (active high), address. The mode: bursts of one, the PHY's CAS latency.
PAUSE = 300
COMMANDS = {PAUSE: (1, 0, 1, 1 << 10), PAUSE + 10: (1, 1, 0, 0), PAUSE + 30: (1, 1, 0, 0),
            PAUSE + 50: (1, 1, 1, None)}
DONE = PAUSE + 70


class Top(Module):
    def __init__(self, name, hz, width=16):
        chip = getattr(modules, name)(hz, "1:1")
        sizes = chip.geom_settings
        self.pads = Record([("a", sizes.addressbits), ("ba", sizes.bankbits), ("cs_n", 1),
                            ("cke", 1), ("ras_n", 1), ("cas_n", 1), ("we_n", 1),
                            ("dm", width // 8), ("dq", width)], name="pads")
        self.submodules.phy = phy = GENSDRPHY(self.pads, hz)
        self.submodules.controller = controller = LiteDRAMController(
            phy.settings, sizes, chip.timing_settings, hz)
        self.submodules.crossbar = crossbar = LiteDRAMCrossbar(controller.interface)
        self.port = crossbar.get_port()
        self.clock_domains.cd_sys = ClockDomain("sys", reset_less=True)
        self.ready = Signal(name="ready")
        clocks = Signal(16)
        self.sync += If(clocks != DONE, clocks.eq(clocks + 1))
        dfi = phy.dfi.p0
        mode = phy.settings.cl << 4
        initial = [dfi.cke.eq(1), dfi.cs_n.eq(1), dfi.ras_n.eq(1), dfi.cas_n.eq(1), dfi.we_n.eq(1),
                   Case(clocks, {clock: [
                       dfi.cs_n.eq(0), dfi.ras_n.eq(1 - ras), dfi.cas_n.eq(1 - cas),
                       dfi.we_n.eq(1 - we), dfi.address.eq(mode if address is None else address)]
                       for clock, (ras, cas, we, address) in COMMANDS.items()})]
        self.comb += [self.ready.eq(clocks == DONE),
                      If(self.ready, controller.dfi.connect(phy.dfi)).Else(*initial)]

    def ports(self):
        port, pads = self.port, self.pads
        pins = (getattr(pads, name) for name, *_ in pads.layout)
        return {self.cd_sys.clk, self.ready, *pins, port.cmd.valid, port.cmd.ready, port.cmd.we,
                port.cmd.addr, port.wdata.valid, port.wdata.ready, port.wdata.data, port.wdata.we,
                port.rdata.valid, port.rdata.ready, port.rdata.data}


top = Top(sys.argv[1], float(sys.argv[2]) * 1e6)
print(verilog.convert(top, top.ports(), name="litedram_sdr"))
