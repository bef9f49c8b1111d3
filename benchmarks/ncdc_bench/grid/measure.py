"""Quality loss by the uneven Bayer grid of a reducing sensor, and the gain by evening it."""

from dataclasses import replace

import cv2
import numpy as np

from ncdc_bench.grid.light import MARGIN
from ncdc_model.correction import correct
from ncdc_model.images import mosaic
from ncdc_model.reference import psnr
from ncdc_spec.interpolation import INTERPOLATIONS
from ncdc_spec.sensors.grid import evened, grid_weight
from ncdc_spec.sensors.level import levelled

__all__ = ["GRIDS", "SAMPLINGS", "measure", "samples"]

GRIDS = ("even", "uneven", "evened")
SAMPLINGS = {"skip 4": (4, (0,)), "skip 2": (2, (0,)), "bin 4": (4, (0, 2, 4, 6)),
             "skip 4, bin 2": (4, (0, 2)), "skip 2, bin 2": (4, (0, 4))}
"""Reduction, and the pixels of which a sample is the mean, counted from the first of them on in
either axis. The last one skips by 2 in the sensor and is binned by 2 in capture."""

_BLACK, _WHITE = 168, 4095      # of the samples
_UNIT = 16                      # of a unit of light, as the linear curve takes it
_RIM = 8                        # samples at the frame's border that are not looked at


def samples(light, members, even, bayer):
    """The 12-bit samples (height, width) of a sensor, black level in.

    An even grid has its samples ``reduction`` active pixels apart, from active pixel 0 on. The
    uneven one has pairs of neighbours, twice as far apart. ``members``: of a sample, see
    :data:`SAMPLINGS`.
    """
    s, values = light.reduction, light.values
    for axis, count in enumerate(light.size[::-1]):
        index = np.arange(count)
        first = MARGIN + (s * index if even else 2 * s * (index // 2) + index % 2)
        values = np.mean([np.take(values, first + k, axis) for k in members], axis=0)
    raw = mosaic(values, bayer) * _UNIT + _BLACK
    return np.clip(np.floor(raw + .5), 0, _WHITE).astype(np.int64)


def measure(descriptor, light, sampling, bayer):
    """Rows of a light under one of :data:`SAMPLINGS`, one for each interpolation and grid.

    The same map corrects each frame. Its picture is compared with the light at the map's source
    coordinates: at the point, and as a mean over the pitch of the grid.

    Returns
    -------
    list of dict
        ``picture``, ``sampling``, ``interpolation``, ``grid``; ``psnr_db`` and ``psnr_mean_db``,
        peak signal-to-noise ratio to either reference; ``gain_db``, ``gain_mean_db``: above the
        even grid's.
    """
    s, members = SAMPLINGS[sampling]
    uneven = samples(light, members, False, bayer)
    frames = {"even": samples(light, members, True, bayer), "uneven": uneven,
              "evened": evened(uneven, grid_weight(s))}
    frames["evened"] = np.pad(frames["evened"], ((0, 2), (0, 2)), mode="edge")
    truths = {name: _truth(descriptor, light, members, name == "even") for name in GRIDS}
    mask = _mask(descriptor)
    rows = []
    for interpolation, each in INTERPOLATIONS.items():
        d = replace(descriptor, geometry=replace(descriptor.geometry, interpolation=each))
        found = {}
        for name in GRIDS:
            picture = correct(d, levelled(frames[name], _BLACK)).picture
            found[name] = [psnr(picture, truth, mask) for truth in truths[name]]
        rows += [{"picture": light.name, "sampling": sampling, "interpolation": interpolation,
                  "grid": name, "psnr_db": point, "psnr_mean_db": mean,
                  "gain_db": point - found["even"][0], "gain_mean_db": mean - found["even"][1]}
                 for name, (point, mean) in found.items()]
    return rows


def _sources(descriptor):
    """Raw coordinates of each corrected pixel."""
    g = descriptor.geometry
    v, u = np.indices(g.corrected[::-1])
    return descriptor.network(*g.normalise(u, v))


def _mask(descriptor):
    """Corrected pixels with a source that is not near the frame's border."""
    g = descriptor.geometry
    inside = [(at >= _RIM) & (at <= size - 1 - _RIM)
              for at, size in zip(_sources(descriptor), g.distorted)]
    return descriptor.valid.mask(g.corrected_width) & inside[0] & inside[1]


def _truth(descriptor, light, members, even):
    """The corrected picture of the light itself, at points and as means over the grid's pitch.

    The origin of an even grid is active pixel 0, that of pairs (1 - s) / 2, from their middles.
    Samples that are means lie in the middle of their pixels.
    """
    s = light.reduction
    origin = MARGIN + (0 if even else (1 - s) / 2) + np.mean(members)
    x, y = (s * at + origin for at in _sources(descriptor))
    points = cv2.remap(light.values, x.astype(np.float32), y.astype(np.float32), cv2.INTER_CUBIC)
    # A box of s pixels, an even number, has its middle half a pixel before its anchor.
    half = 0 if s % 2 else .5
    means = cv2.remap(cv2.blur(light.values, (s, s)), (x + half).astype(np.float32),
                      (y + half).astype(np.float32), cv2.INTER_LINEAR)
    white = (_WHITE - _BLACK) / _UNIT
    return np.clip(points, 0, white), np.clip(means, 0, white)
