"""The boards that are installed, found through the entry points of the group ``ncdc.boards``."""

from importlib.metadata import entry_points

from ncdc_spec.errors import InputError

__all__ = ["GROUP", "board", "board_names"]

GROUP = "ncdc.boards"


def board_names():
    """Names of all boards, sorted."""
    return sorted({point.name for point in entry_points(group=GROUP)})


def board(name):
    """The board called ``name``.

    The result is a :class:`~ncdc_boards.board.Board`, for ``ncdc build``, or a
    :class:`~ncdc_boards.platform_designer.board.DesignerBoard`, for ``ncdc generate``.

    Raises
    ------
    InputError
        If no installed package offers it.
    """
    for point in entry_points(group=GROUP):
        if point.name == name:
            return point.load()
    raise InputError(f"board is {name!r}, one of {', '.join(board_names())} is needed")
