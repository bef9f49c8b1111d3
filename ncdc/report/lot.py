"""The page on a production lot: yield, figures, trend, outliers, and a row per unit."""

import base64
import json

import numpy as np

from ncdc.lot.figures import ERRORS, FIGURES, PASS, VERDICTS
from ncdc.report.embedded import embedded_plot
from ncdc.report.lot_plots import COLOURS, plot_histograms, plot_trend
from ncdc.report.page import write_lot_page

__all__ = ["capability", "control_limits", "write_report"]

_SHOWN = 10             # outliers, and worst units, with a picture
_SIGMAS = 3.0
_DEVIATION = 1.4826     # standard deviation over median absolute deviation, if normal
_JUDGED = tuple(figure for figure in FIGURES if figure.name not in ("points", "photos_used"))


def control_limits(values, magnitude=False):
    """Median, and the limits that 99.7 % of units keep if nothing is wrong: (low, middle, high).

    The limits are three standard deviations from the median, by the median absolute deviation:
    bad units do not widen them. A ``magnitude`` has no lower limit, and the deviation is that of
    the upper half, which is the longer one. Not-a-number without values.
    """
    values = values[np.isfinite(values)]
    if not len(values):
        return np.nan, np.nan, np.nan
    middle = float(np.median(values))
    off = values[values >= middle] - middle if magnitude else np.abs(values - middle)
    reach = _SIGMAS * _DEVIATION * float(np.median(off))
    return (-np.inf if magnitude else middle - reach), middle, middle + reach


def capability(values, errors, low, high):
    """How well units keep limits, as a dict; empty without a limit or two values.

    ``cp``: width of the limits over six standard deviations of the units, None if there is but one
    limit. ``cpk``: distance of the mean from the nearer limit over three. ``error``: root mean
    square of the standard ``errors``, None without one. ``cp_without_error`` and
    ``cpk_without_error``: by the standard deviation without what the errors add to it; None if
    they explain all of it, or are not known.
    """
    known = np.isfinite(values)
    values, errors = values[known], errors[known]
    errors = errors[np.isfinite(errors)]
    if len(values) < 2 or (low is None and high is None):
        return {}
    sigma, mean = float(np.std(values, ddof=1)), float(np.mean(values))
    error = float(np.sqrt(np.mean(errors**2))) if len(errors) else None
    alone = None if error is None else float(np.sqrt(max(sigma**2 - error**2, 0)))
    nearest = min(side for side in (None if low is None else mean - low,
                                 None if high is None else high - mean) if side is not None)
    width = None if low is None or high is None else high - low
    result = {"mean": mean, "sigma": sigma, "error": error}
    for name, spread in (("", sigma), ("_without_error", alone)):
        result |= {f"cp{name}": width / (6 * spread) if spread and width is not None else None,
                   f"cpk{name}": nearest / (3 * spread) if spread else None}
    return result


def write_report(path, database, title):
    """Write the page on the lot in a :class:`ncdc.lot.database.Database`; return its figures.

    Numbers of all units are in memory, 8 bytes each; rows and pictures are not.
    """
    counts, options = database.counts(), json.loads(database.fact("request"))
    table = database.columns(["serial", "verdict", "cause", "station", "judged", "seconds",
                              *(figure.name for figure in FIGURES), *ERRORS])
    control = {figure.name: control_limits(table[figure.name], figure.magnitude)
               for figure in _JUDGED}
    far = _far(table, control)
    plots = [(figure, table[figure.name], control[figure.name],
              [limit for limit in figure.bounds(options) if limit is not None])
             for figure in _JUDGED]
    unknown = np.full(len(far), np.nan)
    able = {figure.name: found for figure in _JUDGED if (found := capability(
        table[figure.name], table.get(figure.error, unknown), *figure.bounds(options)))}
    sections = [
        {"title": "Yield", "text": _yield_text(counts), "rows": _stations(table)},
        {"title": "Causes", "rows": _causes(table)} if table["cause"][1] else None,
        {"title": "Figures",
         "text": "Bars: units. Dashed: control limits, three standard deviations from the median "
                 "as the middle units scatter. What is best at zero has an upper one only. Red: "
                 "limits of the verdict.",
         "pictures": [embedded_plot(plot_histograms, plots)], "rows": _statistics(plots)},
        {"title": "Capability",
         "text": "Cp: width of the limits over six standard deviations of all units, bad ones "
                 "included. Cpk: distance of the mean from the nearer limit over three. The last "
                 "two columns are without what the error of the measurement adds to the spread.",
         "rows": _capabilities(able)} if able else None,
        {"title": "Trend", "text": "Units in the order of judgement, each station in a colour. "
         "Dashed: control limits. Red: limits of the verdict.",
         "legend": _legend(table["station"][1]),
         "pictures": [embedded_plot(plot_trend, plots, table["station"][0])]}]
    outliers, worst = _outliers(database, table, far, control), _worst(database, table)
    write_lot_page(path, title, _lead(database, counts, options), list(filter(None, sections)),
                   groups=[("Outliers", f"Units with a figure outside its control limits: "
                            f"{int((far > 1).sum())}. These are the farthest.", outliers),
                           ("Worst ten", "The largest errors of the map.", worst)],
                   columns=["unit", "verdict", "cause", "station", "judged (UTC)",
                            *(title for figure in FIGURES for title in _titles(figure))],
                   rows=map(_row, database.rows()))
    return {**counts, "outliers": int((far > 1).sum()),
            "control_limits": {name: list(limits) for name, limits in control.items()},
            "capability": able}


def _lead(database, counts, options):
    waiting = counts["units"] - sum(counts[name] for name in VERDICTS)
    return (f"{counts['units']} units{f', of which {waiting} wait' if waiting else ''}. Target "
            f"{options['target']}, {options['neurons'] or 'the fewest'} hidden neurons, seed "
            f"{options['seed']}.")


def _yield_text(counts):
    judged = max(1, sum(counts[name] for name in VERDICTS))
    return ", ".join(f"{counts[name]} {name} ({100 * counts[name] / judged:.1f} %)"
                     for name in VERDICTS) + "."


def _stations(table):
    """Rows of the table of stations."""
    number, names = table["station"]
    verdict, verdicts = table["verdict"]
    passed = verdict == (verdicts.index(PASS) if PASS in verdicts else -1)
    rows = [("station", "units", "pass", "largest error, median", "seconds a unit")]
    for k, name in enumerate(names):
        on = number == k
        rows.append((name, int(on.sum()), f"{100 * passed[on].mean():.1f} %",
                     _median(table["max_error_px"][on], "px", 3),
                     _median(table["seconds"][on], "s", 1)))
    return rows


def _median(values, unit, digits):
    values = values[np.isfinite(values)]
    return f"{np.median(values):.{digits}f} {unit}" if len(values) else "-"


def _causes(table):
    """Rows of the table of causes, most frequent first."""
    number, names = table["cause"]
    found = sorted(((int((number == k).sum()), name) for k, name in enumerate(names) if name),
                   reverse=True)
    return [("cause", "units"), *((name, count) for count, name in found)]


def _legend(names):
    """Colour and name of each station, if there are several."""
    return [(COLOURS[k % len(COLOURS)], name) for k, name in enumerate(names)
            if len(names) > 1]


def _statistics(plots):
    rows = [("figure", "median", "control limits", "outside", "limits")]
    for figure, values, (low, middle, high), limits in plots:
        if not np.isfinite(middle):
            continue
        outside = int(((values < low) | (values > high)).sum())
        rows.append((figure.title, figure.text(middle), _usual(figure, low, high), outside,
                     ", ".join(map(figure.text, limits)) or "-"))
    return rows


def _usual(figure, low, high):
    """Control limits in words."""
    if not np.isfinite(low):
        return f"up to {figure.text(high)}"
    return f"{figure.text(low)} to {figure.text(high)}"


def _capabilities(able):
    rows = [("figure", "mean", "standard deviation", "Cp", "Cpk", "error of a unit",
             "Cp without the error", "Cpk without the error")]
    for figure in _JUDGED:
        if found := able.get(figure.name):
            ratios = (found[name] for name in ("cp", "cpk", "cp_without_error",
                                               "cpk_without_error"))
            cp, cpk, *without = ("-" if ratio is None else f"{ratio:.2f}" for ratio in ratios)
            rows.append((figure.title, figure.text(found["mean"]), figure.text(found["sigma"]),
                         cp, cpk, figure.text(found["error"]), *without))
    return rows


def _far(table, control):
    """How far each unit is out, at most, as a part of the control limits' distance."""
    far = np.zeros(len(table["seconds"]))
    for name, (low, middle, high) in control.items():
        if high > middle:
            off = (table[name] - middle) / (high - middle)
            far = np.fmax(far, np.abs(off) if np.isfinite(low) else off)
    return far


def _outliers(database, table, far, control):
    order = np.argsort(-far, kind="stable")[:_SHOWN]
    return [_card(database, table, k, control) for k in order if far[k] > 1]


def _worst(database, table):
    error = table["max_error_px"]
    order = np.argsort(np.where(np.isfinite(error), -error, np.inf), kind="stable")[:_SHOWN]
    return [_card(database, table, k) for k in order if np.isfinite(error[k])]


def _card(database, table, k, control=None):
    """What the page shows of unit ``k`` of the table: its row, and its picture.

    ``control``: control limits by figure; the text names the figures outside them.
    """
    number, names = table["serial"]
    row = database.unit(names[number[k]])
    picture = database.picture(row["serial"])
    return {"serial": row["serial"], "verdict": row["verdict"],
            "text": "; ".join([*row["reasons"], *_outside(row, control)]) or _figures(row),
            "picture": "data:image/jpeg;base64," + base64.b64encode(picture).decode()
            if picture else ""}


def _outside(row, control):
    """Sentences on the figures outside their control limits."""
    for figure in _JUDGED if control else ():
        value, (low, _, high) = row[figure.name], control[figure.name]
        if value is not None and low < high and not low <= value <= high:
            yield f"{figure.title} {figure.text_of(row)}, {_usual(figure, low, high)} is usual"


def _figures(row):
    return ", ".join(f"{figure.title} {figure.text_of(row)}" for figure in _JUDGED)


def _titles(figure):
    """Titles of a figure's columns: the figure, and its standard error if it has one."""
    title = f"{figure.title}, {figure.unit}".rstrip(", ")
    return [title, "±"] if figure.error else [title]


def _row(row):
    """Row of the table of all units, as JSON that a script element can hold."""
    numbers = [(row[name], figure.digits + 1) for figure in FIGURES
               for name in (figure.name, figure.error) if name]
    cells = [row["serial"], row["verdict"], row["cause"], row["station"],
             f"{row['judged']:%Y-%m-%d %H:%M:%S}",
             *(None if value is None else round(value, digits) for value, digits in numbers),
             row["reasons"]]
    return json.dumps(cells).replace("<", "\\u003c")
