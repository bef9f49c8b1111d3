"""Plots of ``ncdc bench accuracy``: error by number of hidden neurons, and error maps."""

import matplotlib
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from ncdc_bench.accuracy.measure import MODELS, NETWORKS
from ncdc_bench.reference_lenses import ReferenceLens
from ncdc_spec.files import replace_file

__all__ = ["plot_accuracy"]

_STEP = 8              # pixels between the errors of a map
_RANGE = 1e-3, 10      # pixels, of its colours
_COLUMNS = 3
_COLOURS = matplotlib.colormaps["tab20"]       # by position in MODELS: one for all lenses
_SAME = ("pbm7", "pbm8")       # lie on the lines of order 6


def plot_accuracy(folder, fits):
    """Write ``accuracy-LENS.png`` (if a network is there) and ``accuracy-LENS-map.jpg``.

    The first has MSE and largest error by number of hidden neurons, the other maps as lines. The
    second has the error of each map over the frame. Networks are those with the smallest and the
    largest number of neurons.

    Parameters
    ----------
    folder : Path
    fits : list of ncdc_bench.accuracy.measure.Fit

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    fits = [fit for fit in fits if fit.row["seed"] in (None, 0)
            and not fit.row["model"].startswith(_SAME)]
    for lens in dict.fromkeys(fit.row["lens"] for fit in fits):
        own = [fit for fit in fits if fit.row["lens"] == lens]
        if any(fit.row["model"] in NETWORKS for fit in own):
            _by_neurons(folder / f"accuracy-{lens}.png", lens, [fit.row for fit in own])
        _maps(folder / f"accuracy-{lens}-map.jpg", ReferenceLens(lens, own[0].row["residual"]), own)


def _by_neurons(path, lens, rows):
    figure = Figure(figsize=(9.5, 4.6), layout="constrained")
    panels = figure.subplots(1, 2)
    for model in dict.fromkeys(row["model"] for row in rows):
        k = MODELS.index(model)
        own = [row for row in rows if row["model"] == model]
        for axes, name in zip(panels, ("mse", "max")):
            if model in NETWORKS:
                own.sort(key=lambda row: row["hidden_neurons"])
                counts = [row["hidden_neurons"] for row in own]
                axes.plot(counts, [row[name] for row in own], "o-", color=_COLOURS(k % 20),
                          label=model, markersize=4)
                axes.plot(counts, [row[f"fixed_{name}"] for row in own], "+", color="black",
                          markersize=8, label="in integers" if model == "ncdc" else None)
            else:
                axes.axhline(own[0][name], color=_COLOURS(k % 20), linewidth=1.2, label=model,
                             linestyle=("--", "-.", ":")[k % 3])
    for axes, title in zip(panels, ("MSE (px²)", "largest error (px)")):
        axes.set(xlabel="hidden neurons", ylabel=title, yscale="log", title=f"{lens}: {title}")
        axes.set_xticks(sorted({row["hidden_neurons"] for row in rows if row["hidden_neurons"]}))
        axes.grid(alpha=.3, which="both")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, fontsize="small")
    _save(figure, path)


def _maps(path, lens, fits):
    fits = [fit for fit in fits if fit.row["model"] not in NETWORKS or _extreme(fit, fits)]
    truth = lens.truth(_STEP)
    width, height = lens.geometry.corrected
    rows = -(-len(fits) // _COLUMNS)
    columns = min(len(fits), _COLUMNS)
    figure = Figure(figsize=(3.4 * columns + .9, rows * (3.3 * height / width + .3)),
                    layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, fit in zip(panels, fits):
        x, y = fit.back_map(truth.u, truth.v)
        image = np.full((-(-height // _STEP), -(-width // _STEP)), np.nan)
        cell = (truth.v / _STEP).astype(int), (truth.u / _STEP).astype(int)
        image[cell] = np.hypot(x - truth.x, y - truth.y)
        drawn = axes.imshow(image, norm=LogNorm(*_RANGE),
                            cmap=matplotlib.colormaps["viridis"].with_extremes(bad="0.85"))
        count = fit.row["hidden_neurons"]
        axes.set_title(fit.row["model"] + (f", HN {count}" if count else "")
                       + f": max {fit.row['fixed_max' if count else 'max']:.2g} px", fontsize=9)
    figure.colorbar(drawn, ax=panels.tolist(), label=f"{lens.name}: error (px)", shrink=.8)
    _save(figure, path)


def _extreme(fit, fits):
    """Whether a network has the smallest or the largest number of neurons of its kind."""
    counts = [other.row["hidden_neurons"] for other in fits
              if other.row["model"] == fit.row["model"]]
    return fit.row["hidden_neurons"] in (min(counts), max(counts))


def _save(figure, path):
    with replace_file(path) as temporary:
        if path.suffix == ".png":
            figure.savefig(temporary, dpi=80, format="png", metadata={"Software": None})
        else:
            figure.savefig(temporary, dpi=80, format="jpeg", pil_kwargs={"quality": 85})
