"""Frames in NumPy's .npy files."""

import numpy as np
import pytest

from ncdc_spec.errors import InputError
from photo_files import SAMPLES, read

BYTES = (SAMPLES >> 8).astype(np.uint8)


@pytest.mark.parametrize("shape,picked", [
    ((48, 64), ...), ((48, 64, 1), (..., 0)), ((4, 12, 64), 0), ((1, 48, 64), 0),
    ((48, 16, 3), ...), ((4, 16, 16, 3), 0)])
@pytest.mark.parametrize("order", ["C", "F"])
def test_shapes(tmp_path, shape, picked, order):
    values = np.resize(BYTES, shape)
    np.save(tmp_path / "a.npy", np.asarray(values, order=order))
    photo, said = read(tmp_path / "a.npy")
    np.testing.assert_array_equal(photo.image, values[picked])
    several = len(values) if picked == 0 and len(values) > 1 else None
    assert any(f"the first of {several} frames is taken" in text for text in said) == bool(several)
    assert any("taken as R, G, B" in text for text in said) == (shape[-1] == 3)
    assert photo.bayer is None and not photo.lossy


@pytest.mark.parametrize("kind", ["<u2", ">u2"])
def test_deep_samples(tmp_path, kind):
    np.save(tmp_path / "a.npy", (SAMPLES >> 4).astype(kind))
    photo, said = read(tmp_path / "a.npy")
    np.testing.assert_array_equal(photo.image, BYTES)
    assert "taken as 12-bit" in said[0]
    np.testing.assert_array_equal(read(tmp_path / "a.npy", 14)[0].image, SAMPLES >> 10)


@pytest.mark.parametrize("array,reason", [
    (SAMPLES.astype(np.float32), "holds float32 samples, 8 or 16 bit unsigned integers are"),
    (SAMPLES.astype(np.int16), "holds int16 samples"), (SAMPLES.astype(np.uint32), "holds uint32"),
    (SAMPLES > 99, "holds bool samples"), (np.array([None] * 64), "cannot be read: Object arrays"),
    (BYTES.ravel(), r"an array of the shape \(3072,\), \(height, width\), \(frames"),
    (BYTES.reshape(48, 16, 4), r"of the shape \(48, 16, 4\)"),
    (BYTES[:0], "of the shape"), (BYTES[:4], "with sides of at least 8"),
    (BYTES.reshape(2, 2, 12, 64), "of the shape")])
def test_other_arrays_are_rejected(tmp_path, array, reason):
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(InputError, match=reason):
        read(tmp_path / "a.npy")


@pytest.mark.parametrize("cut", [7, 40, 200])
def test_damaged_files_are_rejected(tmp_path, cut):
    np.save(tmp_path / "a.npy", BYTES)
    (tmp_path / "a.npy").write_bytes((tmp_path / "a.npy").read_bytes()[:cut])
    with pytest.raises(InputError, match="a.npy is a NumPy file that cannot be read: [^\n]+$"):
        read(tmp_path / "a.npy")
