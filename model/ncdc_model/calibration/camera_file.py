"""Camera files: OpenCV's, ROS's, Kalibr's and our own, as the exact map of a corrected frame."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ncdc_model.calibration.camera_models import lens_of_table
from ncdc_model.calibration.camera_tables import read_table
from ncdc_model.errors import InputError
from ncdc_model.files import read_bytes
from ncdc_model.geometry import Geometry
from ncdc_model.lens import Camera, Frame, choose_frame
from ncdc_model.valid import valid_mask

__all__ = ["CameraMap", "load_camera_map", "training_grid"]

GRID = 61, 41          # columns and rows of the training grid
BORDER = 240           # further training points on the border of the valid region


@dataclass(frozen=True)
class CameraMap:
    """A calibrated camera and the corrected frame chosen for it.

    Parameters
    ----------
    size : (int, int)
        Width and height of the distorted image.
    frame : Frame
        The corrected image.
    distort : callable
        Distorted pixel of ideal point (a, b); not-a-number where the model folds back.
    undistort : callable
        Its inverse; not-a-number where there is none.
    model : str
        Which model the file holds, for reports.
    digest : str
        Twelve hex digits of the hash of the file.
    """
    size: tuple
    frame: Frame
    distort: object
    undistort: object
    model: str
    digest: str

    def back_map(self, u, v):
        """Distorted pixel (x, y) of the corrected pixel (u, v)."""
        return self.distort(*self.frame.ideal(u, v))

    def geometry(self, **options):
        """:class:`Geometry` of the two images; ``options``: bayer, fill."""
        return Geometry(*self.frame.size, *self.size, **options)


def load_camera_map(path, size=None, zoom=None, camera=None):
    """Read a camera file and choose the corrected frame.

    Understood are OpenCV FileStorage (YAML, XML, JSON), ROS camera_info (YAML), BoofCV and Kalibr
    camchain (YAML), see :mod:`ncdc_model.calibration.camera_models`, and the camera file (TOML)
    of :class:`ncdc_model.lens.Camera`.

    Parameters
    ----------
    path : path
    size : (int, int), optional
        Corrected width and height; default that of the distorted image.
    zoom : str or float, optional
        fit, fill or the magnification in the middle, as in :func:`ncdc_model.lens.choose_frame`;
        default fit. A TOML file that holds a frame keeps it if neither size nor zoom is given.
    camera : str, optional
        Which camera of a camchain.

    Raises
    ------
    InputError
        If the file cannot be read, lacks a value, holds an unknown model or one that does not
        suit the zoom, or not the ``camera``.
    """
    digest = hashlib.sha256(read_bytes(path)).hexdigest()[:12]
    if Path(path).suffix.lower() == ".toml":
        if camera is not None:
            raise InputError(f"{path}: camera {camera} is asked for, the file holds one camera "
                             f"without a name")
        ours = Camera.load(path)
        if size is not None or zoom is not None:
            ours = ours.framed(size, zoom or "fit")
        return CameraMap(ours.size, ours.frame, ours.distort, ours.undistort, "ncdc camera", digest)
    try:
        lens = lens_of_table(read_table(path), camera)
        frame = choose_frame(lens.undistort, lens.distort, lens.size, tuple(size or lens.size),
                             zoom or "fit")
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return CameraMap(lens.size, frame, lens.distort, lens.undistort, lens.model, digest)


def training_grid(back_map, geometry, grid=GRID, border=BORDER, without=None):
    """Exact training pairs (u, v, x, y) of a known map, each of shape (N,).

    A grid over the corrected frame where it is valid, and points along the border of the valid
    region, where a network that is fitted to a grid alone errs most.

    Parameters
    ----------
    back_map : callable
        (x, y) of (u, v); not-a-number where there is no source.
    geometry : Geometry
    grid : (int, int)
        Columns and rows.
    border : int
        Most points on the border.
    without : ndarray of bool, shape (height, width), optional
        Pixels from which no pair is taken.

    Raises
    ------
    InputError
        If too little of the frame has a source.
    """
    width, height = geometry.corrected
    mask = valid_mask(back_map, geometry)
    if mask.mean() < .05:
        raise InputError(f"only {100 * mask.mean():.1f} % of the corrected frame has a source, "
                         f"5 % is the limit; give another zoom")
    u, v = (line.ravel() for line in np.meshgrid(np.linspace(0, width - 1, grid[0]),
                                                 np.linspace(0, height - 1, grid[1])))
    padded = np.pad(mask, 1)
    inner = padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    rows, columns = np.nonzero(mask & ~inner)
    some = np.linspace(0, len(rows) - 1, min(border, len(rows))).astype(int)
    u, v = np.concatenate([u, columns[some]]), np.concatenate([v, rows[some]])
    on = mask if without is None else mask & ~without
    on = on[np.round(v).astype(int), np.round(u).astype(int)]
    u, v = u[on], v[on]
    x, y = back_map(u, v)
    known = np.isfinite(x) & np.isfinite(y)
    return u[known], v[known], x[known], y[known]
