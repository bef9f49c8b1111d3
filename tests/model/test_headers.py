"""The depth that PNM, PNG, JPEG 2000 and AVIF files declare."""

import imagecodecs
import numpy as np
import pytest
from PIL import Image

from ncdc_model.photo.headers import pnm_pictures
from ncdc_spec.errors import InputError
from photo_files import SAMPLES, png, read

WHITES = (1, 100, 127, 255, 511, 1000, 1023, 4095, 16383)


def by_white(samples, white):
    """uint8 by the rule: upper eight bits where there are as many, else scaled and rounded."""
    bits = white.bit_length()
    if bits >= 8 and white + 1 == 1 << bits:
        return samples >> (bits - 8)
    return np.floor(samples * 255 / white + .5)


def pnm(path, kind, samples, white, comment=b"# a comment 12 34\n"):
    height, width = samples.shape[:2]
    if kind == 7:
        head = (f"P7\nWIDTH {width}\nHEIGHT {height}\nDEPTH 1\nMAXVAL {white}\nTUPLTYPE GRAYSCALE\n"
                f"ENDHDR\n").encode()
    else:
        head = b"P%d\n%s%d %d\n%d\n" % (kind, comment, width, height, white)
    body = (" ".join(map(str, samples.ravel())).encode() if kind in (2, 3) else
            samples.astype(">u2" if white > 255 else np.uint8).tobytes())
    path.write_bytes(head + body)


@pytest.mark.parametrize("white", WHITES)
@pytest.mark.parametrize("kind", [2, 3, 5, 6, 7])
def test_maxval_of_pnm(tmp_path, kind, white):
    samples = SAMPLES.astype(np.int64) * white // 65535 // 2     # half as bright as could be
    if kind in (3, 6):
        samples = np.stack([samples, samples[::-1], samples[:, ::-1]], 2)
    pnm(tmp_path / "a.pnm", kind, samples, white)
    photo, said = read(tmp_path / "a.pnm")
    # OpenCV scales samples in ASCII itself, and rounds down.
    away = by_white(samples, white) - photo.image
    assert away.min() >= 0 and away.max() <= (kind in (2, 3) and white == 100) and not said
    if white > 255:
        bits = white.bit_length()
        np.testing.assert_array_equal(read(tmp_path / "a.pnm", bits)[0].image, photo.image)
        with pytest.raises(InputError, match=rf"of {bits} bits \(0 to {white}\), --bits says 16"):
            read(tmp_path / "a.pnm", 16)


@pytest.mark.parametrize("white", [100, 127])
def test_pillow_agrees_on_odd_maxvals(tmp_path, white):
    pnm(tmp_path / "a.pgm", 5, SAMPLES.astype(np.int64) * white // 65535, white)
    difference = (np.asarray(Image.open(tmp_path / "a.pgm")).astype(int)
                  - read(tmp_path / "a.pgm")[0].image)
    assert np.abs(difference).max() <= (white == 100)       # it rounds halves to even


def test_a_sample_above_maxval_is_rejected(tmp_path):
    pnm(tmp_path / "a.pgm", 5, SAMPLES >> 4, 4000)
    with pytest.raises(InputError, match="a sample of 409[0-5] and declares 4000 as the largest"):
        read(tmp_path / "a.pgm")


def test_sixteen_bits_are_no_declaration(tmp_path):
    pnm(tmp_path / "a.pgm", 5, SAMPLES >> 4, 65535)
    assert "taken as 12-bit" in read(tmp_path / "a.pgm")[1][0]
    np.testing.assert_array_equal(read(tmp_path / "a.pgm", 16)[0].image, SAMPLES >> 12)


def test_several_pictures_in_a_pnm(tmp_path):
    pnm(tmp_path / "a.pgm", 5, SAMPLES >> 6, 1023)
    (tmp_path / "a.pgm").write_bytes((tmp_path / "a.pgm").read_bytes() * 3)
    photo, said = read(tmp_path / "a.pgm")
    assert "a.pgm: the first of 3 pictures is taken" in said[0]
    np.testing.assert_array_equal(photo.image, SAMPLES >> 8)
    assert pnm_pictures(b"P4 9 2\nabcdP4 9 2\nabcd") == 2
    assert pnm_pictures(b"P2 1 1 5\n3") == pnm_pictures(b"\x89PNG") == pnm_pictures(b"P5 x") == 1


@pytest.mark.parametrize("dark", [0, 2, 4])
@pytest.mark.parametrize("bits", [9, 10, 12, 14, 15])
def test_sbit_with_samples_in_upper_or_lower_bits(tmp_path, bits, dark):
    samples = (SAMPLES >> (16 - bits) >> dark).astype(np.int64)
    zeros = samples << (16 - bits)
    for stored in (samples, zeros, zeros | samples >> (2 * bits - 16),
                   np.floor(samples * 65535 / ((1 << bits) - 1) + .5).astype(int)):
        png(tmp_path / "a.png", stored, 16, 0, [(b"sBIT", bytes([bits]))])
        photo, said = read(tmp_path / "a.png")
        np.testing.assert_array_equal(photo.image, samples >> (bits - 8))
        assert not said
        np.testing.assert_array_equal(read(tmp_path / "a.png", bits)[0].image, photo.image)
    with pytest.raises(InputError, match=f"declares samples of {bits} bits .*--bits says 16"):
        read(tmp_path / "a.png", 16)


@pytest.mark.parametrize("bits", [4, 5, 7])
def test_sbit_below_eight(tmp_path, bits):
    samples = (SAMPLES >> (16 - bits)).astype(np.int64)
    wanted = np.floor(samples * 255 / ((1 << bits) - 1) + .5)
    for stored in (samples, samples << (8 - bits)):
        png(tmp_path / "a.png", stored, 8, 0, [(b"sBIT", bytes([bits]))])
        np.testing.assert_array_equal(read(tmp_path / "a.png")[0].image, wanted)


def test_sbit_of_colours(tmp_path):
    rgb = np.stack([SAMPLES, SAMPLES[::-1], SAMPLES[:, ::-1]], 2)
    png(tmp_path / "a.png", rgb >> 6, 16, 2, [(b"sBIT", b"\x0a\x0a\x0a")])
    np.testing.assert_array_equal(read(tmp_path / "a.png")[0].image, rgb >> 8)
    png(tmp_path / "a.png", rgb, 16, 2, [(b"sBIT", b"\x10\x10\x10")])
    photo, said = read(tmp_path / "a.png")
    assert not said and (photo.image == rgb >> 8).all()
    png(tmp_path / "a.png", (rgb >> 8) & 0xF8, 8, 2, [(b"sBIT", b"\5\6\5")])
    np.testing.assert_array_equal(read(tmp_path / "a.png")[0].image, (rgb >> 8) & 0xF8)


@pytest.mark.parametrize("bits", [9, 10, 12, 14])
def test_depth_of_jpeg_2000(tmp_path, bits):
    samples = SAMPLES >> (16 - bits) >> 1
    for form in ("jp2", "j2k"):
        (tmp_path / "a.jp2").write_bytes(imagecodecs.jpeg2k_encode(
            samples, bitspersample=bits, reversible=True, level=0, codecformat=form))
        photo, said = read(tmp_path / "a.jp2")
        np.testing.assert_array_equal(photo.image, samples >> (bits - 8))
        assert not said


@pytest.mark.parametrize("bits", [10, 12])
def test_depth_of_avif(tmp_path, bits):
    rgb = np.stack([SAMPLES, SAMPLES[::-1], SAMPLES[:, ::-1]], 2) >> (16 - bits) >> 1
    (tmp_path / "a.avif").write_bytes(imagecodecs.avif_encode(rgb, level=100, bitspersample=bits))
    photo, said = read(tmp_path / "a.avif")
    assert not said and np.abs(photo.image - (rgb >> (bits - 8)).astype(int)).max() <= 1
