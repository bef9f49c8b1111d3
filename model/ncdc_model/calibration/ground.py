"""Tells spots on the target's own ground from those beyond an edge of brightness."""


import cv2
import numpy as np
from scipy.ndimage import map_coordinates
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

__all__ = ["contrast", "on_one_ground"]

_STEP = 0.75           # brightness of one cell over that of the next: less is an edge
_REGION = 20           # cells: a smaller dark part is a mark on the page
_ACROSS = 3            # cells to either side that are compared
_REASON = "on ground of another brightness: a reflection, or beyond a shadow's edge"


def contrast(image, photo):
    """By what part of the page's brightness the dots of ``photo``, PhotoPoints, usually
    are darker than the page half-way to their neighbours across; not-a-number if none has any."""
    place = {tuple(key): k for k, key in enumerate(photo.index.tolist())}
    pairs = np.array([(k, place[i + 1, j + 1]) for (i, j), k in place.items()
                      if (i + 1, j + 1) in place]).reshape(-1, 2)
    if not len(pairs):
        return float("nan")
    page = _brightness(image, photo.xy[pairs].mean(axis=1))
    return float(np.median(1 - _brightness(image, photo.xy[pairs[:, 0]]) / page))


def on_one_ground(image, photo):
    """``photo``, PhotoPoints on a lattice, without those beyond an edge of brightness.

    The middle of each four points is page. Where it is darker by a quarter from one such cell to
    the next there is an edge: of a shadow, or of the page, in whose shiny frame its dots are seen
    again at nearly the same distances. Only points of the largest part without an edge are kept.
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
    # A stroke of a pen darkens a line of cells, but not what lies beyond it.
    for one, other in [pair for far in range(1, _ACROSS + 1) for pair in (
            (np.s_[:-far], np.s_[far:]), (np.s_[:, :-far], np.s_[:, far:]))]:
        same = whole[one] & whole[other]
        low, high = (which(light[one], light[other]) for which in (np.minimum, np.maximum))
        same &= low >= _STEP * high
        pairs.append(np.stack([cell[one][same], cell[other][same]]))
    first, second = np.hstack(pairs)
    count = int(whole.sum())
    _, part = connected_components(coo_matrix((np.ones(len(first)), (first, second)),
                                              shape=(count, count)), directed=False)
    sizes = np.bincount(part)
    main = sizes.argmax()
    drop, inside = np.zeros((2, len(photo.index)), bool)
    inside[corners[whole][part == main].ravel()] = True
    drop[corners[whole][part != main].ravel()] = True
    drop &= ~inside
    # The cell on the edge itself may count as bright: what lies on its other side does not.
    drop[corners[whole][(part != main) & (sizes[part] >= _REGION)].ravel()] = True
    return photo.without(drop, _REASON)


def _brightness(image, places):
    """Of the picture, blurred over some pixels, at ``places`` (n, 2)."""
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    smooth = cv2.blur(grey, (4, 4)).astype(np.float32)
    smooth += 1
    return map_coordinates(smooth, [places[:, 1], places[:, 0]], order=1, mode="nearest")
