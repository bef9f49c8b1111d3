"""Which of a photo's numbered points are believed, and what is said of the others."""

from dataclasses import replace

import numpy as np

from ncdc_model.calibration.neighbours import hold
from ncdc_model.calibration.smooth import MIN_POINTS, fit_smooth
from ncdc_model.errors import InputError

__all__ = ["believed", "place_of"]

_FEW = 300             # points that are held to a smooth lens; more are held to a polynomial
_UNEVEN = 0.04         # of a step: points that scatter by more are not a printed target's


def believed(size, photo, square=True):
    """``photo``, :class:`PhotoPoints`, without the points that disagree with the others.

    What is dropped is listed in it with place and reason.

    Parameters
    ----------
    size : (int, int)
        Width and height of the photo.
    photo : PhotoPoints
        Its index that of a square lattice, of oblique steps if staggered.
    square : bool
        Whether equal steps of the index are equal on the target, so that a lens explains them.

    Raises
    ------
    InputError
        If the points scatter by more than 4 % of their distance: they are no printed target's.
    """
    smooth = None
    if square and MIN_POINTS <= len(photo.index) <= _FEW:
        try:
            smooth = fit_smooth(size, [(photo.index, photo.xy)]).pixels(0, photo.index)
        except (InputError, np.linalg.LinAlgError):
            pass
    held = hold(photo.index, photo.xy, photo.area if photo.area.any() else None, smooth)
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


def place_of(photo):
    """Where a photo's points are, as text: the middle of their surrounding rectangle."""
    x, y = (photo.xy.min(axis=0) + photo.xy.max(axis=0)) / 2
    return f"around ({x:.0f}, {y:.0f})"
