"""Sources of training pairs: points of photos, the file of a calibrated camera, or a map."""

import json
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from ncdc_model.calibration.camera_file import load_camera_map, training_grid
from ncdc_model.calibration.frame import IdealFrame, ideal_frame
from ncdc_model.calibration.page_bend import PHOTOS
from ncdc_model.calibration.points import TargetPoints
from ncdc_model.calibration.points_csv import is_points_csv, load_csv
from ncdc_model.calibration.quality import bent, uneven
from ncdc_model.calibration.remap_file import are_remap_files
from ncdc_model.calibration.remap_source import load_remap
from ncdc_model.flaw_figures import SAG, sag_effect
from ncdc_model.golden.smooth_masks import smooth_masks
from ncdc_model.golden.valid import REACH, Calibrated, Covering, Masks, connected, grid_pitch, grown
from ncdc_model.training.region import region_of
from ncdc_spec.errors import InputError
from ncdc_spec.files import parse_text, read_bytes
from ncdc_spec.geometry import Geometry
from ncdc_spec.interpolation import DEFAULT

__all__ = ["Source", "is_points_file", "load_points", "load_source"]


_GRAIN = 2.0**20       # parts of a pixel to which pairs are rounded
_ANCHORS = 31, 21      # columns and rows of the grid of anchors over the whole frame
_SMOOTH = 16           # corrected pixels: tolerance of the border by the smooth lens


@dataclass(frozen=True)
class Source:
    """Training pairs and other data on the map.

    The pairs are rounded to 2**-20 pixels: the last bit of a lens's arctangent differs from one
    processor to the next, and a training amplifies any difference.

    Parameters
    ----------
    pairs : (u, v, x, y) of ndarray, shape (N,)
        Corrected pixels and their sources in the distorted image.
    geometry : Geometry
    back_map : callable or None
        The exact map (u, v) -> (x, y) over the whole frame, from a camera file or remap tables.
    covering : Covering or None
        Of :meth:`Calibrated.covering`, if there is no exact map.
    smooth : Masks or None
        Sources by the smooth lens that was fitted to the points.
    anchors : (u, v, x, y) or None
        Pairs of the smooth lens where the points do not cover the frame: without them the network
        would diverge there.
    provenance : dict
        For the descriptor: ``source`` (file name), ``source_kind``, ``source_hash``, ``frame``
        (focal length and centre of the corrected image in pixels, and the vertical focal length
        over the horizontal one if they differ), and for points ``homography``.
    frame : IdealFrame or None
        The points' rows and columns, whose straightness measures a network.
    facts : dict
        For the report: for remap tables ``source_columns`` and ``source_rows``, the smallest and
        the largest that they read; ``notes`` and ``warnings``, sentences on how the file was read,
        and on what is odd about it; of one or two photos of a page ``page_sag``: how far the map
        would be off (``rms_px``, ``max_px``) if the page was bent by ``sag_percent`` of its extent.
    blank_beyond : float, optional
        Pixels, for points: what is known of the map less certainly is not valid.
    """
    pairs: tuple
    geometry: Geometry
    back_map: object = None
    covering: Covering | None = None
    smooth: Masks | None = None
    anchors: tuple | None = None
    provenance: dict = field(default_factory=dict)
    frame: IdealFrame | None = None
    facts: dict = field(default_factory=dict)
    blank_beyond: float | None = None

    @cached_property
    def region(self):
        """:class:`~ncdc_model.training.region.Region` of points; None without points."""
        return (region_of(self.frame, self.smooth.inside, self.blank_beyond) if self.frame
                else None)

    @cached_property
    def within(self):
        """Pixels (height, width) near those with a source by the smooth lens, but those that are
        less certain than ``blank_beyond``; None without such a lens."""
        if not self.smooth:
            return None
        near = grown(connected(self.smooth.unfolded), _SMOOTH)
        return near if self.blank_beyond is None else near & self.region.certain

    def __post_init__(self):
        for name in ("pairs", "anchors"):
            if getattr(self, name) is not None:
                rounded = tuple(np.rint(np.asarray(values, np.float64) * _GRAIN) / _GRAIN
                                for values in getattr(self, name))
                object.__setattr__(self, name, rounded)


def is_points_file(path):
    """Whether ``path`` is a file of ``ncdc calibrate``.

    Raises
    ------
    InputError
        If it cannot be read, or is named as one but is no JSON.
    """
    try:
        table = parse_text(path, "points file", json.loads)
    except InputError:
        if b'"ncdc points"' in read_bytes(path):
            raise
        return False
    return isinstance(table, dict) and table.get("format") == "ncdc points"


def load_source(path, size=None, zoom=None, camera=None, sensor=None, page=None, **options):
    """Read a points or camera file and choose the corrected frame, or read remap tables.

    Parameters
    ----------
    path : path or sequence of path
        Two are the tables x and y of a map.
    size : (int, int), optional
        Corrected width and height; default that of the photos. A map has its own.
    zoom : str or float, optional
        As in :func:`ncdc_model.lens.choose_frame`; default fit, or the frame in a camera file,
        see :func:`~ncdc_model.calibration.camera_file.load_camera_map`.
    camera : str, optional
        Which of several cameras or maps in a file.
    sensor : (int, int), optional
        Width and height of the distorted image, for remap tables, camera files and points without
        them; a camera file of another size of the same aspect is scaled.
    page : str, optional
        ``flat`` or ``relief``, as in :class:`TargetPoints`; default that of the points file.
    options
        ``bayer``, ``fill`` and ``interpolation`` as in :class:`Geometry`; the default of the last
        is :data:`ncdc_spec.interpolation.DEFAULT`.

    Raises
    ------
    InputError
        If the file or an option is bad.
    """
    options = {"interpolation": DEFAULT} | options
    paths, tables = are_remap_files(path)
    if page and (tables or load_points(paths[0], sensor) is None):
        raise InputError(f"--{page} states the shape of a photographed target, {paths[0]} holds no "
                         f"points of one")
    if tables:
        return _of_remap(paths, size or zoom, sensor, camera, options)
    path, = paths
    points = load_points(path, sensor)
    if points is None:
        return _of_camera(path, size, zoom, camera, sensor, options)
    if camera is not None:
        raise InputError(f"camera {camera} is asked for, {path} holds points")
    if page and page != points.page:
        points = replace(points, page=page, fits=())
    kind = "CSV" if is_points_csv(path) else points.target
    return _of_points(path, points, kind, size, zoom, options)


def load_points(path, sensor=None):
    """:class:`TargetPoints` of a points file or of a CSV of points; None for any other file.

    ``sensor``: width and height of the photos, which a CSV does not have.

    Raises
    ------
    InputError
        If the file is bad, or the size is not known or differs.
    """
    if is_points_csv(path):
        return load_csv(path, sensor)
    if not is_points_file(path):
        return None
    points = TargetPoints.load(path)
    if sensor is not None and tuple(sensor) != points.size:
        raise InputError("{} holds points of photos of {}x{} pixels, the sensor has {}x{}".format(
            path, *points.size, *sensor))
    return points


def _of_camera(path, size, zoom, camera, sensor, options):
    camera = load_camera_map(path, size, zoom, camera, sensor)
    provenance = {"source": Path(path).name, "source_kind": camera.model,
                  "source_hash": camera.digest, "frame": _numbers(camera.frame)}
    facts = {name: list(sentences) for name, sentences in
             (("notes", camera.notes), ("warnings", camera.warnings)) if sentences}
    return Source(training_grid(camera.back_map, camera.geometry()), camera.geometry(**options),
                  back_map=camera.back_map, provenance=provenance, facts=facts)


def _of_remap(paths, frame, sensor, camera, options):
    if frame is not None:
        raise InputError(f"size and zoom choose the frame of points and camera files, the map of "
                         f"{paths[0]} has its own")
    tables = load_remap(paths, sensor, camera, **options)
    columns, rows = tables.reach
    provenance = {"source": " ".join(Path(path).name for path in paths),
                  "source_kind": tables.model, "source_hash": tables.digest}
    facts = {"source_columns": list(columns), "source_rows": list(rows),
             "warnings": list(tables.warnings)}
    return Source(training_grid(tables.back_map, tables.geometry), tables.geometry,
                  back_map=tables.back_map, provenance=provenance, facts=facts)


def _of_points(path, points, kind, size, zoom, options):
    frame = ideal_frame(points, size, zoom or "fit")
    geometry = Geometry(*frame.camera.frame.size, *points.size, **options)
    (u, v), (x, y) = frame.corrected.T, frame.distorted.T
    pitch = grid_pitch([(u[frame.photo == k], v[frame.photo == k]) for k in np.unique(frame.photo)])
    matrices = [_digits(matrix.ravel()) for matrix in frame.homographies]
    provenance = {"source": Path(path).name, "source_kind": f"{kind} points",
                  "source_hash": points.digest, "frame": _numbers(frame.camera.frame),
                  "points_dropped": sum(frame.rejected.values()),
                  **({"page": points.page} if points.page else {}),
                  "homography": matrices[0] if len(matrices) == 1 else matrices}
    covering = Calibrated(u, v, x, y, REACH * pitch).covering(geometry)
    smooth = smooth_masks(frame.camera.back_map, geometry, covering)
    anchors = training_grid(frame.camera.back_map, geometry, _ANCHORS, sum(_ANCHORS),
                            connected(smooth.unfolded), smooth.covered)
    return Source((u, v, x, y), geometry, covering=covering, smooth=smooth,
                  anchors=anchors, provenance=provenance, frame=frame,
                  facts=_flatness(points, frame))


def _flatness(points, frame):
    """Facts on the shape of the page: warnings, and what few photos do not show of it."""
    facts = {"warnings": bent(frame) + uneven(points, frame)}
    if points.page or len(frame.names) >= PHOTOS:
        return facts
    rms, most = sag_effect(frame.camera, frame, SAG)
    return facts | {"page_sag": {"sag_percent": 100 * SAG, "rms_px": rms, "max_px": most}}


def _numbers(frame):
    return _digits([frame.focal, *frame.centre] + [frame.aspect] * (frame.aspect != 1))


def _digits(values):
    """``values`` as floats of twelve digits: further ones depend on the processor."""
    return [float(f"{value:.12g}") for value in values]
