"""``ncdc train`` for a range of views: nodes that suit all of them."""

from dataclasses import replace

import pytest

from ncdc.cli import main
from ncdc_model.golden.nodes import CURVATURE_LIMIT
from ncdc_model.training import pipeline
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.view_nodes import worst_node_errors
from ncdc_model.view_range import ViewRange
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from plane_lens import seen_lens

LENS = replace(seen_lens((640, 400), 380, (318, 201)), nodes=1)


def at_nodes(nodes="auto", **intervals):
    """Distance that training chooses for a range, and what it reports."""
    views = ViewRange.of(LENS, intervals) if intervals else None
    made, report = pipeline._at_nodes(LENS, TrainingChoices(nodes=nodes, views=views))
    return made.nodes, report


def test_views_take_nearer_nodes_than_the_trained_picture():
    alone, report = at_nodes()
    assert alone == 16 and "views" not in report
    wide = {"pan": (-45.0, 45.0)}
    nodes, report = at_nodes(**wide)
    errors = {int(name): error["max"] for name, error in report["views_nodes_px"].items()}
    assert nodes == 8 and list(errors) == [8, 16, 32]
    assert errors[16] > CURVATURE_LIMIT and report["views"]["pan"] == [-45, 45]
    found = worst_node_errors(LENS, ViewRange.of(LENS, wide))
    assert errors == {one: error for one, (error, _) in found.items()}
    near, _ = at_nodes(zoom=(3.0, 3.0))
    assert near == 16


def test_the_smallest_distance_is_taken_if_none_is_good_enough():
    nodes, report = at_nodes(pan=(60.0, 60.0), zoom=(.25, .25))
    assert nodes == 8 and report["views_nodes_px"]["8"]["max"] > CURVATURE_LIMIT


def test_a_distance_that_is_given_stays():
    assert at_nodes(16, pan=(40.0, 40.0))[0] == 16
    with pytest.raises(InputError, match="evaluated at every pixel, a view needs nodes"):
        at_nodes(1, pan=(40.0, 40.0))


def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "info.yaml").write_text(
        '{"width": 160, "height": 120, "distortion_model": "plumb_bob", "D": [-0.2, 0.05, 0, 0, 0],'
        ' "K": [100.0, 0, 81.5, 0, 100.0, 58.25, 0, 0, 1]}')
    command = ["train", "info.yaml", "--neurons", "1", "--trainer", "ebp", "--epochs", "20",
               "-o", "net.toml"]
    assert main([*command, "--view-pan=-10:10", "--view-zoom", "1:2"]) == 0
    shown = capsys.readouterr().out
    descriptor = Descriptor.load("net.toml")
    assert descriptor.errors["views"]["pan"] == [-10, 10]
    worst = descriptor.errors["views_nodes_px"][str(descriptor.nodes)]["max"]
    assert f"add at most {worst:.5f} px in the views tried, at pan" in shown
    for options, message in (
            (("--view-pan", "5:2"), "pan is 5 to 2, the first number must be the smaller one"),
            (("--view-pan", "5", "--nodes", "1"), "a view needs nodes")):
        assert main([*command, *options]) == 2
        said = capsys.readouterr().err
        assert message in said and "training" not in said
