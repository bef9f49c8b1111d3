"""How still a point of the scene stands in the pictures of a shaking camera."""

from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from ncdc_bench.view.shaking import Shake, ShakingCamera
from ncdc_model.example.render import ideal_samples
from ncdc_model.golden.corrector import valid_coordinates
from ncdc_model.stabilise.quaternions import matrices
from ncdc_model.stabilise.stabiliser import Stabiliser
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
from ncdc_model.view_map import view_map
from ncdc_spec.view_matrix import PlaneCamera

__all__ = ["steadiness", "trained_lens"]

_DEGREES, _FPS, _READOUT = 3.0, 30.0, 0.016
_NEURONS, _STARTS = 8, 4
_PITCH, _RADIUS = 0.16, 0.03    # of the discs, in units of the plane at distance 1
_EDGE = 0.006                   # width of a disc's edge
_FIELD = 4                      # discs to each side of the middle
_MARGIN = 1.8                   # radii around a disc that its centre is measured in
_LEAD = 1.0                     # s of samples before the film and after it


def trained_lens(camera):
    """A descriptor of ``camera``, trained on its map from few starts."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "camera.toml"
        camera.save(path)
        source = load_source(path)
    choices = TrainingChoices(options={"starts": _STARTS}, nodes=8)
    return train_camera(source, _NEURONS, choices).descriptor


def discs(a, b):
    """Light (..., 3) of bright discs on a dark wall, at the points (a, b)."""
    column, row = (np.clip(np.rint(part / _PITCH), -_FIELD, _FIELD) for part in (a, b))
    distance = np.hypot(a - _PITCH * column, b - _PITCH * row)
    level = 20 + 200 * np.clip(.5 - (distance - _RADIUS) / _EDGE, 0, 1)
    return np.repeat(level[..., None], 3, axis=-1)


def steadiness(camera, descriptor, frames, smoothing=0.5, progress=lambda fraction: None):
    """Movement of points from frame to frame, with stabilisation and without.

    Parameters
    ----------
    camera : ncdc_model.lens.Camera
    descriptor : Descriptor
        Trained for it.
    frames : int
    smoothing : float
        As of :class:`~ncdc_model.stabilise.stabiliser.Stabiliser`, seconds.

    Returns
    -------
    dict
        ``frames``, ``points``; ``shake_degrees_rms`` about each axis, ``shake_rate_rms`` in
        degrees per second, ``readout_ms``. ``moved_px_rms``, ``moved_px_max``: of the distance
        between a point's positions in two successive pictures, in pixels. ``moved_px_rms_frame``:
        with one matrix for all rows of a frame; ``moved_px_rms_hardware``: by the integer model,
        with the hardware's table of matrices; ``moved_px_rms_without``: without stabilisation.
        ``off_px_rms``, ``off_px_max``: distance from where the view should show a point.
    """
    shaking = ShakingCamera(camera, Shake(_DEGREES), _READOUT)
    gyroscope = shaking.shake.gyroscope(-_LEAD, frames / _FPS + _LEAD)
    trained = PlaneCamera.of(descriptor)
    stabiliser = Stabiliser(gyroscope, trained, trained, np.eye(3),
                            descriptor.geometry.distorted_height, _READOUT, 0.0, smoothing)
    grid = _PITCH * np.arange(-_FIELD, _FIELD + 1)
    rays = np.stack([*np.meshgrid(grid, grid), np.ones((len(grid),) * 2)], axis=-1).reshape(-1, 3)
    samples = ideal_samples(camera)
    origin = matrices(shaking.shake.orientation(-_LEAD))
    positions = {"held": [], "hardware": [], "frame": [], "free": [], "wanted": []}
    for k in range(frames):
        seconds = k / _FPS
        raw = np.clip(np.rint(shaking.frame(seconds, samples, discs)), 0, 255).astype(np.uint8)
        steady = origin @ matrices(gyroscope.smooth(seconds + _READOUT / 2, smoothing))
        held, rows = _pixels(trained, rays @ steady), stabiliser.matrices(seconds)
        positions["wanted"].append(held)
        free = _pixels(trained, shaking.direction(rays, seconds))
        for name, maps, near in (
                ("held", view_map(descriptor, trained.size, rows), held),
                ("hardware", _integer_map(descriptor, stabiliser.row_view(seconds)), held),
                ("frame", view_map(descriptor, trained.size, rows[len(rows) // 2]), held),
                ("free", view_map(descriptor, trained.size, np.eye(3)), free)):
            positions[name].append(_centres(raw, maps, near, trained.focal))
        progress((k + 1) / frames)
    positions = {name: np.array(found) for name, found in positions.items()}
    off = np.linalg.norm(positions["held"] - positions["wanted"], axis=-1)
    moved = {name: np.linalg.norm(np.diff(found, axis=0), axis=-1)
             for name, found in positions.items()}
    return {"frames": frames, "points": int(np.isfinite(moved["held"]).any(axis=0).sum()),
            "shake_degrees_rms": _DEGREES, "readout_ms": 1000 * _READOUT,
            "shake_rate_rms": float(np.degrees(np.sqrt((gyroscope.rates**2).mean()))),
            "moved_px_rms": _rms(moved["held"]), "moved_px_max": float(np.nanmax(moved["held"])),
            "moved_px_rms_hardware": _rms(moved["hardware"]),
            "moved_px_rms_frame": _rms(moved["frame"]),
            "moved_px_rms_without": _rms(moved["free"]),
            "off_px_rms": _rms(off), "off_px_max": float(np.nanmax(off))}


def _integer_map(descriptor, view):
    """The :func:`~ncdc_model.view_map.view_map` of a view by the integer model."""
    v, u = np.indices(view.size[::-1])
    x, y, valid = valid_coordinates(descriptor, u, v, view)
    x, y = (descriptor.formats.coordinate.real(part) for part in (x, y))
    valid &= descriptor.geometry.inside_by(x, y) >= -1
    return x.astype(np.float32), y.astype(np.float32), ~valid


def _rms(values):
    return float(np.sqrt(np.nanmean(values**2)))


def _pixels(camera, rays):
    """Pixels (n, 2) of directions in a :class:`PlaneCamera`."""
    points = rays @ camera.matrix.T
    return points[:, :2] / points[:, 2:]


def _centres(raw, maps, positions, focal):
    """Centres (n, 2) of the discs near ``positions`` in the picture; not-a-number if one is cut."""
    *source, blank = maps
    picture = cv2.remap(raw[..., 1], *source, cv2.INTER_LINEAR)
    reach = round(_MARGIN * _RADIUS * focal)
    height, width = picture.shape
    found = np.full(positions.shape, np.nan)
    for k, (u, v) in enumerate(np.rint(np.nan_to_num(positions, nan=-1e6)).astype(int)):
        if not (reach <= u < width - reach and reach <= v < height - reach):
            continue
        window = np.s_[v - reach:v + reach + 1, u - reach:u + reach + 1]
        if blank[window].any():
            continue
        weight = np.maximum(picture[window].astype(float) - 40, 0)
        rows, columns = np.mgrid[-reach:reach + 1, -reach:reach + 1]
        found[k] = u, v
        found[k] += np.array([(weight * columns).sum(), (weight * rows).sum()]) / weight.sum()
    return found
