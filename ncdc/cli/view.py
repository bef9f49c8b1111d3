"""The view of a simulated frame: its matrix, or its angles."""

import numpy as np

from ncdc.cli.view_angles import add_stabilisation, add_view, view_of
from ncdc_spec.errors import InputError
from ncdc_spec.view import View
from ncdc_spec.view_rows import MAX_MATRICES

__all__ = ["add_simulated_view", "simulated_view"]


def add_simulated_view(parser):
    """Declare the options --matrix, and those of :mod:`ncdc.cli.view_angles`."""
    parser.add_argument("--matrix", type=float, nargs=9, metavar="H",
                        help="show a view: the matrix, row by row, from its pixels to those of the "
                             "trained picture; the hardware then has --view, as with angles")
    add_view(parser)
    add_stabilisation(parser)


def simulated_view(args, descriptor):
    """The :class:`View` of the options; None without them.

    That of --matrix has the trained picture's size.
    """
    chosen = view_of(args, descriptor)
    if args.matrix is None:
        return chosen.at(matrices=args.view_rows or MAX_MATRICES) if chosen else None
    if chosen:
        raise InputError("--matrix is given together with angles or a size of a view")
    if not np.isfinite(args.matrix).all():
        raise InputError(f"--matrix is {' '.join(f'{h:g}' for h in args.matrix)}, nine finite "
                         f"numbers are needed")
    return View.of(np.reshape(args.matrix, (3, 3)), descriptor.geometry.corrected)
