"""``ncdc lot watch``: a station, which judges units as their photos arrive."""

import signal
from contextlib import closing
from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.cli.lot_options import add_lot_options, checked_options, connected
from ncdc.cli.lot_run import database_at
from ncdc.lot.arrivals import Arrivals
from ncdc.lot.run import SchedulerLost, watch_lot
from ncdc.station.server import StationPage
from ncdc.terminal import say
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc lot watch photos --target dots --neurons 8 --photos 3 -o lot"

_MAX_PHOTOS, _MAX_SETTLE, _MAX_PORT = 1000, 3600.0, 0xFFFF


def add_arguments(parser) -> None:
    """Declare the action's arguments on an argparse parser."""
    parser.add_argument("folder", metavar="FOLDER",
                        help="where a folder per unit arrives, named after its serial number, with "
                             "its photos")
    add_lot_options(parser, timeout=300.0)
    arrival = parser.add_argument_group("when a unit has arrived")
    arrival.add_argument("--photos", type=int, default=1, dest="count", metavar="N",
                         help="its folder has as many photos, or more (default: 1)")
    arrival.add_argument("--settle", type=float, default=2.0, metavar="SECONDS",
                         help="and nothing in it has changed for so long (default: 2)")
    page = parser.add_argument_group("page in the browser")
    page.add_argument("--host", default="127.0.0.1", metavar="ADDRESS",
                      help="address of this machine to serve it on (default: 127.0.0.1, for this "
                           "machine alone); 0.0.0.0: all of them")
    page.add_argument("--port", type=int, default=8047, metavar="N",
                      help="0: any that is free (default: 8047)")
    add_json(parser)


def run(args) -> int:
    """Judge units until Ctrl-C or SIGTERM; 1 if the scheduler was lost."""
    request, limits = checked_options(args)
    _check(args)
    arrivals = Arrivals(args.folder, args.count, args.settle)
    with closing(StationPage(args.host, args.port)) as page:
        with closing(database_at(args.output, create=True)) as database:
            database.begin({**vars(request), **limits}, [], args.station)
            signal.signal(signal.SIGTERM, signal.default_int_handler)
            title = database.address if "://" in args.output else Path(args.output).resolve().name
            page.start(f"lot {title}", database, args.station, arrivals)
            say(f"{page.url} shows the station; Ctrl-C ends it")
            status = _watch(args, database, request, limits, arrivals)
            report = database.counts()
    if not write_report(report, args.json):
        print(f"{report['units']} units: {report['pass']} pass, {report['look']} to look at, "
              f"{report['fail']} fail")
    return status


def _check(args):
    if not 1 <= args.count <= _MAX_PHOTOS:
        raise InputError(f"--photos is {args.count}, the limits are 1 and {_MAX_PHOTOS}")
    if not 0 <= args.settle <= _MAX_SETTLE:
        raise InputError(f"--settle is {args.settle:g} s, the limits are 0 and {_MAX_SETTLE:g}")
    if not 0 <= args.port <= _MAX_PORT:
        raise InputError(f"--port is {args.port}, the limits are 0 and {_MAX_PORT}")


def _watch(args, database, request, limits, arrivals):
    """Judge what arrives; 0 after Ctrl-C, 1 if the scheduler was lost."""
    try:
        with connected(args) as workers:
            say("ready")
            for done in watch_lot(database, workers, request, limits, args.station, arrivals):
                say(": ".join([done.serial, done.verdict,
                               *(done.reasons[-1:] if done.before else done.reasons[:1])]))
    except KeyboardInterrupt:
        return 0
    except SchedulerLost:
        say("ncdc lot: the scheduler has gone; the same command goes on from there")
    return 1
