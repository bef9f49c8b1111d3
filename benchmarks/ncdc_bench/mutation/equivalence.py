"""Whether a mutant is equivalent: its module computes the same in every clock, by Yosys."""

import tempfile
from pathlib import Path

from ncdc_bench.mutation.yosys import run_yosys

__all__ = ["equivalent"]

_TIMEOUT = 60       # seconds for a mutant

def equivalent(netlist, mutant, timeout=_TIMEOUT):
    """Whether a mutant is proved equivalent, for all time, whatever its module is given.

    Registers of the module with and without the change are matched by name; induction proves
    that they and all outputs stay equal.

    Parameters
    ----------
    netlist : str
        RTLIL of the design without mutants.
    mutant : Mutant
    timeout : float
        Seconds; a proof that takes longer counts as none.
    """
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        (folder / "light.il").write_text(netlist)
        return run_yosys(_script(mutant), folder, timeout) is None


def _script(mutant):
    module = mutant.original
    return "\n".join([
        # The modules in it are cut out: what they get are outputs, what they give inputs.
        "read_rtlil light.il", f"copy {module} gold", mutant.command, f"rename {module} gate",
        "select -set parts gold/t:* gate/t:* %u gold/t:$* gate/t:$* %u %d",
        "expose -evert -sep : @parts", "select gold gate",
        "memory -nordff", "opt_clean", "select -clear",
        "equiv_make gold gate equiv", "hierarchy -top equiv", "opt_expr", "opt_clean",
        "equiv_struct", "equiv_simple -undef", "equiv_induct -undef", "equiv_status -assert"])
