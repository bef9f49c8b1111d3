"""Plots of a production lot: a histogram of each figure, and its course over time."""

import numpy as np
from matplotlib.colors import TABLEAU_COLORS
from matplotlib.figure import Figure

__all__ = ["COLOURS", "plot_histograms", "plot_trend"]

# Of the stations. Their names are in the page: it has fonts of every script, and takes no name for
# a formula.
COLOURS = tuple(TABLEAU_COLORS.values())
_COLUMNS = 3
_BINS = 40
_REACH = 3.0            # of the control limits' distance: farther units are in the last bar
_DRAWN = 5000           # units that are drawn as dots: of more some are left out


def plot_histograms(path, plots):
    """Write a PNG of histograms.

    ``plots``: (Figure of the lot, values, (low, middle, high) control limits, limits) each.
    """
    figure, axes = _grid(len(plots), 2.5)
    for one, (about, values, control, limits) in zip(axes, plots):
        values = values[np.isfinite(values)]
        low, high = _range(values, control, limits)
        one.hist(np.clip(values, low, high), _BINS, range=(low, high), color="#7a9cc6")
        for limit in _known(control[0], control[2]):
            one.axvline(limit, color="0.3", linestyle="--", linewidth=1)
        for limit in _drawn(limits, low, high):
            one.axvline(limit, color="#b00020", linewidth=1.5)
        one.set(xlabel=_label(about), ylabel="units")
        one.locator_params(axis="x", nbins=5)
        one.yaxis.get_major_locator().set_params(integer=True)
    figure.savefig(path, dpi=110)


def plot_trend(path, plots, station):
    """Write a PNG of each figure over the units in the order of judgement.

    ``plots`` as of :func:`plot_histograms`; ``station``: number of each unit's station, which has
    one of :data:`COLOURS`.
    """
    figure, axes = _grid(len(plots), 2.2)
    step = max(1, -(-len(station) // _DRAWN))
    for one, (about, values, control, limits) in zip(axes, plots):
        low, high = _range(values[np.isfinite(values)], control, limits)
        for number in np.unique(station):
            at = np.flatnonzero(station == number)[::step]
            one.plot(at + 1, np.clip(values[at], low, high), ".", markersize=4,
                     color=COLOURS[number % len(COLOURS)])
        for limit in _known(control[0], control[2]):
            one.axhline(limit, color="0.3", linestyle="--", linewidth=1)
        for limit in _drawn(limits, low, high):
            one.axhline(limit, color="#b00020", linewidth=1.5)
        one.set(xlabel="unit")
        one.xaxis.get_major_locator().set_params(integer=True)
        one.set_title(_label(about), fontsize="medium")
    figure.savefig(path, dpi=110)


def _grid(count, height):
    rows = -(-count // _COLUMNS)
    figure = Figure(figsize=(12, height * rows), layout="constrained")
    axes = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
    for one in axes[count:]:
        one.set_axis_off()
    return figure, axes


def _range(values, control, limits):
    """Ends of an axis: the values, but no more than some times the control limits' distance."""
    if not len(values):
        return 0.0, 1.0
    low, middle, high = control
    ends = [middle - _REACH * (middle - low), middle + _REACH * (high - middle)]
    first, last = max(values.min(), ends[0]), min(values.max(), ends[1])
    near = _known(low, high, *(limit for limit in limits if ends[0] <= limit <= ends[1]))
    first, last = min([first, *near]), max([last, *near])
    return (first, last) if last > first else (first - .5, last + .5)


def _known(*limits):
    """The limits that there are: a magnitude has no lower one."""
    return [limit for limit in limits if np.isfinite(limit)]


def _drawn(limits, low, high):
    return [limit for limit in limits if low <= limit <= high]


def _label(about):
    return f"{about.title}, {about.unit}" if about.unit else about.title
