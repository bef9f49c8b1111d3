"""A view: a matrix from the pixels of a picture to the plane of the trained corrected picture."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.geometry import MAX_SIZE, MIN_SIZE
from ncdc_spec.nodes import AFTER, BEFORE, NODES

__all__ = ["CAMERA_FORMATS", "COLUMN", "DEPTH_SHIFTS", "FORMATS", "MAX_DEPTH", "MIN_DEPTH",
           "NAMES", "NODE", "NUMERATOR", "PLANE", "PLANE_HEIGHT", "SUM_BITS", "VIEW_REGISTERS",
           "View", "check_view_nodes", "outer_columns", "rounded_matrix", "scale_of",
           "view_values"]

_POSITION, _POSITION_STEP = Q(15, 17), Q(5, 27)
_DEPTH, _DEPTH_STEP = Q(2, 30), Q(-3, 35)

FORMATS = ((_POSITION_STEP, _POSITION_STEP, _POSITION), (_POSITION_STEP, _POSITION_STEP, _POSITION),
           (_DEPTH_STEP, _DEPTH_STEP, _DEPTH))
"""Format of each element of a matrix: rows x, y and depth; columns u, v and 1."""

NAMES = tuple(tuple(f"VIEW_{row}_{column}" for column in "UV0") for row in "XYZ")
"""The register of each element of a matrix."""

PLANE_HEIGHT = "PLANE_HEIGHT"
"""The register of the trained picture's rows."""

VIEW_REGISTERS = tuple(name for row in NAMES for name in row)
"""Those registers in the order of :attr:`View.matrix`."""

CAMERA_FORMATS = {"PLANE_FOCAL": Q(16, 16), "PLANE_CENTRE_X": _POSITION,
                  "PLANE_CENTRE_Y": _POSITION, "PLANE_ASPECT": _DEPTH}
"""Registers of the camera of the trained picture, and their formats."""

DEPTH_SHIFTS = 7
"""Depths of nodes are from 2**-7 to below 2; others have no source."""

SUM_BITS = 46
"""Of X, Y and Z at any node of any matrix, in the fraction bits of their steps.

Steps end at 2**31, and a node is at most 4160 columns and 4095 rows from the origin.
"""

NUMERATOR = Q(15, 12)
"""Of X and Y, shifted like a depth that is shifted to 1..2."""

PLANE = Q(14, 13)
"""Of positions in the trained picture at nodes, in pixels."""

NODE, COLUMN = Q(14, 6), Q(14, 0)
"""Of positions at nodes and between them, where they select a valid span."""

MAX_DEPTH = 2 - 2.0**-20
"""Of a view in its formats, at every node of its picture."""

MIN_DEPTH = 1 / 8
"""Of its deepest node, at least: steps stay precise."""

_DEPTHS = 1e-18, 1e18   # of a real matrix: zero, or beyond all use, is a mistake


@dataclass(frozen=True)
class View:
    """The matrix of a view in the formats of its registers, and the size of its picture.

    With the real matrix H, the pixel (u, v) of the view is at (x, y) of the trained picture,
    in pixels::

        (X, Y, Z) = H (u, v, 1)        x = X / Z        y = Y / Z

    The depth Z is positive in front of the camera. A positive factor of all elements changes
    nothing, so that fixed-point formats suffice: :meth:`of` chooses the factor.

    Parameters
    ----------
    matrix : tuple of 9 int
        Row by row, raw in :data:`FORMATS`.
    size : (int, int)
        Width and height of the view's picture in pixels.
    rows : RowTable, optional
        Of a rolling shutter, see :mod:`ncdc_spec.view_rows`.

    Raises
    ------
    InputError
        If an element does not fit its format, or the size is beyond 8..4096.
    """
    matrix: tuple
    size: tuple
    rows: object = None

    def __post_init__(self):
        for name, value in zip(("width", "height"), self.size):
            if not MIN_SIZE <= value <= MAX_SIZE:
                raise InputError(f"the view's {name} is {value}, the limits are {MIN_SIZE} and "
                                 f"{MAX_SIZE}")
        if len(self.matrix) != 9:
            raise InputError(f"the view's matrix has {len(self.matrix)} elements, 9 are needed")
        for name, q, raw in zip(VIEW_REGISTERS, _flat_formats(), self.matrix):
            if not q.holds(raw):
                raise InputError(f"{name} is {raw}, the limits of {q} are {q.lo} and {q.hi}")

    @classmethod
    def identity(cls, size):
        """The view that is the trained picture itself: the hardware gives the same bits."""
        return cls.of(np.eye(3), size)

    @classmethod
    def of(cls, matrix, size):
        """The view of a real ``matrix``, shape (3, 3), rounded to the formats of the registers.

        All elements are multiplied by the largest power of two with which they fit, and with which
        the depth stays below 2 at every node of the picture. The rounding errors of the
        steps cancel in the middle of the picture.

        Raises
        ------
        InputError
            If an element is not finite, the size or the largest depth is beyond its limits, or an
            element is too large for its format at that depth.
        """
        matrix = np.asarray(matrix, np.float64)
        return cls.scaled(matrix, size, scale_of(matrix, size))

    @classmethod
    def scaled(cls, matrix, size, scale):
        """As :meth:`of`, with the factor ``scale`` of all elements."""
        return cls(rounded_matrix(matrix * scale, size), tuple(map(int, size)))

    def geometry(self, trained):
        """The :class:`Geometry` ``trained`` with the size of the view's picture."""
        return replace(trained, corrected_width=self.size[0], corrected_height=self.size[1])

    @property
    def real(self):
        """The matrix that the integers stand for, shape (3, 3), float64."""
        return np.reshape([float(q.real(raw)) for q, raw in zip(_flat_formats(), self.matrix)],
                          (3, 3))


def scale_of(matrix, size):
    """The largest power of two by which a real ``matrix``, shape (3, 3), fits the registers.

    See :meth:`View.of`, whose errors it raises.
    """
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
        raise InputError(f"the view's matrix is {matrix.tolist()}, 3x3 finite numbers are "
                         f"needed")
    limits = np.array([[q.real(q.hi) for q in row] for row in FORMATS])
    # Scaled by a power of two, which changes no bit: else two terms could overflow to infinities of
    # both signs, in an order that depends on the processor.
    exponent = np.frexp(np.abs(matrix[2]).max())[1]
    with np.errstate(over="ignore"):
        depth = np.ldexp(np.abs(_depths(np.ldexp(matrix, -exponent), size)).max(), exponent)
    if not _DEPTHS[0] <= depth <= _DEPTHS[1]:
        raise InputError(f"the largest depth of the view's matrix is {depth:g}, the limits are "
                         f"{_DEPTHS[0]:g} and {_DEPTHS[1]:g}")
    with np.errstate(divide="ignore", over="ignore"):
        ratios = limits / np.abs(matrix)
    ratio = min(ratios.min(), MAX_DEPTH / depth)
    if ratio * depth < MIN_DEPTH:
        row, column = np.unravel_index(ratios.argmin(), (3, 3))
        raise InputError(f"the view's matrix has {matrix[row, column]:g} in row {row}, column "
                         f"{column}, the limit is {limits[row, column] / MIN_DEPTH:g} times "
                         f"its largest depth of {depth:g}")
    return 2.0**np.floor(np.log2(ratio))


def _flat_formats():
    return [q for row in FORMATS for q in row]


def _depths(matrix, size):
    """Depths at the outermost nodes of a picture of ``size``, between which all others are."""
    return np.array([matrix[2] @ (u, v, 1) for u in outer_columns(size[0])
                     for v in (0, size[1] - 1)])


def outer_columns(width):
    """Columns of the outermost nodes of a picture of that ``width``, at any distance of nodes."""
    return -BEFORE * max(NODES), width + AFTER * max(NODES)


def rounded_matrix(matrix, size, formats=FORMATS):
    """Raw elements of ``matrix`` in ``formats``, by default those of the registers.

    What the steps miss in the middle of a picture of ``size`` is added to the origins.
    """
    middle = np.array([(value - 1) // 2 for value in size])
    raw = []
    for own, row in zip(formats, matrix):
        steps = [int(q.quantise(value)) for q, value in zip(own, row[:2])]
        missed = sum((value - q.real(step)) * at
                     for q, value, step, at in zip(own, row[:2], steps, middle))
        raw += [*steps, int(own[2].quantise(row[2] + missed))]
    return tuple(raw)


def check_view_nodes(nodes):
    """Raise :class:`InputError` unless a network at every ``nodes``-th pixel can have a view."""
    if nodes == 1:
        raise InputError("the network is evaluated at every pixel, a view needs nodes, which "
                         "ncdc train --nodes 8, 16 or 32 gives")


def view_values(view, plane_height):
    """Register values, by name, of a ``view`` of a lens whose trained picture has
    ``plane_height`` rows."""
    return {**dict(zip(VIEW_REGISTERS, view.matrix)),
            PLANE_HEIGHT: plane_height}
