"""Numbers the points of distorted square lattices, step by step from a first point."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.nearest import Nearest

__all__ = ["Lattice", "find_lattices"]

_REACH = 0.30          # of a step: largest distance of a point from its expected position
_CROSS = 0.35          # the same, of the four neighbours that a walk starts with
_AGREE = 0.20          # of a step: farthest from the mean of its two neighbours in a line
_SEEDS = 12            # points nearest the middle from which a walk may start
_SPREAD = 150          # more of them anywhere in the picture, if those fail
_CROSSES = 24          # of these that are tried: points with neighbours on four sides
_SMALL = 9             # points of a lattice, at least


@dataclass(frozen=True)
class Lattice:
    """Points of one lattice: ``where`` (m,) says which of those given, ``index`` (m, 2) their (i,
    j) from 0, ``dropped`` which had a number but failed the check."""
    where: np.ndarray
    index: np.ndarray
    dropped: np.ndarray


def find_lattices(xy, middle, most=3):
    """Square lattices, at most ``most``, of the points ``xy`` (n, 2), largest first.

    A walk starts at a point near ``middle``, (x, y). The middle may be covered: if such a point
    has no neighbours on four sides, or few points are reached, the walk starts elsewhere. Each
    step predicts the next point by the step vectors of its nearest numbered neighbours. So the
    vectors follow the distortion across the picture and around holes. Then the neighbours on
    either side check every number. i grows to the right and j downwards; the smallest is 0.

    Returns
    -------
    list of :class:`Lattice`
    """
    free, found = np.arange(len(xy)), []
    while len(free) >= _SMALL and len(found) < most:
        # Python's complex numbers: single steps of arrays of two take ten times as long.
        at = (xy[free] @ (1, 1j)).tolist()
        best = _largest_walk(xy[free], at, middle)
        if len(best) < _SMALL:
            break
        numbered = _checked(at, best)
        index = np.array(sorted(numbered), int).reshape(-1, 2)
        where = np.array([numbered[tuple(key)] for key in index.tolist()], int)
        walked = np.array(sorted(best.values()), int)
        if len(index) >= _SMALL:
            found.append(Lattice(free[where], index - index.min(axis=0),
                                 free[np.setdiff1d(walked, where)]))
        free = np.delete(free, walked)
    return sorted(found, key=lambda lattice: -len(lattice.where))


def _largest_walk(xy, at, middle):
    """Numbers {(i, j): point} of the longest of the walks from several points.

    ``at``: the points ``xy`` (n, 2) as complex numbers.
    """
    tree, best, crosses = Nearest(xy), {}, 0
    near = tree.query(middle, min(_SEEDS, len(xy)))[1][0]
    spread = np.random.default_rng(1).permutation(len(xy))[:_SPREAD]
    tried = np.zeros(len(xy), bool)
    for number, seed in enumerate(np.concatenate([near, spread])):
        if tried[seed] or len(best) > 0.5 * len(xy):
            continue
        # Points near the middle come first; that is enough if the walk is long.
        if number >= len(near) and (crosses >= _CROSSES or len(best) > 0.3 * len(xy)):
            break
        tried[seed] = True
        steps = _first_steps(xy, tree, seed)
        if steps is None:
            continue
        crosses += 1
        found = _walk(at, tree, int(seed), *(step @ (1, 1j) for step in steps))
        tried[list(found.values())] = True
        if len(found) > len(best):
            best = found
    return best


def _first_steps(xy, tree, seed):
    """Step vectors right and down at point ``seed``, or None without neighbours on four sides."""
    near = tree.query(xy[seed], min(9, len(xy)))[1][0]
    vectors = xy[near[1:]] - xy[seed]
    first = vectors[0]
    # The second direction: the nearest neighbour well off the line of the first one.
    cosine = np.abs(vectors @ first) / (np.linalg.norm(vectors, axis=1) * np.linalg.norm(first))
    across = np.flatnonzero(cosine < 0.6)
    if not across.size:
        return None
    second = vectors[across[0]]
    if abs(first[0]) * np.linalg.norm(second) < abs(second[0]) * np.linalg.norm(first):
        first, second = second, first
    right, down = first * np.sign(first[0]), second * np.sign(second[1])
    # A target seen from the side has short steps one way and long ones the other.
    sizes = np.linalg.norm([right, right, down, down], axis=1)
    ends = xy[seed] + np.array([right, -right, down, -down])
    distance, _ = tree.query(ends)
    return (right, down) if (distance[:, 0] < _CROSS * sizes).all() else None


def _walk(at, tree, seed, right, down):
    """Numbers {(i, j): point} of all points that can be reached from ``seed``."""
    found, used = {(0, 0): seed}, {seed}
    frame = {(0, 0): (complex(right), complex(down))}
    front = [(0, 0)]
    while front:
        reached = []
        for key in front:
            for axis in (0, 1):
                for sign in (1, -1):
                    target = (key[0] + sign, key[1]) if axis == 0 else (key[0], key[1] + sign)
                    if target in found:
                        continue
                    steps = frame[key]
                    expected = _expected(at, found, target, at[found[key]] + sign * steps[axis])
                    _, point = tree.nearest((expected.real, expected.imag))
                    if point in used or not _near(steps, at[point] - expected):
                        continue
                    found[target] = point
                    used.add(point)
                    frame[target] = steps
                    reached.append(target)
        for key in reached:
            frame[key] = _steps(at, found, key, frame[key])
        front = reached
    return found


def _near(steps, offset):
    """Whether ``offset`` is short, measured in ``steps``."""
    right, down = steps
    return max(abs(_cross(offset, down)), abs(_cross(right, offset))) < _REACH * abs(
        _cross(right, down))


def _cross(a, b):
    return a.real * b.imag - a.imag * b.real


def _expected(at, found, target, simple):
    """Where point ``target`` should be: mean of the parallelograms of three neighbours."""
    i, j = target
    guesses = []
    for di in (-1, 1):
        for dj in (-1, 1):
            corner = [found.get(key) for key in ((i + di, j), (i, j + dj), (i + di, j + dj))]
            if None not in corner:
                guesses.append(at[corner[0]] + at[corner[1]] - at[corner[2]])
    return sum(guesses) / len(guesses) if guesses else simple


def _steps(at, found, key, inherited):
    """Step vectors at ``key`` from its numbered neighbours; those of its parent for the rest."""
    i, j = key
    steps = list(inherited)
    for axis, (before, after) in enumerate((((i - 1, j), (i + 1, j)), ((i, j - 1), (i, j + 1)))):
        known = [found[k] for k in (before, key, after) if k in found]
        if len(known) > 1:
            steps[axis] = (at[known[-1]] - at[known[0]]) / (len(known) - 1)
    return tuple(steps)


def _checked(at, found):
    """``found`` without the points that lie off the line of their neighbours.

    The worst is removed first and the rest checked again, so that one stray point does not remove
    its neighbours. A point without two neighbours in any line, as in a corner, is checked by the
    steps of the adjacent lines; without those it is removed.
    """
    found = dict(found)
    scores = {key: _misfit(at, found, key) for key in found}
    while scores:
        worst = max(scores, key=scores.get)
        if scores[worst] <= _AGREE:
            return found
        out = [key for key, score in scores.items() if np.isinf(score)] or [worst]
        for key in out:
            del found[key], scores[key]
        # Points up to two columns and rows away affect the check.
        for key in {(i + di, j + dj) for i, j in out for di in range(-2, 3) for dj in range(-2, 3)}:
            if key in found:
                scores[key] = _misfit(at, found, key)
    return found


def _misfit(at, found, key):
    """Largest distance, in steps, of point ``key`` from lines through its neighbours."""
    i, j = key
    point, worst = at[found[key]], -1.0
    for di, dj in ((1, 0), (0, 1)):
        for a, b in ((-1, 1), (1, 2), (-1, -2)):
            first, second = found.get((i + a * di, j + a * dj)), found.get((i + b * di, j + b * dj))
            if first is None or second is None:
                continue
            step = (at[second] - at[first]) / (b - a)
            offset = abs(point - at[first] + a * step) / abs(step) if step else np.inf
            # Extrapolation beyond the end of a line triples the error by the lens's curvature.
            worst = max(worst, offset if (a, b) == (-1, 1) else offset / 3)
    return worst if worst >= 0 else _lonely_misfit(at, found, key)


def _lonely_misfit(at, found, key):
    """:func:`_misfit` of a point at the edge that has no two neighbours in a line.

    Its step from a neighbour must be that of the adjacent line: at the same position, or one
    further in, where the step may have changed by twice as much.
    """
    scores = []
    for away in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        for side in (away[::-1], (-away[1], -away[0])):
            for shift, allow in ((0, 2), (1, 4)):
                points = [found.get((key[0] + a * away[0] + b * side[0],
                                     key[1] + a * away[1] + b * side[1]))
                          for a, b in ((1, 0), (shift, 1), (shift + 1, 1))]
                if None not in points:
                    near, first, second = (at[point] for point in points)
                    step = first - second
                    offset = abs(near + step - at[found[key]])
                    scores.append(offset / abs(step) / allow if step else np.inf)
    return min(scores, default=np.inf)
