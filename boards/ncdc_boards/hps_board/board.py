"""Description of a board with a hard processor."""

from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["HpsBoard"]


@dataclass(frozen=True)
class HpsBoard:
    """A board with a project by ``ncdc build``, whose frames are in the processor's memory.

    Parameters
    ----------
    name, title : str
        As given on the command line; the name for people.
    family, device : str
        As Quartus names them.
    platform : type
        Subclass of amaranth-boards' platform, with resources ``camera``, ``hdmi``, ``hps_ddr3``.
    core_mhz : float
        Clock of the core and of the ports to the memory.
    clock_plan : callable
        As in :class:`~ncdc_boards.board.Board`.
    memory : dict
        Parameters of the processor in Platform Designer: its DDR3.
    frames : (int, int)
        Address and bytes of the memory that Linux leaves to the frames.
    multiplier_bits : int
        18 or 27: what a multiplier block of the device multiplies.
    sources : tuple of str
        Where pins and memory are published.
    """
    name: str
    title: str
    family: str
    device: str
    platform: type
    core_mhz: float
    clock_plan: Callable
    memory: dict
    frames: tuple
    multiplier_bits: int
    sources: tuple
