"""The options of a frame that begins before the camera's is complete."""

from ncdc.cli.renamed import add_renamed
from ncdc.terminal import Progress
from ncdc_hdl.corrector import Corrector
from ncdc_model.planner.follow import camera_line, follow_bound
from ncdc_spec.errors import InputError

__all__ = ["add_follow", "bound_of", "follow_strip"]


def add_follow(parser):
    """Declare the options."""
    parser.add_argument("--follow", action="store_true",
                        help="begin with the camera's frame, and wait for its rows; raster order "
                             "unless --strip is given")
    parser.add_argument("--line-clocks", type=int, metavar="CLOCKS",
                        help="clocks of a row of the camera with --follow, of which it sends a "
                             "sample in each of the first ones (default: its samples)")
    add_renamed(parser, "--camera-line", "--line-clocks", type=int)


def follow_strip(args, geometry):
    """Columns of the strips where --strip is not given: 0 with --follow, else None for the planner.

    A strip needs nearly all rows of the raw frame at once, so it cannot follow the camera.

    Raises
    ------
    InputError
        If a row of the camera does not fit, or is given without --follow.
    """
    if args.line_clocks is not None and not args.follow:
        raise InputError(f"the camera's line is {args.line_clocks} clocks, which needs --follow")
    if not args.follow:
        return None
    camera_line(args.line_clocks, geometry)
    return 0


def bound_of(args, descriptor, hardware, memory, view=None):
    """The planner's bound for a frame that follows the camera, of a view if there is one; None
    without --follow."""
    if not args.follow:
        return None
    return follow_bound(descriptor, hardware, memory, Corrector(descriptor, hardware).timing,
                        camera=args.line_clocks, view=view, progress=Progress("following"))
