"""``ncdc bench truth --flaws``: flaws of cameras and their standard errors, and the true ones.

Two lenses have their sensor tilted by half a degree to four degrees, each in another direction.
"""

from dataclasses import replace

import numpy as np

from ncdc_bench.truth.lenses import LENSES, TrueLens
from ncdc_bench.truth.synthetic import page_at, points_of, poses
from ncdc_bench.truth.true_flaws import FIGURES, compared
from ncdc_model.calibration.frame import ideal_frame

__all__ = ["CELLS", "TILTS", "failed", "jobs", "row_of", "table", "tilted"]

TILTS = 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0      # degrees
CELLS = {"dots": (32, 24), "chessboard": (14, 10)}
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


def jobs(photos=3):
    """(lens, target, photos) of each row."""
    return [(tilted(lens, degrees, number + len(TILTS) * (lens is _LENSES[1])), target, photos)
            for target in CELLS for lens in _LENSES for number, degrees in enumerate(TILTS)]


def row_of(lens, target, photos, share=1.0, seed=0):
    """A row of the report: figures, standard errors, and what of them fails."""
    pages = [page_at(lens, share, turns, CELLS[target]) for turns in poses(photos)]
    frame = ideal_frame(points_of(lens, pages, target, seed=seed))
    row = {"lens": lens.name, "target": target, "photos": photos, "page_share": share,
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
