"""The paper's figures of the tan-sigmoid, made of this project's: Fig. 10, 11, 13 and 14."""

import numpy as np
from matplotlib.figure import Figure

from ncdc_spec.files import replace_file
from ncdc_spec.tansig import TansigDesign, tansig

__all__ = ["plot_tansig"]

_LIMIT = 15         # of n, as in the paper
_BINS = 300         # intervals of positive n


def plot_tansig(folder, rows):
    """Write ``tansig-fig10.png`` (if it has rows), ``-fig11``, ``-fig13`` and ``-fig14``.

    Parameters
    ----------
    folder : Path
    rows : list of dict
        Rows of :func:`ncdc_bench.tansig.measure.tansig_row`; those of ``mmhbc`` make Fig. 10. The
        others are of the 20-bit golden model, which the rows compare with the Verilog.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    rows = sorted((row for row in rows if row["variant"] == "mmhbc"),
                  key=lambda row: row["fraction_bits"])
    if rows:
        _mse(folder / "tansig-fig10.png", rows)
    design = TansigDesign.for_bits(20)
    n = np.arange((_LIMIT << design.input.f_bits) + 1)
    real, exact = design.input.real(n), np.tanh(design.input.real(n) / 2)
    result = design.output.real(tansig(n, design))
    unit = 2.0**-design.fraction_bits
    _division(folder / "tansig-fig11.png", real, (result - exact) / unit,
              (_divided(n, design) - exact) / unit)
    _characteristic(folder / "tansig-fig13.png", real, result, exact)
    _error(folder / "tansig-fig14.png", real, result - exact, unit)


def _divided(n, design):
    """f(n), n >= 0, from the same exponential by an exact division, rounded."""
    u = design.exponential(n) / 2.0**design.width
    scale = 2.0**design.fraction_bits
    return np.floor((1 - u) / (1 + u) * scale + .5) / scale


def _mse(path, rows):
    figure = Figure(figsize=(6, 3.8), layout="constrained")
    axes = figure.subplots()
    position = np.arange(len(rows))
    for shift, key, name in ((-.2, "mse", "MMHBC and LVC"), (.2, "mse_ideal", "ideal rounding")):
        bars = axes.bar(position + shift, [row[key] for row in rows], .4, label=name)
        axes.bar_label(bars, fmt="%.2e", fontsize="x-small")
    axes.set(yscale="log", ylabel="mean squared error", xlabel="fraction bits",
             title="Tan-sigmoid at fixed point (Fig. 10)", xticks=position)
    axes.set_xticklabels([row["fraction_bits"] for row in rows])
    axes.margins(y=.15)
    axes.legend()
    _save(figure, path)


def _division(path, n, lvc, divided):
    figure = Figure(figsize=(7, 4.6), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True, sharey=True)
    for axes, error, name in zip(panels, (lvc, divided), (
            "LVC, last bit constant", "exact divider (DIV), rounded")):
        _band(axes, n, error)
        root = np.sqrt(np.mean(error**2))
        axes.set(title=f"{name}: largest {np.abs(error).max():.3f}, RMS {root:.3f}",
                 ylabel="error (2$^{-20}$)")
    panels[1].set_xlabel("n")
    figure.suptitle("Division of the same exponential (Fig. 11)")
    _save(figure, path)


def _characteristic(path, n, result, exact):
    figure = Figure(figsize=(6, 3.8), layout="constrained")
    axes = figure.subplots()
    n, result, exact = (values[::len(n) // 1000] for values in (n, result, exact))
    for values, style in ((exact, {"linewidth": 4, "color": "0.75",
                                   "label": "floating point (STD)"}),
                          (result, {"linewidth": 1, "color": "tab:red",
                                    "label": "MMHBC and LVC"})):
        axes.plot(np.append(-n[:0:-1], n), np.append(-values[:0:-1], values), **style)
    axes.set(xlabel="n", ylabel="f(n)", title="Tan-sigmoid from -15 to 15 (Fig. 13)")
    axes.grid(alpha=.3)
    axes.legend()
    _save(figure, path)


def _error(path, n, error, unit):
    figure = Figure(figsize=(7, 3.6), layout="constrained")
    axes = figure.subplots()
    _band(axes, n, error)
    axes.set(xlabel="n", ylabel="f(n) - STD",
             title=f"Error from -15 to 15 (Fig. 14): at most {np.abs(error).max():.2e}")
    scale = axes.secondary_yaxis("right", functions=(lambda e: e / unit, lambda e: e * unit))
    scale.set_ylabel("2$^{-20}$")
    _save(figure, path)


def _band(axes, n, error):
    """Smallest and largest ``error`` in each of many intervals of n, both signs of it.

    ``n``, ``error``: of all positive n; the error is odd as the function is.
    """
    edges = np.arange(_BINS) * len(n) // _BINS
    low, high = np.minimum.reduceat(error, edges), np.maximum.reduceat(error, edges)
    axes.fill_between(np.append(-n[edges[::-1]], n[edges]), np.append(-high[::-1], low),
                      np.append(-low[::-1], high), step="mid", linewidth=.2)
    axes.grid(alpha=.3)


def _save(figure, path):
    with replace_file(path) as temporary:
        figure.savefig(temporary, dpi=90, format="png", metadata={"Software": None})
