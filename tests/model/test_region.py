"""The error of a map over its whole valid region, estimated from points of a target."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.golden.valid import masks_of
from ncdc_model.lens import Camera, rotation
from ncdc_model.training.region import region_of
from ncdc_spec.geometry import Geometry

SIZE = 640, 480


def bump(xy):
    """A local flaw of 2 px, which no smooth lens has."""
    return 2 * np.exp(-((xy - (200, 300))**2).sum(axis=1) / (2 * 45**2))[:, None] * (0.6, 0.8)


def calibrated(flaw=lambda xy: 0.0, margin=0, noise=0.02):
    """Frame of a page whose points keep ``margin`` pixels from the border, and the true map."""
    camera = Camera.from_dict({"width": SIZE[0], "height": SIZE[1], "k": [0.03, -0.01],
                               "f_distorted": 330.0, "centre": [323, 236]})
    i, j = np.meshgrid(np.arange(40), np.arange(30))
    index = np.stack([i.ravel(), j.ravel()], axis=1)
    plane = np.column_stack([index - (19.5, 14.5), np.zeros(len(index))])
    turn, shift = rotation(0.03, -0.02, 0.05), (0.1, 0.2, 13.0)
    xy = np.stack(camera.project(plane @ turn.T + shift), axis=1)
    xy = xy + flaw(xy) + np.random.default_rng(4).normal(0, noise, xy.shape)
    seen = ((xy >= margin) & (xy <= np.array(SIZE) - 1 - margin)).all(axis=1)
    photo = PhotoPoints(index[seen] - index[seen].min(axis=0), xy[seen], np.zeros(seen.sum()), {},
                        "page.png")
    frame = ideal_frame(TargetPoints("dots", SIZE, (photo,)))
    corner, matrix = index[seen].min(axis=0), np.linalg.inv(frame.homographies[0])

    def true_map(u, v):
        i, j, w = matrix @ np.stack([np.asarray(u, float), np.asarray(v, float), np.ones(len(u))])
        cells = np.stack([i / w, j / w], axis=1) + corner - (19.5, 14.5)
        at = np.stack(camera.project(np.column_stack([cells, np.zeros(len(u))]) @ turn.T + shift),
                      axis=1)
        return tuple((at + flaw(at)).T)
    return frame, true_map


def inside_of(frame, geometry):
    """Pixels with a source by the smooth lens."""
    return masks_of(frame.camera.back_map, geometry).inside


@cache
def estimated(flaw):
    """Region of the points of a camera, and the camera's true map."""
    frame, true_map = calibrated(flaw)
    return region_of(frame, inside_of(frame, Geometry(*SIZE, *SIZE))), true_map


@pytest.mark.parametrize("flaw", [
    pytest.param(lambda xy: 0.0, id="even lens", marks=pytest.mark.longer),
    pytest.param(bump, id="bump")])
def test_the_true_map_has_hardly_an_error(flaw):
    region, true_map = estimated(flaw)
    whole, _ = region.errors(true_map)
    assert whole["mse"]**.5 < 0.05 and whole["max"] < 0.4


def test_a_wrong_map_has_the_error_that_it_has():
    region, true_map = estimated(bump)

    def wrong(u, v):
        x, y = true_map(u, v)
        return x + 0.3 * np.sin(u / 60), y + 1.5 * np.exp(-((u - 420)**2 + (v - 150)**2) / 800)
    off = np.hypot(*(np.subtract(wrong(region.u, region.v), true_map(region.u, region.v))))
    whole, _ = region.errors(wrong)
    assert whole["mse"]**.5 == pytest.approx(np.sqrt(np.mean(off[~region.border]**2)), rel=0.1)
    assert off.max() <= whole["max"] < 1.3 * off.max()


@pytest.mark.longer
def test_what_lies_beyond_the_points_is_counted_apart():
    frame, true_map = calibrated(margin=70)
    geometry = Geometry(*SIZE, *SIZE)
    region = region_of(frame, inside_of(frame, geometry))
    even = ~region.border
    inside = (np.abs(region.x - 319.5) < 250) & (np.abs(region.y - 239.5) < 170)
    assert not inside[region.beyond & even].sum() > 0.1 * even.sum()
    assert region.beyond[~inside].all()

    def bent(u, v):
        """Right among the points, wrong towards the left border."""
        x, y = true_map(u, v)
        return x + np.where(x < 60, (60 - x) / 20, 0), y
    whole, beyond = region.errors(bent)
    assert beyond["max"] == whole["max"] > 2.5 and beyond["mse"] > 1.5 * whole["mse"]
    inner = replace(region, beyond=np.zeros_like(region.beyond))
    assert np.isnan(inner.errors(bent)[1]["max"])
