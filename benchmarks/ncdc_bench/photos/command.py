"""``ncdc bench photos``: calibration on photos that careless people take."""

import re
from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress
from ncdc_bench.photos.cases import CASES
from ncdc_bench.photos.measure import try_case
from ncdc_bench.photos.sheet import ContactSheet
from ncdc_bench.photos.targets import Bank
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run", "summary"]

HELP = "calibrate on photos blurred, dark, covered, turned, cut, of two targets and of none"
EXAMPLE = "ncdc bench photos --only charuco -o plots"
KINDS = "dots", "circles", "hexagonal", "staggered", "board", "charuco", "no target"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--data", default="tests/data", metavar="DIR",
                        help="folder of the real photos (default: tests/data of the repository)")
    parser.add_argument("--only", default="", metavar="TEXT",
                        help="cases whose name matches this regular expression only")
    parser.add_argument("--scale", type=float, default=1.0, metavar="PART",
                        help="of the rendered photos' size, from 0.5 (default: 1, 1280x960)")
    parser.add_argument("-o", "--output", metavar="DIR",
                        help="also write pictures of all photos with what was found")
    add_json(parser)


def run(args):
    """Make the photos, calibrate, compare and report; 1 if something false came out silently."""
    if not 0.5 <= args.scale <= 2:
        raise InputError(f"--scale is {args.scale:g}, the limits are 0.5 and 2")
    try:
        cases = [case for case in CASES if re.search(args.only, case.name)]
    except re.error as error:
        raise InputError(f"--only is {args.only!r}, no regular expression: {error}") from error
    if not cases:
        raise InputError(f"--only is {args.only!r}, no case has such a name")
    if args.output:
        check_outputs([Path(args.output) / "photos-1.jpg"], [])
    bank, progress, outcomes, sheet = Bank(args.data, args.scale), Progress("photos"), [], (
        ContactSheet())
    for k, case in enumerate(cases):
        progress(k / len(cases), f" {case.name}")
        photos = case.make(bank)
        found = try_case(case, photos)
        outcomes += found
        if args.output:
            for photo, outcome in zip(photos, found):
                sheet.add(photo, outcome)
    progress(1)
    if args.output:
        sheet.write(Path(args.output))
    report = {"rows": [_row(outcome) for outcome in outcomes], "summary": summary(outcomes)}
    if not write_report(report, args.json):
        print(table(outcomes))
    return int(any(outcome.silent for outcome in outcomes))


def _row(outcome):
    return {"case": outcome.case, "photo": outcome.photo, "expect": outcome.expect,
            "found": outcome.found, "visible": outcome.visible, "false": outcome.false,
            "cut_false": outcome.cut_false, "worst_px": outcome.worst,
            "rejected": outcome.rejected, "message": outcome.message, "used": outcome.used,
            "silent": outcome.silent, "right": outcome.right}


def summary(outcomes):
    """Counts by kind of target, one dict each, and of all."""
    groups = [(kind, [o for o in outcomes if o.case.startswith(kind)]) for kind in KINDS]
    rows = []
    for kind, group in [*groups, ("all", outcomes)]:
        usable = [o for o in group if o.expect == "use"]
        if group:
            rows.append({
                "kind": kind, "photos": len(group), "usable": len(usable),
                "usable_used": sum(o.used and not o.false for o in usable),
                "rejected": sum(o.rejected for o in group),
                "false_points": sum(o.false for o in group),
                "silent_false": sum(o.silent for o in group)})
    return rows


def table(outcomes):
    """Outcomes as text: the photos that fail their expectation, then counts."""
    lines = [f"{o.case}, photo {o.photo}: must {o.expect}; {o.found} points of {o.visible}, "
             f"{o.false} false{', SILENT' if o.silent else ''}; {o.message}"
             for o in outcomes if not o.right]
    lines.append("kind       photos  usable  used rejected  false points  false, no warning")
    for row in summary(outcomes):
        lines.append(f"{row['kind']:<10} {row['photos']:6d} {row['usable']:7d} "
                     f"{row['usable_used']:5d} {row['rejected']:8d} {row['false_points']:13d} "
                     f"{row['silent_false']:18d}")
    return "\n".join(lines)
