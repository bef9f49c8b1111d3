"""``ncdc lot run``: calibrates, trains and judges the units of a lot."""

import socket
import time
from pathlib import Path

from sqlalchemy import URL

from ncdc.cli.common import add_json, add_page, write_report
from ncdc.cli.train import neurons_of, size_of
from ncdc.lot.database import Database
from ncdc.lot.figures import FAIL, FIGURES, LIMITS, PASS, VERDICTS, check_limits
from ncdc.lot.run import SchedulerLost, run_lot
from ncdc.lot.units import STATION_LENGTH, find_units
from ncdc.lot.work import Request
from ncdc.terminal import Progress, say
from ncdc_model.training.choose import GOAL
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import BAYERS
from ncdc_spec.interpolation import DEFAULT, INTERPOLATIONS

__all__ = ["EXAMPLE", "add_arguments", "database_at", "database_file", "run"]

EXAMPLE = "ncdc lot run units/ --target dots --neurons 8 --max-error 0.3 -o lot"

_FILE = "lot.db"
_MAX_TIMEOUT = 1_000_000            # seconds: more than a week


def add_arguments(parser) -> None:
    """Declare the action's arguments on an argparse parser."""
    parser.add_argument("units", metavar="UNITS",
                        help="a folder with a folder of photos per unit; a CSV with the columns "
                             "unit, photo and optionally station; or an address of either that "
                             "fsspec opens, such as s3://bucket/lot")
    parser.add_argument("-o", "--output", default="lot", metavar="LOT",
                        help="folder of the lot, whose lot.db has the results (default: lot); or "
                             "an address of SQLAlchemy, such as postgresql+psycopg://host/lot")
    work = parser.add_argument_group("calibration and training, as of ncdc calibrate and train")
    work.add_argument("--target", default="auto", metavar="KIND",
                      help="dots, circles:CxR, acircles:CxR, chessboard:CxR, charuco:CxR, or auto "
                           "(default)")
    add_page(work)
    work.add_argument("--neurons", type=neurons_of, default=8, metavar="N",
                      help="hidden neurons (default: 8); auto: the fewest that meet --max-error")
    work.add_argument("--seed", type=int, default=0, metavar="S",
                      help="same seed, same networks (default: 0)")
    work.add_argument("--size", metavar="WxH", help="corrected picture (default: the camera's)")
    work.add_argument("--zoom", metavar="Z", help="fit (default), fill, or a magnification")
    work.add_argument("--bayer", choices=BAYERS, default="RGGB",
                      help="colour filter of the sensor (default: RGGB)")
    work.add_argument("--interpolation", choices=list(INTERPOLATIONS), default=DEFAULT.name,
                      help=f"of the hardware (default: {DEFAULT.name})")
    _add_limits(parser.add_argument_group("limits; a unit that violates one fails"))
    where = parser.add_argument_group("where the work is done")
    where.add_argument("--workers", type=int, metavar="N",
                       help="processes on this machine (default: one per processor)")
    where.add_argument("--scheduler", metavar="ADDRESS",
                       help="Dask scheduler whose workers do the work, such as tcp://10.0.0.5:8786")
    where.add_argument("--timeout", type=float, default=3600.0, metavar="SECONDS",
                       help="longest work on a unit: after that its worker ends, and the unit runs "
                            "again as after a crash (default: 3600)")
    where.add_argument("--station", default=socket.gethostname(), metavar="NAME",
                       help="name of the station, for units whose CSV has none (default: the name "
                            "of this machine)")
    add_json(parser)


def _add_limits(parser):
    for figure in FIGURES:
        for option, kind in ((figure.low, "smallest"), (figure.high, "largest")):
            if not option:
                continue
            default = LIMITS[option]
            text = f"{default:g}" if default is not None else "no limit"
            title = figure.title if option != "max_error" else "error of the map anywhere"
            parser.add_argument(f"--{option.replace('_', '-')}", type=float, default=default,
                                metavar={"px": "PX", "°": "DEG", "%": "PERCENT"}.get(
                                    figure.unit, "N"),
                                help=f"{kind} {title} (default: {text})".replace("%", "%%"))


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
    limits = {name: getattr(args, name) for name in LIMITS}
    check_limits(limits)
    request = _request(args, limits)
    if args.workers is not None and args.workers < 1:
        raise InputError(f"--workers is {args.workers}, the minimum is 1")
    if args.scheduler and args.workers:
        raise InputError("--workers is of this machine, the scheduler has its own")
    if not 1 <= args.timeout <= _MAX_TIMEOUT:
        raise InputError(f"--timeout is {args.timeout:g} s, the limits are 1 and {_MAX_TIMEOUT}")
    if not 1 <= len(args.station) <= STATION_LENGTH:
        raise InputError(f"--station has {len(args.station)} characters, the limits are 1 and "
                         f"{STATION_LENGTH}")
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


def _request(args, limits):
    """The checked :class:`Request` of the options."""
    request = Request(
        target=args.target, page=args.page or "", seed=args.seed, zoom=args.zoom, bayer=args.bayer,
        neurons=None if args.neurons == "auto" else args.neurons,
        goal=GOAL if limits["max_error"] is None else limits["max_error"],
        size=size_of(args.size, "size") if args.size else None, interpolation=args.interpolation)
    request.check()
    return request


def _work(args, database, request, limits):
    """Judge every unit that waits, with progress; 1 if the scheduler was lost, else 0."""
    counts, forecast = database.counts(), None
    waiting = counts["units"] - sum(counts[name] for name in VERDICTS)
    if not waiting:
        return 0
    from ncdc.lot.workers import connect  # Dask takes a second

    with connect(args.scheduler, args.workers, args.timeout) as workers:
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
        self.done += 1
        self.counts[done.verdict] += 1
        if done.verdict != PASS:
            say(f"{done.serial}: {done.verdict}: {done.reasons[0]}")
        each = (time.monotonic() - self.start) / self.done
        end = time.localtime(time.time() + each * (self.waiting - self.done))
        self.progress(self.done / self.waiting,
                      f", {self.done} of {self.waiting} units, {self.counts[FAIL]} fail, "
                      f"{each:.1f} s a unit, done at {time.strftime('%H:%M', end)}")
