"""Synthetic units of a production lot, each with its true flaws, some of them bad."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from ncdc_model.example.target import target_photo
from ncdc_model.images import write_image
from ncdc_model.lens import Camera
from ncdc_spec.geometry import MONO

__all__ = ["BAD", "LIMITS", "SIZE", "TrueUnit", "make_lot", "make_unit", "write_photos"]

SIZE = 320, 240
_PHOTOS = 3
_SCALE = 0.012          # ideal units per millimetre of the page
_POSES = (0.0, 0.0), (-14.0, 10.0), (10.0, 16.0)     # turns of the page about x and y, degrees

# What a product with this lens allows: options of `ncdc lot run`.
LIMITS = {"max_error": 0.5, "min_coverage": 70, "min_focal": 165, "max_focal": 177, "max_axis": 5,
          "max_tilt": 2.5, "max_decentring": 1.5, "max_roll": 1.5, "max_uneven": 0.25}


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
    """
    serial: str
    camera: Camera
    roll_deg: float
    kind: str
    seed: int

    def photos(self):
        """Its photos, grey uint8 (height, width)."""
        turn = Rotation.from_euler("z", self.roll_deg, degrees=True).as_matrix()
        for number, (about_x, about_y) in enumerate(_POSES):
            page = Rotation.from_euler("xy", (about_x, about_y), degrees=True).as_matrix()
            plane = turn @ np.column_stack([_SCALE * page[:, :2], (0, 0, 1)])
            photo = target_photo(self.camera, 10 * self.seed + number, MONO, plane)
            yield _SPOILED.get(self.kind, lambda photo: photo)(photo)


def _table(rng):
    """Camera file's table of a good unit: small flaws of every sort."""
    width, height = SIZE
    return {
        "width": width, "height": height, "radial": "kb",
        "k": [0.035, 0.012, -0.004, 0.001], "f_distorted": 171 * (1 + rng.normal(0, .006)),
        "centre": [(width - 1) / 2 + rng.normal(0, 1), (height - 1) / 2 + rng.normal(0, 1)],
        "p": rng.normal(0, .0006, 2).tolist(), "s": [0.0, 0.0, 0.0, 0.0],
        "tilt_rad": np.radians(rng.normal(0, .25, 2)).tolist()}


def _turned(rng, size):
    """Vector of that length in a random direction."""
    angle = rng.uniform(0, 2 * np.pi)
    return [size * np.cos(angle), size * np.sin(angle)]


def _off_axis(table, rng):
    return {"centre": np.add(table["centre"], _turned(rng, 9)).tolist()}


def _uneven(table, rng):
    return {"residual": {"scale": 1.0, "bump_centres": [rng.uniform(-.4, .4, 2).tolist()],
                         "bump_sigmas": [0.12], "bump_vectors": [_turned(rng, 3.0)]}}


# Changes of the camera's table, by what is bad.
_FLAWED = {
    "off axis": _off_axis,
    "decentred": lambda table, rng: {"p": _turned(rng, .02)},
    "tilted": lambda table, rng: {"tilt_rad": np.radians(_turned(rng, 6)).tolist()},
    "short lens": lambda table, rng: {"f_distorted": 171 * .94},
    "uneven": _uneven,
}


def _covered(photo):
    photo = photo.copy()
    photo[:, photo.shape[1] * 55 // 100:] = 90
    return photo


# Changes of the photos.
_SPOILED = {
    "blurred": lambda photo: cv2.GaussianBlur(photo, (0, 0), 4.0),
    "covered": _covered,
}
BAD = (*_FLAWED, "rolled", *_SPOILED)


def make_unit(number, kind="", seed=0):
    """:class:`TrueUnit` of that number, the same for the same arguments."""
    rng = np.random.default_rng((seed, number))
    table = _table(rng)
    if kind in _FLAWED:
        table |= _FLAWED[kind](table, rng)
    roll = 4.0 if kind == "rolled" else rng.normal(0, .3)
    return TrueUnit(f"U{number:04}", Camera.from_dict(table), float(roll), kind, number)


def make_lot(units, bad, seed=0):
    """Yield ``units`` units, of which ``bad`` ones are bad in turn, at random positions."""
    rng = np.random.default_rng(seed)
    kinds = dict(zip(rng.permutation(units)[:bad].tolist(), BAD * (bad // len(BAD) + 1)))
    for number in range(units):
        yield make_unit(number, kinds.get(number, ""), seed)


def write_photos(folder, unit):
    """Write the photos of ``unit`` into a folder of its name in ``folder``."""
    to = Path(folder) / unit.serial
    to.mkdir(parents=True, exist_ok=True)
    for number, photo in enumerate(unit.photos()):
        write_image(to / f"{number}.png", photo)
