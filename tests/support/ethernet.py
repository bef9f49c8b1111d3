"""Ethernet on wires: LiteEth's MAC with one of our interfaces, as Verilog of a device's cells."""

import functools

from litex.build.altera import AlteraPlatform
from litex.build.generic_platform import Pins, Subsignal
from litex.build.lattice import LatticeECP5Platform
from litex.gen import LiteXModule
from migen import ClockDomain

from cocotb_run import Design
from ncdc_hdl.export.verilog import module_verilog
from ncdc_hdl.link.packetiser import Packetiser
from ncdc_sim.runner import hdl_text
from ncdc_soc.mac import mac_core
from ncdc_soc.phy import GmiiPhy, MiiPhy, RgmiiPhy
from ncdc_soc.verilog import litex_verilog
from simulations import HDL

__all__ = ["DEVICES", "PAIRED", "mac_design", "packets_design"]

_STREAM = {"valid": 1, "ready": 1, "last": 1, "data": 32, "last_be": 4, "error": 4}
_DATA = {"rgmii": 4, "gmii": 8, "mii": 4}

DEVICES = {
    "ecp5": (LatticeECP5Platform, "LFE5U-45F-6BG381C", "trellis", "ecp5_cells.v"),
    "altera": (AlteraPlatform, "EP4CE115F29C7", "quartus", "altera_cells.v")}
"""By name: LiteX's platform, a device, its tools, the models of its cells."""

PAIRED = {"ecp5": True, "altera": False}
"""``RgmiiPhy``'s parameter."""


def _signals(name, members):
    return name, 0, *(Subsignal(member, Pins(" ".join(f"{name}{member}{k}" for k in range(bits))))
                      for member, bits in members.items())


def _pins(interface):
    bits = _DATA[interface]
    if interface == "rgmii":
        wires = {"rx_data": bits, "rx_ctl": 1, "tx_data": bits, "tx_ctl": 1}
    else:
        wires = {"rx_data": bits, "rx_dv": 1, "rx_er": 1, "tx_data": bits, "tx_en": 1, "tx_er": 1}
    return [_signals("clock", {"sys": 1, "transmit": 1, "late": 1, "reset": 1}),
            _signals("speed", {"set": 2, "status": 4}),
            _signals("sink", _STREAM), _signals("source", _STREAM),
            _signals("wire_clock", {"rx": 1, "gtx" if interface == "gmii" else "tx": 1}),
            _signals("wire", wires)]


class _Mac(LiteXModule):
    """The MAC, its 32-bit streams at pins."""

    def __init__(self, platform, interface, paired, late, in_words):
        clock, speed = platform.request("clock"), platform.request("speed")
        self.cd_sys = ClockDomain()
        self.comb += [self.cd_sys.clk.eq(clock.sys), self.cd_sys.rst.eq(clock.reset)]
        clocks, wires = platform.request("wire_clock"), platform.request("wire")
        if interface == "rgmii":
            self.phy = phy = RgmiiPhy(clocks, wires, clock.transmit,
                                      clock.late if late else None, paired=paired,
                                      buffered=in_words)
            self.comb += [phy.speed.storage.eq(speed.set), speed.status.eq(phy.status.status)]
        elif interface == "gmii":
            self.phy = phy = GmiiPhy(clocks, wires, clock.transmit)
        else:
            self.phy = phy = MiiPhy(clocks, wires)
        self.core = core = mac_core(phy, in_words)
        sink, source = platform.request("sink"), platform.request("source")
        for name in _STREAM:
            into, out = getattr(core.sink, name), getattr(core.source, name)
            self.comb += (getattr(sink, name).eq(into) if name == "ready"
                          else into.eq(getattr(sink, name)))
            self.comb += (out.eq(source.ready) if name == "ready"
                          else getattr(source, name).eq(out))


def _mac(device, interface, late, paired, in_words=False):
    """Verilog of the module ``mac``, and of its cells."""
    make, part, toolchain, cells = DEVICES[device]
    paired = PAIRED[device] if paired is None else paired
    platform = make(part, _pins(interface), toolchain=toolchain)
    _, text = litex_verilog(platform, lambda: _Mac(platform, interface, paired, late,
                                                     in_words), "mac")
    # What LiteX writes: assignments that wait in processes that do not, pins left open.
    lint = "\n".join(f"/* verilator lint_off {name} */"
                     for name in ("COMBDLY", "CMPCONST", "PINMISSING", "UNOPTFLAT"))
    return "\n".join([lint, text, hdl_text(cells)])


@functools.cache
def mac_design(device, interface, late=False, paired=None, in_words=False):
    """:class:`Design` of a MAC, its cells and its clocks, between streams and wires.

    For Verilator alone: under Icarus processes of LiteX wait for events that never come at time 0,
    or go in circles.

    Parameters
    ----------
    device : str
        Of ``DEVICES``.
    interface : str
        ``rgmii``, ``gmii`` or ``mii``.
    late : bool
        RGMII: whether the device itself makes the transmit clock late; else the board's wire does.
    paired : bool or None
        Of :class:`RgmiiPhy`; None: as the device's cells are.
    in_words : bool
        As :class:`~ncdc_soc.mac.Mac` is on a slow device, and with it the interface.
    """
    defines = f"`define {interface.upper()}\n" + ("`define LATE\n" if late else "")
    bench = (HDL / "ethernet_bench.v").read_text()
    mac = _mac(device, interface, late, paired, in_words)
    return Design("ethernet_bench", defines + bench + mac, delays=True)


@functools.cache
def packets_design(device, capacity):
    """:class:`Design` of a packetiser of 32 bits before such a MAC with RGMII.

    Parameters
    ----------
    device : str
        Of ``DEVICES``.
    capacity : int
        Bytes of a payload, at most.
    """
    packetiser = module_verilog(Packetiser(32, capacity=capacity), "packetiser")
    bench = (HDL / "ethernet_packets_bench.v").read_text()
    return Design("ethernet_packets_bench",
                  "\n".join([bench, packetiser, _mac(device, "rgmii", False, None)]), delays=True)
