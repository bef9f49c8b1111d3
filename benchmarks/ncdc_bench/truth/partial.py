"""``ncdc bench truth --partial``: the map beyond a page that does not fill the picture.

The largest error that the report states must not be less than the true one. Else a warning must
name the share of the picture beyond the points.
"""

import re

import numpy as np

from ncdc_bench.truth.lenses import LENSES, SIZE, TrueLens
from ncdc_bench.truth.measure import found_points, measure
from ncdc_bench.truth.synthetic import page_at, poses

__all__ = ["LENSES_OF_PARTS", "SHARES", "failed", "jobs", "summary", "table"]

SHARES = 0.55, 0.65, 0.75, 0.85, 1.0      # of the picture's width
_FULL = 1.0
_RMS = 0.25            # of the stated rms on full pages, by which the true one may differ
_MIDDLE = (SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2
_NAMES = ("equidistant 105", "equisolid 110", "tilted sensor", "centre off", "pixels 1:1.06",
          "all flaws")
LENSES_OF_PARTS = (
    *(LENSES[name] for name in _NAMES),
    TrueLens("moustache", "opencv", 690.0, (_MIDDLE[0] - 5, _MIDDLE[1] + 3),
             (-.20, .085, 0.0, 0.0, -.011)),
    TrueLens("all flaws off centre", "opencv", 760.0, (609.5, 501.5),
             (-.26, .08, -.005, .004, -.01), (-.03, .035), .97),
    TrueLens("tilted by 5.4 deg", "equidistant", SIZE[0] / 2 / np.radians(50), _MIDDLE,
             tilt=(.08, -.05)))
"""Nine lenses, three of which are not among those of ``ncdc bench truth``."""


def jobs(options):
    """(text, function that gives a row) of each lens and share."""
    return [(f"{lens.name}, {100 * share:.0f} %",
             lambda lens=lens, share=share: row_of(lens, share, options))
            for share in SHARES for lens in LENSES_OF_PARTS]


def row_of(lens, share, options):
    """Row of a page that fills a ``share`` of the width of the picture of ``lens``."""
    pages = [page_at(lens, share, turns) for turns in poses(options.photos or 1)]
    row = {"page_share": share, **measure(
        lens, found_points(lens, pages, "dots", options.exact), options.neurons)}
    row["beyond_named"] = any(re.search(r"\d %.*\bbeyond\b", text) for text in row["warnings"])
    return row | {"fails": _fails(row)}


def _fails(row):
    """Names of the demands that a row does not meet."""
    found, full = [], row["page_share"] >= _FULL
    if row["reported_max_px"] < row["true_max_px"] and (full or not row["beyond_named"]):
        found.append("maximum")
    if full and abs(row["true_rms_px"] / row["reported_rms_px"] - 1) > _RMS:
        found.append("rms")
    return found


def failed(row):
    """Whether a row shows a defect."""
    return bool(row["fails"])


def summary(rows):
    """Counts of rows by share of the page."""
    return {f"{100 * share:.0f}": {
        "rows": len(some), "maximum_too_small": sum(
            row["reported_max_px"] < row["true_max_px"] for row in some),
        "beyond_named": sum(row["beyond_named"] for row in some),
        "failed": sum(map(failed, some))}
        for share in SHARES if (some := [row for row in rows if row["page_share"] == share])}


def table(rows):
    """The rows as a table in Markdown."""
    lines = ["| lens | page, part of the width | beyond the points | map, true: rms / max px | "
             "reported: rms / max px | warned | fails |", "|---|---|---|---|---|---|---|"]
    for row in rows:
        beyond = row["beyond_percent"]
        lines.append("| " + " | ".join([
            row["lens"], f"{100 * row['page_share']:.0f} %",
            "" if beyond is None else f"{beyond:.0f} %",
            f"{row['true_rms_px']:.3f} / {row['true_max_px']:.3f}",
            f"{row['reported_rms_px']:.3f} / {row['reported_max_px']:.3f}",
            "of the share" if row["beyond_named"] else "otherwise" if row["warned"] else "no",
            ", ".join(row["fails"])]) + " |")
    return "\n".join(lines)
