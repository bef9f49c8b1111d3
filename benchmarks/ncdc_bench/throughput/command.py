"""``ncdc bench throughput``: clocks and bytes per pixel of both fetchers, on whole frames."""

from pathlib import Path

from ncdc.cli.common import add_json, report_failures, write_report
from ncdc.terminal import Progress
from ncdc.text_table import text_table
from ncdc_bench.throughput.cross import CROSS, LIMIT, cross_rows
from ncdc_bench.throughput.measure import ALL, DEFAULT, QUICK, goal_rows, measure, table_four
from ncdc_bench.throughput.plots import plot_throughput
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs

__all__ = ["EXAMPLE", "HELP", "add_arguments", "goal_text", "run", "table"]

HELP = ("correct whole frames with the Verilog of both fetchers on modelled memories: clocks and "
        "bytes per pixel, and the planner's predictions")
EXAMPLE = "ncdc bench throughput --quick"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--quick", action="store_true", help="small frames: some minutes")
    which.add_argument("--all", action="store_true", help="every lens and rotation too: hours")
    which.add_argument("--cross", action="store_true",
                       help="the planner compared with the Verilog for pixels per clock, nodes, "
                            "interpolations and ports, each with each, on small frames: an hour")
    parser.add_argument("--plots", metavar="DIR", help="also plot the rows")
    add_json(parser)


def run(args):
    """Measure and report; 1 if a pixel differs, or a goal is missed.

    Small frames do not measure every goal; of the other lists, a goal without a row is missed.
    """
    if args.cross:
        return _cross(args)
    if args.plots:
        check_outputs([Path(args.plots) / "throughput.png"], [])
    runs = QUICK if args.quick else ALL if args.all else DEFAULT
    rows = list(measure(runs, lambda run: Progress(str(run))))
    goals = goal_rows(rows)
    if args.plots:
        plot_throughput(Path(args.plots), rows)
    report = {"rows": rows, "goals": [dict(zip(("goal", "figure", "limit", "holds"), goal))
                                      for goal in goals]}
    if not write_report(report, args.json):
        print(table(rows))
        print("\n".join(["", *(goal_text(*goal) for goal in goals)]))
        print("\n".join(["", "Table IV at 100 MHz", *(
            f"{method:15} {memory:6} {size:9} to {output:6} {fps:7.2f} frames per second"
            for method, memory, size, output, fps in table_four(rows))]))
    missed = [f"missed: {name}" for name, _, _, holds in goals if holds is False]
    if not args.quick:
        missed += [f"no row measures: {name}" for name, _, _, holds in goals if holds is None]
    return report_failures("bench throughput", missed)


def _cross(args):
    """Compare the planner with the Verilog; 1 if a row is off by more than the limit."""
    if args.plots:
        raise InputError("--cross and --plots are given, there is no plot of these rows")
    rows = []
    for row in cross_rows(CROSS, lambda each: Progress(str(each))):
        rows.append(row)
        if args.json != "-":        # who ends it early has the rows so far
            print(cross_text(row), flush=True)
    write_report({"rows": rows, "limit": LIMIT}, args.json)
    return report_failures("bench throughput", [
        f"missed: {cross_text(row)}" for row in rows if not row["holds"]])


def cross_text(row):
    """One line on a row of :func:`ncdc_bench.throughput.cross.cross_rows`."""
    text = (f"{row['interpolation']:8} {row['lanes']} pixels per clock, nodes {row['nodes']:2}, "
            f"{row['data_width']:3} bits, {row['which']:7} split")
    if row["rejected"]:
        return f"{text}: rejected: {row['rejected']}"
    return (f"{text} {row['split']}: {row['clocks_per_pixel']:.4f} clocks per pixel, "
            f"{row['predicted_clocks_per_pixel']:.4f} predicted, {100 * row['off']:+.2f} %, "
            f"{row['pixels_different']} pixels wrong")


def goal_text(name, value, limit, holds):
    """One line on a goal of :func:`ncdc_bench.throughput.measure.goal_rows`."""
    if holds is None:
        return f"{name}: not measured, at most {limit:g} is asked for"
    return f"{name}: {value:.4f}, at most {limit:g} is asked for{'' if holds else ': MISSED'}"


def table(rows):
    """Rows of :func:`ncdc_bench.throughput.measure.measure` as text."""
    return text_table(_COLUMNS, rows)


def _predicted(row):
    value = row["predicted_clocks_per_pixel"]
    return "-" if value is None else f"{value:.4f}"


_COLUMNS = (
    ("fetch", lambda row: row["fetch"]),
    ("memory", lambda row: row["memory"]),
    ("to", lambda row: row["output"]),
    ("size", lambda row: f"{row['width']}x{row['height']}"),
    ("lens", lambda row: f"{row['lens']:g}"),
    ("turn", lambda row: f"{row['rotation']:g}"),
    ("colour", lambda row: row["interpolation"]),
    ("lanes", lambda row: str(row["pixels_per_clock"])),
    ("scan", lambda row: f"{row['strip']}" if row["strip"] else "raster"),
    ("cache", lambda row: f"{row['cache_bytes'] // 1024} KB" if row["cache_bytes"] else "-"),
    ("clocks/px", lambda row: f"{row['clocks_per_pixel']:.4f}"),
    ("predicted", _predicted),
    ("bytes/px", lambda row: f"{row['bytes_read_per_pixel']:.3f}"),
    ("/distinct", lambda row: f"{row['amplification']:.3f}"),
    ("fps", lambda row: f"{row['frames_per_second']:.2f}"),
    ("wrong", lambda row: str(row["pixels_different"])),
)
