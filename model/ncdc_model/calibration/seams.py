"""Tests each gap between the lines of a lattice for a step: no lens makes one, two sheets do."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.calibration.relief import polynomial

__all__ = ["Seam", "find_seam"]

_SIDE = 4              # points on either side of a gap that are looked at
_LEAST = 2             # of them that must be there
_DEGREE = 5            # of the polynomial that takes off most of the lens
_SLOPES = 21           # ways that a seam may lie across the lines, at most half a column per row
_LINES = 5             # lines that must show the step
_STEP = 0.4            # pixels: a smaller step moves no point by more than 0.2
_SIGMAS = 7.0          # times the standard error of the median step
_ELSEWHERE = 4.0       # times what is usual of the other gaps: bumps of the lens


@dataclass(frozen=True)
class Seam:
    """A step across a lattice.

    Parameters
    ----------
    axis : int
        0 for a gap between columns, 1 for one between rows.
    gap : float
        Column or row, with a half, in the middle of the other axis.
    step : ndarray, shape (2,)
        Pixels by which what lies beyond is moved.
    ends : ndarray, shape (2, 2)
        Pixels of the first and last place of it that was looked at.
    """
    axis: int
    gap: float
    step: np.ndarray
    ends: np.ndarray


def steps(index, xy, axis):
    """Step (gaps, lines, 2) in pixels across each gap along ``axis``, and its gain (gaps, lines).

    Along each line one cubic is fitted to up to four points on either side, together with a step
    in the gap; a parabola where there are fewer than seven points. The gain is the variance of the
    step over that of a point; not-a-number where too few points are.
    """
    grid = _grid(index, xy)
    if axis:
        grid = grid.swapaxes(0, 1)
    wide = np.full((grid.shape[0] + 2 * _SIDE, *grid.shape[1:]), np.nan)
    wide[_SIDE:-_SIDE] = grid
    count = grid.shape[0] - 1
    window = np.stack([wide[1 + k:1 + k + count] for k in range(2 * _SIDE)], axis=2)
    there = np.isfinite(window[..., 0])
    offset = np.arange(2 * _SIDE) - _SIDE + 0.5
    terms = np.stack([offset > 0, offset**0, offset, offset**2, offset**3], axis=1).astype(float)
    enough = (there[..., :_SIDE].sum(axis=2) >= _LEAST) & (there[..., _SIDE:].sum(axis=2) >= _LEAST)
    number = there.sum(axis=2)
    step, gain = np.full((*number.shape, 2), np.nan), np.full(number.shape, np.nan)
    for parts, which in ((5, enough & (number >= 7)), (4, enough & (number >= 5) & (number < 7))):
        weight = there[which].astype(float)
        basis = terms[:, :parts]
        square = np.einsum("nk,ki,kj->nij", weight, basis, basis)
        good = np.linalg.cond(square) < 1e8
        inverse = np.linalg.inv(square[good])[:, 0] if good.any() else np.zeros((0, parts))
        values = np.nan_to_num(window[which][good])
        mixed = np.einsum("nk,ki,nkd->nid", weight[good], basis, values)
        at = tuple(part[good] for part in np.nonzero(which))
        step[at] = np.einsum("ni,nid->nd", inverse, mixed)
        gain[at] = inverse[:, 0]
    return step, gain


def find_seam(index, xy):
    """The :class:`Seam` of the points ``index`` (n, 2), ``xy`` (n, 2) of a lattice, or None.

    The steps of all lines across one gap, which may lie askew, or of half of the lines, agree there
    and not elsewhere: the median of both coordinates is far larger than its standard error, and
    than that of gaps away from it. A bump of the lens shows in few lines.
    """
    index = index - index.min(axis=0)
    rest = xy - _smooth(index, xy)
    seams = [seam for seam in (_along(index, xy, rest, axis) for axis in (0, 1)) if seam]
    return max(seams, key=lambda pair: pair[0])[1] if seams else None


def _smooth(index, xy):
    """Places (n, 2) by a polynomial in column and row."""
    degree = min(_DEGREE, *np.ptp(index, axis=0))
    basis = polynomial(index, degree)
    return basis @ np.linalg.lstsq(basis, xy, rcond=1e-9)[0]


def _along(index, xy, rest, axis):
    step, gain = steps(index, rest, axis)
    if not np.isfinite(gain).any() or step.shape[1] < _LINES:
        return None
    usual = np.nanmedian(np.abs(step - np.nanmedian(step, axis=(0, 1))) / np.sqrt(gain)[..., None])
    sigma = 1.4826 * usual
    gaps, lines = step.shape[:2]
    middle = (lines - 1) / 2
    best = None
    for part in (slice(0, lines), slice(0, lines // 2), slice(lines // 2, lines)):
        for slope in np.linspace(-0.5, 0.5, _SLOPES):
            row = np.arange(lines)[part]
            gap = np.rint(np.arange(gaps)[:, None] + slope * (row - middle)).astype(int)
            inside = (gap >= 0) & (gap < gaps)
            seen = np.where(inside[..., None], step[np.clip(gap, 0, gaps - 1), row], np.nan)
            count = np.isfinite(seen[..., 0]).sum(axis=1)
            enough = count >= max(_LINES, 0.6 * len(row))
            if not enough.any():
                continue
            found = np.zeros((gaps, 2))
            found[enough] = np.nanmedian(seen[enough], axis=1)
            size = np.linalg.norm(found, axis=1)
            k = int(size.argmax())
            away = enough & (np.abs(np.arange(gaps) - k) > _SIDE)
            floor = np.median(size[away]) if away.any() else 0.0
            spread = np.sqrt(np.nanmedian(np.where(inside, gain[np.clip(gap, 0, gaps - 1), row],
                                                   np.nan)[k]))
            error = 1.25 * sigma * spread / np.sqrt(count[k])
            score = size[k] / max(_STEP, _SIGMAS * error, _ELSEWHERE * floor)
            if best is None or score > best[0]:
                best = score, k, slope, part, found[k], size[k], floor, error
    return best


def _grid(index, xy):
    grid = np.full((*(index.max(axis=0) + 1), 2), np.nan)
    grid[tuple(index.T)] = xy
    return grid
