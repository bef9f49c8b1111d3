"""Recorded runs of components, replayed on their Verilog: what is found, and what means nothing."""

import pytest
from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.export.verilog import module_verilog
from ncdc_sim.tools import SimulationError
from pipelines import run_bench
from simulations.traces import Units, replay, trace


class Sums(wiring.Component):
    """Running sums of every other value; while there is none, the payload is ``idle``."""
    i: In(4)
    o: Out(stream.Signature(8))
    odd: Out(1)

    def __init__(self, step=0, idle=0):
        super().__init__()
        self.step, self.idle = step, idle

    def elaborate(self, platform):
        m = Module()
        total = Signal(8, init=5)
        m.d.sync += [total.eq(total + self.i + self.step), self.o.valid.eq(~self.o.valid)]
        m.d.comb += [self.o.payload.eq(Mux(self.o.valid, total, self.idle)),
                     self.odd.eq(total[0])]
        return m


def count(dut):
    async def bench(ctx):
        for k in range(20):
            ctx.set(dut.i, k % 16)
            await ctx.tick()

    run_bench(dut, bench)


@pytest.fixture(scope="module")
def traces():
    return {"one": trace(Sums(), count), "other": trace(Sums(step=3), count)[:12]}


def run(traces, **parts):
    transcripts, verilog = [], module_verilog(Units(parts), "units")
    replay({"one": Sums(), "other": Sums(step=3)}, traces, verilog, transcripts)
    return transcripts


def test_the_same_components(traces):
    assert traces["one"][0] == (0, 5 % 2 << 9) and len(traces["one"]) == 20
    (transcript,) = run(traces, one=Sums(), other=Sums(step=3))
    lines = [line.split() for line in transcript.lines if line.startswith("RESULT")]
    assert lines[0] == ["RESULT", "total_clocks", "20"] and int(lines[1][2], 16)


def test_a_payload_that_is_not_valid_means_nothing(traces):
    assert run(traces, one=Sums(idle=77), other=Sums(step=3))


@pytest.mark.parametrize("parts", [{"one": Sums(step=16)}, {"other": Sums(step=2)}])
def test_another_output_in_any_clock_is_found(traces, parts):
    with pytest.raises(SimulationError, match="FAILED clock 1:"):
        run(traces, **{"one": Sums(), "other": Sums(step=3)} | parts)
