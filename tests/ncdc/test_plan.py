"""The planner: what it chooses, what it rejects, and the traffic that it reports."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc.planned_timing import planned_timing
from ncdc_hdl.corrector import Corrector
from ncdc_model.planner.lookups import lookups
from ncdc_model.planner.plan import Fixed, plan
from ncdc_model.planner.scaled import scaled
from ncdc_model.planner.tags import Misses, accesses
from ncdc_model.planner.traffic import distinct_bytes, live_tiles, worst_span
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from windows import random_windows, walking_windows


@pytest.fixture(scope="module")
def barrel():
    return barrel_descriptor((320, 240), (320, 240), hidden_neurons=4, strength=.5)


@pytest.fixture(scope="module")
def waiting():
    """Nodes so close that four pixels per clock wait for them."""
    return replace(barrel_descriptor((160, 120), (160, 120), hidden_neurons=4), nodes=8)


@pytest.fixture(scope="module")
def upright(barrel):
    """A map whose rows run along the columns of the raw frame, and hardly elsewhere."""
    quarter = np.array([[0, 1], [-1, 0]])
    return replace(barrel, hidden_weights=barrel.hidden_weights @ quarter)


def test_distinct_bytes_are_those_of_a_set():
    windows = random_windows(5, (40, 30), reach=56)
    touched = {(x + i, y + j) for x, y in zip(windows.x0[windows.used], windows.y0[windows.used])
               for i in range(3) for j in range(3)}

    class Sizes:
        distorted = 60, 58
    assert distinct_bytes(windows, Sizes) == len(touched) > 1000


def test_live_tiles_are_those_between_first_and_last_use():
    boxes = lookups(walking_windows(5, (40, 30)))
    uses = {}
    for i in np.flatnonzero(boxes.used).tolist():
        for x in (boxes.x0[i], boxes.x1[i]):
            for y in (boxes.y0[i], boxes.y1[i]):
                uses.setdefault((x >> 4, y >> 2), []).append(i)
    most = max(sum(of[0] <= i <= of[-1] for of in uses.values()) for i in range(len(boxes)))
    assert live_tiles(accesses(boxes)) == most > 20


def test_the_worst_span_may_begin_anywhere():
    lookup = np.array([0, 1, 5, 6, 7, 8, 20])
    missed = Misses(lookup, *(np.zeros_like(lookup),) * 3)
    assert worst_span(missed, 30, 64, span=4) == 4 * 64 / 4
    assert worst_span(missed, 2, 64, span=4) == 2 * 64 / 2


def made(descriptor, memory="ddr3", *, fixed=(None, None, None), rate=None, **choices):
    """The plan for a hardware of ``choices``."""
    hardware = Hardware(**choices)
    return plan(descriptor, hardware, memory,
                lambda chosen: Corrector(descriptor, chosen).timing,
                fixed=Fixed(*fixed), rate=rate)


def test_a_stream_is_planned_in_raster_order(barrel):
    planned = made(barrel, output="stream", data_width=128)
    assert planned.hardware.strip == 0
    assert planned.amplification <= 1.02
    assert planned.clocks_per_pixel <= 1.02
    assert planned.worst >= planned.report()["bytes_read_per_pixel"]


def test_memory_takes_the_smaller_cache_of_strips(barrel):
    planned = made(barrel, data_width=128)
    assert planned.hardware.cache.bytes == 8192
    assert planned.amplification <= 1.15


def test_a_larger_cache_must_gain_something(barrel):
    """Where the memory is too slow for the pixels written alone, the smallest cache will do."""
    planned = made(barrel, "sdram")
    assert planned.clocks_per_pixel > 1.02
    assert planned.hardware.cache.bytes == 8192


def test_a_turned_picture_takes_another_split(barrel, upright):
    assert made(barrel, output="stream").hardware.split >= 4
    assert made(upright, output="stream").hardware.split <= 1


def test_fixed_choices_stay(barrel):
    hardware = made(barrel, fixed=(2048, 1, 64)).hardware
    assert (hardware.cache.bytes, hardware.split, hardware.strip) == (2048, 1, 64)


def test_a_rate_takes_a_larger_cache(barrel):
    """What a small cache does not reach, a larger one is chosen for, or it is rejected."""
    small = made(barrel, "fixed:40:2", output="stream", fixed=(1024, None, None))
    assert small.clocks_per_pixel > 1.5
    rate = 1.2 * small.frames_per_second
    assert made(barrel, "fixed:40:2", output="stream", rate=rate).frames_per_second >= rate
    with pytest.raises(InputError, match="frames per second are predicted for a cache of 1024 "
                                         "bytes in raster scan on fixed:40:2 at 100 MHz, "):
        made(barrel, "fixed:40:2", output="stream", fixed=(1024, None, None), rate=rate)


@pytest.mark.parametrize("options,message", [
    (dict(rate=1e9), "1e.09 frames per second are asked for, one pixel per clock gives 1302.1"),
    (dict(rate=0), "the rate is 0 frames per second"),
    (dict(fixed=(5000, None, None)),
     "the cache's size is 5000 bytes, a power of two from 1024 to 262144"),
    (dict(fixed=(2048, 4, None)), "split is 4, the limits are 0 and 3"),
    (dict(fixed=(None, 9, None)), "split is 9, the limits are 0 and 8"),
    (dict(fixed=(None, -1, None)), "split is -1, the limits are 0 and 8"),
    (dict(output="stream", fixed=(None, None, 64)),
     "the strip width is 64, a video stream needs 0"),
    (dict(fixed=(None, None, 40)), "the strip width is 40, 0 .raster. or a multiple of 32"),
    (dict(memory="tape"), "memory is 'tape'"),
    (dict(format="Mono8"), "the format is Mono8, which needs a grey sensor"),
])
def test_what_cannot_be_is_rejected(barrel, options, message):
    with pytest.raises(InputError, match=message):
        made(barrel, **options)


def test_the_command_prints_and_reports(barrel, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    barrel.save("net.toml")
    assert main(["plan", "net.toml", "--to", "stream", "--json", "plan.json"]) == 0
    report = json.loads((tmp_path / "plan.json").read_text())
    out = capsys.readouterr().out
    size, split = report["cache_bytes"], report["cache_split"]
    assert f"cache of {size} bytes, split {split}, raster scan" in out
    assert f"{report['predicted_clocks_per_pixel']:.4f} clocks per pixel" in out
    assert report["data_width"] == 128
    assert main(["plan", "net.toml", "--min-fps", "5000"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("ncdc plan: 5000 frames per second are asked for") and error.count(
        "\n") == 1


@pytest.mark.longer
def test_pixels_that_wait_for_nodes_are_in_the_plan(waiting, tmp_path, monkeypatch, capsys):
    """23 nodes of 2 clocks for the 40 groups of a row: 46 clocks. At every 16th pixel none wait."""
    monkeypatch.chdir(tmp_path)
    waiting.save("net.toml")
    command = ["plan", "net.toml", "--to", "stream", "--pixels-per-clock", "4", "--memory",
               "ideal", "--data-width", "128"]
    assert main([*command, "--json", "plan.json"]) == 0
    out = capsys.readouterr().out
    assert ("pixels wait for nodes, 46 clocks for the 40 groups of a row; trained with --nodes 16 "
            "they would not") in out
    report = json.loads((tmp_path / "plan.json").read_text())
    clocks = report["predicted_clocks_per_pixel"] * 160 * 120
    assert 46 * 120 - 10 < clocks < 46 * 120 + 400
    rate = report["frames_per_second"]
    assert main([*command, "--min-fps", f"{.99 * rate:.1f}"]) == 0
    assert main([*command, "--min-fps", f"{1.01 * rate:.1f}"]) == 2
    assert "frames per second are predicted for a cache" in capsys.readouterr().err
    far = plan(replace(waiting, nodes=16), Hardware(data_width=128, output="stream", lanes=4),
               "ideal", lambda chosen: Corrector(replace(waiting, nodes=16), chosen).timing)
    assert far.clocks < .9 * clocks


@pytest.fixture
def net(barrel, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    barrel.save("net.toml")
    return "net.toml"


def test_the_command_plans_another_size(net, capsys):
    assert main(["plan", net, "--size", "640x480", "--to", "stream", "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["width"], report["height"], report["hardware_exists"]) == (640, 480, True)
    assert report["misses"] > 640 * 480 / 64 / 2
    # Flat, so that there are few rows to plan.
    assert main(["plan", net, "--size", "5120x16", "--to", "stream"]) == 0
    assert ("there is no hardware for 5120x16: coordinates, tags and size registers end at 4096 "
            "pixels a side") in capsys.readouterr().out


def test_another_size_has_the_timing_of_its_own_units():
    """A wider picture has longer rows, whose nodes may take a clock more: fewer tan-sigmoids."""
    hardware = Hardware(data_width=128, output="stream", lanes=4)
    trained = replace(barrel_descriptor((96, 80), (96, 80)), nodes=16)
    wide, wider = scaled(trained, (1920, 80)), scaled(trained, (4160, 80))
    assert hardware.made_for(trained).share < hardware.made_for(wide).share
    own = Corrector(wide, hardware).timing
    assert planned_timing(trained, wide, hardware) == own != Corrector(trained, hardware).timing
    assert planned_timing(trained, wider, hardware) == own      # no hardware, the same units


def test_the_command_plans_a_whole_system(net, capsys):
    system = "--memory", "sdram", "--camera-fps", "200", "--screen-fps", "60"
    assert main(["plan", net, *system, "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["system"]["frames_per_second"] == report["camera_frames_per_second"] == 200
    assert report["system"]["limited_by"] == "camera"
    assert report["system"]["memory_mb_per_second"] == 400
    rates = {row["part"]: row["mb_per_second"] for row in report["system"]["parts"]}
    assert rates == pytest.approx({
        "camera, writes": 200 * .0768, "corrector, writes": 200 * .3072,
        "corrector, reads": 200 * .0768 * report["bytes_read_per_pixel"],
        "screen, reads": 60 * .3072})
    assert report["beside_camera_clocks_per_pixel"] > report["predicted_clocks_per_pixel"]
    assert main(["plan", net, *system]) == 0
    out = capsys.readouterr().out
    assert ("whole system on sdram, which moves 400 MB/s: 200.0 frames per second, the camera is "
            "the limit") in out
    assert f"all                {sum(rates.values()):.1f}" in out


@pytest.mark.parametrize("options,message", [
    (["--size", "640"], "the size is '640', WxH is needed"),
    (["--size", "9000x40"], "the width to plan is 9000, the limits are 8 and 8192"),
    (["--size", "5120x16", "--follow"], "--size 5120x16 is given with --follow"),
    (["--screen-fps", "60"], "--screen-fps 60 is of a whole system: --sensor NAME or --camera-fps"),
    (["--network-mbps", "60"], "--network-mbps 60 is of a whole system"),
    (["--camera-fps", "60", "--sensor", "mt9p031"], "--sensor mt9p031 and --camera-fps 60 are"),
    (["--camera-fps", "0"], "the camera's rate is 0 frames per second"),
    (["--camera-fps", "9000", "--memory", "sdram"],
     "the traffic of camera is 691 MB/s, the memory sdram moves 400 MB/s at most"),
    (["--camera-fps", "9000", "--data-width", "32"],
     "the traffic of the camera is 691 MB/s, a port of 32 bits moves 400 MB/s at most"),
    (["--camera-fps", "9", "--screen-fps", "1e9", "--memory", "ideal", "--to", "memory"],
     "the traffic of the screen is 307200000 MB/s, a port of 32 bits moves 400 MB/s at most"),
    (["--camera-fps", "1e-9"], "the camera's rate is 1e-09 frames per second, with 320x240 samples "
                               "the least is 0.013"),
    (["--camera-fps", "1e306"], "the camera's rate is 1e+306 frames per second"),
    (["--camera-fps", "nan"], "the camera's rate is nan frames per second"),
    (["--camera-fps", "9", "--min-fps", "60"],
     "9.0 frames per second are predicted for the whole system, whose camera is the limit, 60 are"),
    (["--min-fps", "0"], "the rate is 0 frames per second, it must be positive"),
    (["--board", "de1-soc", "--min-fps", "nan"], "the rate is nan frames per second, it must be"),
    (["--board", "de1-soc", "--follow"], "--follow and --board de1-soc are given"),
    (["--board", "de1-soc", "--format", "BGR8"], "--format and --board de1-soc are given"),
    (["--board", "de1-soc", "--size", "640x480"], "--size 640x480 and --board de1-soc are given"),
    (["--board", "de1-soc", "--camera-fps", "9"], "--camera-fps 9 and --board de1-soc are given"),
])
def test_the_command_rejects(net, options, message, capsys):
    assert main(["plan", net, *options]) == 2
    error = capsys.readouterr().err
    assert f"ncdc plan: {message}" in error and "Traceback" not in error
