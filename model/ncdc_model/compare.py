"""Errors of an existing descriptor, measured on points of photos, a camera file or a map."""

from dataclasses import replace

import cv2
import numpy as np
from scipy.spatial import cKDTree

from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.points_csv import is_points_csv
from ncdc_model.calibration.remap_file import are_remap_files
from ncdc_model.calibration.remap_source import load_remap
from ncdc_model.evaluate import evaluate_frame, evaluate_points, float_map
from ncdc_model.fitted_plane import fitted_plane
from ncdc_model.golden.valid import valid_mask
from ncdc_model.lens import Frame
from ncdc_model.lens.inverse import planar_inverse
from ncdc_model.training.source import load_points
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.files import read_bytes

__all__ = ["compare_with_reference", "corrected_points", "difference_from", "fitted_view"]

_VIEW = 2500       # pixels to which a view is fitted
_WIDE = 0.01       # zoom at which no point of a photo falls outside the frame


def compare_with_reference(descriptor, path, camera=None, progress=lambda fraction: None):
    """Errors of ``descriptor`` compared with a points file, a camera file or remap tables.

    ``path``: a path, or two of the tables x and y; ``camera``: which of a camchain, or which of
    several maps in a file. A map is compared at every pixel that is valid in both.

    ``progress`` is called with the fraction done.

    A camera file is compared at every valid pixel: in the corrected frame of training
    (``trained``) if the descriptor is from a camera file. A descriptor from points has an
    arbitrary view of the flat picture, so that it is compared in the plane that fits the float
    network best (``fitted``). Points are compared at their positions, see
    :func:`corrected_points`.

    Returns
    -------
    dict
        ``hidden_neurons``, ``nodes``, ``measured_on`` (frame and its view, points and their pose,
        trained or fitted), ``map_error_float_px``, ``map_error_fixed_px``,
        ``fixed_minus_float_max_px``, and ``valid_pixels`` or ``points``; for a map
        ``valid_pixels_differ``, those with a source in one of the two only; for a camera file
        ``notes``, sentences on how it was read.

    Raises
    ------
    InputError
        If the file is bad, of a camera of another image size, or no point is inside the frame.
    """
    paths, tables = are_remap_files(path)
    if tables:
        return _map_errors(descriptor, paths, camera)
    path, = paths
    points = load_points(path, descriptor.geometry.distorted if is_points_csv(path) else None)
    if points is None:
        back_map, view, notes = _true_map(descriptor, path, camera)
        return {"measured_on": f"frame, view {view}", "notes": notes,
                **evaluate_frame(descriptor, back_map, progress=progress)}
    if camera is not None:
        raise InputError(f"camera {camera} is asked for, {path} holds points")
    u, v, x, y, pose = corrected_points(descriptor, points, path)
    report = evaluate_points(descriptor, u, v, x, y)
    if not report["points"]:
        raise InputError(f"no point of {path} is inside the corrected frame")
    frame = evaluate_frame(descriptor, progress=progress)
    return {"measured_on": f"points, pose {pose}", "hidden_neurons": descriptor.hidden_neurons,
            "nodes": descriptor.nodes,
            "fixed_minus_float_max_px": frame["fixed_minus_float_max_px"],
            **report}


def _map_errors(descriptor, paths, camera):
    geometry, subject = descriptor.geometry, " and ".join(map(str, paths))
    # The same rule of validity: which sources are inside depends on the samples around them.
    tables = load_remap(paths, geometry.distorted, camera, bayer=geometry.bayer,
                        interpolation=geometry.interpolation)
    if tables.geometry.corrected != geometry.corrected:
        raise InputError("{} is the map of a corrected picture with {}x{} pixels, the descriptor "
                         "is for {}x{}".format(subject, *tables.geometry.corrected,
                                               *geometry.corrected))
    theirs = valid_mask(tables.back_map, geometry)
    ours = descriptor.valid.mask(geometry.corrected_width)
    if not (theirs & ours).any():
        raise InputError(f"no pixel has a source both in {subject} and in the descriptor")
    return {"measured_on": "frame, map", **evaluate_frame(descriptor, tables.back_map),
            "valid_pixels_differ": int((theirs != ours).sum())}


def _true_map(descriptor, path, name):
    geometry, provenance = descriptor.geometry, descriptor.provenance
    camera = load_camera_map(path, geometry.corrected, _WIDE, name, geometry.distorted)
    notes = [*camera.notes, *camera.warnings]
    if "frame" not in provenance or "homography" in provenance:
        return fitted_view(descriptor, camera), "fitted", notes
    focal, *centre, aspect = [*provenance["frame"], 1.0][:4]
    frame = Frame(geometry.corrected, focal, tuple(centre), aspect)
    return replace(camera, frame=frame).back_map, "trained", notes


def fitted_view(descriptor, camera):
    """The camera's map from the plane whose homography to (u, v) fits the network best."""
    u, v = _some_valid(descriptor, _VIEW)
    return fitted_plane(camera, u, v, *float_map(descriptor.network, descriptor.geometry)(u, v))


def difference_from(camera, path):
    """Difference of the map of ``camera`` from an earlier calibration of it, whatever the views.

    Parameters
    ----------
    camera : Camera
    path : path
        Descriptor, points file or camera file of the earlier calibration.

    Returns
    -------
    dict
        ``mean``, ``rms`` and ``max`` of the distances in distorted pixels, over the corrected frame
        of the earlier one; ``x`` and ``y``, the pixel with the largest distance.

    Raises
    ------
    InputError
        If the file is bad, or of a camera of another image size.
    """
    u, v, x, y = _map_in(path, camera.size)
    a, b = fitted_plane(camera, u, v, x, y)(u, v)
    far = np.hypot(a - x, b - y)
    worst = int(np.nanargmax(far))
    return {"mean": float(np.nanmean(far)), "rms": float(np.sqrt(np.nanmean(far**2))),
            "max": float(far[worst]), "x": float(x[worst]), "y": float(y[worst])}


def _map_in(path, size):
    """Arrays u, v, x and y of the map in the file ``path``, where it has a source."""
    if b"hidden_weights = [" in read_bytes(path):
        descriptor = Descriptor.load(path)
        _same_size(descriptor.geometry, size, "the camera")
        u, v = _some_valid(descriptor, _VIEW)
        return u, v, *float_map(descriptor.network, descriptor.geometry)(u, v)
    points = load_points(path, size if is_points_csv(path) else None)
    if points is not None and points.size != tuple(size):
        raise InputError("{} holds points of photos of {}x{} pixels, the camera has {}x{}".format(
            path, *points.size, *size))
    camera = (load_camera_map(path, size, None, None, size) if points is None else
              ideal_frame(points).camera)
    width, height = camera.frame.size
    u, v = (part.ravel() for part in np.meshgrid(np.arange(0, width, width / 60),
                                                 np.arange(0, height, height / 45)))
    x, y = camera.back_map(u, v)
    inside = (x >= 0) & (x <= size[0] - 1) & (y >= 0) & (y <= size[1] - 1)
    return u[inside], v[inside], x[inside], y[inside]


def corrected_points(descriptor, points, path):
    """Corrected and distorted pixels of :class:`TargetPoints`, and the origin of the pose.

    If the descriptor was trained on these points, the target's pose is that of its provenance
    (``trained``). Points of other photos of the same camera get the homography that fits the
    float network best (``fitted``), which hides errors that a pose can explain.

    Returns (u, v, x, y, pose); the arrays have shape (N,).
    """
    _same_size(descriptor.geometry, points.size, path)
    frame = ideal_frame(points, descriptor.geometry.corrected, _WIDE)
    provenance = descriptor.provenance
    trained = "homography" in provenance and provenance.get("source_hash") == points.digest
    if trained:
        matrices = np.array(provenance["homography"], np.float64).reshape(-1, 3, 3)
    parts = []
    for number in np.unique(frame.photo):
        on = frame.photo == number
        index, (x, y) = frame.index[on].astype(np.float64), frame.distorted[on].T
        matrix = matrices[number] if trained else _fitted(descriptor, index, x, y)
        if matrix is not None:
            u, v = cv2.perspectiveTransform(index[:, None], matrix)[:, 0].T
            parts.append((u, v, x, y))
    if not parts:
        raise InputError(f"no photo of {path} has points enough inside the corrected frame")
    return *(np.concatenate(part) for part in zip(*parts)), "trained" if trained else "fitted"


def _fitted(descriptor, index, x, y):
    """Homography from ``index`` to corrected pixels by the network's inverse, or None."""
    geometry = descriptor.geometry
    network = float_map(descriptor.network, geometry)
    u, v = _some_valid(descriptor, 5000)
    nearest = cKDTree(np.stack(network(u, v), axis=1)).query(np.stack([x, y], axis=1))[1]
    u0, v0 = u[nearest], v[nearest]
    # planar_inverse starts at its target: shift so that this is the nearest known pixel.
    a, b = planar_inverse(lambda a, b: network(u0 + a - x, v0 + b - y), x, y,
                          scale=geometry.distorted_width)
    u, v = u0 + a - x, v0 + b - y
    width, height = geometry.corrected
    on = (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
    if on.sum() < 8:
        return None
    return cv2.findHomography(index[on], np.stack([u, v], axis=1)[on], 0)[0]


def _some_valid(descriptor, count):
    v, u = np.nonzero(descriptor.valid.mask(descriptor.geometry.corrected_width))
    some = np.linspace(0, len(u) - 1, min(count, len(u))).astype(int)
    return u[some].astype(np.float64), v[some].astype(np.float64)


def _same_size(geometry, size, path):
    if tuple(size) != geometry.distorted:
        raise InputError(f"{path} is of a camera with {size[0]}x{size[1]} pixels, the descriptor "
                         "is for {}x{}".format(*geometry.distorted))
