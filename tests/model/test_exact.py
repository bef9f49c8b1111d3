"""Linear algebra that does not depend on the order of summation."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

from ncdc_model import exact
from ncdc_model.calibration.detect import detect_points
from ncdc_model.images import read_image


def test_cut_sums_are_the_same_in_any_order():
    random = np.random.default_rng(1)
    values = random.uniform(-1.4, 1.4, (2, 1, 1, 1024))
    a, b = (exact.cut(part) for part in values)
    terms = (a * b).ravel()
    sums = {float(np.cumsum(random.permutation(terms))[-1]) for _ in range(50)}
    assert sums == {exact.products([a], [b]).item()}
    uncut = (values[0] * values[1]).ravel()
    assert len({float(np.cumsum(random.permutation(uncut))[-1]) for _ in range(50)}) > 1


def test_two_slices_are_as_good_as_doubles():
    a, b = np.random.default_rng(2).normal(size=(2, 3, 4, 3000))
    parts = [exact.slices(values, exact.scale_of(values, 2), 2) for values in (a, b)]
    np.testing.assert_allclose(exact.products(*parts), a @ b.mT, atol=1e-9)
    assert np.abs(exact.products(parts[0][:1], parts[1][:1]) - a @ b.mT).max() > 1e-9


@pytest.mark.parametrize("value,scale", [(1.4, 1), (1.4000001, 2), (.7, .5), (.71, 1), (3, 4)])
def test_scale_keeps_values_below_its_limit(value, scale):
    assert exact.scale_of(np.array([0, -value])) == scale


def test_solutions_are_those_of_lapack():
    random = np.random.default_rng(3)
    half, right = random.normal(size=(5, 7, 9)), random.normal(size=(5, 7, 2))
    matrix = half @ half.mT
    np.testing.assert_allclose(exact.solve(matrix, right), np.linalg.solve(matrix, right),
                               rtol=1e-8)
    schur = matrix[:, 3:, 3:] - matrix[:, 3:, :3] @ np.linalg.solve(matrix[:, :3, :3],
                                                                    matrix[:, :3, 3:])
    np.testing.assert_allclose(exact.eliminate(matrix, 3), schur, rtol=1e-8, atol=1e-10)
    columns, wanted = random.normal(size=(6, 50)), random.normal(size=50)
    np.testing.assert_allclose(np.abs(exact.triangular(columns)),
                               np.abs(np.linalg.qr(columns.T, mode="r")), atol=1e-12)
    np.testing.assert_allclose(exact.least_squares(columns, wanted),
                               np.linalg.lstsq(columns.T, wanted, rcond=None)[0], atol=1e-12)


def test_a_row_that_says_nothing_new_is_passed_over():
    row = np.array([1., 2, 3])
    columns = np.stack([row, 2 * row, [1, 0, 0]])
    found = exact.least_squares(columns, 3 * row)
    assert found[1] == 0
    np.testing.assert_allclose(found, [3, 0, 0], atol=1e-12)
    gram = columns @ columns.T
    solved = exact.solve(gram[None], (columns @ (3 * row))[None, :, None])[0, :, 0]
    np.testing.assert_allclose(solved, [3, 0, 0], atol=1e-12)


_SCRIPT = """
import sys
from ncdc_model.training.backprop import Stop
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
source = load_source(sys.argv[1], (320, 240))
for trainer, options in ("lm", {"starts": 12, "rounds": 1}), ("ebp", {"stop": Stop(1)}):
    trained = train_camera(source, 3, TrainingChoices(trainer=trainer, options=options))
    trained.descriptor.save(f"{sys.argv[2]}.{trainer}")
"""
_MACHINES = {"one thread": {"OPENBLAS_NUM_THREADS": "1"},
             "two": {"OPENBLAS_NUM_THREADS": "2", "OPENBLAS_CORETYPE": "Haswell"},
             "sixteen": {"OPENBLAS_NUM_THREADS": "16", "OPENBLAS_CORETYPE": "Prescott",
                         "NPY_DISABLE_CPU_FEATURES": "AVX512_ICL X86_V4"}}


@pytest.mark.regress
def test_a_real_photo_gives_the_same_bytes_on_every_kernel(tmp_path):
    photo = os.path.join(os.path.dirname(__file__), "../data/dots/dot_pattern_06.jpg")
    detect_points([(photo, read_image(photo))], "dots").save(tmp_path / "points.json")
    digests = {"lm": set(), "ebp": set()}
    for name, change in _MACHINES.items():
        env = os.environ | change | {"PYTHONPATH": os.pathsep.join(sys.path)}
        subprocess.run([sys.executable, "-c", _SCRIPT, tmp_path / "points.json", tmp_path / name],
                       env=env, check=True)
        for trainer, seen in digests.items():
            content = (tmp_path / f"{name}.{trainer}").read_bytes()
            seen.add(hashlib.sha256(content).hexdigest())
    assert {trainer: len(seen) for trainer, seen in digests.items()} == {"lm": 1, "ebp": 1}
