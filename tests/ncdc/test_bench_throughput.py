"""The bench of whole frames: its lenses, its rows, its goals."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_bench.sources import source_digest, source_files
from ncdc_bench.throughput import command, cross, lenses
from ncdc_bench.throughput.command import table
from ncdc_bench.throughput.lenses import Lens
from ncdc_bench.throughput.measure import ALL, DEFAULT, QUICK, Run, goal_rows, measure, table_four
from ncdc_bench.throughput.plots import plot_throughput
from ncdc_model.planner.plan import best_split
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware

ROW = {"fetch": "cache", "memory": "ddr3", "scan": "raster", "width": 1920, "height": 1080,
       "lens": 120, "rotation": 0, "interpolation": "fast", "output": "stream",
       "data_width": 128, "cache_bytes": 32768, "cache_split": 6, "strip": 0,
       "pixels_per_clock": 1, "clocks_per_pixel": 1.001, "predicted_clocks_per_pixel": 1.0,
       "bytes_read_per_pixel": .97, "amplification": 1.01, "misses": 7, "misses_expected": 7,
       "frames_per_second": 48.0, "pixels_compared": 10, "pixels_different": 0}


def test_a_turn_by_90_degrees_makes_the_picture_upright():
    plain, turned = Lens(120, (64, 48)), Lens(120, (64, 48), 90)
    assert turned.corrected == (48, 64)
    u, v = np.meshgrid(np.arange(48.0), np.arange(64.0))
    x, y = turned.back_map(u, v)
    # Column u, row v of the turned picture shows what the plain one shows there.
    a, b = plain.back_map(63 - v, u)
    np.testing.assert_allclose([x, y], [a, b], atol=1e-9)


def test_the_corrected_rows_of_a_straight_lens_stay_rows():
    """At a small view the lens is nearly a pinhole: no turn, hardly any slope."""
    lens = Lens(20, (64, 48))
    _, y = lens.back_map(np.array([8.0, 56.0]), np.array([24.0, 24.0]))
    assert abs(y[1] - y[0]) < 2
    _, y = Lens(20, (64, 48), 45).back_map(np.array([16.0, 48.0]), np.array([24.0, 24.0]))
    assert abs(y[1] - y[0]) > 16


def test_goals_count_the_worst_row():
    good = goal_rows([ROW])
    assert [name for name, _, _, holds in good if holds is False] == []
    assert sum(holds is True for _, _, _, holds in good) >= 5
    bad = goal_rows([ROW, ROW | {"clocks_per_pixel": 1.03, "pixels_different": 2, "misses": 9}])
    missed = {name: value for name, value, _, holds in bad if holds is False}
    assert missed["wrong pixels"] == 2
    assert missed["misses that the planner did not count"] == 2
    assert missed["clocks predicted, off by a factor of at most"] == pytest.approx(1.03)
    assert missed["clocks per pixel, 1920x1080, lens 120, ddr3, raster to a stream"] == 1.03


class _Anything:
    """What the planner will choose."""

    def __eq__(self, other):
        return True


@pytest.mark.parametrize("runs", [DEFAULT, ALL], ids=["default", "all"])
def test_each_goal_has_a_row_among_the_runs(runs):
    rows = [ROW | run.settings | {"scan": _Anything(), "cache_bytes": run.cache_bytes
                                  or _Anything()} for run in runs]
    assert [name for name, _, _, holds in goal_rows(rows) if holds is None] == []
    wide = [row for row in rows if row["pixels_per_clock"] == 1]
    assert [name for name, _, _, holds in goal_rows(wide) if holds is None] == [
        "clocks per pixel, two pixels per clock (at least 1.9 pixels per clock)",
        "clocks per pixel, directional, four pixels per clock (at least 3.9 pixels per clock)"]


@pytest.mark.parametrize("list_of_runs,status", [("--quick", 0), ("--all", 1)])
def test_a_goal_without_a_row_is_reported_and_is_missed_by_the_long_lists(
        monkeypatch, capsys, list_of_runs, status):
    monkeypatch.setattr(command, "measure", lambda runs, progress: [ROW])
    assert main(["bench", "throughput", list_of_runs]) == status
    out, err = capsys.readouterr()
    name = "clocks per pixel, 1280x1024, sdram, to a stream"
    assert f"{name}: not measured, at most 1.05 is asked for" in out
    assert (f"no row measures: {name}" in err) == bool(status)


def test_no_run_twice_and_every_turn_of_both_lenses():
    for runs in (QUICK, DEFAULT, ALL):
        assert len(set(runs)) == len(runs)
    turns = {(run.lens.degrees, run.lens.rotation) for run in ALL if run.fetch == "cache"}
    assert turns >= {(degrees, turn) for degrees in (105, 120) for turn in (0, 2, 5, 45, 90)}
    assert {run.fetch for run in DEFAULT} == {"cache", "multiport"}


def test_table_four_begins_with_the_paper():
    rows = table_four([ROW, ROW | {"memory": "fixed:100:4"}, ROW | {"rotation": 45}])
    assert [row[-1] for row in rows] == [0.47, 8.21, 48.0]
    assert len(table_four([ROW | {"interpolation": "directional"}])) == 2


def test_rows_are_printed_and_plotted(tmp_path):
    rows = [ROW, ROW | {"fetch": "multiport", "predicted_clocks_per_pixel": None, "strip": 64}]
    text = table(rows)
    assert "1.0010" in text and text.splitlines()[2].split()[0] == "multiport"
    plot_throughput(tmp_path, rows)
    assert (tmp_path / "throughput.png").stat().st_size > 5000


@pytest.mark.many_clocks
@pytest.mark.regress
def test_a_frame_is_measured():
    runs = [Run("cache", Lens(105, (96, 72))), Run("cache", Lens(105, (96, 72), 90)),
            Run("cache", Lens(105, (96, 72), interpolation="directional"))]
    rows = list(measure(runs))
    assert set(rows[0]) == set(ROW)
    for row, size in zip(rows, ((96, 72), (72, 96), (96, 72))):
        assert (row["width"], row["height"]) == size
        assert (row["pixels_compared"], row["pixels_different"]) == (96 * 72, 0)
        assert row["misses"] == row["misses_expected"] > 0
        assert row["clocks_per_pixel"] == pytest.approx(row["predicted_clocks_per_pixel"], rel=.01)
    assert rows[0]["cache_split"] > rows[1]["cache_split"]


@pytest.mark.many_clocks
@pytest.mark.regress
def test_the_quick_bench_keeps_its_goals(tmp_path):
    assert main(["bench", "throughput", "--quick", "--json", str(tmp_path / "rows.json")]) == 0
    report = json.loads((tmp_path / "rows.json").read_text())
    assert len(report["rows"]) == len(QUICK)
    assert all(goal["holds"] is not False for goal in report["goals"])


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package whose module ``train`` needs ``fit`` and, within a function, ``numbers``."""
    monkeypatch.syspath_prepend(tmp_path)
    name = f"trainer_{tmp_path.name}".replace("-", "_")
    folder = tmp_path / name
    folder.mkdir()
    for module, text in {"__init__": "", "train": f"import math\nfrom {name} import fit\n",
                         "fit": f"def f():\n    from {name}.numbers import two\n",
                         "numbers": "two = 2\n", "plots": "three = 3\n"}.items():
        (folder / f"{module}.py").write_text(text)
    return folder


@pytest.mark.parametrize("file,changes", [
    ("train", True), ("fit", True), ("numbers", True), ("__init__", True), ("plots", False)])
def test_a_digest_changes_with_every_file_that_is_imported_and_no_other(package, file, changes):
    def digest():
        return source_digest([f"{package.name}.train"], [package.name], ["numpy"])
    before = digest()
    assert digest() == before
    with open(package / f"{file}.py", "a") as text:
        text.write("# changed\n")
    assert (digest() != before) == changes


def test_a_digest_changes_with_the_version_of_a_library(package, monkeypatch):
    before = source_digest([f"{package.name}.train"], [package.name], ["numpy"])
    monkeypatch.setattr("ncdc_bench.sources.version", lambda name: "0")
    assert source_digest([f"{package.name}.train"], [package.name], ["numpy"]) != before


def test_lenses_are_trained_anew_when_the_trainer_changes(tmp_path, monkeypatch):
    monkeypatch.setenv("NCDC_CACHE", str(tmp_path))
    digest, names = ["before"], []

    class Trained:
        def __init__(self, source, neurons, choices):
            self.descriptor = self

        def save(self, path):
            path.write_text(digest[0])
    monkeypatch.setattr(lenses, "train_camera", Trained)
    monkeypatch.setattr(lenses, "_trainer", lambda: digest[0])
    monkeypatch.setattr(lenses.Descriptor, "load", lambda path: path.read_text())
    for digest[0] in ("before", "before", "after"):
        names.append(lenses.trained(Lens(20, (64, 48))))
    assert names == ["before", "before", "after"] and len(list(tmp_path.glob("lens-*.lock"))) == 2


def test_what_lenses_depend_on():
    files = source_files([lenses.__name__, "ncdc_model.training.pipeline"],
                         ["ncdc_model", "ncdc_spec"])
    assert {"ncdc_bench.throughput.lenses", "ncdc_spec.descriptor", "ncdc_spec.formats",
            "ncdc_model.calibration.camera_file", "ncdc_model.training.levenberg",
            "ncdc_model.training.varpro", "ncdc_model.lens.camera"} <= set(files)
    assert not {"ncdc_model.planner.plan", "ncdc_model.register_map"} & set(files)


@pytest.mark.parametrize("change,holds", [
    ({}, True), ({"clocks": 1011}, False), ({"clocks": 989}, False), ({"clocks": 1009}, True),
    ({"windows_fetched": 8}, False), ({"pixels_different": 1}, False)])
def test_the_planner_is_compared_for_each_choice(monkeypatch, capsys, change, holds):
    """A row for the planned and one for the worst split; a choice that is rejected holds."""
    hardware = Hardware(cache=CacheOptions(64), split=1)
    asked = []

    def planned(descriptor, hardware_, memory, timing, *, fixed):
        asked.append(fixed.split)
        if hardware_.lanes == 2:
            raise InputError("two are too few")
        return SimpleNamespace(hardware=hardware, clocks=1000, clocks_per_pixel=1.0)

    report = {"clocks": 1000, "clocks_per_pixel": 1.0, "pixels_different": 0,
              "windows_fetched": 7, "windows_fetched_expected": 7} | change
    monkeypatch.setattr(cross, "trained", lambda lens: barrel_descriptor((64, 48), (64, 48)))
    monkeypatch.setattr(cross, "plan", planned)
    monkeypatch.setattr(cross, "Corrector", lambda *args: None)
    monkeypatch.setattr(cross, "verilog_of", lambda corrector: "")
    monkeypatch.setattr(cross, "worst_split", lambda descriptor, hardware: 0)
    monkeypatch.setattr(cross, "simulate_correction", lambda *args, **options: SimpleNamespace(
        report=lambda: report))
    monkeypatch.setattr(command, "CROSS", [cross.Combination(1, 1, "fast", 32),
                                           cross.Combination(2, 1, "fast", 32)])
    assert main(["bench", "throughput", "--cross"]) == (0 if holds else 1)
    out, err = capsys.readouterr()
    assert asked == [None, 0, None]
    assert len(out.splitlines()) == 3 and "rejected: two are too few" in out
    assert err.count("missed: fast") == (0 if holds else 2)


def test_the_worst_split_reads_most():
    d = barrel_descriptor((160, 120), (160, 120), hidden_neurons=4, strength=.5)
    hardware = Hardware(cache=CacheOptions(64))
    assert cross.worst_split(d, hardware) != best_split(d, hardware)


def test_each_choice_meets_each():
    assert len(set(cross.CROSS)) == 3 * 4 * 2 * 3
