"""Plot of the error over the number of hidden neurons."""

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ncdc_spec.files import replace_file

__all__ = ["plot_neurons"]


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
    figure = Figure(figsize=(7, 4.2), layout="constrained")
    axes = figure.subplots()
    neurons = [row["hidden_neurons"] for row in tried]
    for key, name, marker in (("max", "largest error", "o"), ("mean", "mean error", "s")):
        axes.plot(neurons, [row[key] for row in tried], marker=marker, linewidth=1.6, label=name)
    axes.axhline(limit, color="0.4", linestyle="--", label=f"wanted: {limit:g} px")
    taken = next(row for row in tried if row["hidden_neurons"] == chosen)
    axes.plot([chosen], [taken["max"]], "o", markersize=13, markerfacecolor="none", color="tab:red",
              label=f"taken: {chosen} neurons, {taken['max']:.3g} px")
    axes.set(title=f"error on {measured_on} over the number of hidden neurons",
             xlabel="hidden neurons", ylabel="error (distorted pixels)", yscale="log")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.grid(alpha=.3, which="both")
    axes.legend(fontsize="small")
    with replace_file(path) as temporary:
        figure.savefig(temporary, dpi=110, format="png", metadata={"Software": None})
