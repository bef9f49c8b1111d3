"""The matrix of a view as an option."""

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.view import View

__all__ = ["add_matrix", "matrix_view"]


def add_matrix(parser):
    """Declare the option --matrix."""
    parser.add_argument("--matrix", type=float, nargs=9, metavar="H",
                        help="show a view: the matrix, row by row, from its pixels to those of the "
                             "trained picture; the hardware then has --view")


def matrix_view(args, geometry):
    """The :class:`View` of --matrix, of the trained picture's size; None without it."""
    if args.matrix is None:
        return None
    if not np.isfinite(args.matrix).all():
        raise InputError(f"--matrix is {' '.join(f'{h:g}' for h in args.matrix)}, nine finite "
                         f"numbers are needed")
    return View.of(np.reshape(args.matrix, (3, 3)), geometry.corrected)
