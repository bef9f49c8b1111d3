"""A table of matrices down the raw frame, for a rolling shutter: what is added to a view's matrix.

Matrix k belongs to the raw row k * step. Between these rows the numbers are linear.
"""

from dataclasses import dataclass

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.view import VIEW_REGISTERS, View, rounded_matrix, scale_of

__all__ = ["MAX_MATRICES", "MIN_MATRICES", "NUMBER_BITS", "ROWS_BANK", "ROWS_COUNT",
           "ROWS_REGISTERS", "ROWS_STATUS", "ROWS_STEP", "ROWS_TABLE", "ROW_BITS", "ROW_FORMATS",
           "ROW_SHIFT", "RowTable", "SETTLING", "SHARE_BITS", "STEPS", "STEP_SHIFT", "row_view",
           "rows_values", "rows_words"]

MIN_MATRICES, MAX_MATRICES = 2, 64
"""Matrices that a table of the hardware can have."""

STEPS = 8, 16, 32, 64
"""Raw rows from matrix to matrix."""

_POSITION, _POSITION_STEP = Q(12, 15), Q(2, 25)
_DEPTH, _DEPTH_STEP = Q(4, 23), Q(-6, 33)

ROW_FORMATS = ((_POSITION_STEP, _POSITION_STEP, _POSITION),
               (_POSITION_STEP, _POSITION_STEP, _POSITION), (_DEPTH_STEP, _DEPTH_STEP, _DEPTH))
"""Format of each element of a table's matrices: rows x, y and depth; columns u, v and 1."""

NUMBER_BITS = 27
"""Of each of these formats."""

STEP_SHIFT = 10
"""Lowest bits of the products with column and row that are cut off: origins have so many fewer."""

ROW_SHIFT = 12
"""Fraction bits of the sums X, Y and Z of a view above those of a table's sums."""

SHARE_BITS = 6
"""Fraction bits of a raw row in steps."""

ROW_BITS = 12
"""Of a raw row."""

SETTLING = 2
"""Times that the first row of a view is computed before it counts."""

ROWS_COUNT, ROWS_STEP, ROWS_BANK = ROWS_REGISTERS = (
    "VIEW_ROWS", "VIEW_ROWS_STEP", "VIEW_ROWS_BANK")
"""Registers of the set: matrices in use, number of the step in :data:`STEPS`, bank."""

ROWS_STATUS = "VIEW_ROWS_STATUS"
"""The register of the matrices that the hardware has space for, and of the bank in use."""

ROWS_TABLE = 1 << 12
"""Word address of the window on the table: + 1024 bank + 16 k + 4 row + column."""


@dataclass(frozen=True)
class RowTable:
    """Matrices that are added to that of a view, in the formats of the hardware.

    A raw row beyond the last matrix has the last one.

    Parameters
    ----------
    step : int
        Raw rows from matrix to matrix, one of :data:`STEPS`.
    matrices : tuple of tuple of 9 int
        Each row by row, raw in :data:`ROW_FORMATS`.

    Raises
    ------
    InputError
        If there is no such step, the number of matrices is beyond 1..64, or an element does not
        fit its format.
    """
    step: int
    matrices: tuple

    def __post_init__(self):
        if self.step not in STEPS:
            raise InputError(f"the step of the table of matrices is {self.step} rows, one of "
                             f"{', '.join(map(str, STEPS))} is needed")
        if not 1 <= len(self.matrices) <= MAX_MATRICES:
            raise InputError(f"the table has {len(self.matrices)} matrices, the limits are 1 and "
                             f"{MAX_MATRICES}")
        for k, matrix in enumerate(self.matrices):
            if len(matrix) != 9:
                raise InputError(f"matrix {k} of the table has {len(matrix)} elements, 9 are "
                                 f"needed")
            for name, q, raw in zip(VIEW_REGISTERS, _flat_formats(), matrix):
                if not q.holds(raw):
                    raise InputError(f"matrix {k} of the table has {raw} for {name}, the limits "
                                     f"of {q} are {q.lo} and {q.hi}")


def row_view(matrices, size, limit=MAX_MATRICES):
    """The :class:`View` with a table of real ``matrices``, shape (raw rows, 3, 3), one of each row.

    The matrix of the middle row is the view's, the table holds what the others differ by. The step
    is the smallest one whose table has ``limit`` matrices at most.

    Raises
    ------
    InputError
        If the frame needs more matrices, or :meth:`View.of` rejects one, or the matrices differ
        too much for their formats.
    """
    rows = len(matrices)
    step = next((step for step in STEPS if _needed(rows, step) <= limit), None)
    if step is None:
        raise InputError(f"the raw frame has {rows} rows, a table of {limit} matrices is for "
                         f"{STEPS[-1] * (limit - 1) + 1}")
    # Beyond the last row the last two go on.
    at = step * np.arange(_needed(rows, step))
    above = np.minimum(at, max(rows - 2, 0))
    rest = (at - above)[:, None, None]
    chosen = matrices[above] + rest * (matrices[np.minimum(above + 1, rows - 1)] - matrices[above])
    middle = matrices[rows // 2]
    scale = min(scale_of(matrix, size) for matrix in (middle, *chosen))
    base = View.scaled(middle, size, scale)
    return View(base.matrix, base.size, RowTable(step, tuple(
        rounded_matrix(scale * matrix - base.real, size, ROW_FORMATS) for matrix in chosen)))


def rows_values(table, bank=0):
    """Register values, by name, of a :class:`RowTable` in ``bank``; of none without a ``table``."""
    if table is None:
        return {ROWS_COUNT: 0, ROWS_STEP: 0, ROWS_BANK: bank}
    return {ROWS_COUNT: len(table.matrices), ROWS_STEP: STEPS.index(table.step), ROWS_BANK: bank}


def rows_words(table, bank=0):
    """(word address, value) of every number of a :class:`RowTable` in ``bank``."""
    return [(ROWS_TABLE + 1024 * bank + 16 * k + 4 * row + column, matrix[3 * row + column])
            for k, matrix in enumerate(table.matrices) for row in range(3) for column in range(3)]


def _needed(rows, step):
    """Matrices, ``step`` rows apart, of a frame."""
    return -(-(rows - 1) // step) + 1


def _flat_formats():
    return [q for row in ROW_FORMATS for q in row]
