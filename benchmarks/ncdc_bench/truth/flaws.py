"""``ncdc bench truth --flaws``: flaws of cameras and their standard errors, and the true ones.

Two lenses have their sensor tilted by half a degree to four degrees, each in another direction.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from ncdc_bench.truth.lenses import LENSES, TrueLens
from ncdc_bench.truth.measure import found_points, page_in_front
from ncdc_bench.truth.true_flaws import FIGURES, compared
from ncdc_model.calibration.frame import ideal_frame

__all__ = ["TARGETS", "TILTS", "failed", "jobs", "row_of", "summary", "table", "tilted"]

TILTS = 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0      # degrees
TARGETS = "dots", "chessboard"
_PHOTOS = 3
_LENSES = (LENSES["equidistant 105"],
           TrueLens("perspective 760", "opencv", 760.0, (642.5, 475.5),
                    (-.26, .08, .0004, -.0003, -.01)))
_FIRST, _NEXT = 37.0, 103.0    # degrees: direction of the first tilt, and from one to the next
_LIMIT = 2.25          # degrees of tilt: a limit that no true tilt is near
_ERRORS, _SHARE, _SHOWN, _LARGE = 3.0, 0.10, 1.5, 0.3      # of the pass columns


def tilted(lens, degrees, number):
    """``lens`` with its sensor tilted; the direction goes with ``number``."""
    turn = np.radians(_FIRST + _NEXT * number)
    return replace(lens, name=f"{lens.name}, {degrees:g} deg", tilt=tuple(
        np.radians(degrees) * np.array([np.cos(turn), np.sin(turn)])))


def jobs(options):
    """(text, function that gives a row) of each target, lens and tilt."""
    found = []
    for target in TARGETS:
        for first, lens in enumerate(_LENSES):
            for number, degrees in enumerate(TILTS):
                lens_here = tilted(lens, degrees, number + first * len(TILTS))
                found.append((f"{lens_here.name}, {target}", partial(
                    row_of, lens_here, target, options.photos or _PHOTOS, options.exact)))
    return found


def row_of(lens, target, photos, exact, seed=0):
    """A row of the report: figures, standard errors, and what of them fails."""
    pages = [page_in_front(lens, target, number) for number in range(photos)]
    frame = ideal_frame(found_points(lens, pages, target, exact, seed))
    row = {"lens": lens.name, "target": target, "photos": photos, "page_share": 1.0,
           **compared(lens, pages[0], frame)}
    return row | {"fails": _fails(row)}


def _fails(row):
    """Names of the demands that a row does not meet."""
    found = []
    for name in FIGURES:
        kind, _, unit = name.partition("_")
        true, value, error = (row[f"{kind}{word}{'_' * bool(unit)}{unit}"]
                              for word in ("_true", "", "_error"))
        if not abs(value - true) <= _ERRORS * error:
            found.append(f"{kind} off")
    true, value, error = (row[f"tilt{word}_deg"] for word in ("_true", "", "_error"))
    if true >= _SHOWN and not abs(value - true) <= _SHARE * true:
        found.append("tilt 10 %")
    if not error <= _LARGE:
        found.append("tilt error")
    # A unit fails or passes a limit when value -+ 2 errors says so.
    if true <= _LIMIT < value - 2 * error:
        found.append("good unit failed")
    if true > _LIMIT >= value + 2 * error:
        found.append("bad unit passed")
    return found


def failed(row):
    """Whether a row shows a defect."""
    return bool(row["fails"])


def summary(rows):
    """Counts of rows by target."""
    return {target: {"rows": len(some), "failed": sum(map(failed, some)),
                     "largest_tilt_error_deg": max(row["tilt_error_deg"] for row in some)}
            for target in TARGETS if (some := [row for row in rows if row["target"] == target])}


def table(rows):
    """The rows as a table in Markdown."""
    lines = ["| lens | target | tilt, true: deg | decentring, true: px | axis, true: px | "
             "focal length, true: px | aspect, true | roll, true: deg | fails |",
             "|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        cells = [row["lens"], row["target"]]
        for kind, unit, digits in (("tilt", "_deg", 2), ("decentring", "_px", 2),
                                   ("axis", "_px", 2), ("focal", "_px", 2), ("aspect", "", 5),
                                   ("roll", "_deg", 3)):
            value, error, true = (row[f"{kind}{word}{unit}"] for word in ("", "_error", "_true"))
            cells.append(f"{value:.{digits}f} ± {error:.{digits}f}, {true:.{digits}f}")
        lines.append("| " + " | ".join([*cells, ", ".join(row["fails"])]) + " |")
    return "\n".join(lines)
