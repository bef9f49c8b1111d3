"""``--neurons auto``: the fewest hidden neurons that meet a maximum error."""

from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import pytest

from commands import call
from lenses import lens
from ncdc.cli import train as command
from ncdc_model.evaluate import evaluate_frame, evaluate_points
from ncdc_model.plots import plot_neurons
from ncdc_model.training import choose
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.levenberg import train_levenberg
from ncdc_model.training.problem import split
from ncdc_model.training.source import load_source
from ncdc_model.training.train import TRAINERS
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError


@pytest.fixture(autouse=True)
def few_starts(monkeypatch):
    monkeypatch.setitem(TRAINERS, "lm", partial(train_levenberg, starts=4, rounds=0))


@pytest.fixture
def camera_file(tmp_path):
    lens().save(tmp_path / "camera.toml")
    return tmp_path / "camera.toml"


@pytest.mark.longer
def test_camera_file_takes_the_first_that_meets_the_error_on_the_whole_frame(camera_file):
    source, seen = load_source(camera_file), []
    trained = choose.choose_camera(source, 3.0, tried=lambda n, worst: seen.append((n, worst)))
    rows = [(row["hidden_neurons"], row["max"]) for row in trained.report["tried"]]
    assert rows == seen and [n for n, _ in rows] == list(range(1, len(rows) + 1)) and len(rows) > 2
    assert all(worst > 3 for _, worst in rows[:-1]) and rows[-1][1] <= 3
    assert trained.descriptor.hidden_neurons == rows[-1][0]
    measured = evaluate_frame(trained.descriptor, lens().back_map)
    assert rows[-1][1] == pytest.approx(max(measured[f"map_error_{kind}_px"]["max"]
                                            for kind in ("float", "fixed")), abs=1e-6)


@pytest.mark.longer
def test_points_are_judged_by_those_held_out_inside_the_frame(camera_file):
    source = replace(load_source(camera_file), back_map=None)
    trained = choose.choose_camera(source, 4.0)
    held_out = split(len(source.pairs[0]), 7)
    errors = evaluate_points(trained.descriptor, *(part[held_out] for part in source.pairs))
    assert trained.report["tried"][-1]["max"] == pytest.approx(
        max(errors[f"map_error_{kind}_px"]["max"] for kind in ("float", "fixed")))
    with pytest.raises(InputError, match="no point is held out, by which the number of hidden"):
        choose.choose_camera(source, 4.0, TrainingChoices(held_out=0))


@pytest.mark.longer
def test_integers_that_miss_the_error_do_not_count(camera_file, monkeypatch):
    source, describe = load_source(camera_file), choose.describe

    def worse(source, training, choices):
        trained = describe(source, training, choices)
        if training.network.hidden_neurons == 3:
            trained.report["map_error_fixed_px"]["max"] = 9.0
        return trained
    monkeypatch.setattr(choose, "describe", worse)
    trained = choose.choose_camera(source, 5.0)
    assert trained.report["tried"][2]["max"] == 9 and trained.descriptor.hidden_neurons == 4


@pytest.mark.longer
def test_without_a_limit_a_tenth_of_a_pixel_is_tried_for(camera_file, monkeypatch, capsys):
    monkeypatch.setattr(choose, "MAX_TRIED", 3)
    out = camera_file.with_name("net.toml")
    call(command, camera_file, "--neurons", "auto", "-o", out)
    d, text = Descriptor.load(out), capsys.readouterr()
    rows = [row["max"] for row in d.errors["tried"]]
    assert d.errors["max_error_px"] == .1 and d.errors["max_error_met"] is False
    assert len(rows) == 3 and rows[d.hidden_neurons - 1] <= 1.1 * min(rows)
    assert all(row > 1.1 * min(rows) for row in rows[:d.hidden_neurons - 1])
    assert "no network of 1 to 3 hidden neurons has a largest error of 0.1 px" in text.err
    assert f"{d.hidden_neurons} hidden neurons are proposed, of 3 numbers tried" in text.out
    assert out.with_name("net.neurons.png").exists()


def test_a_smaller_network_is_preferred_to_one_that_is_hardly_better(camera_file, monkeypatch):
    monkeypatch.setattr(choose, "MAX_TRIED", 3)
    errors = iter([{"max": 3.0, "mean": 1}, {"max": 2.1, "mean": 1}, {"max": 2.0, "mean": 1}])
    monkeypatch.setattr(choose, "_errors", lambda back_map, pairs, region: next(errors))
    assert choose.choose_camera(load_source(camera_file)).descriptor.hidden_neurons == 2


@pytest.mark.longer
def test_points_too_few_for_many_neurons_end_the_row(camera_file):
    source, seen = load_source(camera_file), []
    few = replace(source, pairs=tuple(part[::180] for part in source.pairs))
    taught = (~split(len(few.pairs[0]), 7)).sum()
    choose.choose_camera(few, tried=lambda n, worst: seen.append(n))
    assert 3 <= taught // 3 < 8 and seen == list(range(1, taught // 3 + 1))


def test_the_error_is_drawn_over_the_neurons(tmp_path):
    tried = [{"hidden_neurons": n, "max": 10.0 / n, "mean": 1.0 / n} for n in (1, 2, 3)]
    for name, rows, chosen in (("a", tried, 3), ("b", [*tried[:2], tried[2] | {"max": 8.0}], 3),
                               ("c", tried, 2)):
        plot_neurons(tmp_path / f"{name}.png", rows, chosen, 4, "the whole frame")
    first, *others = (cv2.imread(str(tmp_path / f"{name}.png")) for name in "abc")
    assert first.shape[0] > 300
    assert all((first != other).mean() > .002 for other in others)


def test_none_that_meets_it_is_one_sentence_and_no_file(camera_file, monkeypatch, capsys):
    monkeypatch.setattr(choose, "MAX_TRIED", 2)
    out = camera_file.with_name("net.toml")
    with pytest.raises(InputError, match=r"no network of 1 to 2 hidden neurons has a maximum error "
                                         r"of 0.01 px or less; the best, of 2, has [\d.]+ px"):
        call(command, camera_file, "--neurons", "auto", "--max-error", .01, "-o", out)
    assert not out.exists() and "2 hidden neurons: at most" in capsys.readouterr().err


def test_descriptor_of_the_command_carries_what_was_tried(camera_file):
    out = camera_file.with_name("net.toml")
    call(command, camera_file, "--neurons", "auto", "--max-error", 30, "-o", out)
    d = Descriptor.load(out)
    assert d.errors["max_error_px"] == 30 and d.errors["tried"][-1]["hidden_neurons"] == \
        d.hidden_neurons
    assert np.diff([row["hidden_neurons"] for row in d.errors["tried"]]).tolist() == \
        [1] * (d.hidden_neurons - 1)


@pytest.mark.parametrize("options,message", [
    (["--neurons", 4, "--max-error", 1], "--max-error is an option of --neurons auto, 4 are asked"),
    (["--neurons", 4, "--epochs", 9], "--epochs is an option of the trainer ebp"),
    (["--neurons", 4, "--trainer", "ebp", "--epochs", 0],
     "0 epochs are asked for, the minimum is 1"),
    (["--neurons", "auto", "--max-error", -1], "the maximum error is -1 px, it must be positive"),
])
def test_bad_requests_are_named(camera_file, options, message):
    with pytest.raises(InputError, match=message):
        call(command, camera_file, *options)
