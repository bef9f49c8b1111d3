"""``ncdc bench lines``: the paper's line test on boards corrected by PBM and by the network."""

from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress
from ncdc_bench.accuracy.command import neuron_counts
from ncdc_bench.accuracy.measure import MODELS, NETWORKS, fits_of, jobs_of
from ncdc_bench.lines.measure import (
    board_photo,
    board_pitch,
    corrected,
    crossings,
    find_lines,
    summary,
)
from ncdc_bench.lines.plots import plot_lines
from ncdc_bench.reference_lenses import REFERENCE_LENSES, ReferenceLens
from ncdc_spec.files import check_outputs

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run", "table"]

HELP = ("correct a chessboard seen by simulated lenses with the network and with other maps, and "
        "look for its lines")
EXAMPLE = "ncdc bench lines --lens 105br --neurons 4 -o plots"

_LENSES, _NEURONS = ("PC105", "105br", "120br"), "4,8,12"
_MODELS = ("pbm6-shared", "pbm6-separate", "ncdc")
TRUE = "true"          # the row of the true map: what the measurement itself leaves


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--lens", nargs="+", choices=REFERENCE_LENSES, metavar="NAME",
                        default=_LENSES,
                        help=f"of {', '.join(REFERENCE_LENSES)} (default: {', '.join(_LENSES)})")
    parser.add_argument("--neurons", default=_NEURONS, metavar="LIST",
                        help=f"hidden neurons, as 4,5,6 or 4-16 (default: {_NEURONS})")
    parser.add_argument("--model", nargs="+", choices=MODELS, default=_MODELS, metavar="NAME",
                        help=f"of {', '.join(MODELS)} (default: {', '.join(_MODELS)})")
    parser.add_argument("-o", "--output", metavar="DIR",
                        help="also write a picture for each lens, corrections side by side")
    add_json(parser)


def run(args):
    """Photograph, correct, measure and report."""
    if args.output:
        check_outputs([Path(args.output) / "lines.jpg"], [])
    jobs = jobs_of(args.model, neuron_counts(args.neurons), 1)
    progress, rows = Progress("lines"), []
    for k, name in enumerate(args.lens):
        lens = ReferenceLens(name)
        raw, pitch, results = board_photo(lens), board_pitch(lens.geometry), []

        def measure(row, back_map, real_map, title):
            picture, valid = corrected(back_map, raw, lens.geometry)
            lines = find_lines(picture, valid, pitch, crossings(lens, real_map))
            rows.append({**row, **summary(lines)})
            results.append(("{}: {lines_missed} of {lines} lines missed, off straight by "
                            "{straightness_rms_px:.2f} px rms".format(title, **rows[-1]),
                            picture, lines))
            progress((k + len(results) / (1 + len(jobs))) / len(args.lens), f" {name}: {title}")
        measure({"lens": name, "model": TRUE, "hidden_neurons": None}, lens.camera.back_map,
                lens.camera.back_map, "true map")
        for fit in fits_of(name, jobs):
            model, count = fit.row["model"], fit.row["hidden_neurons"]
            measure({"lens": name, "model": model, "hidden_neurons": count,
                     "mse": fit.row["fixed_mse" if model in NETWORKS else "mse"]},
                    fit.back_map, fit.real_map, f"{model}, HN {count}" if count else model)
        if args.output:
            plot_lines(Path(args.output) / f"lines-{name}.jpg", raw, results[1:])
    if not write_report({"rows": rows}, args.json):
        print(table(rows))


def table(rows):
    """Rows as text."""
    lines = ["lens    model             HN  lines  missed  off straight, px: rms      max"]
    for row in rows:
        lines.append(f"{row['lens']:<7} {row['model']:<16} {row['hidden_neurons'] or '-':>3} "
                     f"{row['lines']:6d} {row['lines_missed']:7d} "
                     f"{row['straightness_rms_px']:22.3f} {row['straightness_max_px']:8.3f}")
    return "\n".join(lines)
