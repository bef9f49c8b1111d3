"""Light on every active pixel of a sensor, through a lens that blurs."""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.example import scene_at
from ncdc_model.lens import Camera
from ncdc_spec.errors import InputError

__all__ = ["MARGIN", "Light", "camera_of", "photo_light", "scene_light"]

MARGIN = 16                 # active pixels around those that the frame is made of
_SUBSAMPLES = 2             # of the scene, per active pixel and axis
_KNOTS = 4                  # samples of the frame between exact inverses of the lens
_STRIP = 64                 # rows of active pixels that are rendered at once


@dataclass(frozen=True)
class Light:
    """Light on a sensor that reduces either axis by ``reduction``.

    Parameters
    ----------
    name : str
    reduction : int
    values : ndarray of float32, shape (height, width, 3)
        Linear light, 0..255, of each active pixel. :data:`MARGIN` more pixels lie before the
        frame's first one and after its last one.
    """
    name: str
    reduction: int
    values: np.ndarray

    @property
    def size(self):
        """Width and height of the frame that the sensor sends."""
        rows, columns = self.values.shape[:2]
        return tuple((length - 2 * MARGIN) // self.reduction for length in (columns, rows))


def camera_of(camera, size):
    """``camera`` with frames of another ``size``: the same lens, its middle in their middle."""
    table, scale = camera.to_dict(), size[0] / camera.size[0]
    table["width"], table["height"] = size
    table["f_distorted"] *= scale
    table["centre"] = [float(new / 2 + scale * (at - old / 2))
                       for at, old, new in zip(table["centre"], camera.size, size)]
    if "residual" in table:
        table["residual"]["scale"] *= scale
    for name in ("f_corrected", "corrected_size", "corrected_centre"):
        table.pop(name, None)
    return Camera.from_dict(table)


def scene_light(camera, reduction, blur):
    """:class:`Light` of the built-in scene through ``camera``, whose frame is the reduced one.

    ``blur``: standard deviation of the lens's point spread, a Gaussian, in active pixels.
    """
    from scipy.interpolate import RectBivariateSpline  # 30 MB, which few need

    width, height = camera.size
    margin = _KNOTS * (2 + MARGIN // reduction // _KNOTS)
    kx, ky = (np.arange(-margin, length + margin + 1., _KNOTS) for length in camera.size)
    fields = [RectBivariateSpline(ky, kx, field)
              for field in camera.undistort(*np.meshgrid(kx, ky))]
    offset = (np.arange(_SUBSAMPLES) - (_SUBSAMPLES - 1) / 2) / _SUBSAMPLES
    xs, ys = ((np.arange(-MARGIN, length * reduction + MARGIN)[:, None] + offset)
              / reduction for length in (width, height))
    strips = []
    for first in range(0, len(ys), _STRIP):
        rows = ys[first:first + _STRIP]
        fine = scene_at(*(field(rows.ravel(), xs.ravel()) for field in fields))
        strips.append(fine.reshape(len(rows), _SUBSAMPLES, len(xs), _SUBSAMPLES, 3)
                      .mean(axis=(1, 3)).astype(np.float32))
    return Light("built-in scene", reduction, _blurred(np.concatenate(strips), blur))


def photo_light(name, photo, reduction, blur):
    """:class:`Light` of a ``photo``, an array (height, width[, 3]) of uint8, whose pixels are the
    active ones.

    Raises
    ------
    InputError
        If the frame would be smaller than 64 x 48 samples.
    """
    colour = np.repeat(photo[..., None], 3, axis=2) if photo.ndim == 2 else photo
    rows, columns = ((length - 2 * MARGIN) // (2 * reduction) * 2 * reduction + 2 * MARGIN
                     for length in colour.shape[:2])
    light = Light(name, reduction,
                  _blurred(np.ascontiguousarray(colour[:rows, :columns]).astype(np.float32), blur))
    if light.size[0] < 64 or light.size[1] < 48:
        raise InputError(f"{name} has {photo.shape[1]}x{photo.shape[0]} pixels: reduced by "
                         f"{reduction} it must have 64x48 at least")
    return light


def _blurred(light, blur):
    return cv2.GaussianBlur(light, (0, 0), blur) if blur else light
