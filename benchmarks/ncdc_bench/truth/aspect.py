"""``ncdc bench truth --aspect``: the focal length from one photo, with pixels that are not square.

It is within 1 % of the true one, or its standard error is larger: then it is not determined. Fits
of a page may end in another minimum, so each aspect is measured in ten poses.
"""

from dataclasses import replace

import numpy as np

from ncdc_bench.truth.lenses import LENSES, SIZE
from ncdc_bench.truth.measure import found_points
from ncdc_bench.truth.synthetic import page_at, poses
from ncdc_bench.truth.true_flaws import compared
from ncdc_model.calibration.frame import ideal_frame

__all__ = ["ASPECTS", "failed", "jobs", "row_of", "summary", "table"]

ASPECTS = 0.90, 0.94, 0.97, 1.0, 1.03, 1.06, 1.09, 1.12
_POSES = 10
_LENS = replace(LENSES["equidistant 105"], name="equidistant 100",
                focal=SIZE[0] / 2 / np.radians(50), centre=(642.5, 477.5))
_CLOSE = 0.01          # of the focal length
_CELLS = 64, 48        # the page goes on beyond the picture
_ACROSS = 40           # of its columns fill the width


def jobs(options):
    """(text, function that gives a row) of each aspect and pose."""
    return [(f"aspect {aspect:g}, pose {pose}",
             lambda aspect=aspect, pose=pose: row_of(aspect, pose, options.exact))
            for aspect in ASPECTS for pose in range(_POSES)]


def row_of(aspect, pose, exact):
    """Row of one photo in pose number ``pose``."""
    lens = replace(_LENS, aspect=aspect)
    page = page_at(lens, _CELLS[0] / _ACROSS, poses(_POSES)[pose], _CELLS)
    points = found_points(lens, [page], "dots", exact, pose)
    row = {"lens": lens.name, "target": "dots", "photos": 1, "page_share": 1.0, "pose": pose,
           **compared(lens, page, ideal_frame(points))}
    off, error = abs(row["focal_px"] / row["focal_true_px"] - 1), (
        row["focal_error_px"] / row["focal_px"])
    return row | {"determined": error <= _CLOSE,
                  "fails": ["focal length"] if error <= _CLOSE < off else []}


def failed(row):
    """Whether a row shows a defect."""
    return bool(row["fails"])


def summary(rows):
    """Counts of rows by aspect."""
    found = {}
    for aspect in ASPECTS:
        if some := [row for row in rows if row["aspect_true"] == aspect]:
            off = [abs(row["focal_px"] / row["focal_true_px"] - 1) for row in some]
            found[f"{aspect:g}"] = {
                "rows": len(some), "determined": sum(row["determined"] for row in some),
                "within_percent": sum(part <= _CLOSE for part in off),
                "worst_percent": 100 * max(off), "failed": sum(map(failed, some))}
    return found


def table(rows):
    """Counts by aspect as a table in Markdown."""
    lines = ["| aspect | photos | determined | within 1 % | largest error of the focal length | "
             "fail |", "|---|---|---|---|---|---|"]
    for aspect, row in summary(rows).items():
        lines.append(f"| {aspect} | {row['rows']} | {row['determined']} | {row['within_percent']} "
                     f"| {row['worst_percent']:.2f} % | {row['failed']} |")
    return "\n".join(lines)
