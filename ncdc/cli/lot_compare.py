"""``ncdc lot compare``: two lots next to each other."""

import numpy as np

from ncdc.cli.common import add_json, write_report
from ncdc.cli.lot_run import database_at
from ncdc.lot.figures import ERRORS, FIGURES, VERDICTS
from ncdc.text_table import text_table

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc lot compare march april"


def add_arguments(parser) -> None:
    """Declare the action's arguments on an argparse parser."""
    parser.add_argument("lots", nargs=2, metavar="LOT",
                        help="folder or address of ncdc lot run -o")
    add_json(parser)


def run(args) -> None:
    """Print yield, medians and spreads of both, and the units whose verdict or network differs."""
    first, second = (_summary(lot) for lot in args.lots)
    rows = [{"what": name, "first": first["share"][name], "second": second["share"][name]}
            for name in VERDICTS]
    rows += [{"what": figure.title, "first": _text(figure, first), "second": _text(figure, second),
              "shift": _shift(first["values"][figure.name], second["values"][figure.name])}
             for figure in FIGURES]
    both = first["units"].keys() & second["units"].keys()
    differ = sorted(serial for serial in both if first["units"][serial] != second["units"][serial])
    report = {"lots": args.lots, "rows": rows, "units_in_both": len(both), "units_differ": differ}
    if not write_report(report, args.json):
        print(text_table([("", lambda row: row["what"]), (args.lots[0], lambda row: row["first"]),
                          (args.lots[1], lambda row: row["second"]),
                          ("shift, deviations", lambda row: row.get("shift"))], rows, left=1))
        if both:
            print(f"{len(both)} units are in both, {len(differ)} of them with another verdict or "
                  f"network{': ' if differ else ''}{', '.join(differ[:10])}")


def _summary(lot):
    """Share of each verdict, values of each figure, verdict and digest of each unit."""
    database = database_at(lot)
    counts = database.counts()
    table = database.columns(["serial", "verdict", "digest",
                              *(figure.name for figure in FIGURES), *ERRORS])
    database.close()
    judged = max(1, sum(counts[name] for name in VERDICTS))
    texts = ([names[k] for k in numbers] for numbers, names in
             (table["serial"], table["verdict"], table["digest"]))
    return {"share": {name: f"{counts[name]} ({100 * counts[name] / judged:.1f} %)"
                      for name in VERDICTS},
            "values": {name: table[name][np.isfinite(table[name])]
                       for name in (*(figure.name for figure in FIGURES), *ERRORS)},
            "units": {serial: about for serial, *about in zip(*texts)}}


def _text(figure, summary):
    """Median and spread of a figure, and the usual standard error of one unit's."""
    values, errors = summary["values"][figure.name], summary["values"].get(figure.error, ())
    if not len(values):
        return None
    error = f", error {np.median(errors):.{figure.digits}f}" if len(errors) else ""
    return f"{figure.text(np.median(values))} ± {np.std(values):.{figure.digits}f}{error}"


def _shift(first, second):
    """Distance of the medians, in standard deviations of the first lot."""
    if not len(first) or not len(second) or not np.std(first):
        return None
    return f"{(np.median(second) - np.median(first)) / np.std(first):+.1f}"
