"""Mutation score of the golden model's arithmetic: which small changes of it no test notices.

Cosmic Ray makes the mutants, each with another operator, number, condition, loop or decorator. The
tests of a module run on each of its mutants, in a process of its own (:mod:`golden_worker`).
Mutants that are equivalent to the module are listed with a reason in ``golden_equivalent.toml``.
"""

import json
import math
import random
import subprocess
import sys
import tomllib
from collections import Counter
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ncdc.cli.common import write_report
from ncdc.terminal import Progress
from ncdc.text_table import text_table
from ncdc_spec.errors import InputError
from ncdc_spec.needs import pip_line

__all__ = ["MIN_SCORE", "MODULES", "Module", "Mutant", "golden_rows", "mutants_of", "run_golden",
           "score", "table"]

MIN_SCORE = .95             # share of the mutants killed, equivalent ones left out

_ROOT = Path(__file__).parents[3]
_LIST = Path(__file__).with_name("golden_equivalent.toml")
_LIBRARIES = ["pytest", "numpy", "cv2", "mpmath", "scipy.spatial", "amaranth.hdl"]
_ALLOWANCE = 5              # seconds of a processor that a mutant may take at least
_TIMES = 10                 # times the seconds of the module itself: more is an endless loop


@dataclass(frozen=True)
class Module:
    """A module whose mutants are made.

    Parameters
    ----------
    name : str
        As in ``import``.
    tests : tuple of str
        Files of ``tests`` that run on a mutant, in this order, until a test fails.
    needs : tuple of str
        Modules imported once for all mutants; none may import the module itself.
    """
    name: str
    tests: tuple
    needs: tuple = ()

    @property
    def source(self):
        """Its file, from the root of the checkout."""
        return f"model/{self.name.replace('.', '/')}.py"


def _golden(name, *tests):
    return Module(f"ncdc_model.golden.{name}", tests, ("ncdc_spec.descriptor",))


def _tansig(name, *tests):
    return Module(f"ncdc_spec.tansig.{name}", tests)


MODULES = {
    "picture": _golden("picture", "model/test_golden_picture.py"),
    "network": _golden("network", "model/test_golden_network.py"),
    "nodes": _golden("nodes", "model/test_golden_nodes.py"),
    "valid": _golden("valid", "model/test_golden_valid.py"),
    "tansig.design": _tansig("design", "model/test_golden_tansig.py"),
    "tansig.lvc": _tansig("lvc", "model/test_golden_lvc.py"),
    "tansig.mmhbc": _tansig("mmhbc", "model/test_golden_mmhbc.py"),
    "tansig.table": _tansig("table", "model/test_golden_table.py"),
}
"""Modules by the names of their rows."""


@dataclass(frozen=True)
class Mutant:
    """One change of a module.

    Parameters
    ----------
    line : int
        Number of the line that changes, from 1.
    before, after : str
        That line, with single spaces; ``after`` is empty if the line is removed.
    text : str
        The whole module with the change.
    """
    line: int
    before: str
    after: str
    text: str

    @property
    def change(self):
        """The lines before and after, which name the mutant in the list of equivalents."""
        return self.before, self.after


def _sites(text):
    """(operator, occurrence, line) of every mutant of a module's ``text``."""
    try:
        from cosmic_ray.ast import ast_nodes, get_ast
        from cosmic_ray.plugins import get_operator, operator_names
    except ImportError:
        raise InputError("cosmic-ray is not installed, which makes the mutants: "
                         + pip_line("test")) from None
    nodes = list(ast_nodes(get_ast(text)))
    found = []
    for name in sorted(operator_names()):
        kind = get_operator(name)
        if kind.arguments():            # names of variables, which a list of mutants cannot guess
            continue
        operator = kind()
        lines = [start[0] for node in nodes for start, _ in operator.mutation_positions(node)]
        found += [(operator, k, line) for k, line in enumerate(lines)]
    return found


def mutants_of(text, number=None, seed=1):
    """Mutants of a module's ``text``, in the order of its lines: a list of :class:`Mutant`.

    ``number``: how many, chosen at random by the ``seed``; all if it is None, or if there are
    fewer.

    Raises
    ------
    InputError
        If Cosmic Ray is not installed.
    """
    sites = _sites(text)
    if number is not None and number < len(sites):
        sites = random.Random(seed).sample(sites, number)
    return [_mutant(text, *site) for site in sorted(sites, key=lambda site: site[2])]


def _mutant(text, operator, occurrence, line):
    from cosmic_ray.mutating import mutate_code
    changed = mutate_code(text, operator, occurrence)
    before, after = text.splitlines(), changed.splitlines()
    same_lines = len(before) == len(after)
    return Mutant(line, *(" ".join(part.split()) for part in
                          (before[line - 1], after[line - 1] if same_lines else "")), changed)


def _equivalents(module):
    """Reasons of the mutants of a module that are listed as equivalent, by their change."""
    entries = tomllib.loads(_LIST.read_text())["equivalent"]
    return {(entry["line"], after): entry["reason"] for entry in entries
            if entry["module"] == module.name for after in entry["mutants"]}


@contextmanager
def _tester(module):
    """A function that says whether the tests of a ``module`` pass with a text, and in how many
    seconds of a processor."""
    job = {"module": module.name, "path": str(_ROOT / module.source),
           "tests": [str(_ROOT / "tests" / file) for file in module.tests]}
    with subprocess.Popen([sys.executable, "-m", "ncdc_bench.mutation.golden_worker"], cwd=_ROOT,
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as worker:
        print(json.dumps([*_LIBRARIES, *module.needs]), file=worker.stdin)

        def test(text, seconds):
            print(json.dumps({**job, "source": text, "seconds": seconds}), file=worker.stdin,
                  flush=True)
            answer = worker.stdout.readline()
            if not answer:
                raise RuntimeError(f"the process that tests {module.name} has ended")
            return json.loads(answer)
        yield test
        worker.stdin.close()


def golden_rows(progress=lambda fraction, note="": None, names=tuple(MODULES), number=None,
                seed=1):
    """Test mutants of the modules ``names``, keys of :data:`MODULES`.

    Parameters
    ----------
    progress : callable
        Called with the fraction done and a note.
    names : sequence of str
    number, seed :
        As of :func:`mutants_of`, for each module.

    Returns
    -------
    list of dict
        For each module ``module``, ``source``, ``tests``, ``mutants``, ``killed``,
        ``equivalent``, ``survived``, ``seconds`` of a processor, ``possible``, the number of all
        mutants, and ``survivors``, a list of dicts with ``file``, ``line`` and ``change``.

    Raises
    ------
    InputError
        If Cosmic Ray is not installed, the tests fail without a mutant, or the list of equivalent
        mutants has one that a test kills, or (if all mutants are made) one that does not exist.
    """
    rows = []
    for k, name in enumerate(names):
        def part(fraction, k=k, name=name):
            progress((k + fraction) / len(names), f" {name}")
        rows.append(_row(name, part, number, seed))
    return rows


def _row(name, progress, number, seed):
    """The row of one module."""
    module = MODULES[name]
    text = (_ROOT / module.source).read_text()
    mutants = mutants_of(text, number, seed)
    reasons = _equivalents(module)
    if number is None and (lost := set(reasons) - {mutant.change for mutant in mutants}):
        raise InputError(f"{_LIST.name} has a mutant of {module.source} that does not exist: "
                         + " -> ".join(min(lost)))
    counts, survivors, total = Counter(), [], 0
    with _tester(module) as test:
        alone = test(text, 600)
        if not alone["passed"]:
            raise InputError(f"the tests of {module.source} fail without a mutant: pytest "
                             + " ".join(f"tests/{file}" for file in module.tests))
        limit = math.ceil(_ALLOWANCE + _TIMES * alone["seconds"])
        for done, mutant in enumerate(mutants):
            progress(done / len(mutants))
            result = test(mutant.text, limit)
            total += result["seconds"]
            listed = mutant.change in reasons
            if listed and not result["passed"]:
                raise InputError(f"{_LIST.name} has a mutant of {module.source} that a test kills, "
                                 f"line {mutant.line}: " + " -> ".join(mutant.change))
            kind = "equivalent" if listed else "survived" if result["passed"] else "killed"
            counts[kind] += 1
            if kind == "survived":
                survivors.append({"file": module.source, "line": mutant.line,
                                  "change": " -> ".join(mutant.change)})
    progress(1)
    return {"module": name, "source": module.source,
            "tests": [f"tests/{file}" for file in module.tests], "possible": len(_sites(text)),
            "mutants": len(mutants),
            **{kind: counts[kind] for kind in ("killed", "equivalent", "survived")},
            "seconds": round(total, 1), "survivors": survivors}


def score(rows):
    """Killed mutants of ``rows`` by those that are not equivalent, 0 to 1; 1 if there is none."""
    killed, survived = (sum(row[kind] for row in rows) for kind in ("killed", "survived"))
    return killed / (killed + survived) if killed + survived else 1.0


def table(rows):
    """Rows of :func:`golden_rows` as text, then the survivors."""
    columns = [(key, lambda row, key=key: row[key])
               for key in ("module", "possible", "mutants", "killed", "equivalent", "survived")]
    columns += [("score, %", lambda row: f"{100 * score([row]):.1f}"),
                ("seconds", lambda row: row["seconds"])]
    lines = [f"{each['file']}:{each['line']}: {each['change']}"
             for row in rows for each in row["survivors"]]
    return "\n".join([text_table(columns, rows, left=1), f"score {100 * score(rows):.1f} %",
                      *lines])


def run_golden(names, number, seed, target):
    """Test mutants with progress on stderr, and print the table; 1 if the score is below its limit.

    ``names``: keys of :data:`MODULES`, None for all. ``number``, ``seed``: as of
    :func:`golden_rows`. ``target``: a file for the report as JSON, "-" for stdout instead of the
    table, or None. An unknown name raises InputError.
    """
    for name in names or ():
        if name not in MODULES:
            raise InputError(f"the module is {name}, one of {', '.join(MODULES)} is needed")
    rows = golden_rows(Progress("mutants"), names or list(MODULES), number, seed)
    if not write_report({"seed": seed, "per_module": number, "rows": rows}, target):
        print(table(rows))
    return int(score(rows) < MIN_SCORE)
