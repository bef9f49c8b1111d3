"""``ncdc simulate``: the view that its options ask for."""

from pathlib import Path

import numpy as np
import pytest

from ncdc.cli import main, simulate
from ncdc_model.images import write_image
from ncdc_spec.view import View
from ncdc_spec.view_matrix import Angles, PlaneCamera
from plane_lens import SIZE, seen_lens

HEAD = "time_s,x_rad_s,y_rad_s,z_rad_s"


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """A function that runs the command with options; what it would have simulated."""
    class Simulated(Exception):
        pass

    def simulated(descriptor, raw, hardware, **options):
        raise Simulated(hardware.view, options["view"], hardware.view_rows)
    monkeypatch.setattr(simulate, "simulate_correction", simulated)
    monkeypatch.chdir(tmp_path)
    seen_lens().save("net.toml")
    write_image("raw.png", np.zeros(SIZE[::-1], np.uint8))
    command = ["simulate", "net.toml", "raw.png", "-o"]

    def run(*options):
        with pytest.raises(Simulated) as error:
            main([*command, "out.png", *options])
        view, shown, run.matrices = error.value.args
        return view, shown
    run.rejected = lambda *options: main([*command, *options])
    return run


def test_the_view_of_the_options(asked):
    assert asked() == (False, None)
    assert asked("--view") == (True, None)
    matrix = "1 .1 2 -.1 1 3 0 .001 1"
    assert asked("--matrix", *matrix.split()) == (
        True, View.of(np.reshape(list(map(float, matrix.split())), (3, 3)), SIZE))
    # A negative number with an exponent is no option.
    assert asked("--matrix", *"1 0 0 -1e-1 1 0 0 0 1".split()) == (
        True, View.of([[1, 0, 0], [-.1, 1, 0], [0, 0, 1]], SIZE))
    wanted = PlaneCamera.of(seen_lens()).looking(Angles(pan=-10, zoom=2), (64, 48))
    assert asked("--pan", "-10", "--zoom", "2", "--view-size", "64x48") == (True, wanted)


def test_the_table_of_a_camera_that_turns(asked):
    """It has as many matrices as the hardware has space for, or none if no row is later."""
    Path("gyro.csv").write_text("\n".join([HEAD, *(f"{k / 100},1,.5,-.2" for k in range(9))]))
    assert asked("--view-rows", "5") == (True, None) and asked.matrices == 5
    assert asked("--gyro", "gyro.csv")[1].rows is None and asked.matrices == 0
    for options, matrices, step, used in (((), 64, 8, 9), (("--view-rows", "5"), 5, 16, 5)):
        view, shown = asked("--gyro", "gyro.csv", "--readout-ms", "20", *options)
        assert view and asked.matrices == matrices
        assert (shown.rows.step, len(shown.rows.matrices)) == (step, used)


@pytest.mark.parametrize("options,words", [
    (("out.png", "--view", "--view-rows", "65"), "has 65 matrices, the limits are 2 and 64"),
    (("out.gif", "--gyro", "a.csv", "--sensor", "mt9p031"), "--gyro is given with --camera"),
    (("out.png", "--pan", "9", "--matrix", *"100010001"), "--matrix is given together with angles"),
    (("out.png", "--matrix", *"10001000", "nan"), "nine finite numbers are needed"),
    (("out.gif", "--pan", "9", "--sensor", "mt9p031"), "--pan is given with --camera mt9p031")])
def test_options_that_are_rejected(asked, capsys, options, words):
    assert asked.rejected(*options) == 2
    assert words in capsys.readouterr().err
