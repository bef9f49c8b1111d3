"""Formats that OpenCV decodes: nothing turned, nothing printed, no damage in silence."""

import os
import sys

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from ncdc_model.photo.quiet import captured_stderr
from ncdc_spec.errors import InputError
from photo_files import SAMPLES, png, read

BYTES = (SAMPLES >> 8).astype(np.uint8)
RGB = np.stack([BYTES, BYTES[::-1], BYTES[:, ::-1]], 2)
# Red above, blue below on the right: turned or mirrored it looks different.
FLAT = np.zeros((48, 64, 3), np.uint8)
FLAT[:16] = 200, 40, 20
FLAT[16:, 32:] = 20, 40, 200


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("suffix", ["jpg", "png", "webp", "avif", "tif", "deep.tif", "cv.tif"])
def test_no_orientation_turns_a_picture(tmp_path, suffix, orientation):
    path = tmp_path / f"a.{suffix}"
    tag = [(274, "H", 1, orientation, True)]
    if suffix == "tif":
        tifffile.imwrite(path, FLAT, photometric="rgb", extratags=tag)
    elif suffix == "deep.tif":
        tifffile.imwrite(path, FLAT.astype(np.uint16) << 4, photometric="rgb", bitspersample=12,
                         extratags=tag)
    elif suffix == "cv.tif":
        cv2.imwrite(str(path), FLAT[:, :, ::-1], [cv2.IMWRITE_TIFF_COMPRESSION, 5])
        with tifffile.TiffFile(path, mode="r+") as file:
            if 274 in file.pages[0].tags:
                file.pages[0].tags[274].overwrite(orientation)
    else:
        exif = Image.Exif()
        exif[274] = orientation
        Image.fromarray(FLAT).save(path, exif=exif, quality=95)
    image = read(path)[0].image
    assert image.shape == FLAT.shape
    assert np.abs(image[8::16, 8::16].astype(int) - FLAT[8::16, 8::16]).max() <= 3


@pytest.mark.parametrize("suffix", ["png", "gif", "webp", "avif"])
def test_the_first_of_an_animation(tmp_path, suffix):
    frames = [Image.fromarray(np.full((48, 64, 3), value, np.uint8)) for value in (200, 99, 5)]
    frames[0].save(tmp_path / f"a.{suffix}", save_all=True, append_images=frames[1:])
    photo, said = read(tmp_path / f"a.{suffix}")
    assert said == [f"{tmp_path / f'a.{suffix}'}: the first of 3 pictures is taken"]
    assert np.abs(photo.image.astype(int) - 200).max() <= 2


def test_several_pictures_in_a_jpeg(tmp_path):
    first, second = (Image.fromarray(np.full((48, 64), value, np.uint8)) for value in (200, 5))
    first.save(tmp_path / "a.jpg", format="MPO", save_all=True, append_images=[second])
    photo, said = read(tmp_path / "a.jpg")
    assert "the first of 2 pictures is taken" in said[0] and (photo.image == 200).all()


def test_channels(tmp_path):
    for name, samples, wanted in (
            ("LA", np.dstack([BYTES, BYTES[::-1]]), BYTES), ("RGBA", np.dstack([RGB, BYTES]), RGB)):
        Image.fromarray(samples, name).save(tmp_path / "a.png")
        np.testing.assert_array_equal(read(tmp_path / "a.png")[0].image, wanted)
    png(tmp_path / "a.png", np.dstack([SAMPLES, SAMPLES[::-1]]), 16, 4)
    np.testing.assert_array_equal(read(tmp_path / "a.png", 16)[0].image, BYTES)
    Image.fromarray(BYTES > 99).save(tmp_path / "a.png")
    np.testing.assert_array_equal(read(tmp_path / "a.png")[0].image, (BYTES > 99) * 255)
    palette = Image.fromarray(RGB).quantize(16)
    for suffix in ("png", "gif", "bmp"):
        palette.save(tmp_path / f"a.{suffix}")
        np.testing.assert_array_equal(read(tmp_path / f"a.{suffix}")[0].image,
                                      np.asarray(palette.convert("RGB")))
        Image.fromarray(BYTES).save(tmp_path / f"a.{suffix}")
        np.testing.assert_array_equal(read(tmp_path / f"a.{suffix}")[0].image, BYTES)


def test_cmyk(tmp_path):
    Image.new("CMYK", (64, 48), (0, 255, 255, 0)).save(tmp_path / "a.jpg")
    photo, said = read(tmp_path / "a.jpg")
    assert "a.jpg is in CMYK: converted to R, G, B" in said[0]
    assert np.abs(photo.image - np.array([255, 0, 0])).max() <= 3


@pytest.mark.parametrize("suffix", ["png", "jpg", "webp", "gif", "bmp", "jp2", "avif", "pgm"])
def test_files_cut_short_are_rejected_without_a_print(tmp_path, suffix, capfd):
    path = tmp_path / f"a.{suffix}"
    cv2.imwrite(str(path), RGB if suffix != "pgm" else BYTES)
    content = path.read_bytes()
    for length in (3, 20, len(content) // 2, len(content) * 9 // 10):
        path.write_bytes(content[:length])
        with pytest.raises(InputError, match=f"a.{suffix} [^\n]*(no image|damaged|video)[^\n]*$"):
            read(path)
    assert capfd.readouterr() == ("", "")


def test_damage_inside_a_jpeg_is_said(tmp_path, capfd):
    cv2.imwrite(str(tmp_path / "a.jpg"), RGB)
    content = bytearray((tmp_path / "a.jpg").read_bytes())
    middle = len(content) // 2
    content[middle:middle + 6] = b"\x12\xf7\x00\xf1\x11\x22"
    (tmp_path / "a.jpg").write_bytes(content)
    photo, said = read(tmp_path / "a.jpg")
    assert photo.image.shape == RGB.shape and "a.jpg is damaged (Corrupt JPEG data: " in said[0]
    content[middle:middle + 2] = b"\xff\xd9"
    (tmp_path / "a.jpg").write_bytes(content)
    with pytest.raises(InputError, match="it is a JPEG file that is damaged, cut short or"):
        read(tmp_path / "a.jpg")
    assert capfd.readouterr() == ("", "")


def test_a_picture_of_too_many_pixels(tmp_path):
    (tmp_path / "a.pgm").write_bytes(b"P5 60000 60000 255\n" + bytes(99))
    with pytest.raises(InputError, match="a.pgm has too many pixels, 178000000 are the limit"):
        read(tmp_path / "a.pgm")
    (tmp_path / "a.pgm").write_bytes(b"P5 13400 13300 255\n" + bytes(99))
    with pytest.raises(InputError, match="a.pgm has 13400x13300 pixels, 178000000 in all"):
        read(tmp_path / "a.pgm")
    tifffile.imwrite(tmp_path / "a.tif", shape=(48, 64), dtype=np.uint8)
    with tifffile.TiffFile(tmp_path / "a.tif", mode="r+") as file:
        file.pages[0].tags[256].overwrite(60000)
        file.pages[0].tags[257].overwrite(60000)
    with pytest.raises(InputError, match="a.tif has 60000x60000 pixels, 178000000 in all"):
        read(tmp_path / "a.tif")


def test_what_is_captured_and_what_comes_after(capfd):
    with captured_stderr() as lines:
        os.write(2, b"from a library in C\n")
        print("in between", file=sys.stderr)
    print("after", file=sys.stderr)
    assert "from a library in C" in lines
    assert capfd.readouterr().err.endswith("after\n")
