"""Matrices of views: the trained picture seen by a pinhole camera that looks elsewhere.

Axes of both cameras: x to the right, y down, z forward. A view turned by ``rotation`` has the axes
that are the columns of that matrix, in the axes of the trained camera.

========= ======================================================================================
positive  the view
========= ======================================================================================
pan       looks to the right
tilt      looks up
roll      is turned clockwise about its own axis, so that its picture turns counter-clockwise
zoom > 1  shows a smaller part, larger
========= ======================================================================================

Pan is about the vertical axis, then tilt about the camera's own horizontal one, then roll: as a
head on a tripod.
"""

from dataclasses import dataclass

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.view import CAMERA_FORMATS, View

__all__ = ["Angles", "LIMITS", "PlaneCamera", "camera_values", "frame_of_values", "has_plane",
           "view_matrix"]

LIMITS = {"pan": (-90.0, 90.0), "tilt": (-90.0, 90.0), "roll": (-180.0, 180.0),
          "zoom": (0.25, 8.0)}
"""Lowest and highest value of each number of :class:`Angles`; degrees but for the zoom."""


@dataclass(frozen=True)
class Angles:
    """Pan, tilt and roll in degrees, and the zoom, a factor; by default the trained picture.

    Raises
    ------
    InputError
        If a value is outside :data:`LIMITS`.
    """
    pan: float = 0.0
    tilt: float = 0.0
    roll: float = 0.0
    zoom: float = 1.0

    def __post_init__(self):
        for name, (low, high) in LIMITS.items():
            if not low <= getattr(self, name) <= high:
                raise InputError(f"{name} is {getattr(self, name):g}, the limits are {low:g} and "
                                 f"{high:g}")

    @property
    def rotation(self):
        """3x3 rotation from the axes of the view to those of the trained camera."""
        (cp, ct, cr), (sp, st, sr) = (turn(np.radians([self.pan, self.tilt, self.roll]))
                                      for turn in (np.cos, np.sin))
        about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        about_x = np.array([[1, 0, 0], [0, ct, -st], [0, st, ct]])
        about_z = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
        return about_y @ about_x @ about_z


@dataclass(frozen=True)
class PlaneCamera:
    """The pinhole camera of a picture without distortion.

    Parameters
    ----------
    size : (int, int)
        Width and height in pixels.
    focal : float
        Focal length in pixels along a row.
    centre : (float, float)
        Pixel of the camera's axis.
    aspect : float
        Focal length along a column over the one along a row.
    """
    size: tuple
    focal: float
    centre: tuple
    aspect: float = 1.0

    @classmethod
    def of(cls, descriptor):
        """The camera of the corrected picture that a ``descriptor`` was trained for.

        Raises
        ------
        InputError
            If the descriptor does not state it, as one trained from a remap table, or states what
            no camera has.
        """
        if not has_plane(descriptor):
            raise InputError("the descriptor does not state the focal length of its picture "
                             "(provenance.frame), which a view needs: train it from points or "
                             "from a camera file")
        frame = descriptor.provenance["frame"]
        numbers = [float(one) if isinstance(one, int | float) else np.nan for one in (*frame, 1)]
        focal, *centre, aspect = numbers[:4]
        if not (np.isfinite(numbers).all() and focal > 0 and aspect > 0):
            raise InputError(f"the descriptor's provenance.frame is {frame}, a focal length above "
                             f"0, the centre and an aspect ratio above 0 are needed")
        return cls(descriptor.geometry.corrected, focal, tuple(centre), aspect)

    @property
    def matrix(self):
        """3x3 matrix from a direction (x, y, z) to the pixel (u, v, 1), but for its depth z."""
        return np.array([[self.focal, 0, self.centre[0]],
                         [0, self.focal * self.aspect, self.centre[1]], [0, 0, 1]])

    def view(self, size=None, zoom=1.0):
        """The camera of a view of ``size`` pixels, by default the same.

        At zoom 1 its row shows as much as a row of this picture. The zoom is about the axis.
        """
        width, height = size = tuple(size or self.size)
        scale = width / self.size[0]
        middle = np.array([width - 1, height - 1]) / 2
        centre = middle + scale * (np.array(self.centre) - (np.array(self.size) - 1) / 2)
        return PlaneCamera(size, zoom * scale * self.focal, tuple(centre.tolist()), self.aspect)

    def looking(self, angles, size=None):
        """The :class:`~ncdc_spec.view.View` of ``angles`` and ``size``, by default the same.

        Raises
        ------
        InputError
            If the view is so far off the axis that its matrix does not fit the registers.
        """
        view = self.view(size, angles.zoom)
        try:
            return View.of(view_matrix(self, view, angles.rotation), view.size)
        except InputError as error:
            named = ", ".join(f"{name} {getattr(angles, name):g}" for name in LIMITS)
            raise InputError(f"{named} is too far off the axis: {error}") from error


def has_plane(descriptor):
    """Whether the descriptor states the camera of its corrected picture."""
    frame = descriptor.provenance.get("frame")
    return isinstance(frame, list | tuple) and len(frame) >= 3


def camera_values(descriptor):
    """Register values, by name, of the camera of the trained picture.

    The corrector does nothing with them: they tell a device what its lens needs for a view. All
    are 0 if the descriptor does not state the camera, or states one that does not fit them.

    Raises
    ------
    InputError
        If it states what no camera has.
    """
    numbers = ()
    if has_plane(descriptor):
        camera = PlaneCamera.of(descriptor)
        numbers = camera.focal, *camera.centre, camera.aspect
    raw = [round(number * 2**q.f_bits) for number, q in zip(numbers, CAMERA_FORMATS.values())]
    fits = raw and raw[0] and all(q.holds(one) for one, q in zip(raw, CAMERA_FORMATS.values()))
    return dict(zip(CAMERA_FORMATS, raw if fits else [0] * len(CAMERA_FORMATS)))


def frame_of_values(values):
    """``provenance.frame`` of a descriptor whose camera the register ``values`` state, by name;
    None if they do not."""
    frame = [float(q.real(values[name])) for name, q in CAMERA_FORMATS.items()]
    return frame if frame[0] > 0 and frame[3] > 0 else None


def view_matrix(trained, view, rotation):
    """Matrix (..., 3, 3) from pixels (u, v, 1) of a view to those of the trained picture.

    The third element of the product is the depth, positive in front of the camera.

    Parameters
    ----------
    trained, view : PlaneCamera
    rotation : ndarray, shape (..., 3, 3)
        From the axes of the view to those of the trained camera.
    """
    return trained.matrix @ rotation @ np.linalg.inv(view.matrix)
