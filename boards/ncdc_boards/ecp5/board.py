"""A board with an ECP5, for open tools."""

from dataclasses import dataclass

from ncdc_boards.camera_board.board import CameraBoard
from ncdc_boards.ecp5.build import prepared

__all__ = ["Ecp5Board"]


@dataclass(frozen=True)
class Ecp5Board(CameraBoard):
    """A board whose bitstream ``ncdc build`` makes."""

    tools = "open"

    def files(self, design, sources=()):
        """The top and all below it in Yosys's own language and as Verilog, and the constraints
        (Lattice's preferences) of its pins, by name.

        ``sources`` are read next to them, no file of these names them.
        """
        return prepared(design)
