"""Options of ``ncdc lot run`` and ``ncdc lot watch``: the work on a unit, limits, workers."""

import socket

from ncdc.cli.common import add_page
from ncdc.cli.train import neurons_of, size_of
from ncdc.lot.figures import FIGURES, LIMITS, check_limits
from ncdc.lot.units import check_station
from ncdc.lot.work import Request
from ncdc_model.training.choose import GOAL
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import BAYERS
from ncdc_spec.interpolation import DEFAULT, INTERPOLATIONS

__all__ = ["add_lot_options", "checked_options", "connected"]

_TLS = {"--tls-ca-file": "certificate, in PEM, of the authority that signed those of a scheduler "
                         "at tls://ADDRESS and of its workers",
        "--tls-cert": "certificate of this command, signed by it",
        "--tls-key": "key of that certificate"}
_MAX_TIMEOUT = 1_000_000            # seconds: more than a week


def add_lot_options(parser, timeout) -> None:
    """Declare the options on an argparse parser; ``timeout``: the default in seconds."""
    parser.add_argument("-o", "--output", default="lot", metavar="LOT",
                        help="folder of the lot, whose lot.db has the results (default: lot); or "
                             "an address of SQLAlchemy, such as postgresql+psycopg://host/lot")
    work = parser.add_argument_group("calibration and training, as of ncdc calibrate and train")
    work.add_argument("--target", default="auto", metavar="KIND",
                      help="dots, circles:CxR, acircles:CxR, chessboard:CxR, charuco:CxR, "
                           "aprilgrid:CxR, or auto (default)")
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
    for option, text in _TLS.items():
        where.add_argument(option, metavar="FILE", help=text)
    where.add_argument("--timeout", type=float, default=timeout, metavar="SECONDS",
                       help="longest work on a unit: after that its worker ends, and the unit runs "
                            f"again as after a crash (default: {timeout:g})")
    where.add_argument("--station", default=socket.gethostname(), metavar="NAME",
                       help="name of the station, for units whose CSV has none (default: the name "
                            "of this machine)")


def _add_limits(parser):
    for figure in FIGURES:
        for option, kind in ((figure.low, "smallest"), (figure.high, "largest")):
            if not option:
                continue
            default = LIMITS[option]
            text = f"{default:g}" if default is not None else "no limit"
            title = figure.limit_title or figure.title
            parser.add_argument(f"--{option.replace('_', '-')}", type=float, default=default,
                                metavar={"px": "PX", "°": "DEG", "%": "PERCENT"}.get(
                                    figure.unit, "N"),
                                help=f"{kind} {title} (default: {text})".replace("%", "%%"))


def connected(args):
    """:func:`ncdc.lot.workers.connect` with the options."""
    from ncdc.lot import workers  # Dask takes a second

    tls = args.tls_ca_file and workers.Tls(args.tls_ca_file, args.tls_cert, args.tls_key)
    return workers.connect(args.scheduler, args.workers, args.timeout, tls)


def checked_options(args):
    """The :class:`Request` and the limits, a dict like :data:`LIMITS`, of the options.

    Raises
    ------
    InputError
        If an option is bad.
    """
    limits = {name: getattr(args, name) for name in LIMITS}
    check_limits(limits)
    request = Request(
        target=args.target, page=args.page or "", seed=args.seed, zoom=args.zoom, bayer=args.bayer,
        neurons=None if args.neurons == "auto" else args.neurons,
        goal=GOAL if limits["max_error"] is None else limits["max_error"],
        size=size_of(args.size, "size") if args.size else None, interpolation=args.interpolation)
    request.check()
    if args.workers is not None and args.workers < 1:
        raise InputError(f"--workers is {args.workers}, the minimum is 1")
    if args.scheduler and args.workers:
        raise InputError("--workers is of this machine, the scheduler has its own")
    files = args.tls_ca_file, args.tls_cert, args.tls_key
    if any(files) and not (all(files) and (args.scheduler or "").startswith("tls://")):
        raise InputError(f"{', '.join(_TLS)} belong together, with --scheduler tls://ADDRESS; "
                         f"{sum(map(bool, files))} of them are given, with --scheduler "
                         f"{args.scheduler}")
    if not any(files) and (args.scheduler or "").startswith("tls://"):
        raise InputError(f"--scheduler is {args.scheduler}, which needs {', '.join(_TLS)}")
    if not 1 <= args.timeout <= _MAX_TIMEOUT:
        raise InputError(f"--timeout is {args.timeout:g} s, the limits are 1 and {_MAX_TIMEOUT}")
    check_station(args.station, "--station")
    return request, limits
