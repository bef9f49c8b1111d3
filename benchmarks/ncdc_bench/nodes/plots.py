"""The plot of ``ncdc bench nodes``: the error that nodes add, by their distance."""

import matplotlib
from matplotlib.figure import Figure

from ncdc_model.golden.nodes import CURVATURE_LIMIT
from ncdc_spec.files import replace_file
from ncdc_spec.nodes import NODES

__all__ = ["plot_nodes"]


def plot_nodes(path, rows, sizes):
    """Write the plot: curvature by size of the picture, and what the integers add.

    Parameters
    ----------
    path : Path
    rows : list of dict
        Rows of :func:`ncdc_bench.nodes.measure.rows_of`, one network per lens.
    sizes : dict
        {lens: {width: :func:`ncdc_bench.nodes.measure.curvatures`}}

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    figure = Figure(figsize=(9.5, 7.2), layout="constrained")
    widths = list(next(iter(sizes.values())))
    panels = figure.subplots(2, 2, sharex=True, sharey=True).ravel()
    colours = matplotlib.colormaps["tab10"]
    for axes, width in zip(panels, widths):
        for k, (lens, found) in enumerate(sizes.items()):
            axes.plot(found[width].keys(), found[width].values(), "o-", markersize=4, label=lens,
                      color=colours(k))
        axes.set_title(f"curvature, pictures {width} pixels wide")
    axes = panels[len(widths)]
    for k, lens in enumerate(sizes):
        own = [row for row in rows if row["lens"] == lens]
        axes.plot([row["nodes"] for row in own], [row["added_max_px"] for row in own], "s-",
                  markersize=4, label=lens, color=colours(k))
        chosen = [row for row in own if row["chosen"]]
        axes.plot([row["nodes"] for row in chosen], [row["added_max_px"] for row in chosen], "o",
                  markersize=11, markerfacecolor="none", color=colours(k))
    axes.set_title("added by integers, own size; ringed: auto")
    for axes in panels:
        axes.axhline(CURVATURE_LIMIT, color="grey", linestyle="--", linewidth=1)
        axes.set_xscale("log", base=2)
        axes.set_yscale("log")
        axes.set_xticks(NODES, [str(nodes) for nodes in NODES])
        axes.grid(alpha=.3)
    for axes in panels[2:]:
        axes.set_xlabel("pixels from node to node")
    for axes in panels[::2]:
        axes.set_ylabel("largest error on an axis, px")
    panels[0].legend(fontsize="small", ncols=2)
    with replace_file(path) as temporary:
        figure.savefig(temporary, dpi=110)
