"""``ncdc simulate --sensor``: what it rejects, and a run whose animation is looked at."""

import json

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_model.images import write_image

SIZE = 64, 48


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A descriptor, a raw frame and a colour picture of its size."""
    path = tmp_path_factory.mktemp("moving")
    barrel_descriptor(SIZE, SIZE, hidden_neurons=2, strength=.4).save(path / "net.toml")
    noise = np.random.default_rng(1).integers(0, 256, (SIZE[1], SIZE[0], 3), np.uint8)
    write_image(path / "raw.png", noise[:, :, 0])
    write_image(path / "photo.png", cv2.GaussianBlur(noise, (0, 0), 3))
    return path


def simulate(folder, *options, image="photo.png", output="moving.png"):
    return main(["simulate", str(folder / "net.toml"), str(folder / image), "-o",
                 str(folder / output), "--camera", "mt9p031", *options])


@pytest.mark.parametrize("options,sentence", [
    (("--frames", "0"), "frames is 0, 1 to 1000 are simulated"),
    (("--frames", "1001"), "frames is 1001, 1 to 1000 are simulated"),
    (("--velocity", "3"), "the velocity is '3', two numbers as in 12,0 are needed"),
    (("--velocity", "0,nan"), "the velocity is 0,nan, at most 1000 pixels per frame"),
    (("--exposure-us", "-1"), "the exposure is -1 us"),
    (("--exposure-us", "nan"), "the exposure is nan us"),
    (("--tone", "sRGB"), "--tone is given with --camera mt9p031, which does not take it"),
    (("--line-clocks", "90"), "--line-clocks is given with --camera mt9p031"),
    (("--sensor", "mt9"), "the sensor is 'mt9', known are mt9p031, mt9d111, ov5640, imx219, "
     "ov5647"),
])
def test_what_is_rejected(folder, capsys, options, sentence):
    assert simulate(folder, *options) == 2
    assert sentence in capsys.readouterr().err
    assert not (folder / "moving.png").exists()


def test_an_output_that_is_no_animation(folder, capsys):
    assert simulate(folder, output="moving.jpg") == 2
    assert "an animation is written as one of .png, .webp, .gif" in capsys.readouterr().err


@pytest.mark.regress
def test_a_raw_frame_stands_still_and_a_photo_moves(folder, tmp_path):
    still, moving = tmp_path / "still.png", tmp_path / "moving.png"
    report = tmp_path / "report.json"
    options = ["--frames", "2", "--velocity", "5,0", "--exposure-us", "100", "--data-width", "64",
               "--json", str(report)]
    net = str(folder / "net.toml")
    for image, output in (("raw.png", still), ("photo.png", moving)):
        assert main(["simulate", net, str(folder / image), "-o", str(output), "--sensor",
                     "mt9p031", *options]) == 0
        figures = json.loads(report.read_text())
        assert figures["pixels_compared"] == 2 * SIZE[0] * SIZE[1]
        assert figures["pixels_different"] == 0
    # A reader may make one of equal frames.
    first, *others = cv2.imreadanimation(str(still))[1].frames
    assert all(np.array_equal(first, other) for other in others)
    one, two = (frame[:, :, :3].astype(int)
                for frame in cv2.imreadanimation(str(moving))[1].frames)
    # What moves by five pixels is nearer to the picture before if that is moved as well.
    middle = slice(8, -8), slice(16, -16)
    there = np.abs(two[middle] - np.roll(one, 5, axis=1)[middle]).mean()
    assert there < .5 * np.abs(two - one)[middle].mean()
