"""Description of a board with a camera and a screen."""

from collections.abc import Callable
from dataclasses import dataclass

from ncdc_boards.sdram.chips import SdramChip
from ncdc_spec.interpolation import INTERPOLATIONS

__all__ = ["Board", "EthernetChip"]


@dataclass(frozen=True)
class EthernetChip:
    """An Ethernet chip with RGMII at the device's pins.

    Parameters
    ----------
    addresses : range
        Addresses of its management registers (MDIO) at which the firmware looks for it.
    delays : bool
        The chip delays the clock that the device sends with the data; else the device does.
    """
    addresses: range
    delays: bool


@dataclass(frozen=True)
class Board:
    """A board that ``ncdc build`` makes a design for.

    Parameters
    ----------
    name, title : str
        As given on the command line; the name for people.
    device : str
        As its tools name it.
    platform : type
        Subclass of amaranth-boards' platform, with a resource ``camera``.
    chip : SdramChip
    memory_bytes : int
        Bytes of the SDRAM that the device reaches.
    core_mhz : float
        Clock of the core and of the SDRAM.
    clock_plan : callable
        From a video mode and ``core_mhz`` to the board's clocks, with ``core_mhz`` and
        ``pixel_mhz``; raises InputError if it has no such pixel clock.
    top : callable
        From a :class:`~ncdc_boards.camera_board.core.Design` to the Elaboratable.
    baud : int
        Bits per second of the serial port.
    multiplier_bits : int
        18 or 27: what a multiplier block of the device multiplies.
    tools : str
        "open": ``ncdc build`` makes the bitstream; "quartus": it writes a Quartus project.
    sources : tuple of str
        Where the pins are published.
    jtag : bool
        The registers are also reached through the JTAG chain that configures the device.
    ethernet : EthernetChip or None
        What ``ncdc build --system`` uses; None: there is none.
    screen : bool
        It has a connector for a monitor; else it always has a processor, and needs ``ethernet``.
    byte_masks : bool
        The device reaches the SDRAM's DQM; else whole words are written.
    interpolations : tuple of str
        Those for which it has block RAM.
    pattern_bits : int
        Bits of block RAM for a test pattern instead of a sensor; 0: it is not supported.
    """
    name: str
    title: str
    device: str
    platform: type
    chip: SdramChip
    memory_bytes: int
    core_mhz: float
    clock_plan: Callable
    top: Callable
    baud: int
    multiplier_bits: int
    tools: str
    sources: tuple
    jtag: bool = False
    ethernet: EthernetChip | None = None
    screen: bool = True
    byte_masks: bool = True
    interpolations: tuple = tuple(INTERPOLATIONS)
    pattern_bits: int = 0
