"""``ncdc doctor``: what is installed and what is missing, by purpose."""

import json
import platform
import sys
from importlib.metadata import version

from ncdc.capabilities import CAPABILITIES, missing

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc doctor"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--json", metavar="FILE", help="write the report as JSON; - for stdout")


def run(args) -> int | None:
    """Check and report; 1 if something is missing without which no command works."""
    found = [(capability, missing(capability)) for capability in CAPABILITIES]
    report = {"ncdc": version("ncdc"), "python": platform.python_version(),
              "system": platform.platform(),
              "capabilities": [{"purpose": one.purpose, "base": one.base,
                                "missing": [vars(thing) for thing in lost]} for one, lost in found]}
    if not _write(report, args.json):
        _print(report)
    needed = [thing.what for one, lost in found if one.base for thing in lost]
    if needed:
        print(f"ncdc doctor: no command works without {', '.join(needed)}", file=sys.stderr)
    return 1 if needed else 0


def _write(report, target):
    """Write JSON as the other commands do, if the packages that they need are there.

    Returns True if it went to stdout.
    """
    if target in (None, "-"):
        if target:
            print(json.dumps(report, indent=2))
        return bool(target)
    from ncdc_spec.files import write_stream
    write_stream(target, json.dumps(report, indent=2) + "\n")
    return False


def _print(report):
    print(f"NCDC {report['ncdc']}, Python {report['python']}, {report['system']}")
    for one in report["capabilities"]:
        print(f"{'missing' if one['missing'] else 'ok':<8} {one['purpose']}")
        lines = {}
        for thing in one["missing"]:
            lines.setdefault(thing["line"], []).append(thing["what"])
        for line, names in _joined(lines):
            print(f"         {', '.join(names)}: {line}")


def _joined(lines):
    """(line to type, names of what it brings); several of ``apt install`` as one."""
    start = "apt install "
    apt = [line for line in lines if line.startswith(start)]
    together = [line for line in lines if line not in apt]
    pairs = [(line, lines[line]) for line in together]
    if apt:
        words = dict.fromkeys(word for line in apt for word in line.removeprefix(start).split())
        pairs.append((start + " ".join(words), [name for line in apt for name in lines[line]]))
    return pairs
