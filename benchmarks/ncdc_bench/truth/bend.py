"""``ncdc bench truth --bend``: pages that are not flat.

Three photos show a smooth bend: it must be found, and named or taken off. One photo does not: its
report should say what a bend would cost.
"""

import re

import numpy as np

from ncdc_bench.truth.bends import Bulge, Cylinder
from ncdc_bench.truth.lenses import LENSES
from ncdc_bench.truth.measure import found_points, measure
from ncdc_bench.truth.render import centroid, seen, whole
from ncdc_bench.truth.synthetic import page_at, poses

__all__ = ["PAGES", "failed", "jobs", "row_of", "summary", "table"]

_CELLS, _ACROSS = (64, 48), 40     # the page goes on beyond the picture, 40 columns fill it
_SHARE = _CELLS[0] / _ACROSS
PAGES = {
    "flat": None, "cylinder .1 %": Cylinder(.001, _ACROSS),
    "cylinder .3 %": Cylinder(.003, _ACROSS),
    "cylinder 1 %": Cylinder(.01, _ACROSS), "cylinder .3 %, askew": Cylinder(.003, _ACROSS, 35.0),
    "bulge": Bulge(.3, 7.7)}
"""Pages by name; the sag is that of the 40 steps that the picture shows."""
_LENS = LENSES["equidistant 105"]
_SEVERAL = 3           # photos that show a bend
_ERRORS, _SAG = 3.0, 0.15    # standard errors, or share of the true sag, that the found one is off
_OFF = 0.15            # pixels rms: a map with less is as of a flat page
_NAMED = re.compile(r"\b(bent|bend|bulge|curved|sag)\b")


def jobs(options):
    """(text, function that gives a row) of each page, seen from several sides and from one."""
    return [(f"{name}, {photos} photo{'s' * (photos > 1)}",
             lambda name=name, photos=photos: row_of(name, photos, options))
            for photos in ([options.photos] if options.photos else [3, 1]) for name in PAGES]


def row_of(name, photos, options):
    """Row of a page."""
    pages = [page_at(_LENS, _SHARE, turns, _CELLS, PAGES[name]) for turns in poses(photos)]
    row = {"page": name, "page_share": 1.0, **measure(
        _LENS, found_points(_LENS, pages, "dots", options.exact), options.neurons)}
    row |= {"sag_true_percent": _sag(pages),
            "named": any(map(_NAMED.search, row["warnings"]))}
    row["bent_max_px"] = row["reported_max_px"] + row["sag_true_percent"] * row["per_sag_px"]
    return row | {"fails": _fails(row)}


def _sag(pages):
    """Largest difference of height of the dots that a photo shows, above the plane that touches the
    page in the middle of them, in percent of the longest row or column that is seen."""
    if pages[0].bend is None:
        return 0.0
    most, length, steps = 0.0, 0, np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    for page in pages:
        index, outline, inside = seen(_LENS, page)
        index = index[whole(_LENS, page, index, centroid(outline), inside)]
        middle = (index.min(axis=0) + index.max(axis=0)) / 2
        height, near = (page.bend.bent(points - page.middle)[1]
                        for points in (index, middle + steps))
        slope = (near[1] - near[2]) / 2, (near[3] - near[4]) / 2
        most = max(most, float(np.ptp(height - (index - middle) @ slope)))
        length = max(length, int(np.ptp(index, axis=0).max()))
    return 100 * most / length


def _fails(row):
    """Names of the demands that a row does not meet."""
    found, flat = [], row["page"] == "flat"
    if flat and (row["named"] or row["sag_percent"] or row["relief_px"]):
        found.append("flat page")
    if row["photos"] >= _SEVERAL and not flat and not row["named"] and row["true_rms_px"] > _OFF:
        found.append("silent")
    # The stated px of a sag are those of a cylinder.
    if row["photos"] < _SEVERAL and isinstance(PAGES[row["page"]], Cylinder) and (
            row["bent_max_px"] < row["true_max_px"]):
        found.append("sag's effect")
    if row["sag_percent"] and not abs(row["sag_percent"] - row["sag_true_percent"]) <= max(
            _ERRORS * row["sag_error_percent"], _SAG * row["sag_true_percent"]):
        found.append("sag")
    return found


def failed(row):
    """Whether a row shows a defect."""
    return bool(row["fails"])


def table(rows):
    """The rows as a table in Markdown."""
    lines = ["| page | photos | map, true: rms / max px | reported: rms / max px | "
             "of this sag: max px | sag, true: % | named | fails |",
             "|---|---|---|---|---|---|---|---|"]
    for row in rows:
        lines.append("| " + " | ".join([
            row["page"], str(row["photos"]),
            f"{row['true_rms_px']:.3f} / {row['true_max_px']:.3f}",
            f"{row['reported_rms_px']:.3f} / {row['reported_max_px']:.3f}",
            f"{row['bent_max_px']:.3f}", _sag_cell(row), "yes" if row["named"] else "no",
            ", ".join(row["fails"])]) + " |")
    return "\n".join(lines)


def _sag_cell(row):
    true = f"{row['sag_true_percent']:.3f}"
    if row["sag_error_percent"] is None:
        return f"none, {true}"
    return f"{row['sag_percent']:.3f} ± {row['sag_error_percent']:.3f}, {true}"


def summary(rows):
    """Counts of rows by page."""
    return {name: {"rows": len(some), "failed": sum(map(failed, some))}
            for name in PAGES if (some := [row for row in rows if row["page"] == name])}
