"""Plot of ``ncdc bench cost``."""

from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, NullLocator

from ncdc_spec.files import replace_file

__all__ = ["PLOT", "plot_cost"]

PLOT = "cost.png"
_PANELS = (("predicted_clocks_per_pixel", "clocks per pixel"),
           ("bytes_read_per_pixel", "bytes read per pixel"),
           ("cache_kb", "planned cache, KB"))
_AREA = (("alm", "ALM, Cyclone V", "tab:blue"), ("m10k", "M10K", "tab:orange"))


def plot_cost(folder, rows):
    """Write :data:`PLOT`: each figure over the pixels of the picture, a line per lens; hollow
    marks where no hardware exists.

    Parameters
    ----------
    folder : Path
    rows : list of dict
        Rows of :func:`ncdc_bench.cost.measure.measure`.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    figure = Figure(figsize=(9, 6.4), layout="constrained")
    panels = figure.subplots(2, 2).ravel()
    rows = [row | {"cache_kb": row["cache_bytes"] / 1024} for row in rows]
    for axes, (key, title) in zip(panels, _PANELS):
        for lens in sorted({row["lens"] for row in rows}):
            mine = [row for row in rows if row["lens"] == lens]
            line, = axes.plot(_megapixels(mine), [row[key] for row in mine], label=f"{lens}°")
            for exists in (True, False):
                some = [row for row in mine if row["hardware_exists"] == exists]
                axes.plot(_megapixels(some), [row[key] for row in some], "o",
                          color=line.get_color(),
                          markerfacecolor=line.get_color() if exists else "white")
        axes.set_ylabel(title)
        _scale(axes, rows)
    panels[0].legend(title="lens", fontsize="small")
    panels[2].set_yscale("log", base=2)
    panels[2].yaxis.set_major_formatter("{x:g}")
    _area(panels[3], rows)
    with replace_file(folder / PLOT) as temporary:
        figure.savefig(temporary, dpi=90, format="png", metadata={"Software": None})


def _area(axes, rows):
    """ALM on the left axis, M10K on the right one, of the rows that were synthesised; nothing
    without any."""
    made = [row for row in rows if row["alm"] is not None]
    if not made:
        axes.set_visible(False)
        return
    for side, (key, title, colour) in zip((axes, axes.twinx()), _AREA):
        side.plot(_megapixels(made), [row[key] for row in made], "o-", color=colour)
        side.set_ylabel(title, color=colour)
        side.set_ylim(0, 1.15 * max(row[key] for row in made))
    _scale(axes, rows)


def _scale(axes, rows):
    """Pixels on a logarithmic axis, a tick for each size."""
    sizes = sorted({(row["width"], row["height"]) for row in rows})
    axes.set_xscale("log")
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks([width * height / 1e6 for width, height in sizes],
                    [f"{width}x{height}" for width, height in sizes], rotation=20,
                    fontsize="small")
    axes.grid(alpha=.3)


def _megapixels(rows):
    return [row["width"] * row["height"] / 1e6 for row in rows]
