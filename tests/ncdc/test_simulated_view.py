"""``ncdc simulate``: the view that its options ask for."""

import numpy as np
import pytest

from ncdc.cli import main, simulate
from ncdc_model.images import write_image
from ncdc_spec.view import View
from ncdc_spec.view_matrix import Angles, PlaneCamera
from plane_lens import SIZE, seen_lens


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """A function that runs the command with options; what it would have simulated."""
    class Simulated(Exception):
        pass

    def simulated(descriptor, raw, hardware, **options):
        raise Simulated(hardware.view, options["view"])
    monkeypatch.setattr(simulate, "simulate_correction", simulated)
    monkeypatch.chdir(tmp_path)
    seen_lens().save("net.toml")
    write_image("raw.png", np.zeros(SIZE[::-1], np.uint8))
    command = ["simulate", "net.toml", "raw.png", "-o"]

    def run(*options):
        with pytest.raises(Simulated) as error:
            main([*command, "out.png", *options])
        return error.value.args
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


@pytest.mark.parametrize("options,words", [
    (("out.png", "--pan", "9", "--matrix", *"100010001"), "--matrix is given together with angles"),
    (("out.png", "--pan", "9", "--follow"), "--follow is given with a view"),
    (("out.png", "--matrix", *"10001000", "nan"), "nine finite numbers are needed"),
    (("out.gif", "--pan", "9", "--sensor", "mt9p031"), "--pan is given with --camera mt9p031")])
def test_options_that_are_rejected(asked, capsys, options, words):
    assert asked.rejected(*options) == 2
    assert words in capsys.readouterr().err
