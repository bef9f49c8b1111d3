"""``ncdc calibrate --live`` and ``camera:0``: films, and cameras of the PC that OpenCV has."""

import json
import time

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from live_camera import HAND_PICKED, Hand, write_film
from ncdc.cli import main
from ncdc_model import pc_camera
from ncdc_model.calibration.points import TargetPoints
from ncdc_model.images import read_image
from ncdc_model.pc_camera import opened_camera
from ncdc_model.remap_tables import remap_tables
from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import GRADIENT

POSES = HAND_PICKED[:3]


class Capture:
    """What ``cv2.VideoCapture`` is to the program: a camera with ``frames`` (h, w, 3), BGR.

    After the last one Ctrl-C is pressed, or none comes. If it is ``paced``, they come at ``rate``.
    """

    def __init__(self, frames, interrupted=False, rate=25.0, paced=False):
        self.frames, self.interrupted, self.rate = list(frames), interrupted, rate
        self.paced = paced
        self.taken, self.released = -1, False

    def __call__(self, number):
        self.number = number
        return self

    def isOpened(self):
        return self.number == 0

    def get(self, what):
        assert what == cv2.CAP_PROP_FPS
        return self.rate

    def grab(self):
        if self.taken + 1 >= len(self.frames):
            if self.interrupted:
                raise KeyboardInterrupt
            return False
        if self.paced:
            time.sleep(1 / self.rate)
        self.taken += 1
        return True

    def retrieve(self):
        return True, self.frames[self.taken]

    def release(self):
        self.released = True


@pytest.fixture
def camera(monkeypatch):
    """Function that makes a :class:`Capture` the only camera of the PC."""
    def install(*args, **more):
        capture = Capture(*args, **more)
        monkeypatch.setattr(pc_camera, "VideoCapture", capture)
        return capture
    return install


def noise(count, size=(96, 64)):
    """Smooth pictures, BGR."""
    rng = np.random.default_rng(1)
    return [cv2.GaussianBlur(rng.integers(0, 256, (*size[::-1], 3), np.uint8), (0, 0), 4)
            for _ in range(count)]


def test_frames_of_a_camera(camera):
    capture = camera(noise(3))
    with opened_camera("camera:0") as opened:
        assert opened.size == (96, 64) and opened.rate == 25
        for frame in noise(3):
            np.testing.assert_array_equal(opened.read(), frame[:, :, ::-1])
        with pytest.raises(InputError, match="camera:0 sends no frame any more"):
            opened.read()
    assert capture.released


def test_the_newest_frame_is_taken(camera):
    """All grabs come at once here, as those of frames that the driver has stored."""
    capture = camera(noise(20))
    with opened_camera("camera:0") as opened:
        opened.newest()
        assert capture.taken >= 8


@pytest.mark.parametrize("name,message", [
    ("camera:1", "camera:1: this PC has no camera of this number"),
    ("camera:", "camera: is no camera of this PC: camera:0 is the first one"),
    ("camera:front", "camera:front is no camera of this PC"),
    ("camera:100", "the limit is camera:99")])
def test_cameras_that_are_not_there(camera, name, message, tmp_path, capsys):
    camera(noise(1))
    kept = tmp_path / "points.json"
    kept.write_text("kept")
    assert main(["calibrate", "--live", name, "-o", str(kept)]) == 2
    assert message in capsys.readouterr().err and kept.read_text() == "kept"


def test_a_pc_without_a_camera_says_so(capsys, tmp_path):
    """With OpenCV's own class, which prints its search."""
    assert main(["calibrate", "--live", "camera:98", "-o", str(tmp_path / "points.json")]) == 2
    assert capsys.readouterr().err == ("ncdc calibrate: camera:98: this PC has no camera of this "
                                       "number, or another program uses it\n")


@pytest.mark.parametrize("mode", ["bilinear", "mosaic"])
def test_a_camera_is_corrected_into_a_film(camera, mode, tmp_path, monkeypatch, capsys):
    av = pytest.importorskip("av")
    monkeypatch.chdir(tmp_path)
    lens = barrel_descriptor((96, 64), (96, 64), strength=.4, interpolation=GRADIENT)
    lens.save("net.toml")
    capture = camera(noise(5), interrupted=True)
    assert main(["correct", "net.toml", "camera:0", "-o", "out.mp4", "--film", mode, "--json",
                 "report.json"]) == 0
    assert capture.released and json.loads((tmp_path / "report.json").read_text())["pictures"] == 5
    with av.open("out.mp4") as film:
        pictures = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
        assert film.streams.video[0].average_rate == 25
    assert len(pictures) == 5
    remapped = cv2.remap(noise(5)[3][:, :, ::-1], *remap_tables(lens), cv2.INTER_LINEAR)
    inside = cv2.erode(lens.valid.mask(96).astype(np.uint8), np.ones((9, 9))) > 0
    # A few grey levels are the film's code, and what the mosaic loses.
    assert np.abs(pictures[3].astype(float) - remapped)[inside].mean() < 8


def test_some_frames_of_a_camera(camera, tmp_path, monkeypatch, capsys):
    pytest.importorskip("av")
    monkeypatch.chdir(tmp_path)
    barrel_descriptor((96, 64), (96, 64)).save("net.toml")
    camera(noise(9))
    assert main(["correct", "net.toml", "camera:0", "-o", "out.mp4", "--frames", "4"]) == 0
    assert "4 pictures" in capsys.readouterr().out
    for arguments, message in [
            (["-o", "out.png"], "out.png is none: films are written as one of .mp4"),
            (["-o", "out.mp4", "--frames", "0"], "--frames is 0, 1 is the limit"),
            (["-o", "out.mp4", "--tone", "sRGB"], "--tone need --film mosaic")]:
        camera(noise(1))
        assert main(["correct", "net.toml", "camera:0", *arguments]) == 2
        assert message in capsys.readouterr().err
    camera(noise(1, (48, 40)))
    assert main(["correct", "net.toml", "camera:0", "-o", "out.mp4"]) == 2
    assert "camera:0 has 48x40 pixels, the descriptor is for 96x64" in capsys.readouterr().err


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """A film in which a chessboard is held in three poses."""
    pytest.importorskip("av")
    path = tmp_path_factory.mktemp("live") / "clip.mp4"
    write_film(path, POSES)
    return path


@pytest.mark.longer
def test_a_film(film, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["calibrate", "--live", str(film), "--target", "chessboard:9x6", "-o", "p.json",
                 "--states", "states.jsonl", "--json", "report.json"]) == 0
    states = [json.loads(line) for line in (tmp_path / "states.jsonl").read_text().splitlines()]
    assert [one["seen"] for one in states].count("taken") == len(POSES) == states[-1]["pictures"]
    seconds = np.diff([one["seconds"] for one in states])
    assert (seconds > .13).all() and seconds.max() < .2
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["covered"] == states[-1]["covered"] < .9 and not states[-1]["done"]
    assert any("the calibration is not complete: its 3 pictures" in text
               for text in report["warnings"])
    points = TargetPoints.load("p.json")
    assert [photo.name for photo in points.photos] == ["01.png", "02.png", "03.png"]
    assert read_image("p.photos/01.png").shape == (360, 480, 3)
    assert "wanted next" in capsys.readouterr().err
    # The folder is not written into again; its pictures give the same points, without difference.
    assert main(["calibrate", "--live", str(film), "-o", "p.json"]) == 2
    assert "p.photos holds the pictures of an earlier run" in capsys.readouterr().err
    assert main(["calibrate", "p.photos", "-o", "again.json", "--previous", "p.json", "--target",
                 "chessboard:9x6", "--json", "again.report.json"]) == 0
    difference = json.loads((tmp_path / "again.report.json").read_text())["difference_px"]
    assert difference["max"] < 1e-3


@pytest.mark.longer
def test_a_camera_that_is_unplugged(camera, tmp_path, monkeypatch, capsys):
    """Its picture is calibrated all the same."""
    monkeypatch.chdir(tmp_path)
    picture = Hand().photo(POSES[0]).image[:, :, ::-1]
    camera([picture] * 60, paced=True)
    assert main(["calibrate", "--live", "camera:0", "--target", "chessboard:9x6"]) == 0
    out, err = capsys.readouterr()
    assert "54 points (chessboard, 9 columns x 6 rows) in 1 of 1 photos" in out
    assert "camera:0 sends no frame any more" in err and "not complete: its 1 picture covers" in err


def test_a_camera_without_a_target(camera, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    camera([np.full((64, 96, 3), 120, np.uint8)] * 40, interrupted=True)
    assert main(["calibrate", "--live", "camera:0", "--states", "-"]) == 2
    out, err = capsys.readouterr()
    assert json.loads(out.splitlines()[0])["seen"] == "nothing"
    assert "no target is seen" in err and "no picture was taken" in err
    assert not (tmp_path / "points.json").exists() and not (tmp_path / "points.photos").exists()


@pytest.mark.parametrize("arguments,message", [
    ([], "no photo is given: files, a folder, or --live camera:0 are needed"),
    (["a.png", "--live", "camera:0"], "--live camera:0 takes its own pictures, a.png is one more"),
    (["--live", "camera:0", "--bits", "12"], "--bits says how files are read, --live camera:0"),
    (["--live", "camera:0", "--pictures", "0"], "--pictures is 0, the limits are 1 and 40"),
    (["--live", "photo.png"], "photo.png is no running source: camera:0, a film"),
    (["--live", "missing.mp4"], "cannot read missing.mp4: No such file or directory"),
    (["--live", "ftp://here"], "'ftp://here' is no URL of a device"),
    (["--live", "camera:0", "--previous", "none.toml"], "cannot read none.toml"),
    (["--live", "camera:0", "--target", "board"], "target is 'board', one of dots"),
    (["--live", "camera:0", "--states", "-", "--json", "-"], "standard output holds one of them")])
def test_bad_options(camera, arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    camera(noise(1))
    assert main(["calibrate", *arguments]) == 2
    assert message in capsys.readouterr().err and not any(tmp_path.iterdir())


