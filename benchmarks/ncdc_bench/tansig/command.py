"""``ncdc bench tansig``: error, equality, size and clock of every tan-sigmoid."""

from argparse import BooleanOptionalAction
from pathlib import Path

from ncdc.cli.common import add_json, report_failures, write_report
from ncdc.terminal import Steps
from ncdc.text_table import text_table
from ncdc.toolchain.flows import check_tools
from ncdc_bench.tansig.measure import tansig_row
from ncdc_bench.tansig.plots import plot_tansig
from ncdc_spec.files import check_outputs
from ncdc_spec.tansig import FRACTION_BITS, VARIANTS, design_for

__all__ = ["EXAMPLE", "HELP", "add_arguments", "complaint", "run", "table"]

HELP = ("run the Verilog of every tan-sigmoid on all of its 2**24 inputs: error, differences from "
        "the golden model, size and clock")
EXAMPLE = "ncdc bench tansig --variant mmhbc --bits 20 --json -"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--variant", nargs="+", choices=list(VARIANTS), default=list(VARIANTS),
                        metavar="V", help=f"of {', '.join(VARIANTS)} (default: all)")
    parser.add_argument("--bits", nargs="+", type=int, choices=FRACTION_BITS, metavar="P",
                        default=list(FRACTION_BITS),
                        help=f"of {', '.join(map(str, FRACTION_BITS))} (default: all)")
    parser.add_argument("--sampled", action="store_true",
                        help="65 thousand inputs instead of all: quick")
    parser.add_argument("--synth", action=BooleanOptionalAction, default=True,
                        help="size and clock by open synthesis (default: yes)")
    parser.add_argument("--route", action=BooleanOptionalAction, default=True,
                        help="with the clock on ECP5, which takes most of the time (default: yes)")
    parser.add_argument("--plots", metavar="DIR",
                        help="also remake Fig. 10, 11, 13 and 14 of the paper as PNG files")
    add_json(parser)


def run(args):
    """Measure and report; 1 if a result is wrong."""
    if args.plots:
        check_outputs([Path(args.plots) / "tansig-fig10.png"], [])
    if args.synth:
        check_tools(", or leave synthesis out with --no-synth")
    rows = []
    for variant in args.variant:
        for bits in args.bits:
            design = design_for(variant, bits)
            rows.append(tansig_row(design, sampled=args.sampled, synthesis=args.synth,
                                   routed=args.route,
                                   progress=Steps(f"{variant}, {bits} bits", quiet=True)))
    if args.plots:
        plot_tansig(Path(args.plots), rows)
    if not write_report({"rows": rows}, args.json):
        print(table(rows))
    return report_failures("bench tansig", [text for text in map(complaint, rows) if text])


def complaint(row):
    """A sentence that says what is wrong with a row of ``tansig_row``; None if nothing is."""
    name = f"{row['variant']} at {row['fraction_bits']} bits"
    if row["differences"]:
        return f"{name}: {row['differences']} results differ from the golden model"
    if row["max_ulp"] >= 1 or row["max_ulp"] > row["bound_ulp"]:
        return (f"{name}: the largest error is {row['max_ulp']:.4f} ulp, the limits are 1 and the "
                f"derived bound, {row['bound_ulp']:.4f}")
    broken = [key for key in ("odd", "zero", "monotonic", "saturated") if not row[key]]
    return f"{name}: not {', not '.join(broken)}" if broken else None


def table(rows):
    """Rows of ``tansig_row`` as text."""
    columns = [(title, render) for title, render, key in _COLUMNS if key is None or key in rows[0]]
    note = "every input" if rows[0]["exhaustive"] else "sampled"
    return (f"errors in ulp of 2**-bits, {rows[0]['inputs']} inputs, {note}\n"
            f"{text_table(columns, rows)}")


# Title, text of a row, key without which the column is left out.
_COLUMNS = (
    ("variant", lambda row: row["variant"], None),
    ("bits", lambda row: str(row["fraction_bits"]), None),
    ("max", lambda row: f"{row['max_ulp']:.4f}", None),
    ("bound", lambda row: f"{row['bound_ulp']:.4f}", None),
    ("within .5", lambda row: f"{100 * row['correctly_rounded']:.2f} %", None),
    ("MSE/ideal", lambda row: f"{row['mse'] / row['mse_ideal']:.3f}", None),
    ("differ", lambda row: str(row["differences"]), None),
    ("latency", lambda row: str(row["latency"]), None),
    ("stages", lambda row: str(row["stages"]), None),
    ("adders", lambda row: str(row["adders"]), None),
    ("table bits", lambda row: str(row["table_bits"]), None),
    ("mult", lambda row: str(row["multipliers"]), None),
    ("LUT", lambda row: str(row["lut"]), "lut"),
    ("FF", lambda row: str(row["ff"]), "ff"),
    ("MHz", lambda row: f"{row['fmax_mhz']:.0f}", "fmax_mhz"),
    ("ALM", lambda row: str(row["alm"]), "alm"),
)
