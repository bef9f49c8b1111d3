"""Photos of a page of dots through a :class:`TrueLens`, four times supersampled."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ncdc_bench.photos.targets import Photo, Truth
from ncdc_bench.truth.lenses import SIZE

__all__ = ["POSES", "RADIUS", "Page", "area", "centroid", "expose", "photograph", "seen", "whole"]

_SUB = 4               # samples of a pixel on each axis
_BAND = 32             # rows at a time: bounds the memory
RADIUS = 0.25          # of a dot, in steps of the page
_PAPER, _INK = 225.0, 26.0
_FALL = 0.35           # of the light is lost in the corners of the picture
_NOISE = 1.2           # grey levels, standard deviation
_FINE = 3.0            # pixels: a dot that is narrower is not counted as seen
_OUTLINE = 64          # corners of a dot's outline
_BENDS = 6             # steps of the search for a bent page's height
_SAME = np.cos(0.05)   # of two directions, 3 degrees apart


@dataclass(frozen=True)
class Page:
    """A page in front of the camera.

    Parameters
    ----------
    columns, rows : int
        Dots, one step apart.
    distance : float
        From the lens to the middle of the page, in steps.
    turns : (float, float, float)
        Rotation vector of the page in degrees.
    bend : Cylinder or Bulge, optional
        Of :mod:`ncdc_bench.truth.bends`; None: the page is flat.
    """
    columns: int
    rows: int
    distance: float
    turns: tuple
    bend: object = None

    @property
    def middle(self):
        """Column and row of its middle."""
        return np.array([(self.columns - 1) / 2, (self.rows - 1) / 2])

    @property
    def plane(self):
        """Matrix (3, 3) from (column, row, 1) to a direction."""
        turn = Rotation.from_rotvec(self.turns, degrees=True).as_matrix()
        return np.column_stack([turn[:, 0], turn[:, 1],
                                (0, 0, self.distance) - turn[:, :2] @ self.middle])

    @property
    def normal(self):
        """Unit vector (3,) away from the camera, along which a bent page has its height."""
        return np.cross(self.plane[:, 0], self.plane[:, 1])

    def rays(self, points):
        """Directions (n, 3), not of unit length, of ``points`` (n, 2) of column and row."""
        if self.bend is None:
            return np.column_stack([points, np.ones(len(points))]) @ self.plane.T
        flat, height = self.bend.bent(points - self.middle)
        return (np.column_stack([flat + self.middle, np.ones(len(points))]) @ self.plane.T
                + height[:, None] * self.normal)


# One photo; two more from other sides.
POSES = (3.0, -4.0, 5.0), (-14.0, 10.0, -3.0), (10.0, 16.0, 92.0)


def photograph(lens, page, seed=0):
    """:class:`Photo` of ``page`` through ``lens``, 1280x960 grey with vignetting and noise.

    Its truth counts the dots whose whole outline lies in the picture, at least 3 pixels wide.
    """
    inverse = np.linalg.inv(page.plane)
    image = expose(lens, lambda angles: _ink(inverse, page, angles), seed)
    return Photo(image, (_truth(lens, page),))


def expose(lens, ink, seed=0, size=SIZE, slant=0.0):
    """Grey uint8 picture of ``size`` through ``lens``, with vignetting and noise.

    ``ink``: function of the directions (2, ...) of samples, as ``lens.angles`` gives them; the
    share of black of each. ``slant``: the samples of a pixel lie in rows and columns that are
    turned by so much; 1/4 spreads them evenly across edges along the rows and columns, too.
    """
    offsets = (np.arange(_SUB) + .5) / _SUB - .5
    image = np.zeros(size[::-1])
    for top in range(0, size[1], _BAND):
        rows = np.arange(top, min(top + _BAND, size[1]))
        for down in offsets:
            for right in offsets:
                image[rows] += ink(lens.angles(np.arange(size[0]) + right + slant * down,
                                               rows + down + slant * right))
    image /= _SUB * _SUB
    x, y = np.meshgrid(*(np.linspace(-1, 1, side) for side in size))
    light = 1 - _FALL * (x * x + y * y) / 2
    grey = (_PAPER + (_INK - _PAPER) * image) * light
    grey += np.random.default_rng(seed).normal(0, _NOISE, grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def _ink(inverse, page, angles):
    """Whether samples in the directions ``angles`` (2, ...) hit a dot: float of that shape."""
    theta = np.hypot(*angles)
    sine = np.sinc(theta / np.pi)
    ray = angles[0] * sine, angles[1] * sine, np.cos(theta)
    i, j, w = (row[0] * ray[0] + row[1] * ray[1] + row[2] * ray[2] for row in inverse)
    with np.errstate(divide="ignore", invalid="ignore"):
        i, j = _unbent(page, inverse, i, j, w) if page.bend else (i / w, j / w)
        hit = (w > 0) & ((i - np.rint(i))**2 + (j - np.rint(j))**2 < RADIUS**2)
        hit &= (i > -.5) & (i < page.columns - .5) & (j > -.5) & (j < page.rows - .5)
    return hit.astype(np.float32)


def _unbent(page, inverse, i, j, w):
    """Column and row of a bent page that samples see; ``i``, ``j``, ``w``: those of the flat page,
    homogeneous."""
    slope, height = inverse @ page.normal, 0.0
    for _ in range(_BENDS):
        scale = (1 + height * slope[2]) / w
        flat = np.stack([i * scale - height * slope[0], j * scale - height * slope[1]], axis=-1)
        points, height = page.bend.unrolled(flat - page.middle)
    return np.moveaxis(points + page.middle, -1, 0)


def seen(lens, page, radius=RADIUS):
    """What ``lens`` shows of round areas of ``radius`` steps about all positions of ``page``.

    Returns ``index`` (n, 2), outlines (n, 64, 2) in pixels, and whether each lies in the picture
    (n,).
    """
    i, j = np.meshgrid(np.arange(page.columns), np.arange(page.rows))
    index = np.stack([i.ravel(), j.ravel()], axis=1)
    turn = 2 * np.pi * np.arange(_OUTLINE) / _OUTLINE
    ring = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rays = page.rays((index[:, None] + ring).reshape(-1, 2))
    outline = lens.project(rays).reshape(len(index), -1, 2)
    inside = (((outline > 0) & (outline < np.array(SIZE) - 1)).all(axis=(1, 2))
              & (rays[:, 2].reshape(len(index), -1) > 0).all(axis=1))
    return index, outline, inside


def whole(lens, page, index, xy, inside):
    """Which (n,) of the pixels ``xy`` (n, 2) of positions ``index`` that are ``inside`` are no
    second picture of a position.

    OpenCV's model shows far points of the page once more inside the picture, beyond its fold.
    """
    there = inside & ((xy > 0) & (xy < np.array(SIZE) - 1)).all(axis=1)
    angles = lens.angles_at(xy[there])
    theta = np.linalg.norm(angles, axis=1)
    found = np.column_stack([angles * np.sinc(theta / np.pi)[:, None], np.cos(theta)])
    ray = page.rays(index[there])
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    there[there] = (found * ray).sum(axis=1) > _SAME
    return there


def _truth(lens, page):
    """Centres of gravity of the dots' pictures, and which dots are whole."""
    index, outline, inside = seen(lens, page)
    xy = centroid(outline)
    # The smallest singular value of an ellipse's outline is its narrow half, times sqrt(n / 2).
    narrow = np.linalg.svd(outline - xy[:, None], compute_uv=False)[:, 1] * 2 / np.sqrt(
        _OUTLINE / 2)
    return Truth("dots", index, xy, whole(lens, page, index, xy, inside) & (narrow >= _FINE))


def centroid(outline):
    """Centre of gravity (n, 2) of polygons (n, corners, 2)."""
    middle = outline.mean(axis=1, keepdims=True)
    here = outline - middle
    after = np.roll(here, -1, axis=1)
    twice = here[..., 0] * after[..., 1] - after[..., 0] * here[..., 1]
    return middle[:, 0] + ((here + after) * twice[..., None]).sum(axis=1) / (
        3 * twice.sum(axis=1)[:, None])


def area(outline):
    """Areas (n,) of polygons (n, corners, 2)."""
    after = np.roll(outline, -1, axis=1)
    return np.abs((outline[..., 0] * after[..., 1]
                   - after[..., 0] * outline[..., 1]).sum(axis=1)) / 2
