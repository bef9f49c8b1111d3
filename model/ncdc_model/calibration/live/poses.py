"""Poses of a target in front of a camera: where it is seen, and where it is wanted next."""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.calibration.smooth_problem import MIN_POINTS
from ncdc_model.calibration.smooth_vector import project

__all__ = ["Pose", "Wish", "plane_of", "wishes"]

# Two poses differ if one of these does: direction, tilt (radians), logarithm of the distance.
_APART = np.radians(4.0), np.radians(10.0), np.log(1.15)
_SIDES = {"left": 1 / 6, "": 1 / 2, "right": 5 / 6}         # parts of the picture's width
_LEVELS = {"top": 1 / 6, "": 1 / 2, "bottom": 5 / 6}
_TILT = np.radians(35.0)
_TILTS = {"facing the camera": (0, 0), "with its right side away": (1, 0),
          "with its left side away": (-1, 0), "with its lower side away": (0, 1),
          "with its upper side away": (0, -1)}


@dataclass(frozen=True)
class Pose:
    """Direction of the target's middle and its normal, unit vectors, and the distance in steps."""
    direction: np.ndarray
    normal: np.ndarray
    distance: float

    @classmethod
    def of(cls, plane, index):
        """Pose of the points ``index`` (n, 2) on a target's ``plane``, see :class:`SmoothFit`."""
        middle = plane[:, :2] @ index.mean(axis=0) + plane[:, 2]
        distance, normal = np.linalg.norm(middle), np.cross(plane[:, 0], plane[:, 1])
        return cls(middle / distance, normal / np.linalg.norm(normal),
                   float(distance / np.linalg.norm(plane[:, 0])))

    def differs(self, other):
        """Whether two poses are so far apart that each has something of its own to say."""
        change = (_angle(self.direction, other.direction), _angle(self.normal, other.normal),
                  abs(np.log(self.distance / other.distance)))
        return any(part > limit for part, limit in zip(change, _APART))


@dataclass(frozen=True)
class Wish:
    """A pose of the target that would help.

    Parameters
    ----------
    text : str
        Where it is, and how it is tilted.
    gain : float
        Part by which it would reduce the uncertainty; see
        :mod:`ncdc_model.calibration.live.information`.
    outline : tuple of (float, float)
        Pixels of its outermost points, in a circle; some may lie outside the frame.
    """
    text: str
    gain: float
    outline: tuple


def plane_of(camera, index, xy):
    """The plane, (3, 3) as in :class:`SmoothFit`, of the points ``index`` (n, 2) that ``camera``
    sees at the pixels ``xy`` (n, 2); None if too few are in front of it."""
    ideal = np.stack(camera.undistort(*xy.T), axis=1)
    known = np.isfinite(ideal).all(axis=1)
    if known.sum() < MIN_POINTS:
        return None
    matrix = cv2.findHomography(index[known].astype(np.float64), ideal[known], 0)[0]
    if matrix is None:
        return None
    first, second, shift = matrix.T / np.sqrt(np.linalg.norm(matrix[:, 0])
                                              * np.linalg.norm(matrix[:, 1]))
    if (matrix[2, :2] @ index.mean(axis=0) + matrix[2, 2]) < 0:
        first, second, shift = -first, -second, -shift
    left, _, right = np.linalg.svd(np.column_stack([first, second, np.cross(first, second)]))
    turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    return np.column_stack([turn[:, 0], turn[:, 1], shift])


def wishes(information, index, distance):
    """The poses of a target of points ``index`` (n, 2) that would help, the best first.

    They are nine positions in the picture and five tilts, at a ``distance`` in steps. A pose of
    which fewer than 12 points would be seen is left out.

    Returns
    -------
    list of Wish
    """
    camera, found = information.camera, []
    width, height = camera.size
    middle = index.mean(axis=0)
    for side, x in _SIDES.items():
        for level, y in _LEVELS.items():
            direction = camera.ray(np.float64(x * width), np.float64(y * height))
            if not np.isfinite(direction).all():
                continue
            position = " ".join(filter(None, (level, side))) or "middle"
            for how, (right, down) in _TILTS.items():
                plane = _plane(distance * direction, middle, right * _TILT, down * _TILT)
                seen = _inside(camera, plane, index)
                if seen.sum() >= MIN_POINTS:
                    found.append(Wish(f"{position} of the picture, {how}",
                                      information.gain(plane, index[seen]),
                                      _outline(camera, plane, index)))
    return sorted(found, key=lambda wish: -wish.gain)


def _plane(centre, middle, right, down):
    """Plane whose point ``middle`` is at ``centre``, its right and lower sides tilted away."""
    first = np.array([np.cos(right), 0, np.sin(right)])
    second = np.array([-np.sin(right) * np.sin(down), np.cos(down), np.cos(right) * np.sin(down)])
    return np.column_stack([first, second, centre - np.column_stack([first, second]) @ middle])


def _outline(camera, plane, index):
    """Pixels of the corners of the rectangle of ``index``, those before the camera."""
    (left, top), (right, bottom) = index.min(axis=0), index.max(axis=0)
    rays = np.array([(left, top, 1), (right, top, 1), (right, bottom, 1),
                     (left, bottom, 1)]) @ plane.T
    return tuple(tuple(map(float, pixel)) for pixel in
                 np.stack(project(camera, *rays[rays[:, 2] > 0].T), axis=1))


def _inside(camera, plane, index):
    rays = index @ plane[:, :2].T + plane[:, 2]
    x, y = project(camera, *rays.T)
    width, height = camera.size
    return (x > 0) & (x < width - 1) & (y > 0) & (y < height - 1) & (rays[:, 2] > 0)


def _angle(a, b):
    return np.arccos(np.clip(a @ b, -1, 1))
