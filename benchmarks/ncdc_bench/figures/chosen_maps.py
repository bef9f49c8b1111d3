"""Numbers of the benches of maps and calibration that pages may quote.

Each function takes a report and gives nested dicts: tables of rows, rows of figures.
"""

__all__ = ["by_lens", "by_neurons", "lines", "nodes", "truth"]

_PART = "mse", "max"
_INTEGERS = "ncdc", "ncdc-skip"          # whose errors are those of the integers


def _word(name):
    return name.replace("-", "_").lower()


def by_lens(report):
    """A row for each map, with MSE and largest error on each lens: ``pc105_mse``, in px²."""
    rows = {}
    for row in report["rows"]:
        name, neurons = row["model"], row["hidden_neurons"]
        title = f"`{name}`, HN {neurons}" if neurons else f"`{name}`"
        figures = rows.setdefault(_word(f"{name}_{neurons}" if neurons else name), {"map": title})
        kind = "fixed_" if name in _INTEGERS else ""
        figures |= {f"{row['lens'].lower()}_{part}": row[kind + part] for part in _PART}
    return rows


def by_neurons(report):
    """For each lens a row for each number of neurons, plain and with the skip path.

    ``skip_path`` has the MSE of both on each lens, in px².
    """
    lenses, both = {}, {}
    for row in report["rows"]:
        lens, neurons = row["lens"].lower(), str(row["hidden_neurons"])
        kind = "skip_" if row["model"] == "ncdc-skip" else ""
        figures = lenses.setdefault(lens, {}).setdefault(neurons, {"neurons": int(neurons)})
        figures |= {f"{kind}{name}": row[key] for name, key in (
            ("mse", "mse"), ("fixed", "fixed_mse"), ("mean", "fixed_mean"), ("max", "fixed_max"),
            ("added", "fixed_added_max"), ("dots", "dots_mse"))}
        pair = both.setdefault(neurons, {"neurons": int(neurons)})
        pair[f"{lens}_{kind}mse"] = row["mse"]
    return lenses | {"skip_path": both}


def lines(report):
    """A row for each lens and map: lines of the board, and how far they are off straight, px."""
    rows = {}
    for row in report["rows"]:
        name, neurons = row["model"], row["hidden_neurons"]
        rows[_word(f"{row['lens']}_{name}_{neurons or ''}").strip("_")] = {
            "lens": row["lens"], "map": f"`{name}`, HN {neurons}" if neurons else f"`{name}`",
            "missed": row["lines_missed"], "lines": row["lines"],
            "rms": row["straightness_rms_px"], "max": row["straightness_max_px"]}
    return rows


def nodes(report):
    """A row for each lens, of the distance that ``auto`` takes; distances on an axis, px."""
    lenses = {}
    for row in report["rows"]:
        figures = lenses.setdefault(row["lens"].lower(), {"lens": row["lens"]})
        figures[f"curvature_{row['nodes']}"] = row["curvature_px"]
        if row["nodes"] == 1:
            figures["every"] = row["fixed_minus_float_max_px"]
        if row["chosen"]:
            figures |= {"nodes": row["nodes"], "added": row["added_max_px"],
                        "mean": row["added_mean_px"], "bound": row["bound_px"],
                        "fixed_minus_float": row["fixed_minus_float_max_px"]}
    for figures in lenses.values():
        figures["apart"] = abs(figures["fixed_minus_float"] - figures["every"])
    return lenses


def truth(report):
    """A row for each lens and number of photos: dots, and errors of the map, px."""
    rows = {}
    for row in report["rows"]:
        rows[_word(f"{row['lens']}_{row['photos']}").replace(" ", "_").replace(":", "_")] = {
            "lens": row["lens"], "photos": row["photos"], "used": row["dots_used"],
            "visible": row["dots_visible"], "false": row["dots_false"],
            "part": 100 * row["dots_used"] / row["dots_visible"],
            **{name: row[f"{name}_px"] for name in (
                "relief", "true_rms", "true_max", "reported_rms", "reported_max",
                "reported_beyond_max", "held_out_max")}}
    return rows
