"""A reader on a port of its own, as the planner has it, compared with the memory in Verilog."""

import random
from fractions import Fraction

import pytest

from memory_model import beats
from ncdc_model.planner.delay_steps import DelaySteps
from ncdc_model.planner.memory_timing import ddr3, sdram
from ncdc_model.planner.ports import memory_port
from ncdc_model.planner.reader_reads import BURST, SteadyReads, with_reads

WORDS, BEGIN, CLOCKS = 4, 20, 1500
BASE, SIZE = 1 << 16, 1 << 15       # of the reader's picture


def addresses():
    """Of the commands that are offered as fast as the port accepts them."""
    rng = random.Random(1)
    return [64 * rng.randrange(BASE // 64) for _ in range(100)]


def measured(memory, width, reader):
    """Clocks from the first command's last word to that of the last one, in Verilog."""
    size = BURST * width // 8
    bursts = range(int(CLOCKS * reader.rate) // size) if reader else ()
    found = beats(memory, [
        *([0, BEGIN, address, WORDS] for address in addresses()),
        *([1, BEGIN + int(k * size / reader.rate), BASE + k * size % SIZE, BURST]
          for k in bursts)], width=width, clocks=CLOCKS + 200)[0]
    return found[-1] - found[WORDS - 1]


def planned(memory, width, reader):
    """The same by the planner."""
    port = memory_port(memory, width, with_reads(None, [reader] if reader else [], width // 8,
                                                 memory.access_bytes), DelaySteps(0))
    clock, ends = 0, []
    for address in addresses():
        accepted, end = port.read(clock, address, WORDS)
        clock = accepted + 1
        ends.append(end)
    return ends[-1] - ends[0]


@pytest.mark.parametrize("memory,width", [(sdram(), 32), (ddr3(), 128)])
def test_commands_alone_take_the_clocks_that_they_take_in_verilog(memory, width):
    assert planned(memory, width, None) == measured(memory, width, None)


@pytest.mark.parametrize("memory,width", [(sdram(), 32), (ddr3(), 128)])
@pytest.mark.parametrize("share", [pytest.param(Fraction(1, 4), marks=pytest.mark.longer),
                                   Fraction(1, 2)])
def test_a_reader_takes_the_clocks_that_it_takes_in_verilog(memory, width, share):
    """``share``: of what the memory moves without a pause."""
    reader = SteadyReads(BASE, SIZE, share * width // 8)
    clocks = measured(memory, width, reader)
    assert planned(memory, width, reader) == pytest.approx(clocks, rel=.04)
    assert clocks > (1 + share) * planned(memory, width, None)
