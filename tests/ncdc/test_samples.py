"""Raw frames of more than eight bits, in 16-bit files and as dumps."""

import re

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from lenses import GEOMETRY, known_network
from ncdc.cli import main
from ncdc_model.golden.corrector import correct
from ncdc_model.images import read_image
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.geometry import ValidRows
from photo_files import dng

SHAPE = GEOMETRY.distorted[::-1]


@pytest.fixture
def corrected(tmp_path, monkeypatch, capsys):
    """Run ncdc correct on a file; what it said, having compared the picture with the model's."""
    monkeypatch.chdir(tmp_path)
    Descriptor.quantise(known_network(), GEOMETRY, ValidRows.everything(320, 240)).save("net.toml")

    def run(*arguments, expected=None):
        status = main(["correct", "net.toml", *arguments, "-o", "out.png"])
        if expected is not None:
            golden = correct(Descriptor.load("net.toml"), expected)
            np.testing.assert_array_equal(read_image("out.png"), golden.picture)
        return status, capsys.readouterr().err
    return run


def samples(bits):
    values = np.random.default_rng(bits).integers(0, 1 << bits, SHAPE)
    values[0, 0] = (1 << bits) - 1
    return values.astype(np.uint16)


@pytest.mark.parametrize("bits", [8, 10, 12, 14, 16])
def test_bits_are_guessed_and_reported(corrected, bits):
    raw = samples(bits)
    cv2.imwrite("raw.png", raw)
    status, said = corrected("raw.png", expected=(raw >> (bits - 8)).astype(np.uint8))
    assert status == 0
    assert (f"raw.png has 16-bit samples, the brightest is {(1 << bits) - 1}: taken as "
            f"{bits}-bit; --bits says otherwise") in said


def test_bits_are_those_given(corrected):
    cv2.imwrite("raw.png", samples(10))
    wanted = (samples(10) >> 4).astype(np.uint8)
    status, said = corrected("raw.png", "--bits", "12", expected=wanted)
    assert status == 0 and "taken as 1" not in said
    assert corrected("raw.png", "--bits", "9")[1] == (
        "ncdc correct: raw.png holds a sample of 1023, 9 bits end at 511\n")
    assert "samples of 17 bits are asked for, the limits are 8 and 16" in corrected(
        "raw.png", "--bits", "17")[1]


@pytest.mark.parametrize("bits,kind", [(8, "<u1"), (10, "<u2"), (12, "<u2"), (16, "<u2")])
def test_a_dump_is_read(corrected, tmp_path, bits, kind):
    raw = samples(bits)
    (tmp_path / "frame.raw").write_bytes(raw.astype(kind).tobytes())
    status, _ = corrected("frame.raw", "--raw", f"320x240:RGGB:{bits}",
                          expected=(raw >> (bits - 8)).astype(np.uint8))
    assert status == 0


def test_a_packed_dump_of_two_frames_with_a_stride(corrected, tmp_path):
    raw = samples(10)
    groups = np.concatenate([(raw >> 2).reshape(240, 80, 4), np.zeros((240, 80, 1), int)], 2)
    rows = np.pad(groups.reshape(240, 400).astype(np.uint8), ((0, 0), (0, 16)))
    (tmp_path / "frame.raw").write_bytes(bytes(rows.size) + rows.tobytes())
    wanted = (raw >> 2).astype(np.uint8)
    status, said = corrected("frame.raw", "--raw", "320x240:RGGB:10p:stride=416:frame=2",
                             expected=wanted)
    assert status == 0 and "frame.raw" not in said
    status, said = corrected("frame.raw", "--raw", "320x240:RGGB:10p:stride=416",
                             expected=np.zeros_like(wanted))
    assert status == 0 and "frame.raw: the first of 2 frames is taken" in said


def test_a_camera_raw_file(corrected, tmp_path):
    raw = samples(12)
    dng(tmp_path / "frame.dng", raw)
    status, said = corrected("frame.dng", expected=(raw >> 4).astype(np.uint8))
    assert status == 0 and "frame.dng is a camera RAW file: its RGGB frame of 320x240" in said
    dng(tmp_path / "frame.dng", raw, pattern=(2, 1, 1, 0))
    assert corrected("frame.dng")[0] == 2
    assert "the raw frame has the pattern BGGR, the descriptor RGGB" in corrected("frame.dng")[1]


def test_an_array(corrected, tmp_path):
    np.save(tmp_path / "frame.npy", samples(12))
    status, said = corrected("frame.npy", "--bits", "12",
                             expected=(samples(12) >> 4).astype(np.uint8))
    assert status == 0 and "frame.npy has one channel: taken as the raw RGGB frame" in said
    status, said = corrected("frame.npy", "--raw", "320x240:RGGB:12")
    assert status == 2 and "it is a NumPy file, which is read without --raw" in said


@pytest.mark.parametrize("option,sentence", [
    ("320x240:RGGB:8", "frame.raw has 153600 bytes, 320x240 samples of 1 byte need 76800; that is "
                       "one frame of 9 to 16 bits, or two of 8 (:frame=1)\n"),
    ("320x241:RGGB:12", "320x241 samples of 2 bytes need 154240; by bits: 8 77120, 9 to 16 154240, "
                        "10p 96400, 12p 115680, 14p 134960\n"),
    ("320x240:RGGB:10p", "320x240 packed samples of 10 bits need 96000; that is one frame of 9 to "
                         "16 bits\n"),
    ("300x240:RGGB:12", "153600 bytes, 300x240 samples of 2 bytes need 144000; rows of 640 bytes "
                        "would fit (:stride=)\n"),
    ("320x240:RGGB:12:stride=1000", "153600 bytes, 240 rows of 1000 bytes need 240000"),
    ("320x240:RGGB:12:stride=639", "the stride is 639 bytes, the samples of a row need 640\n"),
    ("320x240:RGGB:12:frame=2", "frame.raw holds 1 frame, frame 2 is asked for\n"),
    ("320x240:RGGB:12:frame=0", "the frame is 0, frames are counted from 1\n"),
    ("320x240:RGGB:16p", "packed samples of 16 bits are asked for, those of 10, 12, 14 bits are"),
    ("320x240:RGGB:12:frame=1:frame=1", "WxH:PATTERN:BITS is needed"),
    ("320x240:RGGB:12:step=1", "WxH:PATTERN:BITS is needed"),
    ("320x240:BGGR:12", "the raw frame has the pattern BGGR, the descriptor RGGB"),
    ("320x240:RGGB:11", "frame.raw holds a sample of 4095, 11 bits end at 2047"),
    ("320x240:RGGB", "raw is '320x240:RGGB', WxH:PATTERN:BITS is needed, as in 1280x1024:RGGB:12"),
    ("320x240:RGB:12", "the patterns are RGGB, GRBG, GBRG, BGGR"),
    ("4x240:RGGB:12", "a side of the raw frame is 4, the limits are 8 and 4096"),
    ("320x240:RGGB:7", "samples of 7 bits are asked for, the limits are 8 and 16"),
])
def test_a_dump_that_does_not_fit_is_rejected(corrected, tmp_path, option, sentence):
    (tmp_path / "frame.raw").write_bytes(samples(12).tobytes())
    status, said = corrected("frame.raw", "--raw", option)
    assert status == 2 and sentence in said and said.count("\n") == 1


def test_both_options_are_rejected(corrected, tmp_path):
    (tmp_path / "frame.raw").write_bytes(samples(12).tobytes())
    assert "--raw says the bits itself" in corrected("frame.raw", "--raw", "320x240:RGGB:12",
                                                     "--bits", "12")[1]


def test_what_a_picture_is_taken_for_is_reported(corrected):
    grey = (samples(16) >> 8).astype(np.uint8)
    cv2.imwrite("grey.png", grey)
    assert "grey.png has one channel: taken as the raw RGGB frame" in corrected("grey.png")[1]
    cv2.imwrite("colour.png", np.repeat(grey[:, :, None], 3, 2))
    assert "colour.png is a colour picture: mosaiced as RGGB" in corrected("colour.png")[1]
    cv2.imwrite("grey.jpg", grey)
    assert corrected("grey.jpg") == (2, "ncdc correct: grey.jpg is a grey JPEG, a raw RGGB frame "
                                        "or a colour picture is needed; a grey camera is trained "
                                        "with --bayer MONO\n")


def test_a_grey_jpeg_in_a_tiff_is_no_raw_frame(corrected):
    Image.fromarray((samples(16) >> 8).astype(np.uint8)).save("grey.tif", compression="jpeg")
    assert "grey.tif is a grey JPEG, a raw RGGB frame" in corrected("grey.tif")[1]


@pytest.mark.parametrize("orientation", [3, 6])
def test_a_raw_frame_is_not_turned(corrected, orientation):
    raw = samples(12)
    tifffile.imwrite("raw.tif", raw, bitspersample=12, extratags=[(274, "H", 1, orientation, True)])
    assert corrected("raw.tif", "--bits", "12", expected=(raw >> 4).astype(np.uint8))[0] == 0


def _without_hash(path):
    """Text of a points file without the hash of its points, in which the photo's name counts."""
    return re.sub(r'"points": "[0-9a-f]{64}"', "", path.read_text())


def test_calibrate_takes_the_same_options(tmp_path, capsys):
    photo = cv2.imread("tests/data/opencv/left01.jpg", cv2.IMREAD_GRAYSCALE)
    deep = tmp_path / "left.png"
    cv2.imwrite(str(deep), photo.astype(np.uint16) << 2)
    arguments = ["--target", "chessboard:9x6", "-o", str(tmp_path / "points.json")]
    assert main(["calibrate", str(deep), *arguments]) == 0
    assert "taken as 10-bit" in capsys.readouterr().err
    (tmp_path / "left.raw").write_bytes((photo.astype("<u2") << 2).tobytes())
    first = _without_hash(tmp_path / "points.json")
    height, width = photo.shape
    assert main(["calibrate", str(tmp_path / "left.raw"), *arguments,
                 "--raw", f"{width}x{height}:RGGB:10"]) == 0
    assert _without_hash(tmp_path / "points.json") == first.replace("left.png", "left.raw")
