"""The memory model in Verilog as a design of its own, for the cocotb benches."""

import json
import re

from cocotb_run import Design, run_cocotb
from ncdc_sim.memory.timing import memory_settings
from ncdc_sim.runner import HDL

__all__ = ["beats", "memory_model"]


def memory_model(width=32, planted=("", "")):
    """The model with two read ports and 128 KB.

    ``planted``: a text of dram_timing.v and what replaces it.
    """
    timing = (HDL / "dram_timing.v").read_text()
    assert planted[0] in timing
    model = ((HDL / "avalon_memory.v").read_text()
             .replace("parameter PORTS = 1", "parameter PORTS = 2")
             .replace("parameter DATA_WIDTH = 32", f"parameter DATA_WIDTH = {width}")
             .replace("parameter BYTES = 65536", "parameter BYTES = 131072"))
    return Design("avalon_memory", timing.replace(*planted, 1) + model, ("dram_timing",))


def beats(memory, reads, writes=(), *, width=32, clocks=150, simulator="icarus", **options):
    """Clocks of the beats of both ports; reads and writes: (port, clock, address, words)."""
    log = run_cocotb(memory_model(width, **options), "dram_timing", simulator, seed=1,
                     memory=memory_settings(memory, width, 2), reads=list(reads),
                     writes=list(writes), clocks=clocks)
    return json.loads(re.search(r"BEATS (.*)", log)[1])["beats"]
