"""Image files, mosaic and demosaic."""

import cv2
import numpy as np
import pytest

from ncdc_model.images import demosaic, is_raw, mosaic, read_image, write_image
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import BAYER_PHASE, MONO


@pytest.mark.parametrize("shape", [(12, 16, 3), (12, 16)])
def test_png_round_trip(tmp_path, shape):
    image = np.random.default_rng(1).integers(0, 256, shape).astype(np.uint8)
    write_image(tmp_path / "a.png", image)
    np.testing.assert_array_equal(read_image(tmp_path / "a.png"), image)
    assert is_raw(image) == (len(shape) == 2)


def test_colours_are_in_rgb_order(tmp_path):
    red = np.zeros((8, 8, 3), np.uint8)
    red[:, :, 0] = 200
    write_image(tmp_path / "red.png", red)
    np.testing.assert_array_equal(cv2.imread(str(tmp_path / "red.png"))[0, 0], (0, 0, 200))


def test_sixteen_bits_and_alpha(tmp_path):
    cv2.imwrite(str(tmp_path / "deep.png"), np.full((8, 8), 0x1234, np.uint16))
    assert read_image(tmp_path / "deep.png", 16)[0, 0] == 0x12
    cv2.imwrite(str(tmp_path / "alpha.png"), np.full((8, 8, 4), (1, 2, 3, 4), np.uint8))
    np.testing.assert_array_equal(read_image(tmp_path / "alpha.png")[0, 0], (3, 2, 1))


def test_files_that_are_no_images(tmp_path):
    with pytest.raises(InputError, match="cannot read .*No such file"):
        read_image(tmp_path / "absent.png")
    for content in (b"", b"not a picture"):
        (tmp_path / "bad.png").write_bytes(content)
        with pytest.raises(InputError, match="bad.png holds no image that can be decoded"):
            read_image(tmp_path / "bad.png")


def test_unknown_format_leaves_no_file(tmp_path):
    with pytest.raises(InputError, match="'.xyz', which names no image format"):
        write_image(tmp_path / "a.xyz", np.zeros((8, 8), np.uint8))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("bayer", BAYER_PHASE)
def test_mosaic_takes_each_colour_at_its_phase(bayer):
    raw = mosaic(np.tile(np.array([10, 20, 30], np.uint8), (4, 6, 1)), bayer)
    letters = {10: "R", 20: "G", 30: "B"}
    assert "".join(letters[int(value)] for value in raw[:2, :2].ravel()) == bayer


@pytest.mark.parametrize("bayer", BAYER_PHASE)
def test_demosaic_undoes_mosaic_of_plain_colours(bayer):
    colour = np.tile(np.array([200, 90, 30], np.uint8), (8, 8, 1))
    np.testing.assert_array_equal(demosaic(mosaic(colour, bayer), bayer), colour)


def test_a_grey_sensor_sees_brightness():
    colour = np.array([[[10, 20, 30], [255, 255, 255]], [[4, 0, 1], [0, 3, 0]]], np.uint8)
    raw = mosaic(colour, MONO)
    assert raw.dtype == np.uint8 and raw.tolist() == [[20, 255], [1, 2]]
    assert mosaic(colour.astype(float), MONO).tolist() == [[20, 255], [1.25, 1.5]]
    assert (demosaic(raw, MONO) == raw[:, :, None]).all()
