"""``ncdc plan`` of a range of views: the bound and the worst views, what is rejected."""

import json
from dataclasses import replace

import pytest

from ncdc.cli import main
from ncdc_hdl.corrector import Corrector
from ncdc_model.planner.plan import Fixed
from ncdc_model.planner.views import ViewPlanner
from ncdc_model.view_range import ViewRange
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from plane_lens import seen_lens

RANGE = {"roll": (-10.0, 10.0), "zoom": (.8, 3.0)}


@pytest.fixture(scope="module")
def lens():
    return replace(seen_lens((96, 72), 60, (46, 37)), nodes=16)


def planner(lens, memory, views):
    return ViewPlanner(lens, memory, lambda hardware: Corrector(lens, hardware).timing, views)


@pytest.mark.parametrize("memory,options", [
    ("sdram", {"output": "stream"}),
    pytest.param("ddr3", {"data_width": 128, "lanes": 2}, marks=pytest.mark.longer)])
def test_no_view_of_the_range_is_slower_than_the_bound(lens, memory, options):
    views = ViewRange.of(lens, RANGE)
    one = planner(lens, memory, views)
    planned = one.plan(Hardware(view=True, **options))
    hardware = planned.hardware
    assert hardware.cached and planned.scanned > 9 + 64
    assert one.plan_of(planned.slowest_at, hardware) == planned.slowest
    assert planned.slowest.clocks < planned.clocks_bound
    most = one.plan_of(planned.bytes_at, hardware).report()["bytes_read_per_pixel"]
    assert most == planned.bytes_per_pixel
    for angles in views.random(20):
        found = one.plan_of(angles, hardware)
        assert found.clocks <= planned.clocks_bound, angles
        assert found.report()["bytes_read_per_pixel"] <= 1.05 * most


def test_fixed_choices_stay(lens):
    views = ViewRange.of(lens, {"roll": (90.0, 90.0)})
    hardware = planner(lens, "sdram", views).plan(Hardware(view=True), Fixed(2048, 1, 64)).hardware
    assert (hardware.cache.bytes, hardware.split, hardware.strip) == (2048, 1, 64)


def test_the_command(lens, tmp_path, capsys):
    path, report = tmp_path / "net.toml", tmp_path / "plan.json"
    lens.save(path)
    command = ["plan", str(path), "--memory", "sdram", "--to", "stream"]
    assert main([*command, "--pan", "-10:10", "--zoom", "2", "--json", str(report)]) == 0
    shown, found = capsys.readouterr().out, json.loads(report.read_text())
    assert found["views"] == {"pan": [-10, 10], "tilt": [0, 0], "roll": [0, 0], "zoom": [2, 2],
                              "width": 96, "height": 72}
    assert -10 <= found["slowest_view"]["pan"] <= 10 and found["slowest_view"]["zoom"] == 2
    assert found["predicted_clocks_per_pixel"] < found["bound_clocks_per_pixel"]
    assert set(found["views_nodes_px"]) == {"8", "16"}
    worst = found["views_nodes_px"]["16"]
    assert f"nodes 16 pixels apart add at most {worst['max']:.5f} px in the views tried" in shown
    assert main([*command, "--pan", "1", "--view-size", "64x48", "--sensor", "mt9p031", "--json",
                 str(report)]) == 0
    found = json.loads(report.read_text())
    assert (found["views"]["width"], found["views"]["height"]) == (64, 48)
    assert found["beside_camera_clocks_per_pixel"] >= found["predicted_clocks_per_pixel"]


@pytest.mark.parametrize("options,message", [
    (["--pan", "10:-10"], "pan is 10 to -10, the first number must be the smaller one"),
    (["--tilt", "a:b"], "tilt is 'a:b', LOW:HIGH or one number is needed, as in -30:30"),
    (["--zoom", "0.1:2"], "zoom is 0.1, the limits are 0.25 and 8"),
    (["--roll", "5", "--follow"], "--follow is given with a range of views"),
    (["--roll", "5", "--board", "de1-soc"], "boards have no view"),
    (["--view-size", "5x5"], "the view's size is '5x5'"),
    (["--pan", "0:5", "--min-fps", "14000"], "14000 are asked for")])
def test_what_is_rejected(lens, tmp_path, capsys, options, message):
    path = tmp_path / "net.toml"
    lens.save(path)
    command = ["plan", str(path), *([] if "--board" in options else ["--to", "stream"])]
    assert main([*command, *options]) == 2
    [error] = [line for line in capsys.readouterr().err.splitlines() if "ncdc plan" in line]
    assert message in error


def test_views_need_nodes_and_a_focal_length(lens):
    with pytest.raises(InputError, match="evaluated at every pixel, a view needs nodes"):
        planner(replace(lens, nodes=1), "sdram", ViewRange.of(lens, {}))
    with pytest.raises(InputError, match="does not state the focal length"):
        ViewRange.of(replace(lens, provenance={}), {})
