"""What a network is trained on: a points file of photos, or the file of a calibrated camera."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ncdc_model.calibration.camera_file import load_camera_map, training_grid
from ncdc_model.calibration.frame import IdealFrame, ideal_frame
from ncdc_model.calibration.points import TargetPoints
from ncdc_model.errors import InputError
from ncdc_model.files import read_bytes
from ncdc_model.geometry import Geometry
from ncdc_model.interpolation import FAST
from ncdc_model.valid import REACH, Calibrated, grid_pitch

__all__ = ["Source", "is_points_file", "load_source"]


_ANCHORS = 31, 21      # columns and rows of the grid of anchors over the whole frame


@dataclass(frozen=True)
class Source:
    """Training pairs and what else is known of the map.

    Parameters
    ----------
    pairs : (u, v, x, y) of ndarray, shape (N,)
        Corrected pixels and their sources in the distorted image.
    geometry : Geometry
    back_map : callable or None
        The exact map (u, v) -> (x, y) over the whole frame, where a camera file gives it.
    calibrated : Calibrated or None
        Where points cover the map, where no exact one is known.
    smooth_map : callable or None
        The smooth lens that was fitted to the points.
    anchors : (u, v, x, y) or None
        Pairs of the smooth lens where the points do not cover the frame: there the network is
        to follow that lens, since left alone it would run off.
    provenance : dict
        For the descriptor: ``source`` (file name), ``source_kind``, ``source_hash``, ``frame``
        (focal length and centre of the corrected image in pixels), and of points ``homography``.
    frame : IdealFrame or None
        The points' rows and columns, whose straightness measures a network.
    """
    pairs: tuple
    geometry: Geometry
    back_map: object = None
    calibrated: Calibrated | None = None
    smooth_map: object = None
    anchors: tuple | None = None
    provenance: dict = field(default_factory=dict)
    frame: IdealFrame | None = None


def is_points_file(path):
    """Whether ``path`` is a file of ``ncdc calibrate``; :class:`InputError` if unreadable."""
    try:
        table = json.loads(read_bytes(path))
    except ValueError:
        return False
    return isinstance(table, dict) and table.get("format") == "ncdc points"


def load_source(path, size=None, zoom=None, bayer="RGGB", fill=(0, 0, 0), camera=None,
                interpolation=FAST):
    """Read a points or camera file and choose the corrected frame.

    Parameters
    ----------
    path : path
    size : (int, int), optional
        Corrected width and height; default that of the photos.
    zoom : str or float, optional
        As in :func:`ncdc_model.lens.choose_frame`; default fit.
    bayer, fill, interpolation
        As in :class:`Geometry`.
    camera : str, optional
        Which camera of a camchain.

    Raises
    ------
    InputError
        If the file or an option is bad.
    """
    options = dict(bayer=bayer, fill=tuple(fill), interpolation=interpolation)
    if not is_points_file(path):
        return _of_camera(path, size, zoom, camera, options)
    if camera is not None:
        raise InputError(f"camera {camera} is asked for, {path} holds points")
    return _of_points(path, size, zoom, options)


def _of_camera(path, size, zoom, camera, options):
    camera = load_camera_map(path, size, zoom, camera)
    provenance = {"source": Path(path).name, "source_kind": camera.model,
                  "source_hash": camera.digest, "frame": _numbers(camera.frame)}
    return Source(training_grid(camera.back_map, camera.geometry()), camera.geometry(**options),
                  back_map=camera.back_map, provenance=provenance)


def _of_points(path, size, zoom, options):
    points = TargetPoints.load(path)
    frame = ideal_frame(points, size, zoom or "fit")
    geometry = Geometry(*frame.camera.frame.size, *points.size, **options)
    (u, v), (x, y) = frame.corrected.T, frame.distorted.T
    pitch = grid_pitch([(u[frame.photo == k], v[frame.photo == k]) for k in np.unique(frame.photo)])
    matrices = [matrix.ravel().tolist() for matrix in frame.homographies]
    provenance = {"source": Path(path).name, "source_kind": f"{points.target} points",
                  "source_hash": points.digest, "frame": _numbers(frame.camera.frame),
                  "points_dropped": sum(frame.rejected.values()),
                  "homography": matrices[0] if len(matrices) == 1 else matrices}
    calibrated = Calibrated(u, v, x, y, REACH * pitch)
    smooth = frame.camera.back_map
    anchors = training_grid(smooth, geometry, _ANCHORS, sum(_ANCHORS),
                            without=calibrated.mask(smooth, geometry))
    return Source((u, v, x, y), geometry, calibrated=calibrated, smooth_map=smooth,
                  anchors=anchors, provenance=provenance, frame=frame)


def _numbers(frame):
    return [float(frame.focal), *map(float, frame.centre)]
