"""Views of a pinhole for tests, by SciPy's rotations, and matrices that make no sense."""

import numpy as np
from scipy.spatial.transform import Rotation

from ncdc_spec.view import DEPTH_SHIFTS, FORMATS, View
from ncdc_spec.view_rows import NUMBER_BITS, STEPS, RowTable, row_view

__all__ = ["nonsense_table", "nonsense_view", "pinhole_matrix", "random_angles", "random_view",
           "sweeping_view", "turning_view"]


def pinhole_matrix(focal, trained, size, pan, tilt, roll, zoom):
    """Matrix of a view of ``size`` into a trained picture of ``focal`` pixels, angles in degrees.

    The zoom is relative to a view as wide as the trained picture.
    """
    def camera(width, height, f):
        return np.array([[f, 0, (width - 1) / 2], [0, f, (height - 1) / 2], [0, 0, 1.]])
    turn = Rotation.from_euler("yxz", [pan, tilt, roll], degrees=True).as_matrix()
    f = focal * zoom * size[0] / trained[0]
    return camera(*trained, focal) @ turn @ np.linalg.inv(camera(*size, f))


def random_angles(rng, pan=30, tilt=20, roll=10, zoom=(.8, 4)):
    """Pan, tilt and roll up to these angles, and a zoom within these limits."""
    low, high = np.log2(zoom)
    return (*(rng.uniform(-limit, limit) for limit in (pan, tilt, roll)),
            2**rng.uniform(low, high))


def random_view(rng, geometry, focal, size=None, **limits):
    """A view of :func:`random_angles` into the trained picture of ``geometry``."""
    size = size or geometry.corrected
    return View.of(pinhole_matrix(focal, geometry.corrected, size, *random_angles(rng, **limits)),
                   size)


def nonsense_view(rng, size):
    """The trained picture with up to nine registers of any bits, some of them zero or at a limit.
    """
    raw = list(View.identity(size).matrix)
    for k in rng.choice(9, rng.integers(1, 10), replace=False).tolist():
        q = FORMATS[k // 3][k % 3]
        bits = int(rng.integers(q.lo, q.hi)) >> int(rng.integers(0, 32))
        raw[k] = (0, q.lo, q.hi, bits)[rng.integers(0, 4)]
    return View(tuple(raw), size)


def sweeping_view(rng, size):
    """A view whose positions are of any magnitude, and change by up to a third from edge to edge.

    The depth has any magnitude, too. So positions lie close to each power of two, also to those at
    which something overflows.
    """
    raw = []
    for number in range(3):
        step, _, origin = FORMATS[number]
        value = int(rng.choice([-1, 1]) * 2**rng.uniform(0, origin.width - 1)) if number < 2 else (
            int(2**rng.uniform(origin.f_bits - DEPTH_SHIFTS - 1, origin.f_bits + 1)))
        change = rng.uniform(-.3, .3, 2) * value * 2.**(step.f_bits - origin.f_bits) / max(size)
        raw += [min(max(int(one), step.lo), step.hi) for one in change]
        raw.append(min(max(value, origin.lo), origin.hi))
    return View(tuple(raw), size)


def turning_view(rng, geometry, focal, size=None, matrices=8, degrees=4.0, **limits):
    """A view of :func:`random_angles` of a camera that turns while its rolling shutter reads."""
    size, rows = size or geometry.corrected, geometry.distorted_height
    *angles, zoom = random_angles(rng, **limits)
    change = rng.uniform(-degrees, degrees, (3, 3))
    moments = np.linspace(-1, 1, rows)[:, None]
    turned = angles + change[0] * moments + change[1] * np.sin(3 * moments + change[2])
    return row_view(np.array([pinhole_matrix(focal, geometry.corrected, size, *one, zoom)
                              for one in turned]), size, matrices)


def nonsense_table(rng, matrices=8):
    """A table of any numbers, of any size and step."""
    bits = rng.integers(-1 << NUMBER_BITS - 1, 1 << NUMBER_BITS - 1,
                        (rng.integers(1, matrices + 1), 9)) >> rng.integers(0, NUMBER_BITS)
    return RowTable(int(rng.choice(STEPS)), tuple(map(tuple, bits.tolist())))
