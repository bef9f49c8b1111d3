"""``ncdc bench truth``: calibration compared with cameras whose every ray is known."""

import re

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress
from ncdc_bench.truth.boards import BOARDS
from ncdc_bench.truth.boards import POSES as BOARD_POSES
from ncdc_bench.truth.corners import corner_row, detect_boards
from ncdc_bench.truth.lenses import LENSES
from ncdc_bench.truth.measure import detect, measure
from ncdc_bench.truth.render import POSES
from ncdc_spec.errors import InputError
from ncdc_spec.formats import MAX_NEURONS

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run", "table"]

HELP = "calibrate and train on rendered pages of exactly known lenses, compare report and truth"
EXAMPLE = "ncdc bench truth --only tilted --photos 1"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--only", default="", metavar="TEXT",
                        help="lenses whose name matches this regular expression only")
    parser.add_argument("--target", choices=("dots", *BOARDS), default="dots",
                        help="what the photos show: a page of dots (default), or a board")
    parser.add_argument("--photos", type=int, choices=range(1, len(BOARD_POSES) + 1), dest="sides",
                        help=f"photos of the page, from different sides (default: 1, and all: "
                             f"{len(POSES)} of a page of dots, {len(BOARD_POSES)} of a board)")
    parser.add_argument("--neurons", type=int, default=12, metavar="N",
                        help="hidden neurons (default: 12)")
    parser.add_argument("--dots", action="store_true", help="only detect, train nothing")
    add_json(parser)


def run(args):
    """Render, detect, train, compare.

    Returns 1 if a relief was found on the flat page, a point is false or misnumbered, or the
    reported maximum is less than the true one.
    """
    most = len(POSES if args.target == "dots" else BOARD_POSES)
    if not 1 <= args.neurons <= MAX_NEURONS:
        raise InputError(f"{args.neurons} hidden neurons are asked for, the limits are 1 and "
                         f"{MAX_NEURONS}")
    try:
        lenses = [lens for name, lens in LENSES.items() if re.search(args.only, name)]
    except re.error as error:
        raise InputError(f"--only is {args.only!r}, no regular expression: {error}") from error
    if not lenses:
        raise InputError(f"--only is {args.only!r}, no lens has such a name")
    if (args.sides or 1) > most:
        raise InputError(f"--photos is {args.sides}, of {args.target} there are at most {most}")
    jobs = [(lens, photos) for photos in ([args.sides] if args.sides else [1, most])
            for lens in lenses]
    progress, rows = Progress("truth"), []
    for k, (lens, photos) in enumerate(jobs):
        progress(k / len(jobs), f" {lens.name}, {photos} photo{'s' * (photos > 1)}")
        points, found = _found(args.target, lens, photos)
        row = {"lens": lens.name, "target": args.target, "photos": photos, **found}
        rows.append(row if args.dots else row | measure(lens, points, args.neurons))
    progress(1)
    if not write_report({"rows": rows}, args.json):
        print(table(rows))
    return int(any(row.get("dots_false") or row.get("corners_misnumbered") or row.get("relief_px")
                   or row.get("reported_max_px", 0) < row.get("true_max_px", 0) for row in rows))


def _found(target, lens, photos):
    """The points that are detected on the photos, and the row's fields on them."""
    if target in BOARDS:
        points, corners = detect_boards(lens, target, photos)
        return points, corner_row(corners)
    points, dots = detect(lens, photos)
    return points, {"dots_visible": sum(part.visible for part in dots),
                    "dots_used": sum(part.used for part in dots),
                    "dots_false": sum(part.false for part in dots)}


def table(rows):
    """The rows as a table in Markdown, as in docs/explanation/calibration.md."""
    boards = any("corners_used" in row for row in rows)
    points = ("corners used; misnumbered; rms / max px" if boards else "whole dots used; false")
    lines = [f"| lens | photos | {points} | relief | map, true: rms / max px | "
             "reported: rms / max px | beyond the points: max px | held-out points: max px |",
             "|---|---|---|---|---|---|---|---|"]
    for row in rows:
        cells = [row["lens"], row["photos"], _points_cell(row)]
        if "true_rms_px" in row:
            beyond = row["reported_beyond_max_px"]
            cells += [f"{row['relief_px']:.3f}",
                      f"{row['true_rms_px']:.3f} / {row['true_max_px']:.3f}",
                      f"{row['reported_rms_px']:.3f} / {row['reported_max_px']:.3f}",
                      "" if beyond is None else f"{beyond:.3f}", f"{row['held_out_max_px']:.3f}"]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def _points_cell(row):
    """How many points of a row were used, and how well."""
    kind, wrong = (("dots", "dots_false") if "dots_used" in row else
                   ("corners", "corners_misnumbered"))
    used, visible = row[f"{kind}_used"], row[f"{kind}_visible"]
    text = f"{used} of {visible}, {100 * used / max(visible, 1):.1f} %; {row[wrong]}"
    if row.get("corner_rms_px") is not None:
        text += f"; {row['corner_rms_px']:.3f} / {row['corner_max_px']:.3f}"
    return text
