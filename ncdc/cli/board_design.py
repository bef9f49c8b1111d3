"""Options of the commands that make or plan a board's design, and parts of their reports."""

from ncdc.cli.hardware import planned
from ncdc_model.planner.plan import Fixed

__all__ = ["add_mode", "planner", "print_rates", "settings_of"]


def add_mode(parser):
    """Declare the option --mode."""
    parser.add_argument("--mode", metavar="WxH[@20]",
                        help="video mode (default: the smallest that holds the picture); @20: of "
                             "20 frames per second")


def planner(fixed=Fixed(None, None, None), note=lambda line: None):
    """The planner for :meth:`ncdc_boards.board.WholeBoard.design`.

    Parameters
    ----------
    fixed : Fixed
        Settings of the tile cache that are fixed.
    note : callable
        Called with a line on the choice, or None if nothing was left open.
    """
    def plan(hardware, descriptor):
        hardware, line = planned(hardware, fixed, descriptor)
        note(line)
        return hardware
    return plan


def settings_of(args, *names):
    """Settings of a sensor that are given, by name: options whose default is None."""
    given = {name: getattr(args, name) for name in names}
    return {name: value for name, value in given.items() if value is not None}


def print_rates(report):
    """The rates of a report for people."""
    text = f"the sensor sends {report['sensor_frames_per_second']:.1f} frames per second"
    if "corrected_frames_per_second" in report:
        text += f", memory for {report['corrected_frames_per_second']:.1f} corrected ones"
    print(text)
