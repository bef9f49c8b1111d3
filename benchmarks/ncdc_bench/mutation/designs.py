"""What is mutated, and which tests run on it."""

import importlib
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass

from ncdc_bench.mutation.netlist import ROOT, distinct_modules
from ncdc_spec.errors import InputError

__all__ = ["Bench", "Design", "PlayedBench", "designs"]

# Each design and its benches lie with the tests, which run the same benches without a mutant.
_MODULES = ("core", "cache", "front", "nodes", "units", "sums", "system", "camera", "sdram",
            "csi2", "packetiser", "bridges", "screen", "video")


@dataclass(frozen=True)
class Bench:
    """A bench of a design.

    Parameters
    ----------
    name : str
    run : callable
        Called with a Verilog text and further plusargs. Raises AssertionError or SimulationError
        if the design is not as it must be.
    """
    name: str
    run: Callable


@dataclass(frozen=True)
class PlayedBench:
    """A bench whose simulations need no host while they run.

    Mutants run the simulations alone, again and again. Whatever they print or write must be as
    without a mutant, clocks included; a test must compare both as well.

    Parameters
    ----------
    name : str
    run : callable
        Called with a Verilog text and a list, to which it adds a :class:`Transcript` of each of its
        simulations. Raises as a :class:`Bench`.
    """
    name: str
    run: Callable


@dataclass(frozen=True)
class Design:
    """A component with its benches.

    Parameters
    ----------
    name, top : str
        Its name in the report; its top module.
    make : callable
        Makes the component.
    benches : tuple of Bench or PlayedBench
        In the order in which they run until one fails.
    leaves : tuple of str
        Instances, by their paths from the top module, whose modules and all in them are judged
        elsewhere: by another design, or as another instance of this one.
    bare : int
        Levels of modules, from the top on, that only connect their instances and are not judged.
    """
    name: str
    top: str
    make: Callable
    benches: tuple
    leaves: tuple = ()
    bare: int = 0

    def judged(self):
        """Names of the modules that this design judges; None: all."""
        if not self.leaves and not self.bare:
            return None
        return [one.name for one in distinct_modules(self.make(), self.top)
                if not self._leaves(re.sub(r"\$\d+", "", one.original))]

    def _leaves(self, path):
        """Whether the instance ``path`` is judged elsewhere, or nowhere."""
        left = tuple(f"{self.top}.{name}." for name in self.leaves)
        return f"{path}.".startswith(left) or path.count(".") < self.bare


def designs():
    """All designs, by name.

    Raises
    ------
    InputError
        If the tests are not there: the command needs a checkout.
    """
    support = ROOT / "tests" / "support"
    if not (support / "mutation").is_dir():
        raise InputError(f"{support / 'mutation'} is missing: mutation needs a checkout")
    if str(support) not in sys.path:
        sys.path.append(str(support))
    found = [importlib.import_module(f"mutation.{name}").DESIGN for name in _MODULES]
    return {one.name: one for one in found}
