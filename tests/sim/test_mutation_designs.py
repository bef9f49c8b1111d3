"""Which modules a design judges; ``test_mutation_benches.py`` runs its benches."""

from mutation.sdram import DESIGN as SDRAM
from mutation.system import DESIGN as SYSTEM
from ncdc_bench.mutation.netlist import distinct_modules


def test_a_design_leaves_the_modules_of_an_instance_to_another():
    assert SDRAM.judged() is None
    every = [one.name for one in distinct_modules(SYSTEM.make(), SYSTEM.top)]
    judged = SYSTEM.judged()
    left = {name for name in every if name not in judged}
    assert {"ncdc_system", "ncdc_system_capture", "ncdc_system_burst_writer"} <= {*judged}
    assert {"ncdc_system_corrector", "ncdc_system_cache", "ncdc_system_relay_entry"} <= left
    assert "ncdc_system_relay_entries" in judged
