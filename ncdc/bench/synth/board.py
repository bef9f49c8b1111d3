"""What ``ncdc bench synth`` measures of whole boards: all but clocks and pins."""

from ncdc.cli.board_design import board_named
from ncdc_boards.camera_board.core import BoardCore
from ncdc_boards.camera_board.design import design_of, hardware_for, sensor_for
from ncdc_hdl.video.modes import mode_for

__all__ = ["board_core"]

_SENSOR = "mt9p031"


def board_core(name, descriptor):
    """The :class:`BoardCore` of board ``name``: one lens, the D5M's sensor, the smallest mode that
    holds the picture, a tile cache of 32 KB."""
    board, geometry = board_named(name), descriptor.geometry
    return BoardCore(design_of(board, [("lens", descriptor)], sensor_for(_SENSOR, geometry),
                               mode_for(*geometry.corrected), hardware=hardware_for(board)))
