"""Plots of reports: errors and how often they are, the learning curve, error over neurons."""

import cv2
import numpy as np

from ncdc_model.chart import BLUE, GREY, RED, Axes, Chart, Scale

__all__ = ["plot_error_map", "plot_learning_curve", "plot_neurons", "plot_point_errors"]

_COLOURS = cv2.applyColorMap(np.arange(256, dtype=np.uint8)[:, None],
                             cv2.COLORMAP_VIRIDIS)[:, 0, ::-1]
_NO_SOURCE = 217        # grey
_ORANGE = 255, 127, 14
_SIZE = 770, 462        # of a single chart
_WIDE = 1350
_MAP = 90, 770          # columns of the map
_BAR = 800, 820         # of the bar of its colours
_HISTOGRAM = 995, 1325
_BINS = 60


def plot_error_map(path, distance, title):
    """Write a PNG: heat map of ``distance`` over the corrected frame, and its histogram.

    ``distance``: pixels, shape (height, width), ``nan`` (grey) where a pixel has no source.
    """
    height, width = distance.shape
    top = float(np.nanmax(distance, initial=1e-9))
    chart, axes = _panels((0, width - 1), (height - 1, 0))
    left, upper, right, lower = axes.box
    shown = cv2.resize(distance.astype(np.float32), (right - left, lower - upper),
                       interpolation=cv2.INTER_NEAREST)
    picture = _coloured(np.nan_to_num(shown), top)
    picture[~np.isfinite(shown)] = _NO_SOURCE
    chart.picture(axes.box, picture)
    _finish(chart, axes, title, top, distance[np.isfinite(distance)], "pixels")
    chart.save(path)


def plot_point_errors(path, geometry, u, v, distance, held_out, title):
    """Write a PNG: error of every calibrated point at its position, and the histogram.

    ``u``, ``v``: corrected pixels; ``distance``: pixels; ``held_out``: bool, drawn as diamonds,
    or None if it is not known. All of shape (N,).
    """
    width, height = geometry.corrected
    top = max(float(np.max(distance, initial=0)), 1e-9)
    chart, axes = _panels((-.06 * width, 1.06 * width), (1.06 * height, -.06 * height))
    axes.line([0, width - 1, width - 1, 0, 0], [0, 0, height - 1, height - 1, 0], GREY, 1)
    kinds = np.zeros(len(u), bool) if held_out is None else held_out
    for (x, y), colour, diamond in zip(axes.at(u, v), _coloured(distance, top).tolist(), kinds):
        chart.marker(x, y, tuple(colour), "oD"[int(diamond)], 3)
    if held_out is not None:
        signs = [(lambda x, y, kind=kind: chart.marker(x, y, BLUE, kind), text) for kind, text in
                 (("o", "trained on"), ("D", "held out"))]
        chart.legend(sum(_MAP) / 2, axes.box[3] + 66, signs)
    _finish(chart, axes, title, top, distance, "points")
    chart.save(path)


def plot_learning_curve(path, curve, title, steps):
    """Write a PNG of a learning curve: pairs (step, MSE in px^2); ``steps`` names the steps."""
    step, mse = np.array(curve, np.float64).T
    chart, axes = _single(Scale(*_around(step, 1.25), log=True), Scale(*_around(mse, 2), log=True))
    axes.frame(title, steps, "MSE on the training points (square pixels)", grid=True)
    axes.line(np.repeat(step, 2)[1:], np.repeat(mse, 2)[:-1], BLUE)
    x, y = axes.at(step[-1], mse[-1])
    chart.marker(x, y, _ORANGE)
    # The curve only falls: the area below its end is free.
    chart.text(x, y + 15, f"{mse[-1]:.4g}", "rm")
    chart.save(path)


def plot_neurons(path, tried, chosen, limit, measured_on):
    """Write a PNG: largest and mean error of every network tried, over its hidden neurons.

    Parameters
    ----------
    path : path
    tried : list of dict
        ``hidden_neurons``, ``max`` and ``mean`` in pixels, as
        :func:`ncdc_model.training.choose.choose_camera` reports.
    chosen : int
        Hidden neurons of the chosen network.
    limit : float
        The wanted limit of the largest error, in pixels.
    measured_on : str
        Where the errors are measured, for the title.
    """
    neurons = [row["hidden_neurons"] for row in tried]
    errors = {key: [row[key] for row in tried] for key in ("max", "mean")}
    chart, axes = _single(Scale(min(neurons) - .5, max(neurons) + .5),
                          Scale(*_around([*errors["max"], *errors["mean"], limit], 1.5), log=True))
    axes.frame(f"error on {measured_on} over the number of hidden neurons", "hidden neurons",
               "error (distorted pixels)", grid=True)
    entries = []
    for (key, values), colour, kind, name in zip(errors.items(), (BLUE, _ORANGE), "os",
                                                 ("largest error", "mean error")):
        axes.line(neurons, values, colour)
        for x, y in axes.at(neurons, values):
            chart.marker(x, y, colour, kind)
        entries.append((lambda x, y, colour=colour, kind=kind: chart.marker(x, y, colour, kind),
                        name))
    axes.line([min(neurons) - .5, max(neurons) + .5], [limit] * 2, GREY, 1.6, "--")
    entries.append((lambda x, y: chart.line([(x - 12, y), (x + 12, y)], GREY, 1.6, "--"),
                    f"wanted: {limit:g} px"))
    taken = errors["max"][neurons.index(chosen)]
    chart.marker(*axes.at(chosen, taken), RED, radius=8, hollow=True)
    entries.append((lambda x, y: chart.marker(x, y, RED, radius=7, hollow=True),
                    f"taken: {chosen} neurons, {taken:.3g} px"))
    chart.legend(_SIZE[0] / 2, _SIZE[1] - 18, entries)
    chart.save(path)


def _single(x, y):
    """A chart with one frame, and its :class:`Axes`."""
    chart = Chart(*_SIZE)
    return chart, Axes(chart, (100, 40, _SIZE[0] - 20, _SIZE[1] - 85), x, y)


def _around(values, factor):
    """The range of positive ``values`` and a margin, for a logarithmic scale."""
    values = np.maximum(np.asarray(values, np.float64), 1e-12)
    return values.min() / factor, values.max() * factor


def _panels(across, down):
    """A chart for a map of the ranges ``across`` and ``down``, and the map's :class:`Axes`."""
    height = round((_MAP[1] - _MAP[0]) * (down[0] - down[1]) / (across[1] - across[0]))
    height = min(max(height, 220), 800)
    chart = Chart(_WIDE, height + 130)
    return chart, Axes(chart, (_MAP[0], 40, _MAP[1], 40 + height), Scale(*across), Scale(*down))


def _coloured(values, top):
    """RGB (..., 3) of ``values`` from 0 to ``top``."""
    return _COLOURS[np.clip(255 * np.asarray(values) / top, 0, 255).astype(np.uint8)]


def _finish(chart, axes, title, top, values, unit):
    """Frame of the map, bar of its colours, and the histogram."""
    axes.frame(title, "u (corrected pixels)", "v")
    _, upper, _, lower = axes.box
    box = _BAR[0], upper + 20, _BAR[1], lower - 20
    chart.picture(box, np.repeat(_COLOURS[::-1, None], 2, axis=1))
    for value, text in Scale(0, top).ticks()[0]:
        y = box[3] - (box[3] - box[1]) * value / top
        chart.line([(box[2], y), (box[2] + 5, y)], (0, 0, 0))
        chart.text(box[2] + 9, y, text, "lm")
    chart.text(box[2] + 62, (upper + lower) / 2, "error (distorted pixels)", turned=True)
    _histogram(chart, (_HISTOGRAM[0], upper, _HISTOGRAM[1], lower), values, unit)


def _histogram(chart, box, values, unit):
    counts, edges = np.histogram(values, _BINS)
    axes = Axes(chart, box, Scale(0, 1.05 * max(edges[-1], 1e-9)),
                Scale(.8, max(counts.max(), 1) * 1.5, log=True))
    axes.bars(edges, counts, BLUE)
    signs = []
    for level, style in ((50, ":"), (99, "--"), (100, "-")) if len(values) else ():
        value = np.percentile(values, level)
        (x, bottom), (_, top) = axes.at([value] * 2, [.8, max(counts.max(), 1) * 1.5])
        chart.line([(x, top), (x, bottom)], RED, 1.5, style)
        signs.append((lambda x, y, style=style: chart.line([(x - 12, y), (x + 12, y)], RED, 1.5,
                                                           style),
                      f"{level} %: {value:.3g} px" if level < 100 else f"largest: {value:.3g} px"))
    axes.frame("how often", "error (distorted pixels)", unit)
    # A legend inside the axes would cover the lines and the tail of the histogram.
    chart.legend((box[0] + box[2]) / 2 - 10, box[3] + 66, signs)
