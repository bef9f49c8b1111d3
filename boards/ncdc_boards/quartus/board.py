"""Description of a Quartus board, beyond that of every board."""

from dataclasses import dataclass

from ncdc_boards.board import Board

__all__ = ["QuartusBoard"]


@dataclass(frozen=True)
class QuartusBoard(Board):
    """A board for Quartus.

    Parameters
    ----------
    family : str
        As Quartus names it.
    dac : bool
        VGA goes through a converter ADV7123, with a clock; else through resistors.
    """
    family: str = ""
    dac: bool = False
    jtag: bool = True
