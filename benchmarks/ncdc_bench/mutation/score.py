"""Mutants killed by the benches, proved equivalent, and survivors."""

from collections import Counter
from dataclasses import dataclass
from subprocess import SubprocessError

from ncdc_bench.mutation.equivalence import equivalents
from ncdc_bench.mutation.mutants import Mutant, mutate, selecting
from ncdc_spec.errors import InputError

__all__ = ["BrokenBench", "Verdict", "judge", "judge_module", "row_of",
           "summary"]

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

    @property
    def killed(self):
        """Whether a bench fails with it."""
        return self.by not in (EQUIVALENT, SURVIVED)


def judge(design, *, per_module, seed=1, modules=None, skipped=(),
          progress=lambda fraction, note="": None):
    """Yield a list for each module of a design: a :class:`Verdict` on each of its mutants.

    Parameters
    ----------
    design : Design
    per_module, seed, modules, skipped :
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
    mutated = mutate(design.make, design.top, per_module=per_module, seed=seed, modules=modules,
                     skipped=skipped)
    for bench in design.benches:
        reason = failure(bench, mutated.verilog, 0)
        if reason is not None:
            raise BrokenBench(f"the bench {bench.name!r} of {design.name} fails without a mutant: "
                              f"{reason}")
    groups, done, killed = {}, 0, 0
    for mutant in mutated.mutants:
        groups.setdefault(mutant.module, []).append(mutant)
    for group in groups.values():
        verdicts = judge_module(design, mutated, group)
        done, killed = done + len(group), killed + sum(one.killed for one in verdicts)
        progress(done / len(mutated.mutants), f", {killed} of {done} killed")
        yield verdicts


def judge_module(design, mutated, mutants):
    """A :class:`Verdict` on each of the ``mutants`` of one module."""
    by = {one: EQUIVALENT for one in mutants if not one.live}
    by |= {one: name for one in mutants
           if one.live and (name := killer(design.benches, mutated, one))}
    proved = equivalents(mutated.netlist, [one for one in mutants if one not in by])
    by |= {one: EQUIVALENT for one in mutants if one.number in proved}
    return [Verdict(one, by.get(one, SURVIVED)) for one in mutants]


def killer(benches, mutated, mutant):
    """Name of the first of ``benches`` that fails with ``mutant``, None if none does."""
    return next((bench.name for bench in benches
                 if failure(bench, mutated.verilog, mutant.number) is not None), None)


def failure(bench, verilog, number):
    """What a bench says of the mutant ``number``, None if nothing.

    What fails for want of a program, a file or memory says nothing of the mutant, and is raised.
    """
    try:
        bench.run(verilog, selecting(number))
    except (InputError, OSError, MemoryError, SubprocessError):
        raise
    except Exception as error:      # whatever fails a test
        return str(error) or type(error).__name__
    return None


def row_of(verdicts):
    """The row of a distinct module: counts, and its survivors with line and change."""
    first = verdicts[0].mutant
    killers = Counter(one.by for one in verdicts if one.killed)
    survivors = [one.mutant for one in verdicts if one.by == SURVIVED]
    row = {"module": first.module, "source": first.source, "mutants": len(verdicts),
           "killed": killers.total(), "equivalent": sum(one.by == EQUIVALENT for one in verdicts),
           "survived": len(survivors), "killed_by": dict(killers),
           "survivors": [{"line": one.line, "change": one.change, "mutant": one.command}
                         for one in survivors]}
    return row | {"score": score(row)}


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
