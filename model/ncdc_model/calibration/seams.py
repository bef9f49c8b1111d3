"""Tests each gap between the lines of a lattice for a step, as two sheets of paper make one."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.calibration.median import known_median
from ncdc_model.calibration.target_flatness import polynomial

__all__ = ["Seam", "find_seam", "seam_text", "steps"]

_SIDE = 4              # points on either side of a gap that are used
_MIN_POINTS = 3, 2     # of these that must exist; the second for lines of fewer than ten points
_SHORT = 10
_DEGREE = 5            # of the polynomial that removes most of the lens
_SLOPES = 21           # slopes of a seam that are tried, up to half a column per row
_LINES = 5             # lines that must show the step
_STEP = 0.6            # pixels, for a width of up to 1280: a smaller step moves no point by 0.5
_WIDTH = 1280
_SIGMAS = 8.0          # times the standard error of the median step
_ELSEWHERE = 2.5       # times the largest step of other gaps: bumps and waves have similar ones


@dataclass(frozen=True)
class Seam:
    """A step across a lattice.

    Parameters
    ----------
    axis : int
        0 for a gap between columns, 1 for one between rows.
    gap : int
        Column or row after which it lies, in the middle of the other axis.
    step : ndarray, shape (2,)
        Pixels by which the points after it are moved.
    ends : ndarray, shape (2, 2)
        Pixels of its first and last position.
    """
    axis: int
    gap: int
    step: np.ndarray
    ends: np.ndarray


def steps(index, xy, axis):
    """Step (gaps, lines, 2) in pixels across each gap along ``axis``, and its gain (gaps, lines).

    One cubic and a step in the gap are fitted to up to four points on either side along each line;
    with fewer than seven points, one parabola. The gain is the variance of the step over that of a
    point; not-a-number where the points are too few.
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
    minimum = _MIN_POINTS[grid.shape[0] < _SHORT]
    enough = ((there[..., :_SIDE].sum(axis=2) >= minimum)
              & (there[..., _SIDE:].sum(axis=2) >= minimum))
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


def find_seam(index, xy, rest, width=0):
    """The :class:`Seam` of the points ``index`` (n, 2), ``xy`` (n, 2) of a lattice, or None.

    ``rest`` (n, 2): their residuals from a smooth lens, in pixels.

    The steps of all lines, or of half of the lines, agree in one gap, which may be oblique, and
    not elsewhere: their median is much larger than its standard error and than the medians of the
    other gaps. A bump of the lens affects few lines, a wave of the page several gaps. ``width``:
    of the photo; the minimum step is larger in proportion above 1280.
    """
    origin = index.min(axis=0)
    index = index - origin
    rest, best = rest - _smooth(index, rest), None
    fields = [steps(index, rest, axis) for axis in (0, 1)]
    # A seam is across one axis only; the other gives the scatter of the points.
    sigma = min((_scatter(*field) for field in fields if np.isfinite(field[1]).any()), default=0.0)
    minimum = _STEP * max(1.0, width / _WIDTH)
    for axis, (step, gain) in enumerate(fields):
        # No median is larger than the largest of all steps.
        largest = np.abs(step[np.isfinite(gain)]).max(axis=0, initial=0.0)
        if step.shape[1] >= _LINES and np.hypot(*largest) >= minimum:
            found = _largest(step, gain, sigma, minimum)
            if found and (best is None or found[0] > best[0]):
                best = (*found, axis)
    if best is None or best[0] < 1:
        return None
    _, gap, slope, size, axis = best
    middle = (np.ptp(index, axis=0)[1 - axis]) / 2
    near = np.abs(index[:, axis] - 0.5 - gap - slope * (index[:, 1 - axis] - middle)) <= 1
    line = index[near, 1 - axis]
    ends = np.array([xy[near][line == end].mean(axis=0) for end in (line.min(), line.max())])
    return Seam(axis, gap + int(origin[axis]), size, ends)


def seam_text(seam):
    """One sentence about a :class:`Seam`."""
    (left, top), (right, bottom) = seam.ends
    line, side = (("column", "right of"), ("row", "below"))[seam.axis]
    return (f"the points {side} {line} {seam.gap}, from ({left:.0f}, {top:.0f}) to ({right:.0f}, "
            f"{bottom:.0f}), are moved by ({seam.step[0]:.1f}, {seam.step[1]:.1f}) px from where "
            f"the others predict them: a step, which no lens makes; the target may be of two "
            f"sheets, or folded")


def _smooth(index, xy):
    """Positions (n, 2) by a polynomial in column and row."""
    degree = min(_DEGREE, *np.ptp(index, axis=0))
    basis = polynomial(index, degree)
    return basis @ np.linalg.lstsq(basis, xy, rcond=1e-9)[0]


def _scatter(step, gain):
    """Standard deviation of a point, estimated from the scatter of all ``step``."""
    off = np.abs(step - np.nanmedian(step, axis=(0, 1))) / np.sqrt(gain)[..., None]
    return float(1.4826 * np.nanmedian(off))


def _largest(step, gain, sigma, minimum):
    """Score, gap, slope and size of the most certain step; a score of 1 is the limit. None if no
    gap has enough lines."""
    gaps, lines = step.shape[:2]
    best = None
    for part in (slice(0, lines), slice(0, lines // 2), slice(lines // 2, lines)):
        row = np.arange(lines)[part]
        for slope in np.linspace(-0.5, 0.5, _SLOPES):
            gap = np.rint(np.arange(gaps)[:, None] + slope * (row - (lines - 1) / 2)).astype(int)
            inside, at = (gap >= 0) & (gap < gaps), (np.clip(gap, 0, gaps - 1), row)
            seen = np.where(inside[..., None], step[at], np.nan)
            count = np.isfinite(seen[..., 0]).sum(axis=1)
            enough = count >= max(_LINES, 0.6 * len(row))
            if not enough.any():
                continue
            found = np.zeros((gaps, 2))
            found[enough] = known_median(seen[enough])
            size = np.maximum(np.linalg.norm(found, axis=1), 1e-9)
            k = int(size.argmax())
            far = np.abs(np.arange(gaps) - k)
            rivals = np.where(far > _SIDE, size, np.where(far > 2, -found @ found[k] / size[k], 0))
            spread, uneven = (known_median(values[None])[0] for values in (
                np.where(inside[k], gain[at[0][k], row], np.nan),
                np.linalg.norm(seen[k] - found[k], axis=1)))
            error = 1.25 * max(sigma * np.sqrt(spread), 1.4826 * uneven) / np.sqrt(count[k])
            certain = size[k] / max(minimum, _SIGMAS * error)
            if best is None or certain > best[0]:
                best = certain, k, slope, found[k], _ELSEWHERE * rivals.max(initial=0.0)
    if best is None:
        return None
    certain, *found, elsewhere = best
    return min(certain, float(np.linalg.norm(found[2])) / max(elsewhere, 1e-9)), *found


def _grid(index, xy):
    grid = np.full((*(index.max(axis=0) + 1), 2), np.nan)
    grid[tuple(index.T)] = xy
    return grid
