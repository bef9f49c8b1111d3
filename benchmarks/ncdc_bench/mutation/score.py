"""Mutants killed by the benches, proved equivalent, and survivors."""

from collections import Counter
from contextlib import ExitStack
from dataclasses import dataclass
from subprocess import SubprocessError

from ncdc_bench.mutation.equivalence import SECONDS, equivalents
from ncdc_bench.mutation.mutants import Mutant, mutate
from ncdc_bench.mutation.replay import Replay
from ncdc_spec.errors import InputError

__all__ = ["BrokenBench", "Verdict", "judge", "judge_module", "replay", "row_of", "summary"]

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
        replays = [opened.enter_context(replay(design, bench, mutated.verilog))
                   for bench in design.benches]
        for group in groups.values():
            verdicts = judge_module(replays, mutated.netlist, group, seconds)
            done, killed = done + len(group), killed + sum(one.killed for one in verdicts)
            progress(done / total, f", {killed} of {done} killed")
            yield verdicts


def replay(design, bench, verilog):
    """The :class:`Replay` of a bench that passes without a mutant.

    Raises
    ------
    BrokenBench
        If it fails, or its simulations give another result when they run again.
    """
    transcripts = []
    try:
        bench.run(verilog, transcripts)
    except (InputError, OSError, MemoryError, SubprocessError):
        raise
    except Exception as error:      # whatever fails a test
        raise BrokenBench(f"the bench {bench.name!r} of {design.name} fails without a mutant: "
                          f"{error or type(error).__name__}") from error
    made = Replay(bench.name, transcripts)
    with made:
        again = made.difference(0)
    if again is not None:
        raise BrokenBench(f"the bench {bench.name!r} of {design.name} does not run twice the same: "
                          f"{again}")
    return made


def judge_module(replays, netlist, mutants, seconds=SECONDS):
    """A :class:`Verdict` on each of the ``mutants`` of one module.

    Parameters
    ----------
    replays : sequence of Replay
        In the order in which they run until one finds the mutant.
    netlist : str
        RTLIL of the design without mutants.
    mutants : sequence of Mutant
    seconds : float
        As of :func:`judge`.
    """
    by = {one: EQUIVALENT for one in mutants if not one.live}
    by |= {one: name for one in mutants if one.live and (name := killer(replays, one))}
    proved = equivalents(netlist, [one for one in mutants if one not in by], seconds)
    by |= {one: EQUIVALENT for one in mutants if one.number in proved}
    return [Verdict(one, by.get(one, SURVIVED)) for one in mutants]


def killer(replays, mutant):
    """Name of the first bench that finds the ``mutant``, None if none does."""
    return next((one.name for one in replays if one.difference(mutant.number) is not None), None)


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
