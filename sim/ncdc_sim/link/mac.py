"""The network's side of a board's processor, alone: LiteEth's MAC and RGMII of Altera's cells."""

from litex.build.altera import AlteraPlatform
from litex.build.generic_platform import Pins, Subsignal
from litex.gen import LiteXModule
from migen import ClockDomain, Mux

from ncdc_sim.runner import HDL
from ncdc_soc.mac import Mac
from ncdc_soc.phy import RgmiiPhy
from ncdc_soc.verilog import litex_verilog

__all__ = ["mac_verilog"]

_PINS = {"clock": {"sys": 1, "reset": 1, "transmit": 1},
         "packet": {"valid": 1, "ready": 1, "last": 1, "data": 32, "empty": 2},
         "line": {"rx": 1, "tx": 1},
         "wire": {"rx_data": 4, "rx_ctl": 1, "tx_data": 4, "tx_ctl": 1}}


class _Sender(LiteXModule):
    """A :class:`Mac` whose processor is silent; the packetiser's frames are at pins."""

    def __init__(self, platform):
        clock, packet = platform.request("clock"), platform.request("packet")
        self.cd_sys = ClockDomain()
        self.comb += [self.cd_sys.clk.eq(clock.sys), self.cd_sys.rst.eq(clock.reset)]
        self.phy = RgmiiPhy(platform.request("line"), platform.request("wire"), clock.transmit,
                            paired=False)
        self.mac = Mac(self.phy)
        frames = self.mac.frames
        self.comb += [
            frames.valid.eq(packet.valid), packet.ready.eq(frames.ready),
            frames.last.eq(packet.last), frames.data.eq(packet.data),
            frames.last_be.eq(Mux(packet.last, 0b1000 >> packet.empty, 0))]


def mac_verilog(device):
    """Verilog of the module ``mac`` for a device of Altera's, and of the cells in it.

    It sends frames of a packetiser, by its own clock, on RGMII's wires at 1000 Mbit/s.
    """
    pins = [(name, 0, *(Subsignal(member, Pins(" ".join(f"{name}_{member}_{k}"
                                                        for k in range(bits))))
                        for member, bits in members.items())) for name, members in _PINS.items()]
    platform = AlteraPlatform(device, pins, toolchain="quartus")
    _, text = litex_verilog(platform, lambda: _Sender(platform), "mac")
    return text + (HDL / "altera_cells.v").read_text()
