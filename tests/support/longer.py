"""Which tests `make test` leaves to `make longer`, because a newcomer would wait for them.

    python -m pytest -m 'not regress' --cpu-times new.txt       # nothing kept from earlier runs
    python -m pytest -m 'not regress' --cpu-times again.txt
    python tests/support/longer.py new.txt again.txt > tests/longer.txt

What several tests share, a folder or a build, is paid for by the first of them, and by the next
one when that is left out. Nothing kept from earlier runs, and not so often that a block is left
without its tests:

    python -m pytest -m 'not regress and not longer' --cpu-times rest.txt
    python tests/support/longer.py rest.txt > grown.txt && mv grown.txt tests/longer.txt
"""

import resource
import sys
from pathlib import Path

import pytest

__all__ = ["COLLECTED", "LIMIT", "LONGER", "SHARED", "STAYS", "cpu_seconds", "grown", "longer"]

LIMIT = 1       # seconds of a processor, on a new machine and in another run
SHARED = 5      # seconds of a processor that a test may take for what others use after it

COLLECTED = pytest.StashKey()           # names of all tests, before any is left out
LONGER = frozenset((Path(__file__).parents[1] / "longer.txt").read_text().splitlines())

# Longer than that, and still what a newcomer should see: both simulators correct a frame, for each
# interpolation; AXI, the camera, the network and the processor's program; a proof; the printer of
# the Verilog.
STAYS = {
    "tests/ncdc_hdl/test_corrector.py::test_verilog_equals_golden[icarus-hostile-hardware0]",
    "tests/ncdc_hdl/test_corrector.py::test_verilog_equals_golden[verilator-hostile-hardware1]",
    "tests/ncdc_hdl/test_equivalence.py::test_modules_are_what_the_converter_made[0]",
    "tests/ncdc_hdl/test_formal.py::test_holds[tokens]",
    "tests/sim/test_axi.py::test_every_pixel[memory-rough-icarus]",
    "tests/sim/test_gradient.py::test_a_frame_is_that_of_the_golden_model",
    "tests/sim/test_system.py::test_every_frame_is_its_own_raw_frame_corrected[True]",
    "tests/soc/test_ethernet_wires.py::test_small_picture_leaves",
    "tests/soc/test_soc_firmware.py::test_any_frames"}


def cpu_seconds():
    """Seconds of a processor so far, of this process and of its children that have ended."""
    return sum(used.ru_utime + used.ru_stime for used in map(
        resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


def longer(new, again):
    """Names of the tests that take too long, in order, from what two runs took by their names.

    Raises
    ------
    ValueError
        If a test that stays is not among them.
    """
    gone = STAYS - set(new)
    if gone:
        raise ValueError(f"no such test: {', '.join(sorted(gone))}")
    return sorted(name for name, seconds in new.items() if name not in STAYS
                  and max(seconds, again.get(name, 0)) >= LIMIT)


def grown(rest):
    """Names of the tests of ``tests/longer.txt``, and of those that take long of the rest."""
    return sorted(LONGER | {name for name, seconds in rest.items()
                            if name not in STAYS and seconds >= SHARED})


def _times(path):
    rows = (line.split(" ", 1) for line in Path(path).read_text().splitlines())
    return {name: float(seconds) for seconds, name in rows}


if __name__ == "__main__":
    times = [*map(_times, sys.argv[1:])]
    print("\n".join(grown(*times) if len(times) == 1 else longer(*times)))
