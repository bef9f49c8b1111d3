"""``ncdc correct`` and ``simulate`` with a file of views, and what a file must not hold."""

import cv2
import numpy as np
import pytest

from ncdc.cli import main, simulated_views
from ncdc_model.golden.corrector import correct
from ncdc_model.images import write_image
from ncdc_spec.view_list import placed
from ncdc_spec.view_matrix import Angles, PlaneCamera
from plane_lens import SIZE, seen_lens

FILE = """
width = 64
height = 48
[[view]]
width = 64
height = 40
[[view]]
column = 44
row = 2
width = 16
height = 12
pan = -10
zoom = 2.5
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a lens, a raw frame and a file of views, as the present one."""
    monkeypatch.chdir(tmp_path)
    seen_lens().save("net.toml")
    write_image("raw.png", np.random.default_rng(1).integers(0, 256, SIZE[::-1], np.uint8))
    (tmp_path / "views.toml").write_text(FILE)
    return tmp_path


def views():
    camera = PlaneCamera.of(seen_lens())
    return [camera.looking(Angles(), (64, 40)), camera.looking(Angles(pan=-10, zoom=2.5), (16, 12))]


def test_correct_writes_one_picture(folder):
    assert main(["correct", "net.toml", "raw.png", "-o", "out.png", "--view-list",
                 "views.toml"]) == 0
    raw = cv2.imread("raw.png", cv2.IMREAD_GRAYSCALE)
    expected = np.zeros((48, 64, 3), np.uint8)
    expected[:40], expected[2:14, 44:60] = (correct(seen_lens(), raw, view=view).picture
                                            for view in views())
    assert (cv2.imread("out.png")[..., ::-1] == expected).all()


def test_simulate_has_hardware_for_the_views(folder, monkeypatch):
    class Simulated(Exception):
        pass

    def simulated(descriptor, raw, hardware, entries, size, **options):
        raise Simulated(hardware.view, hardware.views, entries, size)
    monkeypatch.setattr(simulated_views, "simulate_view_list", simulated)
    for more, count in (((), 2), (("--view", "--views", "5"), 5)):
        with pytest.raises(Simulated) as error:
            main(["simulate", "net.toml", "raw.png", "-o", "out.png", "--view-list", "views.toml",
                  "--cache-bytes", "1024", "--cache-split", "1", "--strip", "0", *more])
        assert error.value.args == (True, count, placed(views(), [(0, 0), (44, 2)], (64, 48)),
                                    (64, 48))


@pytest.mark.parametrize("change,message", [
    (("width = 64\nheight = 48", "width = 64"), "lacks the value 'height'"),
    (("row = 2", "line = 2"), "view 1: it has the value line, column, row, width"),
    (("row = 2", "row = 40"), "view 1 has 16x12 pixels from column 44, row 40 on, the picture has "
                              "64x48"),
    (("row = 2", "row = 2.5"), "row is 2.5, an integer of 0 to"),
    (("width = 16\n", ""), "views.toml: view 1 lacks the value 'width'"),
    (("height = 12", "height = 7"), "view 1: height is 7, an integer of 8 to 4096 is needed"),
    (("zoom = 2.5", "zoom = 9"), "zoom is 9, the limits are 0.25 and 8"),
    (("zoom = 2.5", "zoom = true"), "zoom is True, a number is needed"),
    (("zoom = 2.5", "zoom = \"2\""), "zoom is '2', a number is needed"),
    (("width = 64", "size = 1\nwidth = 64"),
     "it has the value size, width, height, view are known"),
    (("[[view]]", "[view]"), "is no list of views"),
    (("", "[["), "is no list of views")])
def test_files_that_are_rejected(folder, capsys, change, message):
    (folder / "views.toml").write_text(FILE.replace(*change, 1))
    assert main(["correct", "net.toml", "raw.png", "-o", "out.png", "--view-list",
                 "views.toml"]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1 and not (folder / "out.png").exists()


@pytest.mark.parametrize("command,options,message", [
    ("correct", ("--pan", "3"), "--pan is given with --view-list"),
    ("correct", ("--tone", "sRGB"), "--tone is given with --view-list"),
    ("correct", ("raw.png",), "it takes one picture"),
    ("correct", ("--gyro", "gyro.csv"), "--gyro is given with --view-list"),
    ("correct", ("--json", "views.toml"), "views.toml would replace the input views.toml"),
    ("simulate", ("--gyro", "gyro.csv"), "--gyro is given with --view-list"),
    ("simulate", ("--readout-ms", "4"), "--readout-ms is given with --view-list"),
    ("simulate", ("--field", "full"), "--field is given with --view-list"),
    ("simulate", ("--follow",), "--follow is given with --view-list"),
    ("simulate", ("--views", "9", "--view"), "the number of views is 9, the limits are 2 and 8")])
def test_options_that_do_not_go_with_it(folder, capsys, command, options, message):
    assert main([command, "net.toml", "raw.png", *options, "-o", "out.png", "--view-list",
                 "views.toml"]) == 2
    assert message in capsys.readouterr().err and not (folder / "out.png").exists()


def test_eight_views_at_most(folder, capsys):
    one = "[[view]]\nwidth = 8\nheight = 8\n"
    (folder / "views.toml").write_text("width = 64\nheight = 48\n" + 9 * one)
    assert main(["correct", "net.toml", "raw.png", "-o", "out.png", "--view-list",
                 "views.toml"]) == 2
    assert "1 to 8 tables [[view]] are needed" in capsys.readouterr().err
