"""Charts: where values are drawn, and the numbers at the axes."""

import numpy as np
import pytest
from PIL import Image

from ncdc_model.chart import BLUE, RED, Axes, Chart, Scale


@pytest.mark.parametrize("scale,ticks", [
    (Scale(0, 1), ["0", "0.2", "0.4", "0.6", "0.8", "1"]),
    (Scale(-60, 1300), ["0", "200", "400", "600", "800", "1000", "1200"]),
    (Scale(1020, 0), ["0", "200", "400", "600", "800", "1000"]),
    (Scale(.8, 90, log=True), ["1", "10"]), (Scale(3, 40_000, log=True), ["10", "100", "1000",
                                                                          "10000"]),
    (Scale(1.5, 7, log=True), ["2", "5"]), (Scale(0, 0), ["0"])])
def test_ticks_are_round_numbers(scale, ticks):
    assert [text for _, text in scale.ticks()[0]] == ticks
    assert all(float(text) == pytest.approx(value) for value, text in scale.ticks()[0])


def colours(path, positions):
    picture = np.asarray(Image.open(path).convert("RGB"))
    return [tuple(picture[round(y), round(x)].tolist()) for x, y in positions]


def test_values_are_drawn_where_they_belong(tmp_path):
    chart = Chart(300, 200)
    axes = Axes(chart, (50, 20, 250, 160), Scale(0, 10), Scale(1, 100, log=True))
    positions = axes.at([2, 5, 8], [1, 10, 100])
    np.testing.assert_allclose(positions, [(90, 160), (150, 90), (210, 20)])
    axes.frame("title", "x", "y", grid=True)
    axes.bars(np.array([0.0, 1.0, 2.0]), np.array([10, 0]), BLUE)
    for (x, y), kind in zip(positions, "osD"):
        chart.marker(x, y, RED, kind)
    axes.line([0, 10], [30, 30], RED, 3, "--")
    chart.save(tmp_path / "chart.png")
    assert colours(tmp_path / "chart.png", positions) == [RED] * 3
    assert colours(tmp_path / "chart.png", [(60, 130), (80, 130)])[0] == BLUE
    height = axes.at(0, 30)[1]
    row = np.asarray(Image.open(tmp_path / "chart.png"))[round(height), 50:250]
    dashes = (row == RED).all(axis=1)
    assert .4 < dashes.mean() < .8 and np.abs(np.diff(dashes.astype(int))).sum() > 20
