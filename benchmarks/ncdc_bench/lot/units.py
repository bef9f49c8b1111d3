"""Synthetic units of a production lot, each with its true flaws, some of them bad."""

from dataclasses import dataclass
from itertools import cycle
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from ncdc_model.example.target import COLUMNS, PITCH, target_photo
from ncdc_model.images import write_image
from ncdc_model.lens import Camera
from ncdc_spec.geometry import MONO

__all__ = ["BAD", "LIMITS", "SIZE", "TrueUnit", "make_lot", "make_unit", "write_photos"]

SIZE = 400, 300
_FOCAL = 214.0          # pixels per radian
_SCALE = 0.012          # ideal units per millimetre of the page
_POSES = (0.0, 0.0), (-14.0, 10.0), (10.0, 16.0)     # turns of the page about x and y, degrees
_SAG = 0.01             # of a bent page's width

# What a product with this lens allows: options of `ncdc lot run`.
LIMITS = {"max_error": 0.6, "min_coverage": 70, "min_focal": 206, "max_focal": 222, "max_axis": 6,
          "max_tilt": 2, "max_decentring": 2, "max_roll": 2, "max_aspect": .01, "max_uneven": 0.05}


@dataclass(frozen=True)
class TrueUnit:
    """One unit.

    Parameters
    ----------
    serial : str
    camera : Camera
    roll_deg : float
        Of the sensor in its housing, which hangs level.
    kind : str
        What is bad about it, of :data:`BAD`; empty for a good unit.
    seed : int
        Of the noise in its photos.
    other : TrueUnit, optional
        The unit whose photos are among those of this one.
    """
    serial: str
    camera: Camera
    roll_deg: float
    kind: str
    seed: int
    other: "TrueUnit | None" = None

    def photos(self):
        """Its photos, grey uint8 (height, width)."""
        if self.kind == "duplicate photos":
            yield from self.other.photos()
            return
        for number in range(len(_POSES)):
            if self.kind == "mixed photos" and number == len(_POSES) - 1:
                yield self.other.photo(number, self.seed)
            else:
                yield _SPOILED.get(self.kind, lambda photo, rng: photo)(
                    self.photo(number, self.seed), np.random.default_rng((self.seed, number)))

    def photo(self, number, seed):
        """The photo of that pose; ``seed`` of its noise."""
        turn = Rotation.from_euler("z", self.roll_deg, degrees=True).as_matrix()
        page = Rotation.from_euler("xy", _POSES[number], degrees=True).as_matrix()
        plane = turn @ np.column_stack([_SCALE * page[:, :2], (0, 0, 1)])
        photo = target_photo(self.camera, 10 * seed + number, MONO, plane)
        return self._bent(photo, plane, turn @ page[:, 2]) if self.kind == "bent page" else photo

    def _bent(self, photo, plane, normal):
        """The photo of a page that is the part of a cylinder, from that of the flat page."""
        y, x = np.indices(photo.shape, dtype=float)
        a, b = self.camera.undistort(x, y)
        rays = np.stack([a, b, np.ones_like(a)], axis=-1)
        height, half = np.zeros_like(a), COLUMNS * PITCH / 2
        for _ in range(10):         # the ray meets the page where the page has the ray's height
            surface = np.column_stack([plane[:, :2], plane[:, 2]])
            lifted = np.moveaxis(np.broadcast_to(surface, (*a.shape, 3, 3)), -1, -2).copy()
            lifted[..., 2, :] += _SCALE * height[..., None] * normal
            on = np.linalg.solve(np.moveaxis(lifted, -1, -2), rays[..., None])[..., 0]
            on = on[..., :2] / on[..., 2:]
            height = _SAG * 2 * half * (on[..., 0] / half)**2
        seen = np.concatenate([on, np.ones((*a.shape, 1))], axis=-1) @ plane.T
        x, y = self.camera.distort(seen[..., 0] / seen[..., 2], seen[..., 1] / seen[..., 2])
        return cv2.remap(photo, np.float32(x), np.float32(y), cv2.INTER_CUBIC,
                         borderMode=cv2.BORDER_REPLICATE)


def _table(rng):
    """Camera file's table of a good unit: small flaws of every sort."""
    width, height = SIZE
    return {
        "width": width, "height": height, "radial": "kb",
        "k": [0.035, 0.012, -0.004, 0.001], "f_distorted": _FOCAL * (1 + rng.normal(0, .006)),
        "centre": [(width - 1) / 2 + rng.normal(0, 1), (height - 1) / 2 + rng.normal(0, 1)],
        "p": rng.normal(0, .0006, 2).tolist(), "s": [0.0, 0.0, 0.0, 0.0],
        "tilt_rad": np.radians(rng.normal(0, .25, 2)).tolist()}


def _turned(rng, size):
    """Vector of that length in a random direction."""
    angle = rng.uniform(0, 2 * np.pi)
    return [size * np.cos(angle), size * np.sin(angle)]


def _off_axis(table, rng):
    return {"centre": np.add(table["centre"], _turned(rng, 11)).tolist()}


def _uneven(table, rng):
    return {"residual": {"scale": 1.0, "bump_centres": [rng.uniform(-.4, .4, 2).tolist()],
                         "bump_sigmas": [0.12], "bump_vectors": [_turned(rng, 3.5)]}}


# Changes of the camera's table, by what is bad.
_FLAWED = {
    "off axis": _off_axis,
    "decentred": lambda table, rng: {"p": _turned(rng, .02)},
    "tilted": lambda table, rng: {"tilt_rad": np.radians(_turned(rng, 3)).tolist()},
    "short lens": lambda table, rng: {"f_distorted": _FOCAL * .94},
    "other lens": lambda table, rng: {"k": [-.12, .02, 0.0, 0.0], "f_distorted": _FOCAL * 1.2},
    "aspect": lambda table, rng: {"aspect": 1.03},
    "uneven": _uneven,
}


def _covered(photo, rng):
    photo = photo.copy()
    photo[:, photo.shape[1] * 55 // 100:] = 90
    return photo


def _half_soft(photo, rng):
    """The right half out of focus, as by a lens that stands askew."""
    soft = cv2.GaussianBlur(photo, (0, 0), 2.0)
    part = np.clip((np.arange(photo.shape[1]) / photo.shape[1] - .5) * 10 + .5, 0, 1)
    return np.rint(photo + part * (soft - photo.astype(float))).astype(np.uint8)


def _dead_rows(photo, rng):
    photo = photo.copy()
    photo[rng.choice(len(photo), 2, replace=False)] = 0
    return photo


def _swapped_rows(photo, rng):
    """Pairs of rows in the wrong order in a quarter of the picture, as by a wrong readout."""
    photo, first = photo.copy(), len(photo) * 3 // 8 // 2 * 2
    part = slice(first, first + len(photo) // 4 // 2 * 2)
    photo[part] = photo[part].reshape(-1, 2, photo.shape[1])[:, ::-1].reshape(-1, photo.shape[1])
    return photo


def _noisy(photo, rng):
    return np.clip(photo + rng.normal(0, 30, photo.shape), 0, 255).astype(np.uint8)


# Changes of the photos.
_SPOILED = {
    "blurred": lambda photo, rng: cv2.GaussianBlur(photo, (0, 0), 4.0),
    "half out of focus": _half_soft,
    "covered": _covered,
    "dead rows": _dead_rows,
    "swapped rows": _swapped_rows,
    "noise": _noisy,
}
_MIXED = "duplicate photos", "mixed photos"
BAD = (*_FLAWED, "rolled", "bent page", *_SPOILED, *_MIXED)


def make_unit(number, kind="", seed=0, other=None):
    """:class:`TrueUnit` of that number, the same for the same arguments.

    ``other``: number of the good unit whose photos it has as well, for the kinds that mix.
    """
    rng = np.random.default_rng((seed, number))
    table = _table(rng)
    if kind in _FLAWED:
        table |= _FLAWED[kind](table, rng)
    roll = 4.0 if kind == "rolled" else rng.normal(0, .3)
    return TrueUnit(f"U{number:04}", Camera.from_dict(table), float(roll), kind, number,
                    make_unit(other, seed=seed) if kind in _MIXED else None)


def make_lot(units, bad, seed=0):
    """Yield ``units`` units, of which ``bad`` ones are bad in turn, at random positions.

    What has photos of another unit has those of a good one, each of another.
    """
    rng = np.random.default_rng(seed)
    order = rng.permutation(units).tolist()
    kinds = dict(zip(order[:bad], BAD * (bad // len(BAD) + 1)))
    others = cycle(order[bad:] or order)
    for number in range(units):
        kind = kinds.get(number, "")
        yield make_unit(number, kind, seed, next(others) if kind in _MIXED else None)


def write_photos(folder, unit):
    """Write the photos of ``unit`` into a folder of its name in ``folder``."""
    to = Path(folder) / unit.serial
    to.mkdir(parents=True, exist_ok=True)
    for number, photo in enumerate(unit.photos()):
        write_image(to / f"{number}.png", photo)
