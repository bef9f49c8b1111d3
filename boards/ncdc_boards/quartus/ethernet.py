"""The Ethernet chip of a Quartus board, at the processor's module."""

from amaranth import *

from ncdc_boards.camera_board.pins import buffer, request
from ncdc_boards.quartus.resources import RGMII
from ncdc_hdl.link.processor import ProcessorPort

__all__ = ["MODULE", "join_processor"]

MODULE = "ncdc_processor"
"""Module, and file, of the processor and its MAC."""


def join_processor(m, platform, core):
    """The processor's module between the core and the chip's pins.

    The domains "ethernet" and "ethernet_late" exist.
    """
    pins = request(platform, "eth_rgmii", RGMII)
    mdio = buffer(m, pins.mdio)
    ports = {"i_clock_sys": ClockSignal(), "i_clock_reset": ResetSignal(),
             "i_clock_transmit": ClockSignal("ethernet"),
             "i_clock_late": ClockSignal("ethernet_late"),
             "i_clock_rx": buffer(m, pins.rx_clk).i, "o_clock_tx": buffer(m, pins.tx_clk).o,
             "o_eth_rst_n": buffer(m, pins.rst).o, "o_mdio_mdc": buffer(m, pins.mdc).o,
             "o_mdio_data": mdio.o, "o_mdio_enable": mdio.oe, "i_mdio_pin": mdio.i}
    ports |= {f"i_eth_{name}": buffer(m, getattr(pins, name)).i for name in ("rx_data", "rx_ctl")}
    ports |= {f"o_eth_{name}": buffer(m, getattr(pins, name)).o for name in ("tx_data", "tx_ctl")}
    for path, member, value in ProcessorPort().flatten(core.processor):
        way = "o" if member.flow.name == "Out" else "i"
        ports[f"{way}_processor__{'__'.join(path)}"] = value
    m.submodules.processor = Instance(MODULE, **ports)
