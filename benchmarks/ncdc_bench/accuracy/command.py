"""``ncdc bench accuracy``: the network, its trainers and other maps on the reference lenses."""

from pathlib import Path

import numpy as np

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress
from ncdc_bench.accuracy.measure import MODELS, NETWORKS, fits_of, jobs_of, reliability
from ncdc_bench.accuracy.plots import plot_accuracy
from ncdc_bench.reference_lenses import REFERENCE_LENSES
from ncdc_spec.descriptor import MAX_NEURONS
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs, write_stream

__all__ = ["EXAMPLE", "HELP", "add_arguments", "by_lens", "neuron_counts", "run", "table"]

HELP = ("fit the network and other maps to the same noisy dots of simulated lenses, and measure "
        "all on the whole frame")
EXAMPLE = "ncdc bench accuracy --lens PC105 --neurons 4,5,6 --model ncdc opencv-full"

# Without options: a few minutes on one core. Back-propagation is slow, one network of it will do.
_LENSES = {"PC105": (4, 5, 6), "PC120": (4, 5, 6), "120kb": (8, 10, 12, 16)}
_NEURONS = (4, 6, 8, 10, 12)       # of the other lenses
_SLOW, _SLOW_LENS, _SLOW_NEURONS = "ebp", "PC105", (4,)
_ALL_NEURONS, _ALL_SLOW_NEURONS = tuple(range(4, 17)), (4, 5, 6)


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--lens", nargs="+", choices=REFERENCE_LENSES, metavar="NAME",
                        help=f"of {', '.join(REFERENCE_LENSES)} (default: {', '.join(_LENSES)})")
    parser.add_argument("--neurons", metavar="LIST",
                        help="hidden neurons, as 4,5,6 or 4-16 (default: 4,5,6 on PC105 and "
                             "PC120, 8,10,12,16 on 120kb, else 4,6,8,10,12)")
    parser.add_argument("--model", nargs="+", choices=MODELS, metavar="NAME",
                        help=f"of {', '.join(MODELS)} (default: all, but ebp, which is slow, on "
                             f"{_SLOW_LENS} with {_SLOW_NEURONS[0]} neurons only)")
    parser.add_argument("--seeds", type=int, default=1, metavar="N",
                        help="train each network N times and count the seeds that come within "
                             "10 %% of the best (default: 1)")
    parser.add_argument("--residual", type=float, default=1.0, metavar="TIMES",
                        help="of each lens's own residual, which OpenCV's models do not have, 0 to "
                             "1 (default: 1)")
    parser.add_argument("--table", metavar="FILE",
                        help="write MSE and largest error of each lens and map as Markdown")
    parser.add_argument("--all", action="store_true",
                        help="every lens, 4 to 16 neurons (ebp 4 to 6): hours")
    parser.add_argument("-o", "--output", metavar="DIR",
                        help="also write plots: error by number of neurons, error maps")
    add_json(parser)


def run(args):
    """Fit, measure and report."""
    if args.seeds < 1:
        raise InputError(f"{args.seeds} seeds are asked for, 1 is the limit")
    if args.output:
        check_outputs([Path(args.output) / "accuracy.png"], [])
    work = _work(args)
    total, done, fits = sum(len(jobs) for _, jobs in work), 0, []
    progress = Progress("accuracy")
    for lens, jobs in work:
        progress(done / total, f" {lens}: {_title(*jobs[0][:2])}")
        for fit, following in zip(fits_of(lens, jobs, args.residual), [*jobs[1:], None]):
            done += 1
            fits.append(fit)
            progress(done / total, f" {lens}: {_title(*following[:2])}" if following else "")
    rows = [fit.row for fit in fits]
    if args.output:
        plot_accuracy(Path(args.output), fits)
    if args.table:
        write_stream(args.table, by_lens(rows))
    report = {"rows": rows, "reliability": reliability(rows)}
    if not write_report(report, args.json):
        print(table(rows))
        for group in report["reliability"]:
            print("{lens} {model} HN {hidden_neurons}: {seeds_within_10_percent} of {seeds} seeds "
                  "within 10 % of the best".format(**group))


def _work(args):
    """Lenses and the jobs on each."""
    lenses = args.lens or (REFERENCE_LENSES if args.all else _LENSES)
    work = []
    for lens in lenses:
        neurons = _ALL_NEURONS if args.all else _LENSES.get(lens, _NEURONS)
        if args.neurons:
            neurons = neuron_counts(args.neurons)
        if args.model:
            jobs = jobs_of(args.model, neurons, args.seeds)
        else:
            jobs = jobs_of([model for model in MODELS if model != _SLOW], neurons, args.seeds)
            slow = _ALL_SLOW_NEURONS if args.all else _SLOW_NEURONS if lens == _SLOW_LENS else ()
            jobs += jobs_of([_SLOW], [hn for hn in slow if hn in neurons], args.seeds)
        work.append((lens, jobs))
    return work


def neuron_counts(text):
    """Hidden neurons of a list such as 4,5,8-10; raises InputError."""
    counts = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        try:
            counts += range(int(first), int(last or first) + 1)
        except ValueError as error:
            raise InputError(f"--neurons is {text!r}, numbers as in 4,5,8-10 are needed") from error
    for count in counts:
        if not 1 <= count <= MAX_NEURONS:
            raise InputError(f"{count} hidden neurons are asked for, the limits are 1 and "
                             f"{MAX_NEURONS}")
    if not counts:
        raise InputError(f"--neurons is {text!r}, which names none")
    return sorted(set(counts))


def _title(model, neurons):
    return f"{model}, {neurons} neurons" if model in NETWORKS else model


def table(rows):
    """Rows of ``fits_of`` as text."""
    lines = [f"{'px², px: on the whole frame from the true map':<47}{'fixed point':>19}",
             f"{'lens':<7} {'model':<16} {'HN':>3} {'MSE':>11} {'mean':>8} {'max':>8} {'MSE':>11} "
             f"{'added':>8} {'CPU s':>6}"]
    for row in rows:
        lines.append(
            f"{row['lens']:<7} {row['model']:<16} {_or_dash(row['hidden_neurons'], '3d')} "
            f"{row['mse']:11.6f} {row['mean']:8.4f} {row['max']:8.4f} "
            f"{_or_dash(row['fixed_mse'], '11.6f')} {_or_dash(row['fixed_added_max'], '8.5f')} "
            f"{row['seconds']:6.1f}")
    return "\n".join(lines)


def by_lens(rows):
    """MSE and largest error of ``rows``, of a network in integers, as a Markdown table.

    It has a column for each lens and a line for each model and number of neurons.
    """
    lenses = list(dict.fromkeys(row["lens"] for row in rows))
    cells = {}
    for row in rows:
        neurons, kind = row["hidden_neurons"], "fixed_" if row["hidden_neurons"] else ""
        name = f"`{row['model']}`" + (f", HN {neurons}" if neurons else "")
        cells.setdefault(name, {}).setdefault(row["lens"], " / ".join(
            np.format_float_positional(row[kind + error], precision=3, fractional=False, trim="-")
            for error in ("mse", "max")))
    lines = [["MSE, px² / max, px", *lenses], ["---"] * (len(lenses) + 1)]
    lines += [[name, *(line.get(lens, "") for lens in lenses)] for name, line in cells.items()]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _or_dash(value, form):
    return f"{'-':>{form.split('.')[0].rstrip('df')}}" if value is None else f"{value:{form}}"
