"""``ncdc bench cost``: rows, table and plot."""

import json

import pytest

from ncdc.cli import main
from ncdc_bench.cost import command, measure
from ncdc_bench.cost.lenses import trained_at
from ncdc_bench.cost.plots import PLOT, plot_cost


def row(width, height, lens, exists=True, **figures):
    return {"width": width, "height": height, "lens": lens, "hardware_exists": exists, "nodes": 16,
            "cache_bytes": 16384, "predicted_clocks_per_pixel": 1.001, "bytes_read_per_pixel": .7,
            "amplification": 1.03, "alm": None, "m10k": None, "dsp": None} | figures


ROWS = [row(640, 480, 90, alm=4000, m10k=20, dsp=30), row(3840, 2160, 90, cache_bytes=65536),
        row(7680, 4320, 90, False, cache_bytes=131072), row(640, 480, 180)]


def test_a_lens_of_180_degrees_is_shown_in_part():
    """Half the width is 90 degrees of the sensor, of which the flat picture shows atan(90°)."""
    descriptor = trained_at(180, (96, 72))
    x, _ = descriptor.exact_network(*descriptor.geometry.normalise([0, 95], [35.5, 35.5]))
    # atan(pi/2) of pi/2 radians: 57.5 of 90 degrees.
    assert (x[1] - x[0]) / 95 == pytest.approx(57.52 / 90, abs=.01)


@pytest.mark.longer
def test_a_row_has_the_planned_figures():
    (found,) = measure.measure(((320, 180),), (120,), synth=False)
    assert (found["width"], found["height"], found["lens"]) == (320, 180, 120)
    assert found["hardware_exists"] and found["alm"] is None
    assert 1 < found["predicted_clocks_per_pixel"] < 1.1 < 1.2 * found["amplification"]
    assert found["bytes_read_per_pixel"] == pytest.approx(
        found["distinct_bytes_per_pixel"] * found["amplification"])


def test_the_plot_has_a_mark_for_each_row(tmp_path):
    plot_cost(tmp_path, ROWS)
    assert (tmp_path / PLOT).stat().st_size > 5000


def test_the_command_prints_reports_and_plots(tmp_path, monkeypatch, capsys):
    asked = []

    def rows(sizes, synth, progress):
        asked.append((sizes, synth))
        return ROWS
    monkeypatch.setattr(command, "measure", rows)
    assert main(["bench", "cost", "--quick", "--no-synth", "--plots", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["size", "lens", "hardware", "cache", "clocks/px", "bytes/px",
                                "/distinct", "ALM", "M10K", "DSP"]
    assert lines[3].split() == ["7680x4320", "90", "no", "128", "KB", "1.0010", "0.700", "1.030",
                                "-", "-", "-"]
    assert asked == [(measure.QUICK_SIZES, False)] and (tmp_path / PLOT).exists()
    assert main(["bench", "cost", "--no-synth", "--json", str(tmp_path / "cost.json")]) == 0
    assert json.loads((tmp_path / "cost.json").read_text()) == {"rows": ROWS}
    assert asked[1] == (measure.SIZES, False)
