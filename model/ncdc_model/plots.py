"""Plots of reports: error over the frame with its histogram, and the learning curve."""

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from ncdc_spec.files import replace_file

__all__ = ["plot_error_map", "plot_learning_curve", "plot_point_errors"]

_COLOURS = matplotlib.colormaps["viridis"].with_extremes(bad="0.85")


def plot_error_map(path, distance, title):
    """Write a PNG: heat map of ``distance`` over the corrected frame, and its histogram.

    ``distance``: pixels, shape (height, width), ``nan`` (grey) where a pixel has no source.
    """
    figure, left, right = _panels(distance.shape)
    top = np.nanmax(distance, initial=1e-9)
    image = left.imshow(distance, cmap=_COLOURS, vmin=0, vmax=top, interpolation="nearest")
    left.set(title=title, xlabel="u (corrected pixels)", ylabel="v")
    figure.colorbar(image, ax=left, label="error (distorted pixels)", shrink=.85)
    _histogram(right, distance[np.isfinite(distance)], "pixels")
    _save(figure, path)


def plot_point_errors(path, geometry, u, v, distance, held_out, title):
    """Write a PNG: error of every calibrated point at its position, and the histogram.

    ``u``, ``v``: corrected pixels; ``distance``: pixels; ``held_out``: bool, drawn as diamonds,
    or None if it is not known. All of shape (N,).
    """
    width, height = geometry.corrected
    figure, left, right = _panels((height, width))
    top = max(float(np.max(distance, initial=0)), 1e-9)
    known = held_out is not None
    kinds = (((~held_out, "o", "trained on"), (held_out, "D", "held out")) if known else
             ((np.ones(len(u), bool), "o", None),))
    for which, marker, name in kinds:
        if which.any():
            dots = left.scatter(u[which], v[which], c=distance[which], cmap=_COLOURS, vmin=0,
                                vmax=top, s=16, marker=marker, label=name)
    left.set(title=title, xlabel="u (corrected pixels)", ylabel="v", aspect="equal",
             xlim=(-.06 * width, 1.06 * width), ylim=(1.06 * height, -.06 * height))
    left.add_patch(matplotlib.patches.Rectangle((0, 0), width - 1, height - 1, fill=False,
                                                color="0.5"))
    if known:
        left.legend(loc="upper center", bbox_to_anchor=(.5, -.1), ncols=2, fontsize="small")
    figure.colorbar(dots, ax=left, label="error (distorted pixels)", shrink=.85)
    _histogram(right, distance, "points")
    _save(figure, path)


def plot_learning_curve(path, curve, title, steps):
    """Write a PNG of a learning curve: pairs (step, MSE in px^2); ``steps`` names the steps."""
    figure = Figure(figsize=(7, 4.2), layout="constrained")
    axes = figure.subplots()
    step, mse = np.array(curve, np.float64).T
    axes.step(step, mse, where="post", linewidth=1.6)
    axes.plot(step[-1:], mse[-1:], "o")
    # The curve only falls: the area below its end is free.
    axes.margins(y=.12)
    axes.annotate(f"{mse[-1]:.4g}", (step[-1], mse[-1]), xytext=(6, -14), ha="right",
                  textcoords="offset points")
    axes.set(title=title, xlabel=steps, ylabel="MSE on the training points (px²)",
             xscale="log", yscale="log")
    axes.grid(alpha=.3, which="both")
    _save(figure, path)


def _panels(shape):
    height, width = shape
    figure = Figure(figsize=(12, max(3.2, min(8.5 * .62 * height / width + 1.4, 9))),
                    layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(2.3, 1))
    return figure, left, right


def _histogram(axes, values, unit):
    axes.hist(values, bins=60, color="tab:blue")
    axes.set(title="how often", xlabel="error (distorted pixels)", ylabel=unit, yscale="log")
    if len(values):
        for level, style in ((50, ":"), (99, "--"), (100, "-")):
            value = np.percentile(values, level)
            axes.axvline(value, color="tab:red", linestyle=style,
                         label=f"{level} %: {value:.3g} px" if level < 100 else
                         f"largest: {value:.3g} px")
        # A legend inside the axes would cover the lines and the tail of the histogram.
        axes.legend(loc="upper center", bbox_to_anchor=(.5, -.16), ncols=3, fontsize="small",
                    handlelength=1.4, columnspacing=1)


def _save(figure, path):
    with replace_file(path) as temporary:
        figure.savefig(temporary, dpi=110, format="png", metadata={"Software": None})
