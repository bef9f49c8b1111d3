"""``ncdc bench truth``: calibration compared with cameras whose every ray is known."""

import re

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress
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
    parser.add_argument("--photos", type=int, choices=range(1, len(POSES) + 1), dest="sides",
                        help="photos of the page, from different sides (default: 1, and all)")
    parser.add_argument("--neurons", type=int, default=12, metavar="N",
                        help="hidden neurons (default: 12)")
    parser.add_argument("--dots", action="store_true", help="only detect, train nothing")
    add_json(parser)


def run(args):
    """Render, detect, train, compare.

    Returns 1 if a relief was found on the flat page, a point is false, or the reported maximum is
    less than the true one.
    """
    if not 1 <= args.neurons <= MAX_NEURONS:
        raise InputError(f"{args.neurons} hidden neurons are asked for, the limits are 1 and "
                         f"{MAX_NEURONS}")
    try:
        lenses = [lens for name, lens in LENSES.items() if re.search(args.only, name)]
    except re.error as error:
        raise InputError(f"--only is {args.only!r}, no regular expression: {error}") from error
    if not lenses:
        raise InputError(f"--only is {args.only!r}, no lens has such a name")
    jobs = [(lens, photos) for photos in ([args.sides] if args.sides else [1, len(POSES)])
            for lens in lenses]
    progress, rows = Progress("truth"), []
    for k, (lens, photos) in enumerate(jobs):
        progress(k / len(jobs), f" {lens.name}, {photos} photo{'s' * (photos > 1)}")
        points, dots = detect(lens, photos)
        row = {"lens": lens.name, "photos": photos,
               "dots_visible": sum(part.visible for part in dots),
               "dots_used": sum(part.used for part in dots),
               "dots_false": sum(part.false for part in dots)}
        rows.append(row if args.dots else row | measure(lens, points, args.neurons))
    progress(1)
    if not write_report({"rows": rows}, args.json):
        print(table(rows))
    return int(any(row["dots_false"] or row.get("relief_px") or
                   row.get("reported_max_px", 0) < row.get("true_max_px", 0) for row in rows))


def table(rows):
    """The rows as a table in Markdown, as in docs/explanation/calibration.md."""
    lines = ["| lens | photos | whole dots used; false | relief | map, true: rms / max px | "
             "reported: rms / max px | beyond the points: max px | held-out points: max px |",
             "|---|---|---|---|---|---|---|---|"]
    for row in rows:
        part = 100 * row["dots_used"] / max(row["dots_visible"], 1)
        cells = [row["lens"], row["photos"],
                 f"{row['dots_used']} of {row['dots_visible']}, {part:.1f} %; {row['dots_false']}"]
        if "true_rms_px" in row:
            beyond = row["reported_beyond_max_px"]
            cells += [f"{row['relief_px']:.3f}",
                      f"{row['true_rms_px']:.3f} / {row['true_max_px']:.3f}",
                      f"{row['reported_rms_px']:.3f} / {row['reported_max_px']:.3f}",
                      "" if beyond is None else f"{beyond:.3f}", f"{row['held_out_max_px']:.3f}"]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)
