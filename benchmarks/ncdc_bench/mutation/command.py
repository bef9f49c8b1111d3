"""``ncdc bench mutation``: faults that Yosys plants in the gateware, and those that tests find."""

import json
from pathlib import Path

from ncdc.cli.common import add_json, report_failures, write_report
from ncdc.terminal import Progress
from ncdc.text_table import text_table
from ncdc_bench.mutation.equivalence import SECONDS
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "HELP", "MIN_OVERALL", "MIN_SCORE", "add_arguments", "run"]

HELP = "plant faults in the gateware or the golden model, and count those that the tests find"
EXAMPLE = "ncdc bench mutation --design core --module ncdc_row_gate --survivors"

MIN_OVERALL, MIN_SCORE = .97, .90       # share of mutants killed: of all, and in each module

_MUTANTS = 40       # of each module of the gateware
_COLUMNS = ("module", "mutants", "killed", "equivalent", "survived")


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--model", action="store_true",
                        help="of the golden model instead of the gateware")
    parser.add_argument("--design", nargs="+", metavar="NAME",
                        help="what is mutated (default: all designs)")
    parser.add_argument("--module", nargs="+", metavar="NAME",
                        help="distinct modules, by their names in the Verilog, or in the model "
                             "(default: all)")
    parser.add_argument("--per-module", type=int, metavar="N",
                        help=f"mutants of each module, all if there are fewer (default: "
                             f"{_MUTANTS}; of the model all)")
    parser.add_argument("--seed", type=int, default=1, metavar="N",
                        help="of their choice (default: 1)")
    parser.add_argument("--proof-seconds", type=float, metavar="S",
                        help=f"for proofs of equivalence in each module of the gateware, 0: none "
                             f"(default: {SECONDS})")
    parser.add_argument("--survivors", action="store_true",
                        help="print each survivor's line and change")
    parser.add_argument("--add", action="store_true",
                        help="leave alone the modules that the file of --json has, and add the "
                             "others to it, each as soon as it is judged")
    add_json(parser)


def run(args):
    """Judge all mutants; 1 if a score is below its limit."""
    if args.per_module is not None and args.per_module < 1:
        raise InputError(f"mutants per module are {args.per_module}, the least is 1")
    if args.proof_seconds is not None and args.proof_seconds < 0:
        raise InputError(f"the seconds for proofs are {args.proof_seconds}, the least is 0")
    if args.model:
        return _model(args)
    args.per_module = args.per_module or _MUTANTS
    if args.proof_seconds is None:
        args.proof_seconds = SECONDS
    return _gateware(args)


def _model(args):
    """Judge mutants of the golden model."""
    from ncdc_bench.mutation.golden import run_golden  # needs Cosmic Ray

    for name in ("design", "survivors", "add", "proof_seconds"):
        given = getattr(args, name)
        if given is not None and given is not False:    # 0 seconds are given, too
            raise InputError(f"--{name.replace('_', '-')} is given, --model does not support it")
    return run_golden(args.module, args.per_module, args.seed, args.json)


def _gateware(args):
    """Judge mutants of the gateware."""
    from ncdc_bench.mutation.designs import designs  # they need the tests and Amaranth
    from ncdc_bench.mutation.reasons import explained
    from ncdc_bench.mutation.score import judge, row_of, summary

    known = designs()
    chosen = args.design or list(known)
    for name in chosen:
        if name not in known:
            raise InputError(f"the design is {name}, one of {', '.join(known)} is needed")
    report = _recorded(args)
    table = report["rows"]
    for name in chosen:
        skipped = {row["module"] for row in table if row["design"] == name}
        for verdicts in judge(known[name], per_module=args.per_module, seed=args.seed,
                              modules=args.module or known[name].judged(), skipped=skipped,
                              seconds=args.proof_seconds, progress=Progress(name)):
            table.append(explained({"design": name} | row_of(verdicts)))
            report["summary"] = summary(table)
            if args.add:
                write_report(report, args.json)
    if not write_report(report, args.json):
        print(text_table([(name, lambda row, name=name: row[name]) for name in _COLUMNS]
                         + [("score", lambda row: f"{100 * row['score']:.1f} %")],
                         [*table, {"module": "all", **report["summary"]}]))
    if args.survivors:
        for row in table:
            for one in row["survivors"]:
                why = f" ({one['why']})" if "why" in one else ""
                print(f"{row['module']}: {one['line']}: {one['change']}{why}")
    return report_failures("bench mutation", _failures(table, report["summary"]))


def _recorded(args):
    """The report that is added to, or an empty one."""
    empty = {"seed": args.seed, "per_module": args.per_module, "rows": [], "summary": {}}
    if not args.add:
        return empty
    if args.json in (None, "-"):
        raise InputError("--add needs the file of a report: --json FILE")
    path = Path(args.json)
    if not path.exists():
        return empty
    try:
        report = json.loads(path.read_text())
        found = report["seed"], report["per_module"]
        if not all("design" in row for row in report["rows"]):
            raise KeyError("design")
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path} is no report of this command") from error
    if found != (args.seed, args.per_module):
        raise InputError(f"{path} has seed {found[0]} and {found[1]} mutants per module, not "
                         f"{args.seed} and {args.per_module}")
    return report


def _failures(table, whole):
    """Sentences on scores below their limits, and on reasons of mutants that are killed."""
    from ncdc_bench.mutation.reasons import LIST, stale

    found = [f"{LIST.name} has a mutant of {one.design}, {one.module} that does not survive: "
             f"{one.mutant}" for one in stale(table)]
    found += [f"{row['module']} scores {100 * row['score']:.1f} %, {100 * MIN_SCORE:.0f} % is the "
             f"limit" for row in table if row["score"] < MIN_SCORE]
    if whole["score"] < MIN_OVERALL:
        found.append(f"all modules score {100 * whole['score']:.1f} %, {100 * MIN_OVERALL:.0f} % "
                     f"is the limit")
    return found
