"""Numbers of the benches of maps that pages may quote.

Each function takes a report and gives nested dicts: tables of rows, rows of figures.
"""

__all__ = ["by_lens", "lines", "nodes"]


def _word(name):
    return name.replace("-", "_").lower()


def by_lens(report):
    """A row for each map, with MSE and largest error on each lens: ``pc105_mse``, in px²."""
    rows = {}
    for row in report["rows"]:
        name, neurons = row["model"], row["hidden_neurons"]
        title = f"`{name}`, HN {neurons}" if neurons else f"`{name}`"
        figures = rows.setdefault(_word(f"{name}_{neurons}" if neurons else name), {"map": title})
        kind = "fixed_" if name == "ncdc" else ""       # of a network: the integers'
        figures |= {f"{row['lens'].lower()}_{part}": row[kind + part] for part in ("mse", "max")}
    return rows


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
