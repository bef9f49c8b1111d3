"""Separates spots on the target's own background from those beyond an edge of brightness."""

import cv2
import numpy as np

from ncdc_model.calibration.sampling import bilinear

__all__ = ["contrast", "on_one_background"]

_STEP = 0.75           # ratio of the brightness of two cells: less is an edge
_REGION = 20           # cells: a smaller dark part is a mark on the page
_ACROSS = 3            # cells to either side that are compared
_REASON = "on a background of another brightness: a reflection, or beyond a shadow's edge"


def contrast(image, photo):
    """Median contrast of the dots of ``photo``, PhotoPoints, in parts of the page's brightness.

    The page is sampled half-way to the diagonal neighbours; not-a-number if no dot has any.
    """
    number_of = {tuple(key): k for k, key in enumerate(photo.index.tolist())}
    pairs = np.array([(k, number_of[i + 1, j + 1]) for (i, j), k in number_of.items()
                      if (i + 1, j + 1) in number_of]).reshape(-1, 2)
    if not len(pairs):
        return float("nan")
    page = _brightness(image, photo.xy[pairs].mean(axis=1))
    return float(np.median(1 - _brightness(image, photo.xy[pairs[:, 0]]) / page))


def on_one_background(image, photo):
    """``photo``, PhotoPoints on a lattice, without those beyond an edge of brightness.

    A cell is the page between four points. Two cells have an edge between them if one is darker by
    a quarter: the edge of a shadow, or of a page whose shiny frame mirrors its dots at nearly the
    same distances. Only points of the largest part without an edge remain.
    """
    if len(photo.index) < 9:
        return photo
    origin = photo.index.min(axis=0)
    number = np.full(np.ptp(photo.index, axis=0) + 2, -1)
    number[tuple((photo.index - origin).T)] = np.arange(len(photo.index))
    corners = np.stack([number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]], axis=2)
    whole = (corners >= 0).all(axis=2)
    if not whole.any():
        return photo
    light = np.zeros(whole.shape)
    light[whole] = _brightness(image, photo.xy[corners[whole]].mean(axis=1))
    cell = np.full(whole.shape, -1)
    cell[whole] = np.arange(whole.sum())
    pairs = []
    # A pen stroke darkens a line of cells, but not the cells beyond it.
    for one, other in [pair for far in range(1, _ACROSS + 1) for pair in (
            (np.s_[:-far], np.s_[far:]), (np.s_[:, :-far], np.s_[:, far:]))]:
        same = whole[one] & whole[other]
        low, high = (which(light[one], light[other]) for which in (np.minimum, np.maximum))
        same &= low >= _STEP * high
        pairs.append(np.stack([cell[one][same], cell[other][same]]))
    first, second = np.hstack(pairs)
    part = _parts(first, second, int(whole.sum()))
    sizes = np.bincount(part)
    main = sizes.argmax()
    drop, inside = np.zeros((2, len(photo.index)), bool)
    inside[corners[whole][part == main].ravel()] = True
    drop[corners[whole][part != main].ravel()] = True
    drop &= ~inside
    # The cell on the edge itself may count as bright: points on its other side do not.
    drop[corners[whole][(part != main) & (sizes[part] >= _REGION)].ravel()] = True
    return photo.without(drop, _REASON)


def _parts(first, second, count):
    """Part (count,) of each node of a graph with edges from ``first`` to ``second`` (n,): the
    smallest number of a node in it."""
    part, before = np.arange(count), None
    while not np.array_equal(part, before):
        before, least = part.copy(), np.minimum(part[first], part[second])
        for end in (first, second):
            np.minimum.at(part, end, least)
        part = part[part]
    return part


def _brightness(image, positions):
    """Brightness (n,) of the picture, blurred over 4x4 pixels, at ``positions`` (n, 2)."""
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    smooth = cv2.blur(grey, (4, 4)).astype(np.float32)
    smooth += 1
    return bilinear(smooth, positions)
