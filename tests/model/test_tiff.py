"""TIFF files of tifffile, Pillow and OpenCV, as they are stored."""

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from ncdc_model.photo.tiff import read_tiff
from ncdc_spec.errors import InputError
from photo_files import SAMPLES, read

BYTES = (SAMPLES >> 8).astype(np.uint8)
RGB = np.stack([BYTES, BYTES[::-1], BYTES[:, ::-1]], 2)


def stored(path, samples, bits=None, **options):
    """(photo, warnings) of ``samples`` that tifffile wrote."""
    tifffile.imwrite(path / "a.tif", samples, metadata=None, **options)
    return read(path / "a.tif", bits)


@pytest.mark.parametrize("bits", range(9, 16))
def test_packed_samples_of_any_depth(tmp_path, bits):
    samples = SAMPLES >> (16 - bits) >> 1       # the brightest is half of what could be
    photo, said = stored(tmp_path, samples, bitspersample=bits)
    np.testing.assert_array_equal(photo.image, samples >> (bits - 8))
    assert not said
    np.testing.assert_array_equal(read(tmp_path / "a.tif", bits)[0].image, photo.image)
    with pytest.raises(InputError, match=rf"of {bits} bits \(0 to .*\), --bits says 16"):
        read(tmp_path / "a.tif", 16)


@pytest.mark.parametrize("bits", [1, 2, 4])
def test_few_bits_reach_white(tmp_path, bits):
    samples = SAMPLES >> (16 - bits)
    photo, _ = stored(tmp_path, samples > 0 if bits == 1 else samples.astype(np.uint8),
                      bitspersample=bits, photometric="minisblack")
    np.testing.assert_array_equal(photo.image, samples * (255 // ((1 << bits) - 1)))


def test_sixteen_bits_are_a_guess_or_given(tmp_path):
    photo, said = stored(tmp_path, SAMPLES >> 4, byteorder=">")
    np.testing.assert_array_equal(photo.image, BYTES)
    assert "taken as 12-bit" in said[0]
    np.testing.assert_array_equal(read(tmp_path / "a.tif", 14)[0].image, SAMPLES >> 10)


@pytest.mark.parametrize("options", [
    {"compression": name} for name in ("lzw", "zlib", "packbits", "zstd", "lzma")] + [
    {"compression": "lzw", "predictor": True}, {"tile": (16, 32)}, {"bigtiff": True},
    {"rowsperstrip": 5}], ids=str)
@pytest.mark.parametrize("samples", [BYTES, SAMPLES, RGB, RGB * np.uint16(257)],
                         ids=["grey8", "grey16", "rgb8", "rgb16"])
def test_compressions_and_layouts(tmp_path, samples, options):
    colours = "rgb" if samples.ndim == 3 else "minisblack"
    photo, _ = stored(tmp_path, samples, photometric=colours, **options)
    wide = samples.dtype == np.uint16
    np.testing.assert_array_equal(photo.image, samples >> 8 if wide else samples)
    assert not photo.lossy and photo.bayer is None


@pytest.mark.parametrize("samples", [RGB, RGB * np.uint16(257)], ids=["8", "16"])
def test_planes_of_colours(tmp_path, samples):
    photo, _ = stored(tmp_path, np.moveaxis(samples, 2, 0).copy(), photometric="rgb",
                      planarconfig="separate")
    np.testing.assert_array_equal(photo.image, RGB)


@pytest.mark.parametrize("alpha", ["unassalpha", "assocalpha", "unspecified"])
def test_alpha_is_dropped_and_changes_nothing(tmp_path, alpha):
    veil = BYTES[:, :, None]
    photo, _ = stored(tmp_path, np.dstack([RGB, veil]), photometric="rgb", extrasamples=[alpha])
    np.testing.assert_array_equal(photo.image, RGB)
    for samples in (np.dstack([BYTES[::-1], veil]), np.dstack([SAMPLES[::-1], SAMPLES])):
        photo, _ = stored(tmp_path, samples, photometric="minisblack", planarconfig="contig",
                          extrasamples=[alpha])
        np.testing.assert_array_equal(photo.image, BYTES[::-1])


@pytest.mark.parametrize("bits", [1, 8, 12, 16])
def test_an_inverted_file(tmp_path, bits):
    samples = (SAMPLES > 999 if bits == 1 else SAMPLES >> (16 - bits))
    samples = samples.astype(np.uint8) if bits == 8 else samples
    photo, said = stored(tmp_path, samples, photometric="miniswhite", bitspersample=bits)
    full = (1 << bits) - 1
    wanted = (full - samples.astype(int)) * 255 if bits == 1 else (full - samples) >> (bits - 8)
    np.testing.assert_array_equal(photo.image, wanted)
    assert any("MinIsWhite): inverted" in text for text in said)
    if bits == 16:
        stored(tmp_path, SAMPLES >> 4, photometric="miniswhite")
        np.testing.assert_array_equal(read(tmp_path / "a.tif", 12)[0].image, 255 - BYTES)


def test_a_palette(tmp_path):
    colours = np.random.default_rng(1).integers(0, 256, (3, 256))
    photo, _ = stored(tmp_path, BYTES, photometric="palette",
                      colormap=(colours * 257).astype(np.uint16))
    np.testing.assert_array_equal(photo.image, np.moveaxis(colours[:, BYTES], 0, 2))
    colours[:] = np.arange(255, -1, -1)
    photo, _ = stored(tmp_path, BYTES, photometric="palette",
                      colormap=(colours * 257).astype(np.uint16))
    np.testing.assert_array_equal(photo.image, 255 - BYTES)


@pytest.mark.parametrize("compression", ["group4", "tiff_lzw", "jpeg", "tiff_deflate"])
def test_what_pillow_writes(tmp_path, compression):
    flat = np.full((48, 64, 3), (200, 90, 30), np.uint8)
    picture = Image.fromarray(BYTES > 99 if compression == "group4" else flat)
    picture.save(tmp_path / "a.tif", compression=compression)
    photo, _ = read(tmp_path / "a.tif")
    wanted = (BYTES > 99) * 255 if compression == "group4" else flat
    assert np.abs(photo.image - wanted.astype(int)).max() <= (2 if compression == "jpeg" else 0)
    assert photo.lossy == (compression == "jpeg")


@pytest.mark.parametrize("samples", [BYTES, RGB, SAMPLES], ids=["grey", "rgb", "deep"])
def test_what_opencv_writes(tmp_path, samples):
    cv2.imwrite(str(tmp_path / "a.tif"), samples if samples.ndim == 2 else samples[:, :, ::-1])
    np.testing.assert_array_equal(read(tmp_path / "a.tif", 16 if samples is SAMPLES else None)[
        0].image, RGB if samples is RGB else BYTES)


def test_further_pages_and_previews(tmp_path):
    photo, said = stored(tmp_path, np.stack([BYTES, BYTES[::-1], BYTES]),
                         photometric="minisblack")
    np.testing.assert_array_equal(photo.image, BYTES)
    assert said == [f"{tmp_path / 'a.tif'}: the first of 3 pages is taken"]
    for nested in (0, 1):
        with tifffile.TiffWriter(tmp_path / "a.tif") as file:
            file.write(RGB[::2, ::2], photometric="rgb", subfiletype=1, subifds=nested,
                       metadata=None)
            file.write(BYTES, photometric="minisblack", metadata=None)
        photo, said = read(tmp_path / "a.tif")
        np.testing.assert_array_equal(photo.image, BYTES)
        assert "a.tif begins with a preview: its page of 64x48 pixels is taken" in said[0]
    with pytest.raises(InputError, match=r"a.tif holds only previews \(NewSubfileType 1\)"):
        stored(tmp_path, BYTES, subfiletype=1)


@pytest.mark.parametrize("samples,options,reason", [
    (SAMPLES.astype(np.float32), {}, "holds float32 samples, unsigned integers of 1 to 16 bits"),
    (SAMPLES.astype(np.int16), {}, "holds int16 samples"),
    (SAMPLES.astype(np.uint32), {}, "holds uint32 samples"),
    (np.dstack([RGB, BYTES]), {"photometric": "separated"}, "the colour space SEPARATED, which"),
    (RGB, {"photometric": "cielab"}, "the colour space CIELAB, which is not supported"),
    (RGB, {"photometric": "ycbcr", "subsampling": (1, 1)}, "the colour space YCBCR, which"),
    (RGB, {"photometric": "minisblack", "planarconfig": "contig"}, "MINISBLACK with 3 channels, 1"),
    (np.zeros((16, 16, 16), np.uint8), {"volumetric": True, "tile": (16, 16, 16)}, "one flat")],
    ids=lambda value: value if isinstance(value, str) else "")
def test_other_variants_are_rejected(tmp_path, samples, options, reason):
    with pytest.raises(InputError, match=f"a.tif .*{reason}"):
        stored(tmp_path, samples, **options)


@pytest.mark.parametrize("options", [{}, {"compression": "lzw"}, {"tile": (16, 16)}], ids=str)
def test_files_cut_short_are_rejected_and_nothing_is_printed(tmp_path, options, capfd):
    tifffile.imwrite(tmp_path / "a.tif", BYTES, **options)
    content = (tmp_path / "a.tif").read_bytes()
    for length in (4, 9, 100):
        with pytest.raises(InputError, match="holds no image that can be decoded: it is a TIFF"):
            read_tiff("a", content[:length], None, pytest.fail)
    with tifffile.TiffFile(tmp_path / "a.tif", mode="r+") as file:
        offsets, tag = file.pages[0].dataoffsets, file.pages[0].tags[325 if "tile" in options
                                                                     else 279]
        with pytest.raises(InputError, match="a holds no image .* it is a TIFF file that is cut"):
            read_tiff("a", content[:offsets[-1] + 20], None, pytest.fail)
        tag.overwrite([0] * len(offsets))       # tifffile takes a part without bytes for black
    with pytest.raises(InputError, match="a.tif holds no image .* it is a TIFF file that is cut"):
        read(tmp_path / "a.tif")
    assert capfd.readouterr() == ("", "")


def test_filtered_samples_without_a_camera(tmp_path):
    tags = [(33421, "H", 2, (2, 2), True), (33422, "B", 4, (1, 0, 2, 1), True)]
    photo, said = stored(tmp_path, SAMPLES >> 4, photometric="cfa", extratags=tags)
    np.testing.assert_array_equal(photo.image, BYTES)
    assert photo.bayer == "GRBG" and "taken as 12-bit" in said[0]
    assert "a TIFF with a raw frame: its page of 64x48 samples is taken, filter pattern GRBG" \
        in said[1]
    photo, said = stored(tmp_path, BYTES, photometric="minisblack", extratags=tags)
    assert photo.bayer == "GRBG" and len(said) == 1
    np.testing.assert_array_equal(photo.image, BYTES)
    photo, said = stored(tmp_path, SAMPLES, 16, photometric="cfa")
    assert photo.bayer is None and "filter pattern not declared" in said[0]
    np.testing.assert_array_equal(photo.image, BYTES)
    tags[1] = (33422, "B", 4, (1, 0, 2, 4), True)
    with pytest.raises(InputError, match=r"the filter pattern GRB\? of \(2, 2\), a Bayer pattern"):
        stored(tmp_path, SAMPLES, photometric="cfa", extratags=tags)
    with pytest.raises(InputError, match="the tag BlackLevel, which is supported in DNG only"):
        stored(tmp_path, SAMPLES, photometric="cfa", extratags=[(50714, "H", 1, 64, True)])
