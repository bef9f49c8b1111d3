"""``ncdc bench``: the figures of the documentation, measured again.

The benches belong to the repository, not to the wheel: nothing here imports them by name.
"""

import sys
from importlib import import_module
from importlib.util import find_spec

from ncdc.toolchain.flows import SynthesisError
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc bench tansig --sampled --no-synth"


def _benches():
    """The module of each bench by its name; none without the repository."""
    return import_module("ncdc_bench.commands").BENCHES if find_spec("ncdc_bench") else {}


def add_arguments(parser) -> None:
    """Declare one subcommand per bench on an argparse parser."""
    benches = _benches()
    names = parser.add_subparsers(dest="bench", metavar="NAME", required=bool(benches))
    for name, module in benches.items():
        sub = names.add_parser(name, help=module.HELP, description=module.HELP,
                               epilog=f"example: {module.EXAMPLE}")
        module.add_arguments(sub)


def run(args) -> int | None:
    """Run the chosen bench; 1 if a figure breaks its own bound or a tool fails.

    Raises
    ------
    InputError
        If the benches are not installed.
    """
    if args.bench is None:
        raise InputError("the benches are not in the wheel: ncdc bench needs a clone of the "
                         "repository, installed with make setup")
    try:
        return _benches()[args.bench].run(args)
    except SynthesisError as error:
        print(f"ncdc bench {args.bench}: {error}", file=sys.stderr)
        return 1
