"""A mutant of a register's output keeps what the register holds after configuration."""

import re

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_bench.mutation.mutants import mutate


class Held(wiring.Component):
    """A register without a reset, which begins with 0b1010."""
    i: In(4)
    o: Out(4)

    def elaborate(self, platform):
        m = Module()
        held = Signal(4, init=0b1010, reset_less=True)
        m.d.sync += held.eq(self.i)
        m.d.comb += self.o.eq(held)
        return m


def test_a_register_begins_as_without_the_mutant():
    """Without its initial value a changed bit would begin with 0, selected or not."""
    mutated = mutate(Held, "held", per_module=40)
    changed = {int(re.search(r"bit (\d) of Q", one.change)[1]) for one in mutated.mutants
               if "of Q of the register" in one.change}
    assert changed & {1, 3}, "no mutant changes a bit that begins with 1"
    registers = re.findall(r"^ *reg (?:\[\d:\d\] )?(\S+)(?: = (\d)'[hb]([0-9a-f]+))?;",
                           mutated.verilog, re.MULTILINE)
    values = [value for name, _, value in registers if name != "mutant_select"]
    assert values and all(values), registers
    ones = sum(bin(int(value, 16)).count("1") for value in values)
    assert ones == 2
