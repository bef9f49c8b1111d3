"""``ncdc bench truth``: calibration compared with cameras whose every ray is known."""

import re

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress
from ncdc_bench.truth import aspect, bend, flaws, full, partial
from ncdc_bench.truth.boards import BOARDS
from ncdc_bench.truth.boards import POSES as BOARD_POSES
from ncdc_bench.truth.render import POSES
from ncdc_spec.errors import InputError
from ncdc_spec.formats import MAX_NEURONS

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run"]

HELP = "calibrate and train on rendered pages of exactly known lenses, compare report and truth"
EXAMPLE = "ncdc bench truth --only tilted --photos 1"
_PARTS = {"flaws": flaws, "partial": partial, "bend": bend, "aspect": aspect}


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--flaws", action="store_true",
                      help="tilt, decentring, axis, roll, focal length and aspect with their "
                           "standard errors, of sensors tilted by 0.5 to 4 degrees")
    what.add_argument("--partial", action="store_true",
                      help="pages that fill 55 to 100 %% of the picture's width")
    what.add_argument("--bend", action="store_true", help="pages that are bent")
    what.add_argument("--aspect", action="store_true",
                      help="focal length from one photo, with pixels that are not square")
    parser.add_argument("--exact-points", action="store_true", dest="exact",
                        help="the true points with noise, instead of rendered photos: faster")
    parser.add_argument("--only", default="", metavar="TEXT",
                        help="lenses whose name matches this regular expression only; with the "
                             "first four options, rows")
    parser.add_argument("--target", choices=("dots", *BOARDS), default="dots",
                        help="what the photos show: a page of dots (default), or a board")
    parser.add_argument("--photos", type=int, choices=range(1, len(BOARD_POSES) + 1),
                        help=f"photos of the page, from different sides (default: 1, and all: "
                             f"{len(POSES)} of a page of dots, {len(BOARD_POSES)} of a board)")
    parser.add_argument("--neurons", type=int, default=12, metavar="N",
                        help="hidden neurons (default: 12)")
    parser.add_argument("--dots", action="store_true", help="only detect, train nothing")
    add_json(parser)


def run(args):
    """Render, detect, train, compare.

    Returns 1 if a relief was found on the flat page, a point is false or misnumbered, the reported
    maximum is less than the true one, or a row of another part fails.
    """
    if not 1 <= args.neurons <= MAX_NEURONS:
        raise InputError(f"{args.neurons} hidden neurons are asked for, the limits are 1 and "
                         f"{MAX_NEURONS}")
    part = next((module for name, module in _PARTS.items() if getattr(args, name)), full)
    _check(args, part)
    jobs = _chosen(part.jobs(args), args.only)
    progress, rows = Progress("truth"), []
    for k, (text, row) in enumerate(jobs):
        progress(k / len(jobs), f" {text}")
        rows.append(row())
    progress(1)
    summary = {} if part is full else {"summary": part.summary(rows)}
    if not write_report({"rows": rows, **summary}, args.json):
        print(part.table(rows))
    return int(any(map(part.failed, rows)))


def _check(args, part):
    """Reject what a part of the bench cannot do."""
    most = len(POSES if args.target == "dots" else BOARD_POSES)
    if (args.photos or 1) > most:
        raise InputError(f"--photos is {args.photos}, of {args.target} there are at most {most}")
    if part is not full and args.target != "dots":
        raise InputError(f"--target {args.target} is of the bench without --flaws, --partial, "
                         f"--bend and --aspect, which choose their targets")
    if args.dots and (part is not full or args.exact):
        raise InputError("--dots is of rendered photos of the bench without --flaws, --partial, "
                         "--bend and --aspect: it measures what is detected")
    if args.exact and args.target not in ("dots", "chessboard"):
        raise InputError(f"--exact-points has dots and chessboard, no {args.target}")
    if part is aspect and args.photos not in (None, 1):
        raise InputError(f"--photos is {args.photos}, --aspect measures one photo at a time")


def _chosen(jobs, only):
    """The jobs whose text matches the regular expression ``only``."""
    try:
        chosen = [job for job in jobs if re.search(only, job[0])]
    except re.error as error:
        raise InputError(f"--only is {only!r}, no regular expression: {error}") from error
    if not chosen:
        raise InputError(f"--only is {only!r}, no lens has such a name")
    return chosen
