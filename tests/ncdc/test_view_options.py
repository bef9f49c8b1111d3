"""``ncdc correct``: views, and films of a shaking camera."""

import io
import json
import sys
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest

from ncdc.cli import main
from ncdc_model.golden.corrector import correct
from ncdc_model.images import read_image, write_image
from ncdc_model.stabilise.gyro_file import load_gyroscope
from ncdc_model.stabilise.stabiliser import Stabiliser
from ncdc_model.view_map import view_map
from ncdc_spec.view import View
from ncdc_spec.view_matrix import Angles, PlaneCamera, view_matrix
from plane_lens import SIZE, seen_lens

COUNT = 4
HEAD = "time_s,x_rad_s,y_rad_s,z_rad_s"


@pytest.fixture(scope="module")
def lens():
    return seen_lens(fill=(9, 80, 7))


def scene():
    v, u = np.indices(SIZE[::-1])
    return np.stack([128 + 100 * np.sin(u / 20), 128 + 100 * np.cos(v / 15), 255 - u],
                    axis=-1).astype(np.uint8)


@pytest.fixture
def film(lens, tmp_path, monkeypatch):
    """The working folder, with a descriptor and ``clip.mp4``; PyAV."""
    av = pytest.importorskip("av")
    from ncdc_model.film import writing_film
    monkeypatch.chdir(tmp_path)
    lens.save("net.toml")
    with writing_film("clip.mp4", SIZE, Fraction(25)) as out:
        for _ in range(COUNT):
            out.write(scene())
    return av


def pictures(av, path):
    with av.open(path) as opened:
        return [frame.to_ndarray(format="rgb24") for frame in opened.decode(video=0)]


def expected(av, lens, size, **angles):
    """The film's picture in a view, and pixels away from the edge of the fill."""
    trained, angles = PlaneCamera.of(lens), Angles(**angles)
    *maps, blank = view_map(lens, size, view_matrix(trained, trained.view(size, angles.zoom),
                                                    angles.rotation))
    picture = cv2.remap(pictures(av, "clip.mp4")[0], *maps, cv2.INTER_LINEAR,
                        borderMode=cv2.BORDER_REPLICATE)
    picture[blank] = lens.geometry.fill
    return picture, cv2.erode((~blank).astype(np.uint8), np.ones((9, 9))) > 0


def test_a_view_of_a_film(film, lens):
    assert main(["correct", "net.toml", "clip.mp4", "-o", "view.mp4", "--pan", "-12", "--tilt",
                 "4", "--roll", "8", "--zoom", "1.3", "--view-size", "72x40", "--json",
                 "report.json"]) == 0
    made = pictures(film, "view.mp4")
    wanted, seen = expected(film, lens, (72, 40), pan=-12, tilt=4, roll=8, zoom=1.3)
    assert seen.mean() > .5
    for picture in made:
        assert np.abs(picture.astype(int) - wanted)[seen].mean() < 4    # the film's code
    report = json.loads(open("report.json").read())
    assert report["pictures"] == COUNT == len(made)
    assert report["view"] == {"pan": -12, "tilt": 4, "roll": 8, "zoom": 1.3, "width": 72,
                              "height": 40, "stabilised": False}


def write_turning(path):
    """Samples of a camera that turns about all three axes."""
    open(path, "w").write("\n".join([HEAD, *(
        f"{t:.3f},{np.sin(20 * t):.9f},{np.cos(30 * t):.9f},-.5" for t in np.arange(0, .4, .005))]))


def golden(lens, raw, size, **angles):
    """The picture of the golden model, by a matrix of SciPy's rotation."""
    from scipy.spatial.transform import Rotation
    angles = {"pan": 0, "tilt": 0, "roll": 0, "zoom": 1, **angles}
    turn = Rotation.from_euler("YXZ", [angles[name] for name in ("pan", "tilt", "roll")],
                               degrees=True).as_matrix()
    scale = size[0] / SIZE[0]
    focal, middle = 60 * scale * angles["zoom"], (np.array(size) - 1) / 2
    centre = middle + scale * (np.array([46.5, 33]) - (np.array(SIZE) - 1) / 2)
    own = np.array([[60, 0, 46.5], [0, 60, 33], [0, 0, 1]])
    view = np.array([[focal, 0, centre[0]], [0, focal, centre[1]], [0, 0, 1]])
    return correct(lens, raw, view=View.of(own @ turn @ np.linalg.inv(view), size)).picture


def test_pictures_and_streams_are_the_golden_model_s(lens, tmp_path, monkeypatch, capsysbinary):
    monkeypatch.chdir(tmp_path)
    lens.save("net.toml")
    raws = np.random.default_rng(1).integers(0, 256, (2, *SIZE[::-1]), np.uint8)
    for k, raw in enumerate(raws):
        write_image(f"frames/{k}.png", raw)
    options = ["--pan", "12", "--tilt", "-4", "--roll", "8", "--zoom", "1.3"]
    options += ["--view-size", "72x40"]
    wanted = [golden(lens, raw, (72, 40), pan=12, tilt=-4, roll=8, zoom=1.3) for raw in raws]
    assert main(["correct", "net.toml", "frames/0.png", "-o", "one.png", "--json", "report.json",
                 *options]) == 0
    np.testing.assert_array_equal(read_image("one.png"), wanted[0])
    assert json.loads(open("report.json").read())["pixels"] == 72 * 40
    assert main(["correct", "net.toml", "frames", "-o", "out", *options]) == 0
    np.testing.assert_array_equal(read_image("out/1.png"), wanted[1])
    capsysbinary.readouterr()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(raws.tobytes())))
    assert main(["correct", "net.toml", "-", "--raw", "96x64:RGGB:8", "-o", "-", *options]) == 0
    assert capsysbinary.readouterr().out == b"".join(one.tobytes() for one in wanted)


def test_a_film_as_raw_frames_is_held_still(film, lens):
    """Each frame by the integer model, with a table of matrices of its own."""
    write_turning("gyro.csv")
    options = ["--gyro", "gyro.csv", "--readout-ms", "20", "--smooth", "100"]
    assert main(["correct", "net.toml", "clip.mp4", "-o", "held.mp4", "--film", "mosaic",
                 *options]) == 0
    assert main(["correct", "net.toml", "clip.mp4", "-o", "free.mp4", "--film", "bilinear",
                 *options]) == 0
    for k, (held, remapped) in enumerate(zip(pictures(film, "held.mp4"),
                                             pictures(film, "free.mp4"))):
        seen = remapped.any(axis=2) & held.any(axis=2)
        assert seen.mean() > .3
        assert np.abs(held.astype(int) - remapped)[seen].mean() < 6, k


def test_raw_frames_are_held_still(lens, tmp_path, monkeypatch, capsysbinary):
    """One, and some of a stream: the second one begins a fifth of a second later."""
    monkeypatch.chdir(tmp_path)
    lens.save("net.toml")
    write_turning("gyro.csv")
    raws = np.random.default_rng(1).integers(0, 256, (2, *SIZE[::-1]), np.uint8)
    write_image("raw.png", raws[0])
    options = ["--gyro", "gyro.csv", "--readout-ms", "20", "--smooth", "100"]
    trained = PlaneCamera.of(lens)
    held = Stabiliser(load_gyroscope("gyro.csv"), trained, trained, np.eye(3), SIZE[1], .02, 0.0,
                      100.0)
    wanted = [correct(lens, raw, view=held.row_view(k / 5)).picture for k, raw in enumerate(raws)]
    assert main(["correct", "net.toml", "raw.png", "-o", "one.png", *options]) == 0
    np.testing.assert_array_equal(read_image("one.png"), wanted[0])
    capsysbinary.readouterr()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(raws.tobytes())))
    assert main(["correct", "net.toml", "-", "--raw", "96x64:RGGB:8", "--fps", "5", "-o", "-",
                 *options]) == 0
    assert capsysbinary.readouterr().out == b"".join(one.tobytes() for one in wanted)


def test_a_film_of_a_camera_that_pans(film, lens):
    """The gyroscope's second axis, turned about, is the camera's; without smoothing no turn is
    undone, with much of it all but the mean is."""
    rate = np.radians(100)
    rows = [f"{t:.3f},{-rate:.9f},0,0" for t in np.arange(-.1, .4, .005)]
    open("gyro.csv", "w").write("\n".join([HEAD, *rows]))
    options = ["--gyro", "gyro.csv", "--gyro-axes", "y,-x,z", "--gyro-offset", "0.02"]
    assert main(["correct", "net.toml", "clip.mp4", "-o", "held.mp4", *options, "--smooth",
                 "100"]) == 0
    assert main(["correct", "net.toml", "clip.mp4", "-o", "free.mp4", *options, "--smooth",
                 "0"]) == 0
    middle = (-.1 + .395) / 2
    for k, (held, free) in enumerate(zip(pictures(film, "held.mp4"), pictures(film, "free.mp4"))):
        for picture, pan in ((held, np.degrees(rate) * (middle - .02 - k / 25)), (free, 0)):
            wanted, seen = expected(film, lens, SIZE, pan=pan)
            assert seen.mean() > .3
            assert np.abs(picture.astype(int) - wanted)[seen].mean() < 4, (k, pan)


def test_the_time_of_a_film_is_from_its_first_picture(film):
    """A film whose time stamps begin at 5 s, and samples from 0 to 1 s."""
    open("still.csv", "w").write("\n".join([HEAD, *(f"{k / 20},0,0,0" for k in range(21))]))
    with film.open("clip.mp4") as clip, film.open("late.mkv", "w") as late:
        stream = late.add_stream_from_template(clip.streams.video[0])
        for packet in clip.demux(video=0):
            if packet.dts is not None:
                moved, packet.stream = round(5 / packet.time_base), stream
                packet.pts, packet.dts = packet.pts + moved, packet.dts + moved
                late.mux(packet)
    with film.open("late.mkv") as late:
        assert next(late.decode(video=0)).time == 5
    assert main(["correct", "net.toml", "late.mkv", "-o", "view.mkv", "--gyro", "still.csv"]) == 0
    assert len(pictures(film, "view.mkv")) == COUNT


@pytest.mark.parametrize("options,message", [
    (["--pan", "91"], "pan is 91, the limits are -90 and 90"),
    (["--zoom", "0"], "zoom is 0, the limits are 0.25 and 8"),
    (["--view-size", "5000x4"], "the view's size is '5000x4'"),
    (["--view-size", "big"], "the view's size is 'big'"),
    (["--smooth", "2"], "--smooth is given, it needs --gyro"),
    (["--gyro", "none.csv"], "cannot read none.csv"),
    (["--gyro", "still.csv", "--readout-ms", "300"], "the readout is 0.3 s, the limits are 0 and"),
    (["--gyro", "still.csv", "--gyro-offset", "3"], "samples are from 0 s to 1 s")])
def test_bad_options(film, capsys, options, message):
    open("still.csv", "w").write("\n".join([HEAD, *(f"{k / 20},0,0,0" for k in range(21))]))
    open("view.mp4", "w").write("kept")
    assert main(["correct", "net.toml", "clip.mp4", "-o", "view.mp4", *options]) == 2
    assert message in capsys.readouterr().err
    assert open("view.mp4").read() == "kept"


def test_a_gyroscope_needs_times(lens, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lens.save("net.toml")
    open("still.csv", "w").write("\n".join([HEAD, "0,0,0,0", ".05,0,0,0"]))
    Path("frames").mkdir()
    write_image("frames/raw.png", np.zeros(SIZE[::-1], np.uint8))
    for source, output, message in (("camera:0", "view.mp4", "camera:0 is a camera, --gyro needs"),
                                    ("frames", "out", "files have no times, --gyro needs a film")):
        assert main(["correct", "net.toml", source, "-o", output, "--gyro", "still.csv"]) == 2
        assert message in capsys.readouterr().err


def test_a_view_needs_a_focal_length(film, capsys):
    text = open("net.toml").read()
    for frame, message in (("5", "does not state the focal length"),
                           ("[0.0, 1.0, 2.0]", "provenance.frame is [0.0, 1.0, 2.0], a focal"),
                           ('["a", 1, 2]', "provenance.frame is ['a', 1, 2], a focal length"),
                           ("[60.0, 1.0, 2.0, -1.0]", "and an aspect ratio above 0 are needed")):
        assert "frame = [60.0, 46.5, 33.0]" in text
        open("net.toml", "w").write(text.replace("[60.0, 46.5, 33.0]", frame))
        assert main(["correct", "net.toml", "clip.mp4", "-o", "view.mp4", "--pan", "1"]) == 2
        assert message in capsys.readouterr().err
