"""Options of the commands that make or plan a board's design, and the design that they ask for."""

from ncdc.cli.hardware import planned
from ncdc_boards.board import Board
from ncdc_boards.camera_board.budget import check_lanes, check_memory
from ncdc_boards.camera_board.design import design_of, hardware_for, sensor_for
from ncdc_boards.catalogue import board as board_of
from ncdc_boards.hps_board.board import HpsBoard
from ncdc_boards.hps_board.ports import DATA_WIDTH
from ncdc_hdl.video.modes import mode_for, mode_named
from ncdc_model.planner.plan import Fixed
from ncdc_spec.errors import InputError
from ncdc_spec.sensors.field import FULL

__all__ = ["add_mode", "board_named", "designed", "print_rates", "rates"]

_BAYER_SENSOR = "mt9p031"


def add_mode(parser):
    """Declare the option --mode."""
    parser.add_argument("--mode", metavar="WxH[@20]",
                        help="video mode (default: the smallest that holds the picture); @20: of "
                             "20 frames per second")


def board_named(name):
    """A board with a camera; InputError if it is none."""
    board = board_of(name)
    if isinstance(board, HpsBoard):
        raise InputError(f"the memory of the {name} is its processor's: ncdc plan --memory hps "
                         f"--data-width {DATA_WIDTH}")
    if not isinstance(board, Board):
        raise InputError(f"the board {name} has no design of ours, its project for Platform "
                         f"Designer is made by ncdc generate --board {name}")
    return board


def designed(board, named, *, sensor=None, mode=None, fixed=Fixed(None, None, None), hardware=None,
             settings=None, processor=False):
    """A board's design, its sensor and crop, the memory's budget, a line on the tile cache.

    Parameters
    ----------
    board : Board
    named : sequence of (path, Descriptor)
    sensor, mode : str, optional
        Names. Defaults: the D5M's sensor, and the smallest mode that holds the picture.
    fixed : Fixed
        Settings of the tile cache that are fixed.
    hardware : Hardware, optional
        As of :func:`hardware_for`, its default.
    settings : dict, optional
        ``exposure_us``, ``pixel_clock_hz`` and ``field`` of the sensor. Defaults: 10 ms, its clock
        undivided, the largest field that fits.
    processor : bool
        With a processor and Ethernet; a board without a screen always is.

    Raises
    ------
    InputError
        If a mode is given without a screen. If the picture does not fit the mode, the mode does not
        fit the board, or the frames do not fit the memory.
    """
    geometry = named[0][1].geometry
    wanted = _mode(board, geometry, mode)
    # The clocks first: they are checked at once, and planning takes seconds.
    board.clock_plan(wanted, board.core_mhz)
    sensor_crop = sensor_for(sensor or _BAYER_SENSOR, geometry,
                        **{"exposure_us": 10_000.0, "field": FULL} | (settings or {}))
    hardware = hardware or hardware_for(board)
    check_lanes(board, hardware_for(board), hardware.lanes)
    hardware, line = planned(hardware, fixed, named[0][1])
    design = design_of(board, named, sensor_crop, wanted, hardware=hardware,
                       processor=processor or not board.screen)
    return design, sensor_crop, check_memory(design, sensor_crop[0]), line


def _mode(board, geometry, name):
    """The video mode of a design; None if the board has no screen."""
    if not board.screen:
        if name:
            raise InputError(f"the mode {name} is asked for, the board {board.name} has no screen")
        return None
    smallest = mode_for(*geometry.corrected)
    wanted = mode_named(name) if name else smallest
    if not wanted.holds(*geometry.corrected):
        raise InputError(f"the picture has {geometry.corrected_width}x"
                         f"{geometry.corrected_height} pixels, the mode {name} does not hold "
                         f"it: {smallest.name} does")
    return wanted


def rates(budget):
    """Rates of memory and sensor, by name."""
    return {"memory_mb_per_second": budget.carried / 1e6,
            "screen_mb_per_second": budget.screen / 1e6,
            "sensor_frames_per_second": budget.frames_per_second,
            "corrected_frames_per_second": budget.corrected_per_second}


def print_rates(report):
    """:func:`rates` for people."""
    print(f"the sensor sends {report['sensor_frames_per_second']:.1f} frames per second, memory "
          f"for {report['corrected_frames_per_second']:.1f} corrected ones")
