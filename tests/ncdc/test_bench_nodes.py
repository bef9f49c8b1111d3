"""``ncdc bench nodes``: its figures on a small map, its bound, its report and plot."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_bench.nodes import command
from ncdc_bench.nodes.measure import curvatures, rows_of
from ncdc_model.evaluate import evaluate_frame, float_map
from ncdc_model.golden.network import coordinates, frame_coordinates
from ncdc_model.golden.nodes import curvature


@pytest.fixture(scope="module")
def small():
    return barrel_descriptor((192, 40), (192, 40), hidden_neurons=4)


def test_rows_are_those_of_whole_frames(small):
    rows = rows_of("PC105", small)
    assert [row["nodes"] for row in rows] == [1, 8, 16, 32]
    assert sum(row["chosen"] for row in rows) == 1
    every = small.formats.coordinate.real(np.stack(frame_coordinates(small)))
    mask = small.valid.mask(192)
    for row in rows:
        d = replace(small, nodes=row["nodes"])
        own = small.formats.coordinate.real(np.stack(frame_coordinates(d)))
        # The rounded network at every pixel is half a last bit off what the row compares to.
        rounded = np.abs(own - every)[:, mask]
        assert abs(rounded.max() - row["added_max_px"]) <= 2**-11 + 2**-18
        assert row["added_mean_px"] < row["added_max_px"] <= row["bound_px"]
        assert row["fixed_minus_float_max_px"] == evaluate_frame(d)["fixed_minus_float_max_px"]
    assert rows[0]["added_max_px"] <= 2**-11 + 2**-18 < rows[-1]["added_max_px"]


def test_a_slip_of_the_interpolation_breaks_the_bound(small, monkeypatch):
    def slip(descriptor, u, v):
        return [raw + 3 * (descriptor.nodes > 1) for raw in coordinates(descriptor, u, v)]
    monkeypatch.setattr("ncdc_bench.nodes.measure.coordinates", slip)
    rows = rows_of("PC105", small)
    assert [row["added_max_px"] > row["bound_px"] for row in rows[:2]] == [False, True]


def test_another_width_is_the_same_map_scaled(small):
    own = curvature(float_map(small.exact_network, small.geometry), small.geometry, small.valid)
    assert curvatures(small, 192)[8] == pytest.approx(own[8], rel=1e-6)
    # Twice the pixels, twice the scale, an eighth of the bend: a quarter of the curvature error.
    assert curvatures(small, 384)[8] == pytest.approx(own[8] / 4, rel=.15)


def test_the_command_reports_and_plots(small, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(command, "descriptor_of", lambda lens, neurons: small)
    assert main(["bench", "nodes", "--lens", "PC105", "--neurons", "4", "-o", str(tmp_path),
                 "--json", str(tmp_path / "nodes.json")]) == 0
    rows = json.loads((tmp_path / "nodes.json").read_text())["rows"]
    assert {"lens", "hidden_neurons", "nodes", "chosen", "added_max_px", "added_mean_px",
            "bound_px", "fixed_minus_float_max_px"} <= set(rows[0])
    assert (tmp_path / "nodes.png").stat().st_size > 10000
    assert "PC105" in capsys.readouterr().out
