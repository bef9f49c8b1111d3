"""Whether mutants are equivalent: their module computes the same in every clock, by Yosys."""

import tempfile
from pathlib import Path

from ncdc_bench.mutation.yosys import run_yosys

__all__ = ["SECONDS", "equivalents"]

SECONDS = 120       # for the mutants of a module

_ALONE = 6          # a mutant tried alone has this part of the seconds of all
_PROVED = "Equivalence successfully proven!"


def equivalents(netlist, mutants, seconds=SECONDS):
    """Numbers of the ``mutants`` of one module that are proved equivalent.

    Each holds for all time, whatever the module is given: registers with and without the change
    are matched by name, and induction proves that they and all outputs stay equal. The modules in
    it are cut out, so what they are given must be equal as well.

    Parameters
    ----------
    netlist : str
        RTLIL of the design without mutants.
    mutants : sequence of Mutant
        Those whose proof does not end in time count as different.
    seconds : float
        For all together. If that is too short, each is tried alone, for a part of it. 0: no proofs.
    """
    if not mutants or not seconds:
        return set()
    together = _proved(netlist, mutants, seconds)
    if together is not None:
        return together
    return set().union(*(_proved(netlist, [one], seconds / _ALONE) or set() for one in mutants))


def _proved(netlist, mutants, timeout):
    """Numbers of those that are proved; None if Yosys fails or does not end in time."""
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        (folder / "light.il").write_text(netlist)
        if run_yosys(_script(mutants), folder, timeout) is not None:
            return None
        return {one.number for one in mutants
                if _PROVED in (folder / f"{one.number}.txt").read_text()}


def _script(mutants):
    module = mutants[0].original
    lines = ["read_rtlil light.il", f"copy {module} gold", f"blackbox * gold %d {module} %d",
             "design -save all"]
    for one in mutants:
        lines += [
            "design -load all", one.command, f"rename {module} gate",
            "select -set parts gold/t:* gate/t:* %u gold/t:$* gate/t:$* %u %d",
            "expose -evert -sep : @parts", "select gold gate", "memory -nordff", "opt_clean",
            "select -clear", "equiv_make gold gate equiv", "hierarchy -top equiv", "opt_expr",
            "opt_clean", "equiv_struct", "equiv_simple -undef", "equiv_induct -undef",
            f"tee -o {one.number}.txt equiv_status"]
    return "\n".join(lines)
