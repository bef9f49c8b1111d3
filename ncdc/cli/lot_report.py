"""``ncdc lot report``: one page of HTML on a lot."""

from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.cli.lot_run import database_at
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc lot report lot -o lot.html"


def add_arguments(parser) -> None:
    """Declare the action's arguments on an argparse parser."""
    parser.add_argument("lot", metavar="LOT", help="folder or address of ncdc lot run -o")
    parser.add_argument("-o", "--output", default="lot.html", metavar="FILE",
                        help="page to write (default: lot.html)")
    parser.add_argument("--parquet", metavar="FILE",
                        help="write the rows of all units for other software")
    add_json(parser)


def run(args) -> None:
    """Write the page, and the rows."""
    from ncdc.report import lot  # Matplotlib takes half a second

    database = database_at(args.lot)
    if not any(database.counts()[verdict] for verdict in ("pass", "look", "fail")):
        raise InputError(f"{args.lot} has no unit that was judged: ncdc lot run judges them")
    title = database.address if "://" in args.lot else Path(args.lot).resolve().name
    report = lot.write_report(args.output, database, f"The lot {title}")
    if args.parquet:
        from ncdc.lot.parquet import write_parquet
        write_parquet(args.parquet, database.rows())
    database.close()
    if not write_report({**report, "page": args.output}, args.json):
        print(f"look at {args.output}")
