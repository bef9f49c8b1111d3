"""Plot of the throughput bench: clocks and bytes per pixel of every row."""

from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ncdc_spec.files import replace_file

__all__ = ["plot_throughput"]

_PANELS = (("clocks_per_pixel", "clocks per pixel"),
           ("bytes_read_per_pixel", "bytes read per pixel"))
_COLOURS = {"cache": "tab:blue", "multiport": "tab:orange"}


def plot_throughput(folder, rows):
    """Write ``throughput.png``: a bar per row, logarithmic, what the planner predicts as a mark.

    Parameters
    ----------
    folder : Path
    rows : list of dict
        Rows of :func:`ncdc_bench.throughput.measure.measure`.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    figure = Figure(figsize=(9, 1.2 + .28 * len(rows)), layout="constrained")
    positions = range(len(rows))
    for axes, (key, title) in zip(figure.subplots(1, 2, sharey=True), _PANELS):
        values = [row[key] for row in rows]
        bars = axes.barh(positions, values, color=[_COLOURS[row["fetch"]] for row in rows])
        axes.bar_label(bars, fmt="%.4g", fontsize="x-small", padding=2)
        if key == "clocks_per_pixel":
            known = [k for k in positions if rows[k]["predicted_clocks_per_pixel"]]
            axes.plot([rows[k]["predicted_clocks_per_pixel"] for k in known], known, "k|",
                      label="predicted")
            axes.legend(fontsize="x-small")
        axes.set(xscale="log", xlabel=title, yticks=list(positions), xlim=(.2, 3 * max(values)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_yticklabels([_label(row) for row in rows], fontsize="x-small")
        axes.grid(axis="x", alpha=.3)
    axes.invert_yaxis()
    with replace_file(folder / "throughput.png") as temporary:
        figure.savefig(temporary, dpi=90, format="png", metadata={"Software": None})


def _label(row):
    scan = f"strips {row['strip']}" if row["strip"] else "raster"
    lanes = f", {row['pixels_per_clock']} per clock" if row["pixels_per_clock"] > 1 else ""
    size = f"{row['width']}x{row['height']}"
    return (f"{row['fetch']}, {row['interpolation']}{lanes}, {row['memory']} to {row['output']}, "
            f"{size}, lens {row['lens']:g}, {row['rotation']:g}°, {scan}")
