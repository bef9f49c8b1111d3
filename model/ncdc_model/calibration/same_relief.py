"""Proof of relief: the same heights of the same page in photos from different positions."""

import numpy as np

__all__ = ["proven"]

_ALIKE = 0.8           # correlation of two photos' heights above which they show the same page
_LENS = 0.5            # times that: a larger correlation at equal pixels may come from the lens
_COMMON = 100          # points that both photos show


def proven(indices, points, heights):
    """Which of the photos show a relief that another photo, taken from elsewhere, shows too.

    The numbers of dots begin anew with each photo. So two photos' heights are compared at every
    shift and quarter turn. They show the same page if the largest correlation is 0.8 or more. A
    lens flaw would correlate as well, but at the same pixels of both pictures. So relief is proven
    only if the heights at equal pixels correlate much less.

    Parameters
    ----------
    indices, points, heights : sequence of ndarray
        Arrays (n, 2), (n, 2) in pixels and (n,) per photo; no points if it shows no relief.

    Returns
    -------
    ndarray of bool, shape (photos,)
    """
    shown = np.zeros(len(indices), bool)
    for one in range(len(indices)):
        for other in range(one + 1, len(indices)):
            if min(len(indices[one]), len(indices[other])) < _COMMON:
                continue
            page = _on_page(indices[one], heights[one], indices[other], heights[other])
            picture = _on_picture(points[one], heights[one], points[other], heights[other])
            if page >= _ALIKE and abs(picture) <= _LENS * page:
                shown[[one, other]] = True
    return shown


def _on_page(index, height, other_index, other_height):
    """Largest correlation of two photos' heights over all shifts and quarter turns."""
    best = -1.0
    for turn in (((1, 0), (0, 1)), ((0, 1), (-1, 0)), ((-1, 0), (0, -1)), ((0, -1), (1, 0))):
        first, there = _grid(index, height)
        second, seen = _grid(other_index @ np.array(turn), other_height)
        second, seen = second[::-1, ::-1], seen[::-1, ::-1]
        n = np.rint(_convolved(there, seen))
        enough = n >= max(_COMMON, 0.3 * min(there.sum(), seen.sum()))
        if not enough.any():
            continue
        n = np.where(enough, n, np.inf)
        a, b = _convolved(first, seen) / n, _convolved(there, second) / n
        product = _convolved(first, second) / n - a * b
        spread = ((_convolved(first**2, seen) / n - a * a)
                  * (_convolved(there, second**2) / n - b * b))
        best = max(best, float((product / np.sqrt(np.maximum(spread, 1e-12)))[enough].max()))
    return best


def _convolved(first, second):
    """Full convolution of two arrays of two axes."""
    shape = np.add(first.shape, second.shape) - 1
    return np.fft.irfft2(np.fft.rfft2(first, shape) * np.fft.rfft2(second, shape), shape)


def _on_picture(xy, height, other_xy, other_height):
    """Correlation of two photos' heights at equal positions in the picture."""
    from scipy.interpolate import griddata  # a third of a second that few photos need
    there = griddata(other_xy, other_height, xy)
    both = np.isfinite(there)
    if both.sum() < _COMMON:
        return 0.0
    return float(np.corrcoef(height[both], there[both])[0, 1])


def _grid(index, height):
    """Heights, normalised to mean 0 and standard deviation 1, and ones where there are points."""
    index = index - index.min(axis=0)
    values, there = np.zeros((2, *(index.max(axis=0) + 1)))
    values[tuple(index.T)] = (height - height.mean()) / max(height.std(), 1e-12)
    there[tuple(index.T)] = 1
    return values, there
