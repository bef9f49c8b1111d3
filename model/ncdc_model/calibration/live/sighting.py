"""What one frame of a running camera shows of a target."""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.calibration.blobs import find_blobs
from ncdc_model.calibration.boards import grey_picture
from ncdc_model.calibration.charuco import sees_markers
from ncdc_model.calibration.corners import find_corner_lattices
from ncdc_model.calibration.detect import detect_points, parse_target
from ncdc_model.calibration.focus import dot_blur
from ncdc_model.calibration.lattice import find_lattices
from ncdc_model.calibration.smooth_problem import MIN_POINTS
from ncdc_model.calibration.subpixel import edge_blur, gaps
from ncdc_model.calibration.tags import find_tags
from ncdc_spec.errors import InputError

__all__ = ["Sighting", "may_show", "sighting_of"]

_WIDTH = 960           # pixels: larger frames are reduced, as their details would take time only
_GLANCE = 480          # pixels: width of the copy in which a first glance looks for targets
_MATCHED = 0.9         # of the points: with fewer another part of the target is seen


@dataclass(frozen=True)
class Sighting:
    """The points of a target in one frame.

    Parameters
    ----------
    target : str
        As of ``ncdc calibrate --target``.
    index, xy : ndarray, shape (n, 2)
        Column and row of the points that the border does not cut; their pixels in the frame.
    blur : float
        Usual blur of edges, a Gaussian's sigma in pixels of the frame; not-a-number if unknown.
    """
    target: str
    index: np.ndarray
    xy: np.ndarray
    blur: float

    def moved(self, other):
        """Median distance in pixels of the points from those of an ``other`` sighting; infinite
        if many have none near them."""
        far = np.linalg.norm(self.xy[:, None] - other.xy, axis=2)
        step = np.median(gaps(self.index, self.xy))
        nearest = far.min(axis=1)
        if min(np.mean(nearest < step / 2), np.mean(far.min(axis=0) < step / 2)) < _MATCHED:
            return np.inf
        return float(np.median(nearest))


def may_show(image, target):
    """Whether a small copy of ``image``, uint8 (h, w) or (h, w, 3), shows a part of the ``target``.

    It takes a tenth of the time of a search. Small markers and dense pages may be missed.
    """
    kind, _, _ = parse_target(target)
    scale = min(1.0, _GLANCE / image.shape[1])
    grey = cv2.resize(grey_picture(image), None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    if kind in ("auto", "chessboard", "charuco") and find_corner_lattices(grey):
        return True
    if kind in ("auto", "dots", "circles", "acircles") and (_shows_dots(grey)
                                                            or _shows_dots(255 - grey)):
        return True
    if kind in ("auto", "aprilgrid") and find_tags(grey) is not None:
        return True
    return kind in ("auto", "charuco") and sees_markers(grey)


def _shows_dots(grey):
    """Whether dark spots lie on a lattice."""
    spots = find_blobs(cv2.cvtColor(grey, cv2.COLOR_GRAY2RGB))
    found = find_lattices(spots.xy, (np.array(grey.shape[::-1]) - 1) / 2, 1)
    return bool(found) and len(found[0].where) >= MIN_POINTS


def sighting_of(image, target):
    """:class:`Sighting` of the ``target`` in ``image``, uint8 (h, w) or (h, w, 3); None without
    enough points."""
    scale = max(1.0, image.shape[1] / _WIDTH)
    if scale > 1:
        small = tuple(int(round(side / scale)) for side in image.shape[1::-1])
        whole = grey_picture(image) if image.ndim == 2 else image
        image = cv2.resize(whole, small, interpolation=cv2.INTER_AREA)
        scale = np.array(whole.shape[1::-1]) / small
    try:
        points = detect_points([("frame", image)], target)
    except InputError:
        return None
    photo = points.photos[0].whole
    if len(photo.index) < MIN_POINTS or np.ptp(photo.index, axis=0).min() < 2:
        return None
    grey = grey_picture(image)
    blur = (dot_blur(grey, photo) if photo.area.any() else
            edge_blur(grey, photo.xy, gaps(photo.index, photo.xy)))
    usual = float(np.nanmedian(blur)) if np.isfinite(blur).any() else np.nan
    size = "" if points.target_size is None else "{}x{}".format(*points.target_size)
    return Sighting(f"{points.target}:{size}".rstrip(":"), points.places(photo.index),
                    (photo.xy + .5) * scale - .5, usual * float(np.mean(scale)))
