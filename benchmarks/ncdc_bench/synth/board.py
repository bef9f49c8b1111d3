"""Whole boards for ``ncdc bench synth``, without clocks and pins."""

from dataclasses import replace

from ncdc_boards.camera_board.core import BoardCore
from ncdc_boards.camera_board.design import design_of, hardware_for, sensor_for
from ncdc_boards.catalogue import board_for
from ncdc_hdl.video.modes import mode_for
from ncdc_spec.cache_options import CacheOptions

__all__ = ["board_core"]

_SENSOR = "mt9p031"
_CACHE_BYTES = 32 << 10


def board_core(name, descriptor):
    """The :class:`BoardCore` of board ``name``: one lens, the D5M's sensor, the smallest mode that
    holds the picture, a tile cache of 32 KB."""
    board, geometry = board_for("plan", name), descriptor.geometry
    hardware = replace(hardware_for(board),
                       cache=CacheOptions.of_bytes(_CACHE_BYTES, geometry.interpolation))
    return BoardCore(design_of(board, [("lens", descriptor)], sensor_for(_SENSOR, geometry),
                               mode_for(*geometry.corrected), hardware=hardware))
