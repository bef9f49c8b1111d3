"""Formats by content, and those that are named but not read."""

import struct

import cv2
import numpy as np
import pytest
from PIL import Image

from ncdc_model.photo.kinds import Kind, kind_of
from ncdc_spec.errors import InputError
from photo_files import read

GREY = np.arange(48 * 64).reshape(48, 64).astype(np.uint8)


@pytest.mark.parametrize("suffix,kind", [
    (".png", Kind.PNG), (".jpg", Kind.JPEG), (".jp2", Kind.JPEG_2000), (".webp", Kind.WEBP),
    (".gif", Kind.GIF), (".bmp", Kind.BMP), (".pgm", Kind.PNM), (".tif", Kind.TIFF),
    (".avif", Kind.AVIF)])
def test_what_opencv_and_pillow_write(tmp_path, suffix, kind):
    path = tmp_path / f"a{suffix}"
    assert cv2.imwrite(str(path), GREY if suffix != ".gif" else np.dstack([GREY] * 3))
    assert kind_of(path.read_bytes(), path) is kind
    if suffix != ".jp2":
        Image.fromarray(GREY).save(path)
        assert kind_of(path.read_bytes(), path) is kind
    disguised = tmp_path / "a.dat"
    disguised.write_bytes(path.read_bytes())
    assert read(disguised)[0].image.shape[:2] == (48, 64)


def box(brand, more=b""):
    return struct.pack(">I", 16 + len(more)) + b"ftyp" + brand + bytes(4) + more + bytes(99)


@pytest.mark.parametrize("content,name", [
    (box(b"heic", b"mif1"), r"a HEIF photo \(HEIC\), .* save the photo as PNG or TIFF"),
    (box(b"mif1", b"heic"), "a HEIF photo"),
    (box(b"isom", b"avc1"), r"a video \(MP4 or QuickTime\), .*extract a frame as PNG"),
    (box(b"qt  "), "a video"), (box(b"mp42"), "a video"), (box(b"3gp5"), "a video"),
    (struct.pack(">I", 8) + b"wide" + bytes(99), "a video"),
    (b"RIFF\1\0\0\0AVI LIST" + bytes(99), r"a video \(AVI\)"),
    (b"\x1aE\xdf\xa3" + bytes(99), r"a video \(Matroska"),
    ((b"G" + bytes(187)) * 3, r"a video \(MPEG transport"), (b"YUV4MPEG2 W8", "a video"),
    (b"\0\0\0\1\x67" + bytes(99), r"a video \(H.264"),
    (b"\xff\x0a" + bytes(99), "a JPEG XL file"), (b"%PDF-1.7", "a PDF document"),
    (b"8BPS\0\1", "a Photoshop file"), (b"PK\3\4" + bytes(99), "a zip archive, as .npz is"),
    (b"v/1\1" + bytes(99), "an OpenEXR file"), (b"PF\n8 8\n-1\n", "a PFM file"),
    (b"<?xml version='1.0'?><svg/>", "a text in XML or HTML"),
    (b"", "it is empty")])
def test_other_formats_are_named(tmp_path, content, name):
    path = tmp_path / "photo.png"
    path.write_bytes(content)
    with pytest.raises(InputError, match=f"photo.png .*{name}"):
        read(path)


def test_avif_with_a_general_brand():
    assert kind_of(box(b"mif1", b"avif"), "a") is Kind.AVIF
    assert kind_of(box(b"crx "), "a") is Kind.CAMERA_RAW
    assert kind_of(b"II*\0\x10\0\0\0CR\2\0", "a") is Kind.CAMERA_RAW
