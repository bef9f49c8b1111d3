"""Which modules a design judges; ``test_mutation_benches.py`` runs its benches."""

from mutation.camera import DESIGN as CAMERA
from mutation.sdram import DESIGN as SDRAM
from mutation.system import DESIGN as SYSTEM
from ncdc_bench.mutation.netlist import distinct_modules


def test_a_design_leaves_the_modules_of_an_instance_to_another():
    assert SDRAM.judged() is None
    every = [one.name for one in distinct_modules(SYSTEM.make(), SYSTEM.top)]
    judged = SYSTEM.judged()
    left = {name for name in every if name not in judged}
    assert "ncdc_system" in judged
    assert {"ncdc_system_corrector", "ncdc_system_cache", "ncdc_system_relay_entry",
            "ncdc_system_capture", "ncdc_system_burst_writer"} <= left


def test_what_the_system_leaves_is_judged_alone():
    """Each class below it, outside the corrector, is a module of the design of its parts."""
    def sources(design, names):
        return {one.source for one in distinct_modules(design.make(), design.top)
                if one.name in names and one.source}

    system = distinct_modules(SYSTEM.make(), SYSTEM.top)
    outside = {one.name for one in system if one.original != SYSTEM.top
               and not one.original.startswith(f"{SYSTEM.top}.corrector")}
    judged = {*CAMERA.judged()}
    assert sources(SYSTEM, outside) <= sources(CAMERA, judged)
    wrappers = {one.name for one in distinct_modules(CAMERA.make(), CAMERA.top)
                if one.source.startswith("simulations") or one.original.count(".") < 2}
    assert wrappers and not wrappers & judged
