"""``ncdc bench lot``: a lot of synthetic units with known flaws, and kills in between."""

import tempfile
from pathlib import Path

from ncdc.cli.common import add_json, report_failures, write_report
from ncdc.terminal import Progress
from ncdc.text_table import text_table
from ncdc_bench.lot.units import BAD, make_lot, write_photos
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run"]

HELP = "judge a lot of synthetic units with known flaws, killed in between, and compare with truth"
EXAMPLE = "ncdc bench lot --units 200 --bad 60 --kill"

_COLUMNS = ("units", "workers", "passed_bad", "failed_good", "looked_at_good", "seconds_per_unit",
            "kills", "resumed", "repeated", "lost", "worst_flaw_percent")


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--units", type=int, default=200, metavar="N",
                        help="units of the lot (default: 200)")
    parser.add_argument("--bad", type=int, metavar="N",
                        help=f"how many of them are bad, in {len(BAD)} ways (default: 3 of 10)")
    parser.add_argument("--workers", type=int, default=2, metavar="N",
                        help="worker processes (default: 2)")
    parser.add_argument("--seed", type=int, default=0, metavar="S",
                        help="of the flaws (default: 0)")
    parser.add_argument("--kill", action="store_true",
                        help="kill a worker, the driver and the scheduler, and go on each time")
    parser.add_argument("--folder", metavar="FOLDER",
                        help="store photos and database there (default: a temporary folder)")
    add_json(parser)


def run(args):
    """Write photos, run the lot, compare; 1 if a bad unit passes, or one is lost or repeated."""
    from ncdc_bench.lot.judgement import compared  # SQLAlchemy takes half a second
    from ncdc_bench.lot.processes import KILLS, run_with_kills

    bad = args.units * 3 // 10 if args.bad is None else args.bad
    if not 0 <= bad <= args.units or args.units < 1 or args.workers < 1:
        raise InputError(f"{args.units} units, {bad} bad ones and {args.workers} workers are "
                         f"asked for; 1 unit and worker or more are needed, and no more bad ones "
                         f"than units")
    if args.kill and args.units < 3 * len(KILLS):
        raise InputError(f"{args.units} units are too few to kill {len(KILLS)} processes in "
                         f"between, {3 * len(KILLS)} are needed")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(args.folder or temporary)
        units, progress = list(make_lot(args.units, bad, args.seed)), Progress("photos")
        for number, unit in enumerate(units):
            progress(number / len(units))
            write_photos(folder / "units", unit)
        progress(1)
        seconds, kills = run_with_kills(folder, args.workers, KILLS if args.kill else ())
        row = {"workers": args.workers, "kills": kills, "seconds": seconds,
               **compared(folder / "lot", units)}
    row["seconds_per_unit"] = seconds / row["units"]
    if not write_report({"rows": [row]}, args.json):
        print(text_table([(name, lambda row, name=name: _shown(row[name])) for name in _COLUMNS],
                         [row]))
        print(f"1000 units would take {1000 * row['seconds_per_unit'] / 3600:.1f} hours")
    return report_failures("bench lot", _failures(row))


def _shown(value):
    return f"{value:.3g}" if isinstance(value, float) else value


def _failures(row):
    """Sentences on what must not be."""
    texts = {"passed_bad": "bad units passed", "lost": "units have no verdict",
             "repeated": "units were judged twice"}
    found = [f"{row[name]} {text}" for name, text in texts.items() if row[name]]
    disturbed = row["failed_good"] + row["looked_at_good"]
    if disturbed > .03 * row["good"]:
        found.append(f"{disturbed} of {row['good']} good units failed or are to be looked at, 3 % "
                     f"is the limit")
    return found
