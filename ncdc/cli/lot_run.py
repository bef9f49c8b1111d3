"""``ncdc lot run``: calibrates, trains and judges the units of a lot."""

import time
from pathlib import Path

from sqlalchemy import URL

from ncdc.cli.common import add_json, write_report
from ncdc.cli.lot_options import add_lot_options, checked_options, connected
from ncdc.lot.database import Database
from ncdc.lot.figures import FAIL, PASS, VERDICTS
from ncdc.lot.run import SchedulerLost, run_lot
from ncdc.lot.units import find_units
from ncdc.terminal import Progress, say
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "add_arguments", "database_at", "database_file", "run"]

EXAMPLE = "ncdc lot run units/ --target dots --neurons 8 --max-error 0.3 -o lot"

_FILE = "lot.db"


def add_arguments(parser) -> None:
    """Declare the action's arguments on an argparse parser."""
    parser.add_argument("units", metavar="UNITS",
                        help="a folder with a folder of photos per unit; a CSV with the columns "
                             "unit, photo and optionally station; or an address of either that "
                             "fsspec opens, such as s3://bucket/lot")
    add_lot_options(parser, timeout=3600.0)
    add_json(parser)


def database_file(output):
    """Path of the database of the lot in the folder ``output``; an address as it is."""
    return output if "://" in output else str(Path(output) / _FILE)


def database_at(output, create=False):
    """The :class:`Database` of a lot: in the folder ``output``, or at that address.

    Raises
    ------
    InputError
        If it cannot be opened, or there is none.
    """
    if "://" in output:
        return Database(output, create)
    path = Path(database_file(output))
    if create:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"cannot write {output}: {error.strerror}") from error
    elif not path.is_file():
        raise InputError(f"{output} holds no lot: there is no {path}")
    return Database(URL.create("sqlite", database=str(path)), create)


def run(args) -> int:
    """Run the lot; 1 if the scheduler was lost."""
    request, limits = checked_options(args)
    units = find_units(args.units)
    database = database_at(args.output, create=True)
    database.begin({**vars(request), **limits}, units, args.station)
    before = database.counts()
    status = _work(args, database, request, limits)
    report = {**database.counts(), "resumed": sum(before[name] for name in VERDICTS)}
    database.close()
    if not write_report(report, args.json):
        print(f"{report['units']} units: {report['pass']} pass, {report['look']} to look at, "
              f"{report['fail']} fail")
    return status


def _work(args, database, request, limits):
    """Judge every unit that waits, with progress; 1 if the scheduler was lost, else 0."""
    counts, forecast = database.counts(), None
    waiting = counts["units"] - sum(counts[name] for name in VERDICTS)
    if not waiting:
        return 0
    with connected(args) as workers:
        forecast = _Forecast(counts, waiting)
        try:
            for done in run_lot(database, workers, request, limits, args.station):
                forecast(done)
        except SchedulerLost:
            say(f"ncdc lot: the scheduler has gone after {forecast.done} of {waiting} units; the "
                f"same command goes on from there")
            return 1
    return 0


class _Forecast:
    """Progress of a run: what came out so far, and when the last unit will be judged."""

    def __init__(self, counts, waiting):
        self.counts, self.waiting, self.done = dict(counts), waiting, 0
        self.progress, self.start = Progress("lot"), time.monotonic()
        self.progress(0)

    def __call__(self, done):
        """Show that a unit is :class:`Done`; a line of its own says why it does not pass."""
        self.counts[done.verdict] += 1
        if done.before:
            self.counts[done.before] -= 1
        self.done += not done.before
        if done.verdict != PASS:
            say(f"{done.serial}: {done.verdict}: {done.reasons[-1 if done.before else 0]}")
        each = (time.monotonic() - self.start) / self.done
        end = time.localtime(time.time() + each * (self.waiting - self.done))
        self.progress(self.done / self.waiting,
                      f", {self.done} of {self.waiting} units, {self.counts[FAIL]} fail, "
                      f"{each:.1f} s a unit, done at {time.strftime('%H:%M', end)}")
