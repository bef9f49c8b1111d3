"""Linear algebra that does not depend on the order of summation."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

from ncdc_model import exact


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
import hashlib, sys
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
choices = TrainingChoices(trainer=sys.argv[3], options=eval(sys.argv[4]))
trained = train_camera(load_source(sys.argv[1], (320, 240)), 3, choices)
trained.descriptor.save(sys.argv[2])
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    from ncdc.cli import main
    folder = tmp_path_factory.mktemp("page")
    photo = os.path.join(os.path.dirname(__file__), "../data/dots/dot_pattern_06.jpg")
    assert main(["calibrate", photo, "--target", "dots", "-o", str(folder / "points.json")]) == 0
    return folder / "points.json"


@pytest.mark.parametrize("trainer,options", [
    ("lm", "dict(starts=12, rounds=1)"),
    ("ebp", "dict(stop=__import__('ncdc_model.training.backprop').training.backprop.Stop(2))")])
def test_a_real_photo_gives_the_same_bytes_on_every_kernel(page, tmp_path, trainer, options):
    digests = {}
    for name, change in {
            "one thread": {"OPENBLAS_NUM_THREADS": "1"},
            "two": {"OPENBLAS_NUM_THREADS": "2", "OPENBLAS_CORETYPE": "Haswell"},
            "sixteen": {"OPENBLAS_NUM_THREADS": "16", "OPENBLAS_CORETYPE": "Prescott"},
            "no AVX-512": {"NPY_DISABLE_CPU_FEATURES": "AVX512_ICL X86_V4"}}.items():
        output = tmp_path / f"{name}.toml"
        env = os.environ | change | {"PYTHONPATH": os.pathsep.join(sys.path)}
        subprocess.run([sys.executable, "-c", _SCRIPT, str(page), str(output), trainer, options],
                       env=env, check=True)
        digests[name] = hashlib.sha256(output.read_bytes()).hexdigest()
    assert len(set(digests.values())) == 1, digests
