"""The composite camera: a wide-angle lens with manufacturing flaws, and its file."""

import json
import tomllib
from dataclasses import dataclass, replace
from numbers import Real

import numpy as np

from ncdc_model.lens.flaws import AsymmetricSurface, BrownWeng, TiltedSensor
from ncdc_model.lens.frame import Frame, choose_frame
from ncdc_model.lens.radial import AsariPolynomial, KannalaBrandt, Rational
from ncdc_spec.errors import InputError
from ncdc_spec.files import parse_text, write_text
from ncdc_spec.geometry import MAX_SIZE

__all__ = ["Camera"]

_RADIAL = {"kb": KannalaBrandt, "brown": Rational, "asari": AsariPolynomial}
_NAMES = ("width", "height", "radial", "k", "p", "s", "tilt_rad", "centre", "f_distorted",
          "aspect", "f_corrected", "corrected_size", "corrected_centre", "residual")
_SURFACE = ("scale", "bump_centres", "bump_sigmas", "bump_vectors", "poly")


@dataclass(frozen=True)
class Camera:
    """Map from corrected to distorted pixels through every stage of a real, low-cost camera.

    ``back_map`` of (u, v): the ideal point (a, b) of the corrected frame; ``radial``;
    ``decentring`` (14) and thin prism; ``tilt``; distorted pixel = ``focal`` (x, ``aspect`` y) +
    ``centre``; ``surface`` adds pixels. Pixel centres are integers.

    Parameters
    ----------
    size : (int, int)
        Width and height of the distorted image.
    radial : KannalaBrandt, Rational or AsariPolynomial
    focal : float
        Distorted pixels per unit of the ideal plane at the centre.
    centre : (float, float)
        Distorted pixel of the optical axis.
    frame : Frame
        The corrected picture.
    decentring : BrownWeng
    tilt : TiltedSensor
    surface : AsymmetricSurface
    aspect : float
        Width of a pixel over its height.
    """
    size: tuple
    radial: object
    focal: float
    centre: tuple
    frame: Frame
    decentring: BrownWeng
    tilt: TiltedSensor
    surface: AsymmetricSurface
    aspect: float = 1.0

    def distort(self, a, b):
        """Distorted pixel of the ideal point (a, b); not-a-number outside the lens's view."""
        x, y = self.tilt.distort(*self.decentring.distort(*self.radial.distort(a, b)))
        return self.surface.distort(self.focal * x + self.centre[0],
                                    self.focal * self.aspect * y + self.centre[1])

    def undistort(self, x, y):
        """Ideal point of the distorted pixel (x, y); not-a-number where the lens has none."""
        x, y = self.surface.undistort(x, y)
        x = (x - self.centre[0]) / self.focal
        y = (y - self.centre[1]) / (self.focal * self.aspect)
        return self.radial.undistort(*self.decentring.undistort(*self.tilt.undistort(x, y)))

    def back_map(self, u, v):
        """Distorted pixel (x, y) of the corrected pixel (u, v)."""
        return self.distort(*self.frame.ideal(u, v))

    def corrected(self, x, y):
        """Corrected pixel (u, v) of the distorted pixel (x, y), the inverse of ``back_map``."""
        return self.frame.pixel(*self.undistort(x, y))

    def project(self, rays):
        """Distorted pixel of directions or points ``rays`` (..., 3) in camera coordinates.

        Not-a-number for a ray that is not in front of the camera.
        """
        a, b, z = np.moveaxis(np.asarray(rays, np.float64), -1, 0)
        z = np.where(z > 0, z, np.nan)
        return self.distort(a / z, b / z)

    def ray(self, x, y):
        """Unit direction, shape (..., 3), of the distorted pixel (x, y)."""
        a, b = self.undistort(x, y)
        ray = np.stack([a, b, np.ones_like(a)], axis=-1)
        return ray / np.linalg.norm(ray, axis=-1, keepdims=True)

    def framed(self, size=None, zoom="fit"):
        """The same camera with the corrected frame of ``size`` (default: the image's) and zoom."""
        return replace(self, frame=choose_frame(self.undistort, self.distort, self.size,
                                                tuple(size or self.size), zoom))

    def to_dict(self):
        """Plain numbers, strings and lists, as in the camera file."""
        kind = next(name for name, model in _RADIAL.items() if isinstance(self.radial, model))
        p0, p1 = self.decentring.p[:2]
        table = {
            "width": self.size[0], "height": self.size[1], "radial": kind,
            "k": list(self.radial.a if kind == "asari" else self.radial.k),
            "p": [p1, p0, *self.decentring.p[2:]], "s": list(self.decentring.s),
            "tilt_rad": list(self.tilt.angles), "centre": list(self.centre),
            "f_distorted": self.focal, "f_corrected": self.frame.focal,
            "corrected_size": list(self.frame.size), "corrected_centre": list(self.frame.centre)}
        if self.aspect != 1:
            table["aspect"] = self.aspect
        if self.surface.scale:
            table["residual"] = {name: getattr(self.surface, name) for name in _SURFACE}
        return table

    @classmethod
    def from_dict(cls, table):
        """Camera of :meth:`to_dict`'s table.

        ``width``, ``height``, ``f_distorted`` and ``centre`` are needed. ``radial`` is kb
        (default, equidistant), brown (rational) or asari, ``k`` its coefficients; ``p``
        (OpenCV's order), ``s``, ``tilt_rad``, ``aspect`` and ``residual`` are the flaws. Without
        ``f_corrected`` the frame is that of zoom fit.

        Raises
        ------
        InputError
            If a value is missing, of the wrong kind, not finite or out of range.
        """
        try:
            return cls._of_table(table)
        except KeyError as error:
            raise InputError(f"the camera lacks the value {error}") from error
        except InputError:
            raise
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"the camera holds a value of the wrong kind: {error}") from error

    @classmethod
    def _of_table(cls, table):
        size = _vector(table, "corrected_size", None, 2)
        width, height = _number(table, "width"), _number(table, "height")
        sides = [("width", width), ("height", height)]
        for name, value in sides + [("corrected_size", value) for value in size or ()]:
            if value != int(value) or not 8 <= value <= MAX_SIZE:
                raise InputError(f"the camera's {name} is {value:g}, a whole number of 8 to "
                                 f"{MAX_SIZE} is needed")
        focal = _positive(table, "f_distorted")
        kind = table.get("radial", "kb")
        if kind not in _RADIAL:
            raise InputError(f"the camera's radial model is {kind!r}, one of {', '.join(_RADIAL)} "
                             f"is needed")
        p = _vector(table, "p", (0.0, 0.0))
        if len(p) < 2:
            raise InputError(f"the camera's p is {table['p']!r}, at least 2 numbers are needed")
        surface = _surface(table.get("residual", {}), (int(width), int(height)))
        camera = cls(
            size=(int(width), int(height)), radial=_RADIAL[kind](_vector(table, "k", ())),
            focal=focal, centre=_vector(table, "centre", None, 2), frame=None,
            aspect=_positive({"aspect": 1.0} | table, "aspect"),
            decentring=BrownWeng(p=(p[1], p[0], *p[2:]), s=_vector(table, "s", (0.0,) * 4, 4)),
            tilt=TiltedSensor(_vector(table, "tilt_rad", (0.0, 0.0), 2)), surface=surface)
        size = tuple(int(value) for value in size) if size else camera.size
        if "f_corrected" not in table:
            return camera.framed(size)
        middle = (size[0] - 1) / 2, (size[1] - 1) / 2
        return replace(camera, frame=Frame(size, _positive(table, "f_corrected"),
                                           _vector(table, "corrected_centre", middle, 2)))

    def save(self, path):
        """Write the camera file (TOML); it is replaced whole or not at all."""
        table = self.to_dict()
        residual = table.pop("residual", None)
        lines = ["# NCDC camera: ideal lens and manufacturing flaws; pixels, radians."]
        lines += [f"{name} = {json.dumps(value)}" for name, value in table.items()]
        if residual:
            lines += ["", "[residual]"]
            lines += [f"{name} = {json.dumps(value)}" for name, value in residual.items()]
        write_text(path, "\n".join(lines) + "\n")

    @classmethod
    def load(cls, path):
        """Read and check a camera file; raises :class:`InputError` as :meth:`from_dict`."""
        table = parse_text(path, "camera file", tomllib.loads)
        try:
            _known(table, _NAMES, "camera")
            return cls.from_dict(table)
        except InputError as error:
            raise InputError(f"{path}: {error}") from error


def _surface(table, size):
    """The :class:`AsymmetricSurface` of the part ``residual``, every bump complete."""
    _known(table, _SURFACE, "camera's residual")
    surface = AsymmetricSurface(size=size, **{name: _frozen(table[name], f"residual {name}")
                                              for name in _SURFACE if name in table})
    if table and "scale" not in table:
        raise InputError("the camera's residual lacks the value 'scale'")
    for name in _SURFACE:
        if name in table and isinstance(getattr(surface, name), tuple) == (name == "scale"):
            raise InputError(f"the camera's residual {name} is {table[name]!r}, "
                             f"{'a number is' if name == 'scale' else 'numbers are'} needed")
    counts = [len(getattr(surface, name)) for name in _SURFACE[1:4]]
    if len(set(counts)) > 1:
        raise InputError(f"the camera's residual has {counts[0]} bump_centres, {counts[1]} "
                         f"bump_sigmas and {counts[2]} bump_vectors, as many of each are needed")
    for name in ("bump_centres", "bump_vectors"):
        for pair in getattr(surface, name):
            if np.shape(pair) != (2,):
                raise InputError(f"the camera's residual {name} holds {pair}, pairs are needed")
    for sigma in surface.bump_sigmas:
        if isinstance(sigma, tuple) or not sigma > 0:
            raise InputError(f"the camera's residual bump_sigmas holds {sigma}, positive numbers "
                             f"are needed")
    if surface.poly and [np.shape(row) for row in surface.poly] != [(9,), (9,)]:
        raise InputError("the camera's residual poly needs two rows of nine numbers")
    return surface


def _known(table, names, what):
    if not isinstance(table, dict):
        raise InputError(f"the {what} is {table!r}, names and values are needed")
    for name in table:
        if name not in names:
            raise InputError(f"the {what} has the unknown value {name!r}")


def _positive(table, name):
    number = _number(table, name)
    if number <= 0:
        raise InputError(f"the camera's {name} is {number:g}, it must be positive")
    return number


def _frozen(value, name):
    """``value`` with lists as tuples, every number finite."""
    if isinstance(value, (list, tuple)):
        return tuple(_frozen(item, name) for item in value)
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"the camera's {name} holds {value!r}, a number is needed")
    number = float(value)
    if not np.isfinite(number):
        raise InputError(f"the camera's {name} holds {number}, a finite number is needed")
    return number


def _number(table, name):
    number = _frozen(table[name], name)
    if isinstance(number, tuple):
        raise InputError(f"the camera's {name} is {table[name]!r}, a number is needed")
    return number


def _vector(table, name, default, length=None):
    if name not in table and (default is not None or name == "corrected_size"):
        return default
    vector = _frozen(table[name], name)
    nested = not isinstance(vector, tuple) or any(isinstance(item, tuple) for item in vector)
    if nested or length not in (None, len(vector)):
        raise InputError(f"the camera's {name} is {table[name]!r}, {length or 'some'} numbers are "
                         f"needed")
    return vector
