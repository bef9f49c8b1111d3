"""``ncdc bench mutation``: faults that Yosys plants in the gateware, and those that tests find."""

from ncdc.cli.common import add_json, report_failures, write_report
from ncdc.terminal import Progress
from ncdc.text_table import text_table
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "HELP", "MIN_OVERALL", "MIN_SCORE", "add_arguments", "run"]

HELP = "plant faults in the gateware, chosen by Yosys, and count those that its tests find"
EXAMPLE = "ncdc bench mutation --design core --module ncdc_row_gate --per-module 10"

MIN_OVERALL, MIN_SCORE = .97, .90       # share of mutants killed: of all, and in each module

_COLUMNS = ("module", "mutants", "killed", "equivalent", "survived")


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--design", nargs="+", metavar="NAME",
                        help="what is mutated (default: all designs)")
    parser.add_argument("--module", nargs="+", metavar="NAME",
                        help="distinct modules, by their names in the Verilog (default: all)")
    parser.add_argument("--per-module", type=int, default=40, metavar="N",
                        help="mutants of each module, all if there are fewer (default: 40)")
    parser.add_argument("--seed", type=int, default=1, metavar="N",
                        help="of Yosys's choice (default: 1)")
    parser.add_argument("--survivors", action="store_true",
                        help="print each survivor's line and change")
    add_json(parser)


def run(args):
    """Judge all mutants; 1 if a score is below its limit."""
    from ncdc_bench.mutation.designs import designs  # they need the tests and Amaranth
    from ncdc_bench.mutation.score import judge, rows, summary

    known = designs()
    chosen = args.design or list(known)
    for name in chosen:
        if name not in known:
            raise InputError(f"the design is {name}, one of {', '.join(known)} is needed")
    if args.per_module < 1:
        raise InputError(f"mutants per module are {args.per_module}, the least is 1")
    table = []
    for name in chosen:
        verdicts, _ = judge(known[name], per_module=args.per_module, seed=args.seed,
                            modules=args.module, progress=Progress(name))
        table += [{"design": name} | row for row in rows(verdicts)]
    report = {"seed": args.seed, "per_module": args.per_module, "rows": table,
              "summary": summary(table)}
    if not write_report(report, args.json):
        print(text_table([(name, lambda row, name=name: row[name]) for name in _COLUMNS]
                         + [("score", lambda row: f"{100 * row['score']:.1f} %")],
                         [*table, {"module": "all", **report["summary"]}]))
    if args.survivors:
        for row in table:
            for one in row["survivors"]:
                print(f"{row['module']}: {one['line']}: {one['change']}")
    return report_failures("bench mutation", _failures(table, report["summary"]))


def _failures(table, whole):
    """Sentences on scores below their limits."""
    found = [f"{row['module']} scores {100 * row['score']:.1f} %, {100 * MIN_SCORE:.0f} % is the "
             f"limit" for row in table if row["score"] < MIN_SCORE]
    if whole["score"] < MIN_OVERALL:
        found.append(f"all modules score {100 * whole['score']:.1f} %, {100 * MIN_OVERALL:.0f} % "
                     f"is the limit")
    return found
