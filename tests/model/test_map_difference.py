"""Difference of a lens from an earlier calibration, whatever the views."""

from dataclasses import replace

import numpy as np
import pytest

from lenses import lens
from ncdc_model.compare import difference_from
from ncdc_model.lens import KannalaBrandt
from ncdc_spec.errors import InputError
from quick_lenses import quick_descriptor, save_points


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The same lens as a camera file, as points, and as a network of these, by name."""
    folder = tmp_path_factory.mktemp("earlier")
    lens().framed((200, 160), 0.8).save(folder / "camera.toml")
    save_points(folder / "points.json")
    quick_descriptor(folder / "points.json").save(folder / "net.toml")
    return folder


def test_the_same_lens_does_not_differ(files):
    for name, limit in (("camera.toml", 1e-5), ("points.json", 1e-4)):
        found = difference_from(lens(), files / name)
        assert found["mean"] <= found["rms"] <= found["max"] < limit, name
    # The network is not trained: it errs by some 0.7 px itself.
    assert difference_from(lens(), files / "net.toml")["mean"] < 1


def test_another_lens_differs_where_it_is_another_one(files):
    k0, k1 = lens().radial.k
    other = replace(lens(), radial=KannalaBrandt((k0 + .01, k1)))
    found = difference_from(other, files / "camera.toml")
    assert .02 < found["rms"] < found["max"]
    # The view takes up most of what the corners of the frame differ by.
    corners = lens().undistort(np.array([0, 319, 0, 319.0]), np.array([0, 0, 239, 239.0]))
    moved = np.hypot(*np.subtract(other.distort(*corners), lens().distort(*corners)))
    assert moved.max() > 2 * found["max"]
    twice = difference_from(replace(lens(), radial=KannalaBrandt((k0 + .02, k1))),
                            files / "camera.toml")
    assert twice["rms"] == pytest.approx(2 * found["rms"], rel=.1)
    assert np.hypot(found["x"] - 160, found["y"] - 120) > 80       # at the rim


def test_a_camera_of_another_size_is_rejected(files):
    other = replace(lens(), size=(330, 240))
    for name in ("points.json", "net.toml"):
        with pytest.raises(InputError, match="320x240"):
            difference_from(other, files / name)
