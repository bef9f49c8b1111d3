"""``ncdc bench``: the figures of the documentation, measured again."""

import sys

from ncdc.toolchain.flows import SynthesisError
from ncdc_bench.accuracy import command as accuracy
from ncdc_bench.client import command as client
from ncdc_bench.grid import command as grid
from ncdc_bench.lines import command as lines
from ncdc_bench.network import command as network
from ncdc_bench.nodes import command as nodes
from ncdc_bench.photos import command as photos
from ncdc_bench.pictures import command as pictures
from ncdc_bench.synth import command as synth
from ncdc_bench.system import command as system
from ncdc_bench.tansig import command as tansig
from ncdc_bench.throughput import command as throughput
from ncdc_bench.truth import command as truth
from ncdc_bench.window import command as window

__all__ = ["BENCHES", "EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc bench tansig --sampled --no-synth"
BENCHES = {"accuracy": accuracy, "client": client, "grid": grid, "lines": lines,
           "network": network, "nodes": nodes, "photos": photos, "pictures": pictures,
           "synth": synth, "system": system, "tansig": tansig, "throughput": throughput,
           "truth": truth, "window": window}


def add_arguments(parser):
    """Declare one subcommand per bench on an argparse parser."""
    names = parser.add_subparsers(dest="bench", metavar="NAME", required=True)
    for name, module in BENCHES.items():
        sub = names.add_parser(name, help=module.HELP, description=module.HELP,
                               epilog=f"example: {module.EXAMPLE}")
        module.add_arguments(sub)


def run(args):
    """Run the chosen bench; 1 if a figure breaks its own bound or a tool fails."""
    try:
        return BENCHES[args.bench].run(args)
    except SynthesisError as error:
        print(f"ncdc bench {args.bench}: {error}", file=sys.stderr)
        return 1
