"""A range of views, and ways to find the one in which some figure is largest."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.view_matrix import LIMITS, Angles, PlaneCamera

__all__ = ["ViewRange"]

_LEVELS = 0.0, 0.5, 1.0     # of the grid, on each number that varies
_SPREAD = 32                # more views for each number that varies
_STEPS = 1 / 8, 1 / 16, 1 / 32, 1 / 64, 1 / 128     # of a climb, as shares of the range


@dataclass(frozen=True)
class ViewRange:
    """All views of one size whose pan, tilt, roll and zoom are each in an interval.

    Parameters
    ----------
    camera : PlaneCamera
        Of the trained picture.
    low, high : Angles
        Ends of the intervals.
    size : (int, int)
        Width and height of the views.

    Raises
    ------
    InputError
        If an interval is empty, or its ends are so far off the axis that no register holds them.
    """
    camera: PlaneCamera
    low: Angles
    high: Angles
    size: tuple

    def __post_init__(self):
        for name in LIMITS:
            low, high = (getattr(end, name) for end in (self.low, self.high))
            if low > high:
                raise InputError(f"{name} is {low:g} to {high:g}, the first number must be the "
                                 f"smaller one")
        for shares in product(*((0.0, 1.0) for _ in self.varying)):
            self.view(self._at(shares))

    @classmethod
    def of(cls, descriptor, intervals, size=None):
        """The range of a ``descriptor``; ``intervals``: low and high value of each number by its
        name, those of the trained picture where one is absent."""
        camera = PlaneCamera.of(descriptor)
        low, high = (Angles(**{name: ends[k] for name, ends in intervals.items()})
                     for k in (0, 1))
        return cls(camera, low, high, tuple(size or camera.size))

    @property
    def varying(self):
        """Names of the numbers that are not the same in all views."""
        return [name for name in LIMITS if getattr(self.low, name) < getattr(self.high, name)]

    @property
    def report(self):
        """The range under its names in every report."""
        return {**{name: [getattr(self.low, name), getattr(self.high, name)] for name in LIMITS},
                "width": self.size[0], "height": self.size[1]}

    def view(self, angles):
        """The :class:`~ncdc_spec.view.View` of ``angles``."""
        return self.camera.looking(angles, self.size)

    def random(self, count, seed=1):
        """Yield ``count`` random :class:`Angles`, zooms evenly in their logarithm."""
        rng = np.random.default_rng(seed)
        for _ in range(count):
            yield self._at(rng.uniform(size=len(self.varying)))

    def _at(self, shares):
        """The :class:`Angles` at a share, 0 to 1, of each interval that varies."""
        numbers = vars(self.low) | {
            name: float(_between(name, getattr(self.low, name), getattr(self.high, name), share))
            for name, share in zip(self.varying, shares)}
        return Angles(**numbers)

    def scan(self):
        """Views all over the range: list of :class:`Angles`.

        These are the ends and the middle of all intervals in all combinations, and more views that
        are evenly spread between them. They are always the same.
        """
        count = len(self.varying)
        shares = [*product(_LEVELS, repeat=count), *map(tuple, _spread(_SPREAD * count, count))]
        return [self._at(each) for each in shares]

    def climb(self, score, begin):
        """Change single numbers of the view ``begin`` as long as its score rises, in ever smaller
        steps. Returns the :class:`Angles` where it ends.

        Parameters
        ----------
        score : callable
            A number for :class:`Angles`.
        begin : Angles
        """
        best, value = begin, score(begin)
        for step in _STEPS:
            while True:
                around = [self._moved(best, name, by) for name in self.varying
                          for by in (-step, step)]
                nearby = max(around, key=score, default=best)
                if (higher := score(nearby)) <= value:
                    break
                best, value = nearby, higher
        return best

    def _moved(self, angles, name, by):
        """``angles`` with one number changed by a share of its interval, within it."""
        low, high = getattr(self.low, name), getattr(self.high, name)
        if name == "zoom":
            moved = angles.zoom * (high / low)**by
        else:
            moved = getattr(angles, name) + by * (high - low)
        return replace(angles, **{name: min(high, max(low, moved))})


def _between(name, low, high, share):
    """The value at a ``share`` of an interval; zooms are even in their logarithm."""
    if share in (0, 1):
        return high if share else low
    return low * (high / low)**share if name == "zoom" else low + share * (high - low)


def _spread(count, dimensions):
    """``count`` points that fill a cube of ``dimensions`` sides 0 to 1 evenly, an additive
    recurrence: shape (count, dimensions)."""
    ratio = 2.0
    for _ in range(50):         # the root of ratio**(dimensions + 1) = ratio + 1
        ratio = (1 + ratio)**(1 / (dimensions + 1))
    steps = ratio ** -np.arange(1.0, dimensions + 1)
    return (0.5 + np.outer(np.arange(1, count + 1), steps)) % 1
