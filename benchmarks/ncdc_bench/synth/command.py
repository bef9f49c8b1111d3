"""``ncdc bench synth``: size and clock of the corrector's blocks from open tools."""

from operator import itemgetter

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Steps
from ncdc.text_table import text_table
from ncdc.toolchain.flows import check_tools, tool_versions
from ncdc_bench.synth.blocks import BLOCKS
from ncdc_bench.synth.breakdown_report import run_breakdown
from ncdc_bench.synth.measure import BROKEN_DOWN, TARGETS, block_rows
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run", "table"]

HELP = "size and clock of the corrector's blocks, by open synthesis and placement"
EXAMPLE = "ncdc bench synth --block tansig neuron --target ecp5 --seeds 1"

_SEEDS = 5
_COLUMNS = ("block", "variant", "target", "alm", "le", "lut", "ff", "dsp", "ram_blocks", "fmax_mhz",
            "fmax_plain_mhz")


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--block", nargs="+", choices=list(BLOCKS), default=list(BLOCKS),
                        metavar="NAME", help=f"of {', '.join(BLOCKS)} (default: all)")
    parser.add_argument("--variant", nargs="+", metavar="NAME",
                        help="only these variants of the blocks, as in the table")
    parser.add_argument("--target", nargs="+", choices=TARGETS, metavar="NAME",
                        help=f"of {', '.join(TARGETS)} (default: all)")
    parser.add_argument("--seeds", type=int, metavar="N",
                        help=f"placements on ECP5, whose median clock counts (default: {_SEEDS})")
    parser.add_argument("--plain", action="store_true",
                        help="on ECP5 also the clock of the netlist as Yosys leaves it, the "
                             "registers of RAMs and multipliers unused: twice the placements")
    parser.add_argument("--breakdown", action="store_true",
                        help="what each module takes, on the Cyclones: their flows end with a "
                             "netlist whose cells have names")
    parser.add_argument("--plots", metavar="DIR",
                        help="with --breakdown, a picture of each block too")
    add_json(parser)


def run(args):
    """Synthesise what is not known yet, and report."""
    if args.seeds is not None and args.seeds < 1:
        raise InputError(f"seeds is {args.seeds}, the minimum is 1")
    chosen = [(block, variant) for block in args.block for variant in BLOCKS[block]
              if not args.variant or variant in args.variant]
    if not chosen:
        known = dict.fromkeys(variant for block in args.block for variant in BLOCKS[block])
        raise InputError(f"the variants are {', '.join(args.variant)}, the blocks have "
                         f"{'; '.join(known)}")
    targets = args.target or [name for name in TARGETS
                              if not args.breakdown or name in BROKEN_DOWN]
    if args.plots and not args.breakdown:
        raise InputError(f"--plots {args.plots} is given, it needs --breakdown")
    for option in ("seeds", "plain"):
        if args.breakdown and getattr(args, option):
            raise InputError(f"--{option} is given, --breakdown runs no place and route")
    check_tools()
    if args.breakdown:
        run_breakdown(chosen, targets, args)
        return
    rows = []
    for k, (block, variant) in enumerate(chosen):
        steps = Steps(f"{k + 1} of {len(chosen)}, {block} {variant}")
        rows += block_rows(block, variant, targets, args.seeds or _SEEDS, steps, args.plain)
        steps("done")
    if not write_report({"tools": tool_versions(), "rows": rows}, args.json):
        print(table(rows))


def table(rows):
    """Rows of ``block_rows`` as text."""
    return text_table([(name, itemgetter(name)) for name in _COLUMNS], rows, left=3)
