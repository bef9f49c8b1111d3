"""Camera RAW files: the raw frame, never the preview. Written by pidng and tifffile."""

import struct

import imagecodecs
import numpy as np
import pytest
import tifffile

from ncdc_spec.errors import InputError
from photo_files import SAMPLES, dng, read

RAW = SAMPLES >> 4
BYTES = (SAMPLES >> 8).astype(np.uint8)


def test_a_file_of_pidng():
    y, x = np.mgrid[:48, :64]
    light = (x * 61 + y * 139) % 3896
    photo, said = read("tests/data/raw/pidng_gbrg12.dng", 12)
    assert photo.bayer == "GBRG" and not photo.lossy
    np.testing.assert_array_equal(photo.image, np.floor(light * 255 / 3895 + .5))
    assert said == ["tests/data/raw/pidng_gbrg12.dng is a camera RAW file: its GBRG frame of 64x48 "
                    "pixels is taken, from column 0, row 0 of 64x48, black level 200, white 4095"]


@pytest.mark.parametrize("letters", ["RGGB", "GRBG", "GBRG", "BGGR"])
def test_the_raw_frame_and_its_pattern(tmp_path, letters):
    dng(tmp_path / "a.dng", RAW, pattern=tuple("RGB".index(letter) for letter in letters))
    (tmp_path / "a.png").write_bytes((tmp_path / "a.dng").read_bytes())
    for name in ("a.dng", "a.png"):
        photo, _ = read(tmp_path / name)
        assert photo.bayer == letters
        np.testing.assert_array_equal(photo.image, BYTES)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_nothing_is_turned(tmp_path, orientation):
    dng(tmp_path / "a.dng", RAW, more=[(274, "H", 1, orientation, True)])
    np.testing.assert_array_equal(read(tmp_path / "a.dng")[0].image, BYTES)


def test_black_of_each_colour(tmp_path):
    dng(tmp_path / "a.dng", RAW, white=4000, more=[(50713, "H", 2, (2, 2), True),
                                                  (50714, "H", 4, (64, 70, 80, 90), True)])
    photo, said = read(tmp_path / "a.dng")
    black = np.tile([[64, 70], [80, 90]], (24, 32))
    light = np.clip((RAW.astype(int) - black) / (4000 - black), 0, 1)
    np.testing.assert_array_equal(photo.image, np.floor(light * 255 + .5))
    assert "black level 64/70/80/90, white 4000" in said[0]
    dng(tmp_path / "a.dng", RAW, white=60, more=[(50714, "H", 1, 64, True)])
    with pytest.raises(InputError, match="the black level 64 and the white level 60: that leaves"):
        read(tmp_path / "a.dng")


def test_margins_are_left_out(tmp_path):
    dng(tmp_path / "a.dng", RAW, more=[(50829, "H", 4, (4, 6, 44, 64), True)])
    photo, said = read(tmp_path / "a.dng")
    np.testing.assert_array_equal(photo.image, BYTES[4:44, 6:64])
    assert "RGGB frame of 58x40 pixels is taken, from column 6, row 4 of 64x48" in said[0]


def test_compressed_samples(tmp_path):
    tags = [(50706, "B", 4, (1, 4, 0, 0), True), (50708, "s", 0, "Peer", True),
            (271, "s", 0, "Peer", True), (272, "s", 0, "Camera", True),
            (33421, "H", 2, (2, 2), True), (33422, "B", 4, (2, 1, 1, 0), True),
            (50717, "H", 1, 4095, True)]
    with tifffile.TiffWriter(tmp_path / "a.dng") as file:
        file.write(iter([imagecodecs.ljpeg_encode(RAW, bitspersample=12)]), shape=RAW.shape,
                   dtype=np.uint16, compression=7, photometric="cfa", rowsperstrip=48,
                   metadata=None, extratags=tags)
    photo, _ = read(tmp_path / "a.dng")
    assert photo.bayer == "BGGR"
    np.testing.assert_array_equal(photo.image, BYTES)


def test_a_grey_sensor(tmp_path):
    dng(tmp_path / "a.dng", RAW)
    content = (tmp_path / "a.dng").read_bytes()
    cfa, linear = (struct.pack("<HHIH", 262, 3, 1, kind) for kind in (32803, 34892))
    assert content.count(cfa) == 1
    (tmp_path / "a.dng").write_bytes(content.replace(cfa, linear))
    photo, _ = read(tmp_path / "a.dng")
    assert photo.bayer == "MONO"
    np.testing.assert_array_equal(photo.image, BYTES)


def test_a_frame_that_libraw_does_not_know(tmp_path):
    dng(tmp_path / "a.dng", RAW[:16, :16])       # too small for it
    photo, said = read(tmp_path / "a.dng")
    assert photo.bayer == "RGGB" and "its page of 16x16 samples is taken" in said[0]
    np.testing.assert_array_equal(photo.image, BYTES[:16, :16])
    dng(tmp_path / "a.dng", RAW[:16, :16], more=[(50714, "H", 1, 64, True)])
    with pytest.raises(InputError, match="a camera RAW file that LibRaw cannot read .*; save its"):
        read(tmp_path / "a.dng")


_XTRANS = (1, 1, 0, 1, 1, 2, 1, 1, 2, 1, 1, 0, 2, 0, 1, 0, 2, 1,
           1, 1, 2, 1, 1, 0, 1, 1, 0, 1, 1, 2, 0, 2, 1, 2, 0, 1)


@pytest.mark.parametrize("options,reason", [
    ({"pattern": _XTRANS}, "a filter pattern that is not Bayer's, as Fujifilm's X-Trans"),
    ({"samples": np.dstack([RAW] * 3), "photometric": 34892}, "without a raw frame: its pixels")])
def test_other_sensors_are_rejected(tmp_path, options, reason):
    dng(tmp_path / "a.dng", **{"samples": RAW} | options)
    with pytest.raises(InputError, match=reason):
        read(tmp_path / "a.dng")


def test_bits_that_contradict_and_damage(tmp_path, capfd):
    dng(tmp_path / "a.dng", RAW)
    with pytest.raises(InputError, match=r"samples of 12 bits \(0 to 4095\), --bits says 14"):
        read(tmp_path / "a.dng", 14)
    content = (tmp_path / "a.dng").read_bytes()
    (tmp_path / "a.dng").write_bytes(content[:-3000])
    with pytest.raises(InputError, match="a.dng "):
        read(tmp_path / "a.dng")
    for mark in (b"II*\0\x10\0\0\0CR\2\0", b"FUJIFILMCCD-RAW ", b"\0\0\0\x18ftypcrx "):
        (tmp_path / "a.raf").write_bytes(mark + bytes(5000))
        with pytest.raises(InputError, match="a.raf is a camera RAW file that LibRaw cannot read"):
            read(tmp_path / "a.raf")
    assert capfd.readouterr() == ("", "")
