"""``ncdc lot``: calibrates every unit of a production lot, judges and records it."""

from sqlalchemy.exc import SQLAlchemyError

from ncdc.cli import lot_compare, lot_export, lot_report, lot_run, lot_show, lot_watch
from ncdc.cli.lot_run import database_file
from ncdc.lot.database import reason_of
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc lot run units --target dots --neurons auto -o lot"

_ACTIONS = {
    "run": (lot_run, "calibrate, train and judge the units that have no verdict yet"),
    "watch": (lot_watch, "judge units as their photos arrive, with a page in the browser"),
    "report": (lot_report, "write one page of HTML: yield, figures, trend, outliers, all units"),
    "show": (lot_show, "print what is known of one unit, and write its descriptor and picture"),
    "export": (lot_export, "write the image of each unit's EEPROM"),
    "compare": (lot_compare, "print two lots next to each other"),
}


def add_arguments(parser) -> None:
    """Declare one subcommand per action on an argparse parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    for name, (module, text) in _ACTIONS.items():
        sub = actions.add_parser(name, help=text, description=text,
                                 epilog=f"example: {module.EXAMPLE}")
        module.add_arguments(sub)
        sub.set_defaults(action_of=module.run)


def run(args) -> int | None:
    """Run the chosen action.

    Raises
    ------
    InputError
        If the database fails, or a file to write is the database.
    """
    lots = args.lots if args.action == "compare" else [
        args.output if args.action in ("run", "watch") else args.lot]
    outputs = [args.output, args.parquet] if args.action == "report" else []
    check_outputs(list(filter(None, outputs)), [database_file(lot) for lot in lots],
                  [args.json] if args.json not in (None, "-") else [])
    try:
        return args.action_of(args)
    except SQLAlchemyError as error:
        raise InputError(f"the database failed: {reason_of(error)}") from error
