"""A smooth camera and the poses of a target as one vector of numbers.

In this order: focal length, centre, k, p and its higher terms, s0 and s2, tilt of the sensor,
aspect of its pixels, ratio of the target's distances, then six numbers a photo.
"""

from types import SimpleNamespace

import cv2
import numpy as np

from ncdc_model.lens import AsymmetricSurface, BrownWeng, Camera, Frame, KannalaBrandt, TiltedSensor

__all__ = ["ASPECT", "DECENTRING", "FLAWS", "LENS", "MAX_RATIO", "TERMS", "TILT", "camera_of",
           "crosses", "fixed", "guess", "lens_of", "planes_of", "project"]

TERMS = 4              # of the radial polynomial
LENS = 3 + TERMS + 4 + 2 + 2 + 1 + 1      # parameters of the lens
DECENTRING = slice(3 + TERMS, 9 + TERMS)          # with the thin prism
TILT = slice(9 + TERMS, 11 + TERMS)
ASPECT = 11 + TERMS
# Groups of parameters that a fit leaves out where the points do not show them: the higher terms
# of a decentring, a tilted sensor and pixels that are not square.
FLAWS = {"higher decentring": (5 + TERMS, 6 + TERMS), "tilt": (9 + TERMS, 10 + TERMS),
         "aspect": (ASPECT,)}

MAX_RATIO = 0.15, 0.10   # differences of the pixels' aspect and the target's ratio from 1


def fixed(flaws):
    """Numbers of the parameters of the lens that are zero without the other :data:`FLAWS`."""
    return [number for name, numbers in FLAWS.items() if name not in flaws for number in numbers]


def lens_of(vector):
    """The lens of a vector: what :func:`project` needs of a :class:`Camera`."""
    focal, cx, cy, *rest = vector[:LENS].tolist()
    k, (p0, p1, p2, p3, s0, s2, *tilt, aspect, _) = rest[:TERMS], rest[TERMS:]
    return SimpleNamespace(
        focal=focal, centre=(cx, cy), aspect=_ratio(aspect, MAX_RATIO[0]),
        radial=KannalaBrandt(tuple(k)), tilt=TiltedSensor(tuple(tilt)),
        decentring=BrownWeng(p=(p0, p1, p2, p3), s=(s0, 0.0, s2, 0.0)))


def planes_of(vector):
    """Planes (photos, 3, 3) of a vector: they take (column, row, 1) to a direction."""
    poses = vector[LENS:].reshape(-1, 6)
    angle, cross = crosses(poses[:, :3])
    planes = (np.eye(3) + np.sin(angle) / angle * cross
              + (1 - np.cos(angle)) / angle**2 * (cross @ cross))
    planes[:, :, 1] *= _ratio(vector[LENS - 1], MAX_RATIO[1])
    planes[:, :, 2] = poses[:, 3:]
    return planes


def crosses(turns):
    """Angles (n, 1, 1) of rotation vectors (n, 3), at least a tiny one, and the matrices (n, 3, 3)
    of their cross products."""
    x, y, z = turns.T
    cross = np.zeros((len(turns), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -z, y, -x
    return (np.maximum(np.sqrt((turns * turns).sum(axis=1)), 1e-9)[:, None, None],
            cross - cross.swapaxes(1, 2))


def _ratio(value, limit):
    """The ratio that a number without limits stands for."""
    return 1 + limit * np.tanh(value / limit)


def camera_of(vector, size):
    """The :class:`Camera` of a vector."""
    lens = lens_of(vector)
    return Camera(size=tuple(size), frame=Frame(tuple(size), lens.focal, lens.centre),
                  surface=AsymmetricSurface(tuple(size)),
                  **vars(lens) | {"aspect": float(lens.aspect)})


def project(camera, x, y, z):
    """Pixels x and y of directions that may be more than 90 degrees off the axis."""
    across = np.hypot(x, y)
    angle = np.arctan2(across, z)
    q = angle * angle
    radius = np.ones_like(q)
    power = q
    for coefficient in camera.radial.k:
        radius = radius + coefficient * power
        power = power * q
    scale = angle * radius / np.maximum(across, 1e-12)
    x, y = camera.tilt.distort(*camera.decentring.distort(x * scale, y * scale))
    return (camera.focal * x + camera.centre[0],
            camera.focal * camera.aspect * y + camera.centre[1])


def guess(size, focal, aspect, indices, points):
    """Parameters of an equidistant lens of ``focal`` pixels and a pixel ``aspect``, the poses by
    direct linear fits."""
    centre = (np.array(size) - 1) / 2
    lens = np.concatenate([[focal], centre, np.zeros(LENS - 3)])
    lens[ASPECT] = MAX_RATIO[0] * np.arctanh((aspect - 1) / MAX_RATIO[0])
    return np.concatenate([lens] + [_pose(index, (xy - centre) / (focal, focal * aspect))
                                    for index, xy in zip(indices, points)])


def _pose(index, flat):
    """Rotation vector and shift that take (i, j, 0) to the directions of points ``flat``.

    The points are those of an equidistant lens of focal length 1.
    """
    angle = np.linalg.norm(flat, axis=1, keepdims=True)
    rays = np.hstack([flat * np.sinc(angle / np.pi), np.cos(angle)])
    # Centred and scaled indices keep the linear system well conditioned.
    middle, spread = index.mean(axis=0), index.std() + 1e-9
    plane = np.column_stack([(index - middle) / spread, np.ones(len(index))])
    a, b, c = rays.T[:, :, None] * plane.T[None].swapaxes(1, 2)
    nothing = np.zeros_like(a)
    system = np.vstack([np.hstack([nothing, -c, b]), np.hstack([c, nothing, -a]),
                        np.hstack([-b, a, nothing])])
    matrix = np.linalg.svd(system, full_matrices=False)[2][-1].reshape(3, 3)
    if np.sum((plane @ matrix.T) * rays) < 0:
        matrix = -matrix
    matrix = matrix @ np.array([[1, 0, -middle[0]], [0, 1, -middle[1]], [0, 0, spread]]) / spread
    first, second, shift = matrix.T
    scale = np.sqrt(np.linalg.norm(first) * np.linalg.norm(second))
    third = np.cross(first, second) / scale
    left, _, right = np.linalg.svd(np.column_stack([first, second, third]))
    turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    return np.concatenate([cv2.Rodrigues(turn)[0].ravel(), shift / scale])
