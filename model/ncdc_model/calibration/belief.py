"""Which of a photo's numbered points are believed, and what is said of the others."""

from dataclasses import replace

import numpy as np

from ncdc_model.calibration.neighbours import hold, parts
from ncdc_model.calibration.smooth import MIN_POINTS, fit_smooth
from ncdc_spec.errors import InputError

__all__ = ["believed", "oblique", "place_of", "separated"]

_FEW = 200             # points that a smooth lens is fitted to
_EXPLAINED = 3.0       # pixels, median: a lens that leaves more explains nothing
_FAR_BETTER = 2.5      # times: the scatter about a lens over that about a polynomial
_OBLIQUE = 0.35        # cosine of the angle of a lattice's steps: more is no square one's
_PARTS = 4             # of a lattice that are looked at
_UNEVEN = 0.04         # of a step: points that scatter by more are not a printed target's


def believed(size, photo):
    """``photo``, :class:`PhotoPoints`, without the points that disagree with the others.

    What is dropped is listed in it with place and reason.

    Parameters
    ----------
    size : (int, int)
        Width and height of the photo.
    photo : PhotoPoints
        Its index that of a square lattice, of oblique steps if staggered.

    Raises
    ------
    InputError
        If the points scatter by more than 4 % of their distance: they are no printed target's.
    """
    area = photo.area if photo.area.any() else None
    smooth = _lens(size, photo)
    held = hold(photo.index, photo.xy, area, size=size)
    if smooth is not None:
        # A polynomial that describes them far better: oblique steps, which no lens explains. Of
        # corners, such steps mean a board seen from the side; of circles, a staggered grid, unless
        # the lens is strong: there it has to be the better one.
        by_lens = hold(photo.index, photo.xy, area, smooth, size)
        far_better = 1.0 if area is not None and oblique(photo) else _FAR_BETTER
        held = held if by_lens.sigma > far_better * held.sigma else by_lens
    if held.keep.any() and held.sigma > _UNEVEN * held.step:
        raise InputError(f"its points scatter by {held.sigma:.1f} pixels about a smooth lattice, "
                         f"{100 * held.sigma / held.step:.0f} % of their distance, "
                         f"{100 * _UNEVEN:.0f} % is the limit: that is no printed target")
    dropped = tuple((float(photo.xy[k, 0]), float(photo.xy[k, 1]), doubt.value)
                    for k, doubt in sorted(held.doubts.items()))
    rejected = dict(photo.rejected)
    for *_, reason in dropped:
        rejected[reason] = rejected.get(reason, 0) + 1
    keep = held.keep
    index = photo.index[keep]
    return replace(photo, index=index - index.min(axis=0) if len(index) else index,
                   xy=photo.xy[keep], area=photo.area[keep], cut=photo.cut[keep],
                   rejected=rejected, dropped=photo.dropped + dropped, agreement=held.sigma)


def separated(photo):
    """``photo`` cut into the parts that belong together, if its lines have kinks; the largest
    first, PhotoPoints each."""
    part = parts(photo.index, photo.xy)
    sizes = np.bincount(part[part >= 0]) if (part >= 0).any() else []
    found = []
    for number in np.argsort(sizes)[::-1][:_PARTS]:
        on = part == number
        found.append(replace(photo, index=photo.index[on] - photo.index[on].min(axis=0),
                             xy=photo.xy[on], area=photo.area[on], cut=photo.cut[on]))
    return found


def _lens(size, photo):
    """Where a smooth lens has the points (n, 2), or None if it explains nothing."""
    if len(photo.index) < MIN_POINTS:
        return None
    tried = np.random.default_rng(1).permutation(len(photo.index))[:_FEW]
    try:
        fit = fit_smooth(size, [(photo.index[tried], photo.xy[tried])], rough=True)
        places = fit.pixels(0, photo.index)
    except (InputError, np.linalg.LinAlgError):
        return None
    off = np.median(np.linalg.norm(places - photo.xy, axis=1))
    return places if off < _EXPLAINED and np.isfinite(places).all() else None


def place_of(photo):
    """Where a photo's points are, as text: the middle of their surrounding rectangle."""
    x, y = (photo.xy.min(axis=0) + photo.xy.max(axis=0)) / 2
    return f"around ({x:.0f}, {y:.0f})"


def oblique(lattice):
    """Whether the two steps of most of a lattice's points are far from a right angle."""
    place = {tuple(key): point for key, point in zip(lattice.index.tolist(), lattice.xy)}
    steps = np.array([(place[i + 1, j] - point, place[i, j + 1] - point)
                      for (i, j), point in place.items()
                      if (i + 1, j) in place and (i, j + 1) in place])
    if not len(steps):
        return False
    across, down = steps.swapaxes(0, 1)
    cosine = (across * down).sum(axis=1) / np.linalg.norm(across, axis=1) / np.linalg.norm(
        down, axis=1)
    return bool(np.median(np.abs(cosine)) > _OBLIQUE)
