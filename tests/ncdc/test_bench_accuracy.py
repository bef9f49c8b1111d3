"""``ncdc bench accuracy``: rows, figures, plots, bad requests, the goals on reference lenses."""

import json
from pathlib import Path

import numpy as np
import pytest

from ncdc.cli import main
from ncdc_bench.accuracy.command import by_lens, table
from ncdc_bench.accuracy.measure import MODELS, NETWORKS, fits_of, jobs_of, reliability
from ncdc_bench.accuracy.plots import plot_accuracy
from ncdc_bench.baselines import BASELINES
from ncdc_bench.reference_lenses import REFERENCE_LENSES, ReferenceLens

regress = pytest.mark.regress
KEYS = {"lens", "residual", "model", "hidden_neurons", "seed", "mse", "mean", "max", "fixed_mse",
        "fixed_mean", "fixed_max", "fixed_added_max", "dots_mse", "seconds"}


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """Rows of a quick run of the command, by model."""
    report = tmp_path_factory.mktemp("bench") / "report.json"
    assert main(["bench", "accuracy", "--lens", "PC105", "--neurons", "4", "--model", "ncdc",
                 "pbm6-shared", "pbm6-separate", "mesh128-bicubic", "--json", str(report)]) == 0
    return {row["model"]: row for row in json.loads(report.read_text())["rows"]}


@pytest.mark.longer
def test_rows(rows):
    assert list(rows) == ["ncdc", "pbm6-shared", "pbm6-separate", "mesh128-bicubic"]
    for row in rows.values():
        assert set(row) == KEYS and row["lens"] == "PC105" and row["seconds"] > 0
        assert row["mean"]**2 < row["mse"] < row["max"]**2
    ncdc, pbm = rows["ncdc"], rows["pbm6-shared"]
    assert (ncdc["hidden_neurons"], ncdc["seed"]) == (4, 0)
    assert pbm["hidden_neurons"] is None and pbm["fixed_mse"] is None


@pytest.mark.longer
def test_figures(rows):
    assert rows["ncdc"]["mse"] <= .155
    assert rows["ncdc"]["fixed_mse"] == pytest.approx(rows["ncdc"]["mse"], rel=1e-3)
    assert 0 < rows["ncdc"]["fixed_added_max"] <= .0022
    # The study found 4.81 and 0.158 for Asari's polynomial with one centre and with two.
    assert rows["pbm6-shared"]["mse"] == pytest.approx(4.81, rel=.01)
    assert rows["pbm6-separate"]["mse"] == pytest.approx(.158, rel=.03)
    # The noise of the dots is in the error on them, 2 * 0.05^2, and mostly not in the map.
    assert rows["mesh128-bicubic"]["mse"] < .001 < .003 < rows["mesh128-bicubic"]["dots_mse"]


@pytest.mark.longer
def test_errors_are_those_of_the_map():
    fit, = fits_of("PC105", [("opencv-fisheye", None, None)])
    lens = ReferenceLens("PC105")
    truth, dots = lens.truth(), lens.dots()
    x, y = fit.back_map(truth.u, truth.v)
    distance = np.hypot(x - truth.x, y - truth.y)
    assert fit.row["mse"] == pytest.approx((distance**2).mean())
    assert fit.row["mean"] == pytest.approx(distance.mean())
    assert fit.row["max"] == pytest.approx(distance.max())
    x, y = fit.back_map(dots.u, dots.v)
    assert fit.row["dots_mse"] == pytest.approx(((x - dots.x)**2 + (y - dots.y)**2).mean())


def test_a_lens_without_residual_is_one_that_a_model_describes(tmp_path):
    """OpenCV's five coefficients are four times nearer, and the command writes the table of it."""
    report, written = tmp_path / "report.json", tmp_path / "table.md"
    assert main(["bench", "accuracy", "--lens", "PC120", "--model", "brown5", "--residual", "0",
                 "--json", str(report), "--table", str(written)]) == 0
    row, = json.loads(report.read_text())["rows"]
    whole, = fits_of("PC120", [("brown5", None, None)])
    assert row["residual"] == 0 and whole.row["residual"] == 1
    assert row["mse"] < whole.row["mse"] / 4
    assert written.read_text() == by_lens([row])
    assert f"| `brown5` | {row['mse']:.3g} / {row['max']:.3g} |" in written.read_text()


def test_a_residual_beyond_the_limits_is_rejected(capsys):
    assert main(["bench", "accuracy", "--lens", "PC105", "--residual", "nan"]) == 2
    assert "the residual is nan times the lens's own, the limits are 0 and 1" in (
        capsys.readouterr().err)


def test_the_page_compares_as_the_report_does():
    docs = Path(__file__).resolve().parents[2] / "docs"
    rows = json.loads((docs / "figures/accuracy-residual-0.json").read_text())["rows"]
    best = {row["lens"]: row["mse"] for row in rows if row["model"] == "opencv-full"}
    times = [row["mse"] / best[row["lens"]] for row in rows if row["hidden_neurons"] == 12]
    text = f"Its MSE is {min(times):.1f} to {max(times):.0f} times less"
    assert text in (docs / "evidence/accuracy.md").read_text()


def test_jobs():
    assert jobs_of(["pbm6-shared", "ncdc"], [4, 5], 2) == [
        ("pbm6-shared", None, None), ("ncdc", 4, 0), ("ncdc", 4, 1), ("ncdc", 5, 0), ("ncdc", 5, 1)]
    assert set(MODELS) == set(NETWORKS) | set(BASELINES)


@pytest.mark.parametrize("options, networks, slow", [
    ([], {"PC105": [4, 5, 6], "PC120": [4, 5, 6], "120kb": [8, 10, 12, 16]}, {"PC105": [4]}),
    (["--lens", "105br"], {"105br": [4, 6, 8, 10, 12]}, {}),
    (["--lens", "PC105", "--neurons", "5,7-8"], {"PC105": [5, 7, 8]}, {}),
    (["--all"], {lens: list(range(4, 17)) for lens in REFERENCE_LENSES},
     {lens: [4, 5, 6] for lens in REFERENCE_LENSES})])
def test_what_is_done_without_options(options, networks, slow, monkeypatch, capsys):
    asked = {}

    def fits_of(lens, jobs, residual):
        asked[lens] = jobs
        return []
    monkeypatch.setattr("ncdc_bench.accuracy.command.fits_of", fits_of)
    assert main(["bench", "accuracy", *options]) == 0
    assert {lens: [hn for model, hn, _ in jobs if model == "ncdc"]
            for lens, jobs in asked.items()} == networks
    assert {lens: found for lens, jobs in asked.items()
            if (found := [hn for model, hn, _ in jobs if model == "ebp"])} == slow
    assert all({model for model, _, _ in jobs} >= {*BASELINES, "ncdc-skip"}
               for jobs in asked.values())


def test_reliability_counts_the_seeds_near_the_best():
    rows = [{"lens": "PC105", "model": "ncdc", "hidden_neurons": 4, "seed": seed, "dots_mse": mse}
            for seed, mse in enumerate([.15, .164, .166, .4])]
    rows += [{"lens": "PC105", "model": "brown5", "hidden_neurons": None, "seed": None},
             {**rows[0], "hidden_neurons": 5}]
    assert reliability(rows) == [{"lens": "PC105", "model": "ncdc", "hidden_neurons": 4,
                                  "seeds": 4, "seeds_within_10_percent": 2}]


@pytest.mark.longer
def test_table(rows):
    note, titles, *lines = table(list(rows.values())).splitlines()
    assert len({len(line) for line in (titles, *lines)}) == 1 and "fixed point" in note
    assert lines[0].split()[:3] == ["PC105", "ncdc", "4"]
    assert lines[1].split()[2] == "-" == lines[1].split()[6]


def test_plots(tmp_path):
    # Every map of one lens, quickly: the plot needs rows and maps, not good ones.
    fit, = fits_of("PC105", [("pbm6-separate", None, None)])
    row = {**fit.row, "model": "ncdc", "seed": 0, "fixed_mse": .2, "fixed_max": 2.0}
    networks = [type(fit)({**row, "hidden_neurons": n, "mse": .1 / n}, fit.back_map, fit.real_map)
                for n in (4, 5, 6)]
    plot_accuracy(tmp_path, [fit, *networks])
    assert {path.name for path in tmp_path.iterdir()} == {"accuracy-PC105.png",
                                                          "accuracy-PC105-map.jpg"}


@pytest.mark.parametrize("options, message", [
    (["--neurons", "4,x"], "--neurons is '4,x', numbers as in 4,5,8-10 are needed"),
    (["--neurons", "6-4"], "--neurons is '6-4', which names none"),
    (["--neurons", "0-4"], "0 hidden neurons are asked for, the limits are 1 and 32"),
    (["--neurons", "4-33"], "33 hidden neurons are asked for, the limits are 1 and 32"),
    (["--seeds", "0"], "0 seeds are asked for, 1 is the limit"),
    (["--model", "spline"], "invalid choice: 'spline'"),
    (["-o", "/dev/null/plots"], "cannot write /dev/null/plots/accuracy.png"),
    (["--lens", "90kb"], "invalid choice: '90kb'")])
def test_bad_requests_are_named(options, message, capsys):
    try:
        assert main(["bench", "accuracy", *options]) == 2
    except SystemExit as end:
        assert end.code == 2
    error = capsys.readouterr().err
    assert message in error and len(error.splitlines()) == 1


@regress
@pytest.mark.parametrize("lens, goals", [
    ("PC105", {4: (.155, None), 5: (.041, None), 6: (.016, None)}),
    ("PC120", {4: (.047, None), 5: (.0050, None), 6: (.0014, None)}),
    ("120kb", {8: (.12, None), 12: (.008, .45), 16: (.001, .15)})])
def test_goals(lens, goals):
    for fit in fits_of(lens, jobs_of(["ncdc"], list(goals), 1)):
        mse, largest = goals[fit.row["hidden_neurons"]]
        assert fit.row["fixed_mse"] <= mse
        assert largest is None or fit.row["fixed_max"] <= largest


@regress
@pytest.mark.parametrize("lens", REFERENCE_LENSES)
def test_ten_neurons_beat_the_full_model_of_opencv(lens):
    network, model = fits_of(lens, [("ncdc", 10, 0), ("opencv-full", None, None)])
    assert network.row["fixed_mse"] < model.row["mse"]
