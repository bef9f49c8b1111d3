"""``ncdc bench synth --breakdown``: what each module of a block takes, as a table and a picture."""

import re
from operator import itemgetter
from pathlib import Path

from matplotlib import colormaps
from matplotlib.figure import Figure

from ncdc.cli.common import write_report
from ncdc.terminal import Steps
from ncdc.text_table import text_table
from ncdc.toolchain.flows import tool_versions
from ncdc_bench.synth.blocks import ONLY
from ncdc_bench.synth.breakdown import RESOURCES, totals
from ncdc_bench.synth.measure import BROKEN_DOWN, breakdown_of
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs, replace_file

__all__ = ["breakdown_table", "plot_breakdown", "run_breakdown"]

_LEVELS = 2             # of modules below the top in tables and pictures
_TITLES = {"alm": "ALM", "le": "logic elements", "ff": "flip-flops", "ram_blocks": "block RAMs",
           "dsp": "multipliers"}
_SMALL = .014           # share of a panel's height that a name needs


def run_breakdown(chosen, targets, args):
    """Break down the ``chosen`` (block, variant) on ``targets``, and report.

    Parameters
    ----------
    chosen : sequence of (str, str)
    targets : sequence of str
    args : argparse.Namespace
        Options of ``ncdc bench synth``: ``plots`` and ``json``.

    Raises
    ------
    InputError
        If a target has no breakdown, or a picture cannot be written.
    """
    for target in targets:
        if target not in BROKEN_DOWN:
            raise InputError(f"--breakdown is given for {target}, there is one for "
                             f"{' and '.join(BROKEN_DOWN)}")
    runs = [(block, variant, target) for block, variant in chosen for target in targets
            if ONLY.get(variant, target) == target]
    pictures = [Path(args.plots or "") / f"{_file_name(*run)}.png" for run in runs]
    if args.plots:
        check_outputs(pictures, [])
    found = []
    for k, (run, picture) in enumerate(zip(runs, pictures)):
        steps = Steps(f"{k + 1} of {len(runs)}, {' '.join(run)}")
        rows = breakdown_of(*run, steps)
        found.append(dict(zip(("block", "variant", "target"), run)) | {"modules": rows})
        if args.plots:
            plot_breakdown(picture, " ".join(run), rows)
        steps("done")
    if not write_report({"tools": tool_versions(), "rows": found}, args.json):
        print("\n\n".join(f"{one['block']} {one['variant']} {one['target']}\n"
                          f"{breakdown_table(one['modules'])}" for one in found))


def breakdown_table(rows):
    """Rows of ``breakdown`` as text: modules down to the second level, with all that is in them."""
    shown = [row for row in _sorted(totals(rows)) if _level(row) <= _LEVELS]
    columns = [("module", _indented), *((name, itemgetter(name)) for name in RESOURCES
                                        if shown[0][name] is not None)]
    return text_table(columns, shown, left=1)


def plot_breakdown(path, title, rows):
    """Write a picture with a panel for each resource: modules from left to right, their parts
    after them, the height of each its share."""
    found = _sorted(totals(rows))
    shown = [name for name in _TITLES if found[0][name]]
    figure = Figure(figsize=(13, 9), layout="constrained")
    figure.suptitle(title)
    parts = [row["path"] for row in found if _level(row) == 1]
    colours = {path: colormaps["tab20"](k % 20) for k, path in enumerate(parts)}
    widths = [1.5 if name in ("alm", "le") else 1 for name in shown]
    panels = figure.subplots(1, len(shown), width_ratios=widths, squeeze=False)[0]
    for axes, name in zip(panels, shown):
        whole = found[0][name]
        axes.set_title(f"{_TITLES[name]}: {_number(whole)}", fontsize="medium")
        axes.set(xlim=(0, _LEVELS), ylim=(whole, 0), xticks=[], yticks=[])
        end = _draw(axes, name, found, "", 0, colours)
        if own := whole - end:
            _bar(axes, 0, end, own, f"between them {_number(own)}", "lightgrey")
    with replace_file(path) as temporary:
        figure.savefig(temporary, dpi=90, format="png", metadata={"Software": None})


def _draw(axes, name, rows, path, at, colours):
    """Draw the parts of the module at ``path`` from height ``at`` on, and the parts in them;
    return where they end."""
    level = path.count(".") + 1 if path else 0
    parts = [row for row in rows if _level(row) == level + 1 and _parent(row["path"]) == path]
    for row in sorted(parts, key=itemgetter(name), reverse=True):
        size = row[name]
        if not size:
            continue
        _bar(axes, level, at, size, f"{row['path'].rpartition('.')[2]} {_number(size)}",
             colours[row["path"].split(".")[0]])
        if level + 1 < _LEVELS:
            _draw(axes, name, rows, row["path"], at, colours)
        at += size
    return at


def _bar(axes, level, at, size, text, colour):
    """Draw one box, with its text if there is space for it."""
    axes.bar(level + .5, size, width=1, bottom=at, color=colour, alpha=.9 if level == 0 else .6,
             edgecolor="white", linewidth=.6)
    if size > _SMALL * axes.get_ylim()[0]:
        axes.text(level + .04, at + size / 2, text, va="center", fontsize="x-small", clip_on=True)


def _number(value):
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def _sorted(rows):
    """Rows of :func:`totals` as a tree, the largest module of each first."""
    size = "alm" if rows[0]["alm"] is not None else "le"
    sizes = {row["path"]: row[size] for row in rows}

    def position(row):
        names = row["path"].split(".") if row["path"] else []
        paths = [".".join(names[:k + 1]) for k in range(len(names))]
        return [(-sizes[path], path) for path in paths]
    return sorted(rows, key=position)


def _level(row):
    """Depth of a row's module below the top."""
    return row["path"].count(".") + 1 if row["path"] else 0


def _parent(path):
    return path.rpartition(".")[0]


def _indented(row):
    """The last name of a row's path, after two blanks for each level."""
    return "  " * _level(row) + (row["path"].rpartition(".")[2] or "all")


def _file_name(block, variant, target):
    return "-".join(re.findall("[a-z0-9]+", f"{block} {variant} {target}".lower()))
