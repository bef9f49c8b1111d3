"""The lens of a calibration goes to the training in the points file, and only if it is of them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from ncdc_model.calibration import frame as module
from ncdc_model.calibration import points as points_module
from ncdc_model.calibration.descent import descend
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.training.source import load_source
from quick_lenses import save_points

# Focal length, centre and radial terms of the lens of the file.
EXPECTED = [165.00126266479492, 161.46531105041504, 117.76376342773438,
            0.029857248067855835, 0.010188519954681396, -0.00018930435180664062,
            7.665157318115234e-05]


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """A points file with its lens, as of ``ncdc calibrate``."""
    path = tmp_path_factory.mktemp("points") / "points.json"
    save_points(path)
    points = TargetPoints.load(path)
    photos = tuple(replace(photo, area=np.full(len(photo.xy), 9.04)) for photo in points.photos)
    points = replace(points, photos=photos).rounded
    replace(points, fits=ideal_frame(points).fits).save(path)
    return path


def test_training_uses_it(file, monkeypatch):
    again = ideal_frame(replace(TargetPoints.load(file), fits=()))

    def fitted(*_):
        raise AssertionError("the lens is fitted again")
    monkeypatch.setattr(module, "fit_smooth", fitted)
    source = load_source(file)
    assert source.frame.camera == again.camera and len(source.frame.fits) == 2
    np.testing.assert_array_equal(source.frame.distorted, again.distorted)
    assert [vars(fit)["prior"] for fit in again.fits] == [fit.prior for fit in source.frame.fits]
    with pytest.raises(AssertionError, match="fitted again"):
        load_source(file, page="flat")


@pytest.mark.parametrize("change", [
    lambda table: table["photos"][1]["points"][3].__setitem__(2, 100.5),
    lambda table: table["photos"][1]["points"][3].__setitem__(4, 99.0),
    lambda table: table.update(page="relief"), lambda table: table["lens"].update(version=0),
    lambda table: table["lens"].update(points="0"), lambda table: table.update(lens=7),
    lambda table: table["lens"]["fits"][0]["vector"].__delitem__(slice(5, None)),
    lambda table: table["lens"]["fits"][0]["vector"].__setitem__(0, float("nan"))],
    ids=["point", "area", "page", "version", "hash", "no table", "short", "no number"])
def test_a_lens_of_other_points_is_not_taken(file, tmp_path, change):
    table = json.loads(file.read_text())
    assert len(TargetPoints.load(file).fits) == 2
    change(table)
    (tmp_path / "other.json").write_text(json.dumps(table))
    assert TargetPoints.load(tmp_path / "other.json").fits == ()


def test_the_points_of_the_file_are_the_rounded_ones(file, tmp_path):
    xy = np.random.default_rng(0).uniform(0, 200, (40, 2))
    index = np.stack(np.meshgrid(np.arange(8), np.arange(5)), axis=-1).reshape(-1, 2)
    points = TargetPoints("dots", (320, 240), (PhotoPoints(index, xy, xy[:, 0]),))
    points.save(tmp_path / "points.json")
    (loaded,), (rounded,) = (TargetPoints.load(tmp_path / "points.json").photos,
                             points.rounded.photos)
    np.testing.assert_array_equal(loaded.xy, rounded.xy)
    np.testing.assert_array_equal(loaded.area, rounded.area)
    assert (rounded.xy != xy).any()


def test_another_fit_is_another_version(file):
    """If these numbers change, FIT_VERSION must too: files with the old ones are about."""
    fit = TargetPoints.load(file).fits[-1]
    assert points_module.FIT_VERSION == 2
    np.testing.assert_allclose(fit.vector[:7], EXPECTED, rtol=1e-6, atol=1e-9)


def test_a_descent_ends_at_the_robust_minimum():
    """A line through points, one of which is far off and counts linearly."""
    x = np.arange(20.0)
    y = 3 + 2 * x + np.where(x == 7, 100, 0)
    found, cost = descend(lambda line: line[0] + line[1] * x - y,
                          lambda line: np.stack([np.ones(20), x, np.zeros(20)]),
                          np.array([0.0, 0.0, 5.0]), .5)
    np.testing.assert_allclose(found, [3, 2, 5], atol=.1)
    assert cost == pytest.approx(.5 * (100 - .25), rel=.01)
