"""The sums of a frame's colours, alone: frames so large that the highest bits count."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.backend.colour import SUMS, ColourSums
from ncdc_sim.runner import build_bench, command_of
from ncdc_sim.tools import SimulationError
from ncdc_sim.transcript import transcribed
from simulations import HDL

__all__ = ["DESIGN", "sum_frames"]

_LARGEST = 8_700_000    # clocks of white pixels that set bit 31 of a sum


class Sums(wiring.Component):
    """The sums of one lane; ``start`` is their ``begin``, which is a word of Verilog."""
    start: In(1)
    counts: In(1)
    i: In(24)
    sums: Out(SUMS)

    def elaborate(self, platform):
        m = Module()
        m.submodules.colour_sums = sums = ColourSums(1)
        m.d.comb += [sums.begin.eq(self.start), sums.counts.eq(self.counts),
                     Value.cast(sums.i).eq(self.i), self.sums.eq(sums.sums)]
        return m


def sum_frames(clocks, frame):
    """The bench of frames, each of ``frame`` clocks, compared with the bench's own sums."""
    def bench(verilog, transcripts=None):
        program = build_bench("sums", "sums_bench", [
            ("sums.v", verilog), ("sums_bench.v", (HDL / "sums_bench.v").read_text())])
        lines = []
        transcribed([*command_of(program), f"+clocks={clocks}", f"+frame={frame}"], lines.append,
                    transcripts)
        if not any(line.startswith("RESULT sums") for line in lines):
            raise SimulationError(f"the sums are wrong: {lines}")
    return bench


DESIGN = Design("sums", "sums", Sums, (
    PlayedBench("small frames", sum_frames(20_000, 1500)),
    PlayedBench("a large frame", sum_frames(_LARGEST, _LARGEST))), bare=1)
