"""Cameras of Scaramuzza's OCamCalib toolbox: calib_results.txt, and ocam_model in a .mat."""

import re

import numpy as np

from ncdc_model.calibration.files.lens import file_lens, matrix_of, numbers, whole
from ncdc_spec.errors import InputError

__all__ = ["is_ocam", "ocam_lens", "ocam_struct_lens"]

_STEPS = 4096          # of the table from which Newton's method starts
_AGREE = .1            # pixels: difference of the two polynomials that is warned of
_MOST = 64             # coefficients, as in the toolbox's C code
_WRONG = 5.0           # pixels: difference at which one of them must be wrong


def is_ocam(text):
    """Whether ``text`` is a calib_results.txt."""
    return re.match(r"(?i)\s*#\s*polynomial coefficients for the direct mapping", text) is not None


def ocam_lens(text):
    """:class:`FileLens` of a calib_results.txt.

    Its lines: the polynomial of the radius, the inverse polynomial of the angle (each after the
    number of its coefficients), row and column of the centre from 0, c d e, height and width.

    Raises
    ------
    InputError
        If a line is missing or of another length, or as of :func:`ocam_struct_lens`.
    ValueError
        If a value is no number.
    """
    lines = [line.split("#")[0].split() for line in text.splitlines()]
    lines = [[float(part) for part in line] for line in lines if line]
    if len(lines) != 5:
        raise InputError(f"it is an OCamCalib file with {len(lines)} lines of numbers, 5 are "
                         f"needed: two polynomials, centre, affine parameters, height and width")
    for line, name in zip(lines, ("polynomial", "inverse polynomial")):
        if len(line) > _MOST:
            raise InputError(f"the {name} has {len(line) - 1} coefficients, the limit is {_MOST}")
        if line[0] != len(line) - 1:
            raise InputError(f"the {name} has {len(line) - 1} coefficients, {line[0]:g} are stated")
    (_, *direct), (_, *inverse), centre, affine, size = lines
    return _lens(direct, inverse, centre, affine, size)


def ocam_struct_lens(table):
    """:class:`FileLens` of the struct ocam_model of a .mat, whose pixels count from 1.

    Raises
    ------
    InputError
        If a value is not finite, a list of another length, the first coefficient not negative, or
        the two polynomials differ by 5 pixels.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    inverse = table.get("pol", table.get("invpol"))
    return _lens(table["ss"], [] if inverse is None else np.ravel(inverse)[::-1],
                 [table["xc"] - 1, table["yc"] - 1], [table[name] for name in "cde"],
                 [table["height"], table["width"]])


def _lens(direct, inverse, centre, affine, size):
    direct = np.polynomial.Polynomial(numbers(direct, "polynomial"))
    row, column = numbers(centre, "centre", (2,))
    c, d, e = numbers(affine, "list c d e", (3,))
    height, width = numbers(size, "image size", (2,))
    size = whole(width, "width"), whole(height, "height")
    focal = -direct(0)
    if not focal > 0:
        raise InputError(f"the first coefficient of the polynomial is {-focal:g}, OCamCalib's is "
                         f"negative, as its cameras look along -z")
    reach = 1.2 * max(np.hypot(row - y, column - x) for y in (0, height) for x in (0, width))
    radius = _radius(direct, reach)

    def distortion(a, b):
        r = np.hypot(a, b)
        scale = np.where(r > 0, radius(np.arctan(r)) / np.where(r > 0, r, 1) / focal, 1)
        return scale * (a + e * b), scale * (c * b + d * a)
    return file_lens(size, matrix_of(focal, focal, column, row), distortion, "OCamCalib",
                     warnings=_compared(direct, numbers(inverse, "inverse polynomial"),
                                        min(size) / 2))


def _radius(direct, reach):
    """The function that gives the radius in pixels, up to ``reach``, of an angle off the axis."""
    slope = direct.deriv()
    radii = np.linspace(0, reach, _STEPS)
    angles = np.arctan2(radii, -direct(radii))
    falls = np.flatnonzero(~(np.diff(angles) > 0))
    end = falls[0] + 1 if len(falls) else len(radii)

    def radius(angle):
        rho = np.interp(angle, angles[:end], radii[:end], right=np.nan)
        for _ in range(2):      # Newton's method: the table is a 1e-4 of a pixel off
            z = -direct(rho)
            rho = rho - (np.arctan2(rho, z) - angle) * (rho**2 + z**2) / (z + rho * slope(rho))
        return rho
    return radius


def _compared(direct, inverse, reach):
    """Warnings of how far the ``inverse`` polynomial is off the ``direct`` one, up to ``reach``."""
    if not len(inverse):
        return ()
    radii = np.linspace(reach / 100, reach, 100)
    again = np.polynomial.Polynomial(inverse)(np.arctan(direct(radii) / radii))
    off = float(np.abs(again - radii).max())
    if off > _WRONG:
        raise InputError(f"the two polynomials differ by {off:.3g} px, {_WRONG:g} px are the "
                         f"limit: they are not of the same camera")
    return (f"the two polynomials differ by {off:.2f} px, the direct one is taken",) * (
        off > _AGREE)
