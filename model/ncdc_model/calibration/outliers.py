"""Rejects the outliers among a photo's numbered points, each with a reason."""

from dataclasses import replace

import numpy as np

from ncdc_model.calibration.neighbours import check_neighbours, parts
from ncdc_model.calibration.smooth import rough_lens
from ncdc_spec.errors import InputError

__all__ = ["location_text", "oblique", "split_at_kinks", "without_outliers"]

_EXPLAINED = 3.0       # pixels, median residual: a lens that leaves more does not fit
_FAR_BETTER = 2.5      # times: the scatter about a lens over that about a polynomial
_OBLIQUE = 0.35        # cosine of the angle of a lattice's steps: a square one has less
_PARTS = 4             # of a split lattice, at most
_UNEVEN = 0.04         # of a step: points of a printed target scatter by less


def without_outliers(size, photo, places=None):
    """``photo``, :class:`PhotoPoints`, without the points that disagree with the others.

    The result lists the dropped points with position and reason.

    Parameters
    ----------
    size : (int, int)
        Width and height of the photo.
    photo : PhotoPoints
        Its indices are on a square lattice, with oblique steps if the target is staggered.
    places : ndarray, shape (n, 2), optional
        Where the points are on the target, if their distances differ. Then only a lens can predict
        them, and the numbers stay as they are; else they begin at 0.

    Raises
    ------
    InputError
        If the points scatter by more than 4 % of their distance: a printed target has less; or
        no lens explains the ``places``.
    """
    area = photo.area if photo.area.any() else None
    on_target = photo.index if places is None else places
    lens = rough_lens(size, on_target, photo.xy, _EXPLAINED)
    smooth = None if lens is None else lens.pixels(0, on_target)
    if places is not None:
        if smooth is None:
            raise InputError("no smooth lens explains its points: that is no flat printed target")
        checked = check_neighbours(photo.index, photo.xy, area, smooth, size)
    else:
        checked = check_neighbours(photo.index, photo.xy, area, size=size)
    if smooth is not None and places is None:
        # A polynomial fits far better if the steps are oblique, which no lens explains. Corners
        # have such steps on a board seen from the side. Circles have them on a staggered grid,
        # unless the lens is strong: then the lens has to fit better.
        by_lens = check_neighbours(photo.index, photo.xy, area, smooth, size)
        far_better = 1.0 if area is not None and oblique(photo) else _FAR_BETTER
        checked = checked if by_lens.sigma > far_better * checked.sigma else by_lens
    if checked.keep.any() and checked.sigma > _UNEVEN * checked.step:
        raise InputError(f"its points scatter by {checked.sigma:.1f} pixels about a smooth "
                         f"lattice, {100 * checked.sigma / checked.step:.0f} % of their distance, "
                         f"{100 * _UNEVEN:.0f} % is the limit: that is no printed target")
    dropped = tuple((float(photo.xy[k, 0]), float(photo.xy[k, 1]), reason.value)
                    for k, reason in sorted(checked.reasons.items()))
    rejected = dict(photo.rejected)
    for *_, reason in dropped:
        rejected[reason] = rejected.get(reason, 0) + 1
    keep = checked.keep
    index = photo.index[keep]
    return replace(photo,
                   index=index - index.min(axis=0) if len(index) and places is None else index,
                   xy=photo.xy[keep], area=photo.area[keep], cut=photo.cut[keep],
                   rejected=rejected, dropped=photo.dropped + dropped, agreement=checked.sigma)


def split_at_kinks(photo):
    """Parts of ``photo`` between the kinks of its lines: list of PhotoPoints, largest first."""
    part = parts(photo.index, photo.xy)
    sizes = np.bincount(part[part >= 0]) if (part >= 0).any() else []
    found = []
    for number in np.argsort(sizes)[::-1][:_PARTS]:
        on = part == number
        found.append(replace(photo, index=photo.index[on] - photo.index[on].min(axis=0),
                             xy=photo.xy[on], area=photo.area[on], cut=photo.cut[on]))
    return found


def location_text(photo):
    """Text for messages: the middle of the rectangle around a photo's points."""
    x, y = (photo.xy.min(axis=0) + photo.xy.max(axis=0)) / 2
    return f"around ({x:.0f}, {y:.0f})"


def oblique(lattice):
    """Whether the two steps at most points of a lattice are far from a right angle."""
    position = {tuple(key): point for key, point in zip(lattice.index.tolist(), lattice.xy)}
    steps = np.array([(position[i + 1, j] - point, position[i, j + 1] - point)
                      for (i, j), point in position.items()
                      if (i + 1, j) in position and (i, j + 1) in position])
    if not len(steps):
        return False
    across, down = steps.swapaxes(0, 1)
    cosine = (across * down).sum(axis=1) / np.linalg.norm(across, axis=1) / np.linalg.norm(
        down, axis=1)
    return bool(np.median(np.abs(cosine)) > _OBLIQUE)
