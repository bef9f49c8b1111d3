"""Errors of the integer model's views, and their blank pixels, on the reference lenses."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ncdc_bench.nodes.measure import descriptor_of
from ncdc_bench.reference_lenses import ReferenceLens
from ncdc_model.evaluate import evaluate_frame, float_map
from ncdc_model.golden.picture import window_address
from ncdc_model.golden.view import view_coordinates
from ncdc_spec.view_matrix import Angles, PlaneCamera

__all__ = ["RANGE", "random_angles", "row_of", "view_lens"]

RANGE = {"pan": (-30.0, 30.0), "tilt": (-20.0, 20.0), "roll": (-10.0, 10.0), "zoom": (0.8, 4.0)}
"""Of the random views."""

_NODES = 8
_ROWS = 8               # every so many rows of a view are compared
_EDGE = 0.5             # px around the edge of the valid region, where either is right


def view_lens(name, neurons):
    """The reference lens ``name`` as a descriptor at nodes that states its focal length."""
    frame = ReferenceLens(name).camera.frame
    return replace(descriptor_of(name, neurons), nodes=_NODES,
                   provenance={"frame": [frame.focal, *frame.centre]})


def random_angles(count, seed=1):
    """Yield ``count`` random :class:`Angles` in :data:`RANGE`, zooms evenly in their logarithm."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        values = {name: float(rng.uniform(low, high)) for name, (low, high) in RANGE.items()}
        low, high = np.log(RANGE["zoom"])
        yield Angles(**values | {"zoom": float(np.exp(rng.uniform(low, high)))})


def row_of(name, descriptor, views, progress=lambda fraction: None):
    """Figures of ``views`` random views of a lens.

    Positions in the trained picture are computed in real numbers with SciPy's rotations, the map
    there is the float network's.

    Returns
    -------
    dict
        ``lens``, ``views``, ``pixels``; ``map_error_max_px``: largest error of a filled pixel's
        source; ``lens_error_max_px``: the integers' own largest error without a view;
        ``wrongly_filled``, ``wrongly_blank``: pixels that are more than half a pixel beyond or
        inside of what has a source.
    """
    worst, counts = 0.0, np.zeros(3, int)
    for k, angles in enumerate(random_angles(views)):
        error, *found = _compared(descriptor, angles)
        worst, counts = max(worst, error), counts + found
        progress((k + 1) / views)
    pixels, filled, blank = counts.tolist()
    return {"lens": name, "views": views, "pixels": pixels, "map_error_max_px": worst,
            "lens_error_max_px": evaluate_frame(descriptor)["fixed_minus_float_max_px"],
            "wrongly_filled": filled, "wrongly_blank": blank}


def _compared(descriptor, angles):
    """Largest error, and counts of pixels, wrongly filled and wrongly blank ones, of a view."""
    geometry, coordinate = descriptor.geometry, descriptor.formats.coordinate
    width, height = geometry.corrected
    v, u = np.mgrid[0:height:_ROWS, 0:width]
    x, y, valid = view_coordinates(descriptor, PlaneCamera.of(descriptor).looking(angles), u, v)
    *_, inside = window_address(x, y, geometry, coordinate)
    filled = valid & inside
    column, row = _true_positions(descriptor, angles, u, v)
    true_x, true_y = float_map(descriptor.network, geometry)(column, row)
    error = np.hypot(coordinate.real(x) - true_x, coordinate.real(y) - true_y)
    around = [_has_source(descriptor, column + du, row + dv)
              for du in (-_EDGE, _EDGE) for dv in (-_EDGE, _EDGE)]
    outside = geometry.inside_by(true_x, true_y)
    never = ~np.logical_or.reduce(around) | (outside < -1 - _EDGE)
    always = np.logical_and.reduce(around) & (outside > -1 + _EDGE)
    return (float(error[filled].max(initial=0)), filled.size, int((filled & never).sum()),
            int((~filled & always).sum()))


def _true_positions(descriptor, angles, u, v):
    """Positions in the trained picture; what is not in front of the camera is far outside."""
    focal, *centre = descriptor.provenance["frame"]
    turn = Rotation.from_euler("YXZ", [angles.pan, angles.tilt, angles.roll], degrees=True)
    a, b = ((part - middle) / (angles.zoom * focal) for part, middle in zip((u, v), centre))
    ray = np.stack([a, b, np.ones(u.shape)], axis=-1)
    x, y, z = np.moveaxis(ray @ turn.as_matrix().T, -1, 0)
    z = np.where(z > 0, z, np.nan)
    return tuple(np.nan_to_num(focal * part / z + middle, nan=-1e6)
                 for part, middle in zip((x, y), centre))


def _has_source(descriptor, column, row):
    width, height = descriptor.geometry.corrected
    column, row = np.rint(column).astype(int), np.rint(row).astype(int)
    there = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    return there & descriptor.valid.mask(width)[np.where(there, row, 0), np.where(there, column, 0)]
