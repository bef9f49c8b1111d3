"""Mutants killed by the benches, proved equivalent, and survivors."""

from dataclasses import dataclass

from ncdc_bench.mutation.equivalence import equivalent
from ncdc_bench.mutation.mutants import Mutant, mutate, selecting
from ncdc_spec.errors import InputError

__all__ = ["BrokenBench", "Verdict", "judge", "rows", "summary"]

EQUIVALENT, SURVIVED = "equivalent", "survived"


class BrokenBench(RuntimeError):
    """A bench fails on the design without a mutant: its verdicts would say nothing."""


@dataclass(frozen=True)
class Verdict:
    """What became of a mutant.

    Parameters
    ----------
    mutant : Mutant
    by : str
        Name of the bench that fails with it, :data:`EQUIVALENT`, or :data:`SURVIVED`.
    """
    mutant: Mutant
    by: str


def judge(design, *, per_module, seed=1, modules=None, progress=lambda fraction, note="": None):
    """A :class:`Verdict` on each mutant of a design, and the :class:`Mutated` design.

    Parameters
    ----------
    design : Design
    per_module, seed, modules :
        As of :func:`ncdc_bench.mutation.mutants.mutate`.
    progress : callable
        Called with a fraction, 0..1, and a note.

    Raises
    ------
    BrokenBench
        If a bench fails without a mutant.
    InputError
        As of :func:`ncdc_bench.mutation.mutants.mutate`.
    """
    mutated = mutate(design.make, design.top, per_module=per_module, seed=seed, modules=modules)
    for bench in design.benches:
        reason = failure(bench, mutated.verilog, 0)
        if reason is not None:
            raise BrokenBench(f"the bench {bench.name!r} of {design.name} fails without a mutant: "
                              f"{reason}")
    verdicts, killed = [], 0
    for k, mutant in enumerate(mutated.mutants):
        by = verdict(design, mutated, mutant)
        killed += by not in (EQUIVALENT, SURVIVED)
        verdicts.append(Verdict(mutant, by))
        progress((k + 1) / len(mutated.mutants), f", {killed} of {k + 1} killed")
    return verdicts, mutated


def verdict(design, mutated, mutant):
    """Name of the first bench that fails with ``mutant``; else whether it is equivalent."""
    for bench in design.benches:
        if failure(bench, mutated.verilog, mutant.number) is not None:
            return bench.name
    return EQUIVALENT if equivalent(mutated.netlist, mutant) else SURVIVED


def failure(bench, verilog, number):
    """What a bench says of the mutant ``number``, None if nothing."""
    try:
        bench.run(verilog, selecting(number))
    except InputError:
        raise
    except Exception as error:      # whatever fails a test
        return str(error) or type(error).__name__
    return None


def rows(verdicts):
    """A row for each distinct module: counts, and its survivors with line and change."""
    table = {}
    for one in verdicts:
        mutant = one.mutant
        row = table.setdefault(mutant.module, {
            "module": mutant.module, "source": mutant.source, "mutants": 0, "killed": 0,
            "equivalent": 0, "survived": 0, "killed_by": {}, "survivors": []})
        row["mutants"] += 1
        if one.by == EQUIVALENT:
            row["equivalent"] += 1
        elif one.by == SURVIVED:
            row["survived"] += 1
            row["survivors"].append({"line": mutant.line, "change": mutant.change,
                                     "mutant": mutant.command})
        else:
            row["killed"] += 1
            row["killed_by"][one.by] = row["killed_by"].get(one.by, 0) + 1
    return [row | {"score": score(row)} for row in table.values()]


def score(row):
    """Killed of the mutants that are not equivalent, 0..1; 1 if all are."""
    counted = row["mutants"] - row["equivalent"]
    return row["killed"] / counted if counted else 1.0


def summary(table):
    """All rows together, and the lowest score of one."""
    whole = {name: sum(row[name] for row in table)
             for name in ("mutants", "killed", "equivalent", "survived")}
    return {"modules": len(table), **whole, "score": score(whole),
            "lowest_score": min(row["score"] for row in table)}
