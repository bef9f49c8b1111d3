"""Camera files, of other programs and of NCDC, as the exact map of a corrected frame."""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ncdc_model.calibration.files.known import reject_known_text
from ncdc_model.calibration.files.read import read_lens
from ncdc_model.golden.valid import valid_mask
from ncdc_model.lens import Camera, Frame, choose_frame
from ncdc_model.mask_border import border_pixels
from ncdc_spec.errors import InputError
from ncdc_spec.files import read_bytes
from ncdc_spec.geometry import Geometry

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
        Name of the lens model, for reports.
    digest : str
        Twelve hex digits of the hash of the file.
    notes, warnings : tuple of str
        Sentences on how the file was read, and on what is odd about it.
    """
    size: tuple
    frame: Frame
    distort: object
    undistort: object
    model: str
    digest: str
    notes: tuple = ()
    warnings: tuple = ()

    def back_map(self, u, v):
        """Distorted pixel (x, y) of the corrected pixel (u, v)."""
        return self.distort(*self.frame.ideal(u, v))

    def geometry(self, **options):
        """:class:`Geometry` of the two images; ``options``: bayer, fill."""
        return Geometry(*self.frame.size, *self.size, **options)


def load_camera_map(path, size=None, zoom=None, camera=None, sensor=None):
    """Read a camera file and choose the corrected frame.

    The formats are those of :mod:`ncdc_model.calibration.files`: OpenCV, ROS, BoofCV, Kalibr,
    camodocal, COLMAP, mrcal, MATLAB, RealSense, NeRF, MC-Calib, OCamCalib, DepthAI, OpenSfM,
    stella_vslam; and the camera file (TOML) of
    :class:`ncdc_model.lens.Camera`.

    Parameters
    ----------
    path : path
    size : (int, int), optional
        Corrected width and height; default that of the distorted image.
    zoom : str or float, optional
        fit, fill or the magnification in the middle, as in :func:`ncdc_model.lens.choose_frame`.
        Without size and zoom, the frame is that of the file, if it holds one: a projection
        matrix, or the frame of an NCDC file; else zoom is fit.
    camera : str, optional
        Which of several cameras in the file.
    sensor : (int, int), optional
        Width and height of the frames to be corrected: if the file does not state them, or another
        size of the same aspect.

    Raises
    ------
    InputError
        If the file cannot be read, lacks a value, holds an unknown model, one that does not
        suit the zoom or the sensor, or not the ``camera``.
    """
    content = read_bytes(path)
    if Path(path).suffix.lower() == ".toml":
        return _ours(path, content, size, zoom, camera, sensor)
    try:
        lens = read_lens(path, content, camera, sensor)
        size, notes, ends = tuple(size or lens.size), lens.notes, _end(lens)
        if lens.frame is not None and zoom is None and size == lens.size:
            frame = lens.frame
            notes += (f"the corrected picture is that of the projection matrix: focal lengths "
                      f"{frame.focal:.2f} and {frame.aspect * frame.focal:.2f}, centre "
                      f"({frame.centre[0]:.2f}, {frame.centre[1]:.2f}); --zoom gives another",)
        elif any(side in ends for side in ("left", "right")) and zoom in (None, "fit", "fill"):
            raise InputError(f"{ends}; check the coefficients and the size, or give a number as "
                             f"--zoom for the part that it reaches")
        else:
            frame = choose_frame(lens.undistort, lens.distort, lens.size, size, zoom or "fit")
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return CameraMap(lens.size, frame, lens.distort, lens.undistort, lens.model,
                     _digest(content), notes, lens.warnings + (ends,) * bool(ends))


def _end(lens):
    """Sentence on where the model of the :class:`FileLens` ends; "" if it reaches the middles of
    the image's edges."""
    if not np.isfinite(lens.limit):
        return ""
    width, height = lens.size
    points, _ = replace(lens, rotation=None).undistort(
        np.array([0, width - 1, (width - 1) / 2, (width - 1) / 2]),
        np.array([(height - 1) / 2, (height - 1) / 2, 0, height - 1]))
    missed = [edge for edge, point in zip(("left", "right", "upper", "lower"), points)
              if not np.isfinite(point)]
    if not missed:
        return ""
    return (f"the lens model does not reach the {' and '.join(missed)} "
            f"edge{'s' * (len(missed) > 1)} of the image: it ends at "
            f"{np.degrees(np.arctan(lens.limit)):.1f} degrees off its axis, where it has a pole or "
            f"folds back")


def _ours(path, content, size, zoom, camera, sensor):
    if camera is not None:
        raise InputError(f"{path}: camera {camera} is asked for, the file holds one camera without "
                         f"a name")
    try:
        reject_known_text(content.decode("utf-8", "replace"))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    ours = Camera.load(path)
    if sensor is not None and tuple(sensor) != ours.size:
        raise InputError("{}: the camera is for {}x{} pixels, the sensor has {}x{}; a camera file "
                         "of ours is not scaled".format(path, *ours.size, *sensor))
    if size is not None or zoom is not None:
        ours = ours.framed(size, zoom or "fit")
    return CameraMap(ours.size, ours.frame, ours.distort, ours.undistort, "ncdc camera",
                     _digest(content))


def _digest(content):
    return hashlib.sha256(content).hexdigest()[:12]


def training_grid(back_map, geometry, grid=GRID, border=BORDER, mask=None, without=None):
    """Exact training pairs (u, v, x, y) of a known map, each of shape (N,).

    They are a grid over the valid part of the corrected frame and points along the border of the
    valid region, where a network fitted to a grid alone has its largest errors.

    Parameters
    ----------
    back_map : callable
        (x, y) of (u, v); not-a-number where there is no source.
    geometry : Geometry
    grid : (int, int)
        Columns and rows.
    border : int
        Points on the border, at most.
    mask : ndarray of bool, shape (height, width), optional
        The valid pixels, if they are known: those of
        :func:`~ncdc_model.golden.valid.valid_mask`.
    without : ndarray of bool, shape (height, width), optional
        Pixels from which no pair is taken.

    Raises
    ------
    InputError
        If too little of the frame has a source.
    """
    width, height = geometry.corrected
    mask = valid_mask(back_map, geometry) if mask is None else mask
    if mask.mean() < .05:
        raise InputError(f"only {100 * mask.mean():.1f} % of the corrected frame has a source, "
                         f"5 % is the limit; give another zoom")
    u, v = (line.ravel() for line in np.meshgrid(np.linspace(0, width - 1, grid[0]),
                                                 np.linspace(0, height - 1, grid[1])))
    rows, columns = border_pixels(mask, border)
    u, v = np.concatenate([u, columns]), np.concatenate([v, rows])
    on = mask if without is None else mask & ~without
    on = on[np.round(v).astype(int), np.round(u).astype(int)]
    u, v = u[on], v[on]
    x, y = back_map(u, v)
    known = np.isfinite(x) & np.isfinite(y)
    return u[known], v[known], x[known], y[known]
