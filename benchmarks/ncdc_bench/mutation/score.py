"""Mutants killed by the benches, proved equivalent, and survivors."""

from collections import Counter
from contextlib import ExitStack
from dataclasses import dataclass
from subprocess import SubprocessError

from ncdc_bench.mutation.designs import Bench, PlayedBench
from ncdc_bench.mutation.equivalence import SECONDS, equivalents
from ncdc_bench.mutation.mutants import Mutant, mutate, selecting
from ncdc_bench.mutation.replay import Replay
from ncdc_spec.errors import InputError

__all__ = ["BrokenBench", "Verdict", "judge", "judge_module", "row_of", "summary",
           "trial"]

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
        Name of the bench that finds it, :data:`EQUIVALENT`, or :data:`SURVIVED`.
    """
    mutant: Mutant
    by: str

    @property
    def killed(self):
        """Whether a bench finds it."""
        return self.by not in (EQUIVALENT, SURVIVED)


def judge(design, *, per_module, seed=1, modules=None, skipped=(), seconds=SECONDS,
          progress=lambda fraction, note="": None):
    """Yield a list for each module of a design: a :class:`Verdict` on each of its mutants.

    Parameters
    ----------
    design : Design
    per_module, seed, modules :
        As of :func:`ncdc_bench.mutation.mutants.mutate`.
    skipped : collection of str
        Names of modules that are mutated, but not judged.
    seconds : float
        For proofs in each module, see :func:`ncdc_bench.mutation.equivalence.equivalents`.
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
    groups, done, killed = {}, 0, 0
    for mutant in mutated.mutants:
        if mutant.module not in skipped:
            groups.setdefault(mutant.module, []).append(mutant)
    if not groups:
        return
    total = sum(map(len, groups.values()))
    with ExitStack() as opened:
        trials = [opened.enter_context(trial(design, bench, mutated.verilog))
                  for bench in design.benches]
        for group in groups.values():
            verdicts = judge_module(trials, mutated.netlist, group, seconds)
            done, killed = done + len(group), killed + sum(one.killed for one in verdicts)
            progress(done / total, f", {killed} of {done} killed")
            yield verdicts


def trial(design, bench, verilog):
    """A context that tries mutants of ``verilog`` on a bench, which passes without one.

    Raises
    ------
    BrokenBench
        If it fails, or its simulations give another result when they run again.
    """
    played, transcripts = isinstance(bench, PlayedBench), []
    reason = failure(bench, verilog, transcripts if played else selecting(0))
    if reason is not None:
        raise BrokenBench(f"the bench {bench.name!r} of {design.name} fails without a mutant: "
                          f"{reason}")
    if not played:
        return Rerun(bench, verilog)
    made = Replay(bench.name, transcripts)
    with made:
        again = made.difference(0)
    if again is not None:
        raise BrokenBench(f"the bench {bench.name!r} of {design.name} does not run twice the same: "
                          f"{again}")
    return made


@dataclass(frozen=True)
class Rerun:
    """A bench that runs anew with each mutant.

    Parameters
    ----------
    bench : Bench
    verilog : str
    """
    bench: Bench
    verilog: str

    @property
    def name(self):
        """That of the bench."""
        return self.bench.name

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def difference(self, number):
        """What the bench says of the mutant ``number``, None if nothing; see :func:`failure`."""
        return failure(self.bench, self.verilog, selecting(number))


def failure(bench, verilog, more):
    """Why a bench fails, None if it does not.

    What fails for want of a program, a file or memory says nothing of the design, and is raised.
    """
    try:
        bench.run(verilog, more)
    except (InputError, OSError, MemoryError, SubprocessError):
        raise
    except Exception as error:      # whatever fails a test
        return str(error) or type(error).__name__
    return None


def judge_module(trials, netlist, mutants, seconds=SECONDS):
    """A :class:`Verdict` on each of the ``mutants`` of one module.

    Parameters
    ----------
    trials : sequence of Replay or Rerun
        In the order in which they run until one finds the mutant.
    netlist : str
        RTLIL of the design without mutants.
    mutants : sequence of Mutant
    seconds : float
        As of :func:`judge`.
    """
    by = {one: EQUIVALENT for one in mutants if not one.live}
    by |= {one: name for one in mutants if one.live and (name := killer(trials, one))}
    proved = equivalents(netlist, [one for one in mutants if one not in by], seconds)
    by |= {one: EQUIVALENT for one in mutants if one.number in proved}
    return [Verdict(one, by.get(one, SURVIVED)) for one in mutants]


def killer(trials, mutant):
    """Name of the first bench that finds the ``mutant``, None if none does."""
    return next((one.name for one in trials if one.difference(mutant.number) is not None), None)


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
