"""Designs whose synchronisers are metastable, as Verilog to be simulated."""

import itertools
import re
from collections import Counter

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from cocotb_run import Design
from ncdc_hdl.export.verilog import module_verilog
from ncdc_sim.ports import ports_of
from simulations import HDL

__all__ = ["Metastability", "metastable_counts", "metastable_design", "metastable_verilog"]

_KINDS = ("metastable_flop", "metastable_reset")


class _Placeholder(wiring.Component):
    """Placeholder of a module of ``hdl/metastable.v``, with the same ports."""

    def __init__(self, width, number):
        self.number = number
        super().__init__({"clk": In(1), "i": In(width), "o": Out(width)})

    def elaborate(self, platform):
        m = Module()
        m.domains.flop = ClockDomain(local=True, reset_less=True)
        # The number distinguishes equal ones: each has a random sequence of its own.
        m.d.comb += ClockSignal("flop").eq(self.clk)
        m.d.flop += self.o.eq(self.i ^ self.number)
        return m


class MetastableFlop(_Placeholder):
    """First flop of a signal's synchroniser."""


class MetastableReset(_Placeholder):
    """First flop of a synchroniser for the end of an asynchronous reset."""


class Metastability:
    """An Amaranth platform: the first flop of each synchroniser has a module of its own.

    :func:`metastable_verilog` replaces that module by the metastable one.
    """

    def __init__(self):
        self.count = 0      # synchronisers

    def get_ff_sync(self, synchroniser):
        """Amaranth's replacement for an FFSynchronizer."""
        m = Module()
        i, domain, init = synchroniser.i, synchroniser._o_domain, synchroniser._init
        if not synchroniser._reset_less:
            raise ValueError("a synchroniser with a reset is not simulated as metastable")
        m.submodules.first = first = self._first(MetastableFlop, len(i))
        stages = [Signal(len(i), name=f"stage{k}", init=init, reset_less=True)
                  for k in range(1, synchroniser._stages)]
        # The first flop begins as zero.
        m.d.comb += [first.clk.eq(ClockSignal(domain)), first.i.eq(i ^ init)]
        for before, after in zip((first.o ^ init, *stages), stages):
            m.d[domain] += after.eq(before)
        m.d.comb += synchroniser.o.eq(stages[-1])
        return m

    def get_async_ff_sync(self, synchroniser):
        """Amaranth's replacement for an AsyncFFSynchronizer and a ResetSynchronizer."""
        m = Module()
        m.domains.after = ClockDomain(async_reset=True, local=True)
        m.submodules.first = first = self._first(MetastableReset, 1)
        i = synchroniser.i if synchroniser._edge == "pos" else ~synchroniser.i
        stages = [Signal(name=f"stage{k}", init=1) for k in range(1, synchroniser._stages)]
        clock = ClockSignal(synchroniser._o_domain)
        m.d.comb += [first.clk.eq(clock), first.i.eq(i), ClockSignal("after").eq(clock),
                     ResetSignal("after").eq(i), synchroniser.o.eq(stages[-1])]
        for before, after in zip((first.o, *stages), stages):
            m.d.after += after.eq(before)
        return m

    def _first(self, kind, width):
        self.count += 1
        return kind(width, self.count)


def metastable_verilog(verilog):
    """``verilog``, made for the platform :class:`Metastability`, with flops that are metastable.

    Raises
    ------
    ValueError
        If it has none.
    """
    number = itertools.count()

    def replace(match):
        name = match[1]
        kind = next(kind for kind in _KINDS if kind in name)
        ports = ports_of(match[0], name)
        # A reset that never comes is a constant in the module.
        i, declared = ("i", ["input wire [{0}:0] i"]) if "i" in ports else ("1'b0", [])
        head = ", ".join(["input wire clk", *declared, "output wire [{0}:0] o"])
        parameters = [f".WIDTH({ports['o']})"] if kind == "metastable_flop" else []
        parameters = ", ".join([*parameters, f".NUMBER({next(number)})"])
        return (f"module {name} ({head.format(ports['o'] - 1)});\n"
                f"  {kind} #({parameters}) flop (.clk(clk), .i({i}), .o(o));\nendmodule")

    text, count = re.subn(rf"^module (\w*_(?:{'|'.join(_KINDS)})\w*) \(.*?^endmodule", replace,
                          verilog, flags=re.MULTILINE | re.DOTALL)
    if not count:
        raise ValueError("the Verilog has no synchroniser of the platform Metastability")
    return text + (HDL / "metastable.v").read_text()


def metastable_design(component, top="dut", platform=None):
    """:func:`cocotb_run.design_of`, with flops that are metastable."""
    platform = platform or Metastability()
    return Design(top, metastable_verilog(module_verilog(component, top, platform)))


def metastable_counts(log):
    """How often each bit, by its path, took another value than a plain flop, as a lower bound.

    That is its input's value before a change (``late``), or after it (``early``).

    ``log``: what a simulation printed.
    """
    counts = {}
    for path, kind, count in re.findall(r"METASTABLE (\S+) (\w+) (\d+)", log):
        counts.setdefault(path, Counter())[kind] = int(count)
    return counts
