"""Centres of dots that the picture's border cuts, from the visible part."""

import cv2
import numpy as np

from ncdc_model.calibration.blobs import flat_field
from ncdc_model.calibration.sampling import sample

__all__ = ["recover_cut_dots"]

_MOVE = 0.35           # of a step: largest distance of a centre from its expected position
_LIKE = 0.70           # smallest correlation of a cut dot's picture with that of a whole one
_STEPS = 12            # Gauss-Newton iterations, at most
_DONE = 1e-3           # pixels


def recover_cut_dots(image, xy, index, area):
    """Dots next to the numbered ones that the border cuts but whose centre lies in the picture.

    The picture of a dot is nearly that of its neighbour further in. So the neighbour's picture,
    scaled as the lattice's steps change, is registered on the visible part of the cut dot by least
    squares, free in brightness and contrast. The position of the whole dot's centroid is then the
    cut dot's: it has the same bias as a whole dot's centroid. A centre outside the picture is not
    determined and not used.

    Parameters
    ----------
    image : ndarray of uint8
        As in :func:`ncdc_model.calibration.blobs.find_blobs`.
    xy, index, area : ndarray
        Whole dots, their (i, j) and areas.

    Returns
    -------
    xy, index, area : ndarray
        The recovered dots only; their indices continue the given ones, so they may be negative.
    """
    limit = np.array(image.shape[1::-1]) - 0.5
    flat, whole = None, {tuple(key): n for n, key in enumerate(index.tolist())}
    position = {key: xy[n] for key, n in whole.items()}
    found, front = {}, list(position)
    while front:
        reached = []
        for key, lines in _expected(position, front):
            starts = _starts(position, whole, area, lines)
            if not starts or not _may_be_cut(starts, limit):
                continue
            flat = flat_field(image) if flat is None else flat
            result = _centre(flat, starts)
            if result is None:
                continue
            centre, size = result
            apart = np.linalg.norm(np.array(list(position.values())) - centre, axis=1).min()
            if 0 <= _inside(centre, limit) < _reach(size) and apart > np.sqrt(size):
                position[key], found[key] = centre, size
                reached.append(key)
        front = reached
    keys = sorted(found)
    return (np.array([position[key] for key in keys]).reshape(-1, 2),
            np.array(keys, int).reshape(-1, 2), np.array([found[key] for key in keys]))


def _expected(position, front):
    """Missing neighbours of the dots ``front``, each with the lines of three that lead to it."""
    guesses = {}
    for i, j in front:
        for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            key = i + di, j + dj
            line = [(i - k * di, j - k * dj) for k in range(3)]
            if key not in position and all(other in position for other in line):
                guesses.setdefault(key, []).append(line)
    return sorted(guesses.items())


def _starts(position, whole, area, lines):
    """What each of the ``lines`` that leads to a dot says of it: the whole dot next to it, where it
    is expected, how far at most from there, the change of shape, and the area of the whole dot."""
    found = []
    for line in lines:
        first, second, third = (position[key] for key in line)
        if line[0] in whole:
            # The third difference along a line of four is zero, as that of a parabola.
            expected = 3 * first - 3 * second + third
            found.append((first, expected, _MOVE * np.linalg.norm(first - second),
                          _change(position, line, expected - first), area[whole[line[0]]]))
    return found


def _may_be_cut(starts, limit):
    """Whether a dot may have its centre in the picture, and be cut by the border."""
    middle, moved = (np.mean([start[k] for start in starts], axis=0) for k in (1, 2))
    inside = _inside(middle, limit)
    return inside + moved >= 0 and inside - moved < _reach(_size(starts))


def _inside(centre, limit):
    """Pixels from ``centre`` to the nearest border, negative outside."""
    return min(centre.min() + 0.5, (limit - centre).min())


def _size(starts):
    """Area of the cut dot, were it whole."""
    return float(np.mean([size * np.linalg.det(shape) for _, _, _, shape, size in starts]))


def _reach(size):
    """Pixels from the border within which the centre of a cut dot of area ``size`` lies."""
    return 1.5 * np.sqrt(max(size, 0) / np.pi) + 2


def _centre(flat, starts):
    """Centre and area of the cut dot that lines lead to, or None."""
    results = []
    for model, expected, moved, shape, size in starts:
        result = _register(flat, model, expected, shape, 1.7 * np.sqrt(size / np.pi) + 1)
        if result is None or np.linalg.norm(result - expected) > moved:
            return None
        results.append(result)
    return np.mean(results, axis=0), _size(starts)


def _change(position, line, step):
    """Matrix (2, 2) that takes the shape of the dot ``line[0]`` to that of the next one.

    The steps along and across the line change again as they did from the previous dot to this one.
    """
    (i, j), (k, l) = line[:2]
    across = [(position.get((a + l - j, b + k - i)), position.get((a - l + j, b - k + i)))
              for a, b in line[:2]]
    before = position[line[0]] - position[line[1]]
    if any(point is None for pair in across for point in pair):
        return np.eye(2) * np.linalg.norm(step) / np.linalg.norm(before)
    here, inner = (first - second for first, second in across)
    return np.stack([step, 2 * here - inner], axis=1) @ np.linalg.inv(
        np.stack([before, here], axis=1))


def _register(flat, model, start, shape, radius):
    """Position near ``start`` where the picture around the whole dot at ``model`` fits best.

    The result is None if the correlation of the two is too small.
    """
    height, width = flat.shape
    centre, back = np.array(start, np.float64), np.linalg.inv(shape)
    for _ in range(_STEPS):
        left, top = np.ceil(np.maximum(centre - radius, 0)).astype(int)
        right, bottom = np.floor(np.minimum(centre + radius, (width - 1, height - 1))).astype(int)
        if right - left < 2 or bottom - top < 2:
            return None
        x, y = np.meshgrid(np.arange(left, right + 1), np.arange(top, bottom + 1))
        near = (x - centre[0])**2 + (y - centre[1])**2 <= radius**2
        x, y = x[near], y[near]
        at = back @ np.stack([x - centre[0], y - centre[1]]) + model[:, None]
        h = 0.5
        moves = np.array([(0, 0), (h, 0), (-h, 0), (0, h), (0, -h)])
        values, east, west, south, north = sample(
            flat, at.T + moves[:, None], cv2.INTER_CUBIC).astype(np.float64)
        seen = flat[y, x].astype(np.float64)
        if np.ptp(seen) == 0 or np.ptp(values) == 0:
            return None
        one = np.ones_like(values)
        even = values - values.mean()
        gain = (even @ seen) / (even @ even)
        slope = -gain * np.stack([east - west, south - north], axis=1) / (2 * h) @ back
        system = np.column_stack([values, one, slope])
        try:
            solution = np.linalg.lstsq(system, seen, rcond=None)[0]
        except np.linalg.LinAlgError:
            return None
        move = np.clip(solution[2:], -1, 1)
        centre = centre + move
        if np.linalg.norm(centre - start) > 2 * radius:
            return None
        if np.linalg.norm(move) < _DONE:
            break
    correlation = np.corrcoef(values, seen)[0, 1]
    return centre if correlation > _LIKE and gain > 0.3 else None
