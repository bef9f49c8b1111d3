"""The Ethernet chip of a board, connected to the processor's module."""

from amaranth import *
from amaranth.build import Clock, Pins, Resource, Subsignal

from ncdc_boards.camera_board.pins import buffer, request
from ncdc_hdl.link.processor import ProcessorPort

__all__ = ["MODULE", "RGMII", "join_processor", "rgmii"]

MODULE = "ncdc_processor"
"""Module, and file, of the processor and its MAC."""

RGMII = ("rst", "mdc", "mdio", "tx_clk", "tx_ctl", "tx_data", "rx_clk", "rx_ctl", "rx_data")
"""Signals of an Ethernet chip as amaranth-boards has them; "rst" is low in a reset."""


def rgmii(attrs, **pins):
    """An Ethernet chip with RGMII, pins by the names of :data:`RGMII`."""
    directions = {"mdio": "io", "rx_clk": "i", "rx_ctl": "i", "rx_data": "i"}
    clocks = {"rx_clk": [Clock(125e6)]}
    return Resource("eth_rgmii", 0, *(
        Subsignal(name, Pins(pins[name], dir=directions.get(name, "o")), *clocks.get(name, []))
        for name in RGMII), attrs)


def join_processor(m, platform, core, chip, *, reset=None, received=None):
    """The processor's module between the core and the chip's pins.

    The domain "ethernet" exists, and "ethernet_late" if the device delays the clock to the chip.

    Parameters
    ----------
    chip : EthernetChip
    reset : Value, optional
        Reset of the processor; by default that of the core's domain.
    received : callable, optional
        Function of module, name and pins; returns what the processor's input cells take.
    """
    pins = request(platform, "eth_rgmii", RGMII)
    mdio = buffer(m, pins.mdio)
    ports = {"i_clock_sys": ClockSignal(),
             "i_clock_reset": ResetSignal() if reset is None else reset,
             "i_clock_transmit": ClockSignal("ethernet"),
             "i_clock_rx": buffer(m, pins.rx_clk).i, "o_clock_tx": buffer(m, pins.tx_clk).o,
             "o_eth_rst_n": buffer(m, pins.rst).o, "o_mdio_mdc": buffer(m, pins.mdc).o,
             "o_mdio_data": mdio.o, "o_mdio_enable": mdio.oe, "i_mdio_pin": mdio.i}
    ports |= {} if chip.delays else {"i_clock_late": ClockSignal("ethernet_late")}
    for name in ("rx_data", "rx_ctl"):
        value = buffer(m, getattr(pins, name)).i
        ports[f"i_eth_{name}"] = received(m, name, value) if received else value
    ports |= {f"o_eth_{name}": buffer(m, getattr(pins, name)).o for name in ("tx_data", "tx_ctl")}
    for path, member, value in ProcessorPort().flatten(core.processor):
        way = "o" if member.flow.name == "Out" else "i"
        ports[f"{way}_processor__{'__'.join(path)}"] = value
    m.submodules.processor = Instance(MODULE, **ports)
