"""The simulated lenses and their dots: exactly those on which the accuracy goals were set."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from ncdc_bench.reference_lenses import (
    COLUMNS,
    MARGIN,
    NOISE,
    REFERENCE_LENSES,
    ROWS,
    ReferenceLens,
    reference_table,
)
from ncdc_model.lens import Camera
from ncdc_spec.errors import InputError

SHARED = Path(__file__).resolve().parents[3] / "shared" / "lenses"


def values(problem):
    return np.stack([problem.u, problem.v, problem.x, problem.y])


@pytest.mark.parametrize("name", REFERENCE_LENSES)
def test_camera_equals_the_lens_of_the_study(name):
    table = reference_table(name)
    camera, (u, v, x, y) = Camera.from_dict(table), np.array(table["check"]).T
    np.testing.assert_allclose(camera.back_map(u, v), (x, y), atol=1e-6)
    np.testing.assert_allclose(camera.corrected(x, y), (u, v), atol=1e-6)


def test_dots_are_those_the_goals_were_set_on():
    state = hashlib.sha256()
    for name in REFERENCE_LENSES:
        state.update(np.rint(1e6 * values(ReferenceLens(name).dots())).astype("<i8").tobytes())
    assert state.hexdigest()[:16] == "ec6b30a2baffe13c"


@pytest.mark.parametrize("name", REFERENCE_LENSES)
def test_dots_equal_those_outside_the_repository(name):
    if not SHARED.is_dir():
        pytest.skip("the folder ../shared/lenses next to the repository is absent")
    assert json.loads((SHARED / "lenses.json").read_text())[name] == reference_table(name)
    given = np.loadtxt(SHARED / f"{name}_dots.csv", delimiter=",", skiprows=1).T
    np.testing.assert_array_equal(values(ReferenceLens(name).dots()), given)


def test_noise_is_of_the_stated_size_and_the_page_is_cut_by_the_photo():
    lens = ReferenceLens("120kb")
    noisy, exact, other = (lens.dots(), lens.dots(noise=0), lens.dots(seed=1))
    x, y = lens.camera.back_map(exact.u, exact.v)
    np.testing.assert_allclose((exact.x, exact.y), (x, y), atol=1e-6)
    error = np.concatenate([noisy.x - x, noisy.y - y])
    assert error.std() == pytest.approx(NOISE, rel=4 / np.sqrt(2 * len(error)))
    assert len(noisy) == len(other) < COLUMNS * ROWS and (noisy.x != other.x).all()
    width, height = lens.geometry.distorted
    assert MARGIN <= x.min() and x.max() <= width - 1 - MARGIN
    assert MARGIN <= y.min() and y.max() <= height - 1 - MARGIN


def test_truth_is_every_pixel_with_a_source():
    lens = ReferenceLens("PC105")
    truth = lens.truth(16)
    u, v = np.meshgrid(np.arange(0, 1280, 16), np.arange(0, 1024, 16))
    x, y = lens.camera.back_map(u, v)
    inside = (x >= 0) & (x <= 1279) & (y >= 0) & (y <= 1023)
    assert len(truth) == inside.sum() < inside.size
    np.testing.assert_array_equal(values(truth), [a[inside] for a in (u, v, x, y)])


def test_unknown_lens_is_named():
    with pytest.raises(InputError, match="lens is '90kb', one of PC105, PC120, 105kb, 105br"):
        ReferenceLens("90kb")
