"""``ncdc bench nodes``: what the network at nodes adds to the coordinates of the lenses."""

from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress
from ncdc_bench.accuracy.command import neuron_counts
from ncdc_bench.nodes.measure import WIDTHS, curvatures, descriptor_of, rows_of
from ncdc_bench.nodes.plots import plot_nodes
from ncdc_bench.reference_lenses import REFERENCE_LENSES
from ncdc_spec.files import check_outputs

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run", "table"]

HELP = ("evaluate the integer network of each reference lens at nodes 1, 8, 16 and 32 pixels "
        "apart, and measure what that adds on the whole frame")
EXAMPLE = "ncdc bench nodes --lens PC105 --neurons 6"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--lens", nargs="+", choices=REFERENCE_LENSES, metavar="NAME",
                        default=list(REFERENCE_LENSES),
                        help=f"of {', '.join(REFERENCE_LENSES)} (default: all)")
    parser.add_argument("--neurons", default="12", metavar="LIST",
                        help="hidden neurons, as 8,12 or 4-16 (default: 12)")
    parser.add_argument("-o", "--output", metavar="DIR",
                        help="also write a plot of the added error by distance of nodes, nodes.png")
    add_json(parser)


def run(args):
    """Train, measure and report; 1 if a figure breaks its bound."""
    neurons = neuron_counts(args.neurons)
    plot = Path(args.output) / "nodes.png" if args.output else None
    if plot:
        check_outputs([plot], [])
    rows, sizes, progress = [], {}, Progress("nodes")
    jobs = [(lens, count) for lens in args.lens for count in neurons]
    for k, (lens, count) in enumerate(jobs):
        def part(fraction, text=f" {lens}, {count} neurons", k=k):
            progress((k + fraction) / len(jobs), text)
        part(0)
        descriptor = descriptor_of(lens, count)
        rows += rows_of(lens, descriptor, part)
        if plot and count == neurons[-1]:
            sizes[lens] = {width: curvatures(descriptor, width) for width in WIDTHS}
    if plot:
        plot_nodes(plot, [row for row in rows if row["hidden_neurons"] == neurons[-1]], sizes)
    if not write_report({"rows": rows}, args.json):
        print(table(rows))
    return int(any(row["added_max_px"] > row["bound_px"] for row in rows))


def table(rows):
    """Rows of :func:`ncdc_bench.nodes.measure.rows_of` as text."""
    lines = ["px on an axis, over every valid pixel",
             f"{'lens':<7} {'HN':>3} {'nodes':>5} {'auto':>5} {'curvature':>9} {'added':>8} "
             f"{'mean':>8} {'bound':>8} {'fixed - float':>13}"]
    lines += [f"{row['lens']:<7} {row['hidden_neurons']:3d} {row['nodes']:5d} "
              f"{'*' if row['chosen'] else '':>5} {row['curvature_px']:9.6f} "
              f"{row['added_max_px']:8.5f} {row['added_mean_px']:8.5f} {row['bound_px']:8.5f} "
              f"{row['fixed_minus_float_max_px']:13.5f}" for row in rows]
    return "\n".join(lines)
