"""``ncdc bench cost``: what a corrector costs as the picture and the lens's view grow."""

from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress
from ncdc.text_table import text_table
from ncdc.toolchain.flows import check_tools
from ncdc_bench.cost.measure import QUICK_SIZES, SIZES, measure
from ncdc_bench.cost.plots import PLOT, plot_cost
from ncdc_spec.files import check_outputs

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run", "table"]

HELP = ("plan lenses of 90 to 180 degrees for pictures from 640x480 to 7680x4320, and synthesise "
        "the planned hardware: ALM, RAM, clocks and bytes per pixel")
EXAMPLE = "ncdc bench cost --quick --no-synth"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--quick", action="store_true", help="the smallest picture: half a minute")
    parser.add_argument("--no-synth", action="store_true", help="plan only: no ALM and RAM")
    parser.add_argument("--plots", metavar="DIR", help="also plot the rows")
    add_json(parser)


def run(args):
    """Measure and report."""
    if not args.no_synth:
        check_tools(", or use --no-synth")
    if args.plots:
        check_outputs([Path(args.plots) / PLOT], [])
    rows = list(measure(QUICK_SIZES if args.quick else SIZES, synth=not args.no_synth,
                        progress=Progress))
    if args.plots:
        plot_cost(Path(args.plots), rows)
    if not write_report({"rows": rows}, args.json):
        print(table(rows))


def table(rows):
    """Rows of :func:`ncdc_bench.cost.measure.measure` as text."""
    return text_table(_COLUMNS, rows)


_COLUMNS = (
    ("size", lambda row: f"{row['width']}x{row['height']}"),
    ("lens", lambda row: row["lens"]),
    ("hardware", lambda row: "yes" if row["hardware_exists"] else "no"),
    ("cache", lambda row: f"{row['cache_bytes'] // 1024} KB"),
    ("clocks/px", lambda row: f"{row['predicted_clocks_per_pixel']:.4f}"),
    ("bytes/px", lambda row: f"{row['bytes_read_per_pixel']:.3f}"),
    ("/distinct", lambda row: f"{row['amplification']:.3f}"),
    ("ALM", lambda row: row["alm"]),
    ("M10K", lambda row: row["m10k"]),
    ("DSP", lambda row: row["dsp"]),
)
