"""The border of a region of a picture."""

import numpy as np

__all__ = ["border_mask", "border_pixels"]


def border_mask(mask):
    """Pixels of ``mask`` (height, width) without a neighbour in it on one of four sides."""
    padded = np.pad(mask, 1)
    return mask & ~(padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:])


def border_pixels(mask, most):
    """Rows and columns of at most so many pixels of the border, spread evenly along it."""
    rows, columns = np.nonzero(border_mask(mask))
    some = np.linspace(0, len(rows) - 1, min(most, len(rows))).astype(int)
    return rows[some], columns[some]
