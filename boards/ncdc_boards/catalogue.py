"""The boards that are installed, found through the entry points of the group ``ncdc.boards``."""

from importlib.metadata import entry_points

from ncdc_boards.board import Board
from ncdc_spec.errors import InputError

__all__ = ["GROUP", "board", "board_for", "board_names"]

GROUP = "ncdc.boards"


def board_names():
    """Names of all boards, sorted."""
    return sorted({point.name for point in entry_points(group=GROUP)})


def board(name) -> Board:
    """The :class:`~ncdc_boards.board.Board` called ``name``.

    Raises
    ------
    InputError
        If no installed package offers it.
    """
    for point in entry_points(group=GROUP):
        if point.name == name:
            return point.load()
    raise InputError(f"board is {name!r}, one of {', '.join(board_names())} is needed")


def board_for(command, name):
    """The board called ``name``, if a command takes it: for build a
    :class:`~ncdc_boards.board.WholeBoard`, for plan a :class:`~ncdc_boards.board.PlannedBoard`,
    for generate a :class:`~ncdc_boards.board.CorrectorBoard`.

    Raises
    ------
    InputError
        If no installed package offers it, or it is for other commands.
    """
    found = board(name)
    if command not in found.commands:
        raise InputError(f"the board {name} {found.elsewhere}")
    return found
