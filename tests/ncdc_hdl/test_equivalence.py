"""Every distinct module of ``ncdc.v`` compared with the netlist that Amaranth's converter made.

The corrector is small in what multiplies: two neurons, sixteen tiles. Each planted error is one
that a printer could make, in the text alone.
"""

import re
from dataclasses import replace

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from cameras import barrel_descriptor
from equivalence import prove
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog.convert import Netlist
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import GRADIENT

# Those that are not proved here, and why; whole frames run through them in simulation.
NOT_PROVED = {
    "ncdc_fifo_backmap_queue": "as registers its memory of 128 words is too much for the induction",
    "ncdc_tiles": "as registers its memories of tiles are too much for the induction",
}
# Memories as registers make these take half of the time of all.
LONG = {"ncdc_fifo_interpolator_queue", "ncdc_sync_fifo_buffered_words"}
SHARDS = 8

# Module, what its text has, what an erring printer would have made of it.
PLANTED = [
    ("ncdc_ramp_x", r"(\w+) \+ (\w+)", r"\1 - \2"),
    ("ncdc_pending", r"if \(([^()]+)\) (\w+) <= ", r"\2 <= "),
    ("ncdc_row_gate", r"if \((.*)\) (\w+) <= ", r"if (~(\1)) \2 <= "),
    pytest.param("ncdc_fills", r"\.w_en\(w_en\)([^;]*)\.r_en\(r_en\)", r".w_en(r_en)\1.r_en(w_en)",
                 marks=pytest.mark.longer),
]


@pytest.fixture(scope="module")
def netlist():
    return Netlist(Corrector(barrel_descriptor((16, 12), (16, 12), hidden_neurons=2),
                             Hardware(cache=CacheOptions(16, pending=4, outstanding=2))), "ncdc")


@pytest.fixture(scope="module")
def at_nodes():
    """With the network at nodes, weights in memories, four pixels per clock of 6x6 windows."""
    plain = barrel_descriptor((40, 12), (40, 12), hidden_neurons=4, interpolation=GRADIENT)
    cache = CacheOptions(16, pending=4, outstanding=2, interpolation=GRADIENT)
    return Netlist(Corrector(replace(plain, nodes=8), Hardware(
        data_width=128, output="stream", lanes=4, share=2, cache=cache)), "ncdc")


@pytest.mark.longer
def test_the_others_are_named(netlist):
    names = set(netlist.names.values())
    assert len(names) == len(netlist.names) and LONG | set(NOT_PROVED) < names
    assert len(names - LONG - set(NOT_PROVED)) >= 40


@pytest.mark.parametrize("shard", [
    0, *(pytest.param(k, marks=pytest.mark.regress) for k in range(1, SHARDS))])
def test_modules_are_what_the_converter_made(netlist, shard):
    apart = LONG | set(NOT_PROVED)
    prove_all(netlist, [key for key in netlist.written() if netlist.names[key] not in apart]
              [shard::SHARDS])


@pytest.mark.regress
def test_long_ones_too(netlist):
    prove_all(netlist, [key for key in netlist.written() if netlist.names[key] in LONG])


@pytest.mark.regress
@pytest.mark.parametrize("shard", range(SHARDS))
def test_modules_at_nodes(netlist, at_nodes, shard):
    """Those that are others than without nodes."""
    known = {"\n".join(netlist.lines(key)) for key in netlist.written()}
    others = [key for key in at_nodes.written() if at_nodes.names[key] not in NOT_PROVED
              and "\n".join(at_nodes.lines(key)) not in known]
    assert len(others) >= 30
    prove_all(at_nodes, others[shard::SHARDS])


def prove_all(netlist, originals):
    for original in originals:
        error = prove(netlist, original)
        assert error is None, f"{netlist.names[original]}: {error}"


class NamedNext(wiring.Component):
    """A register without reset whose next value has a name, and no other reader."""
    i: In(4)
    o: Out(4)

    def elaborate(self, platform):
        m = Module()
        following = Signal(4)
        held = Signal(4, reset_less=True)
        with m.If(self.i[0]):
            m.d.comb += following.eq(self.i + 1)
        m.d.sync += held.eq(following)
        m.d.comb += self.o.eq(held)
        return m


def test_a_named_net_that_only_a_register_reads():
    netlist = Netlist(NamedNext(), "named")
    original, = netlist.written()
    assert any("wire [3:0] following = " in line for line in netlist.lines(original))
    assert prove(netlist, original) is None


@pytest.mark.parametrize("name,pattern,wrong", PLANTED)
def test_an_error_of_the_printer_is_found(netlist, name, pattern, wrong):
    original = next(key for key, value in netlist.names.items() if value == name)
    head, end, body = "\n".join(netlist.lines(original)).partition("\n);\n")
    changed = re.sub(pattern, wrong, body, count=1)
    assert changed != body
    text = head + end + changed
    error = prove(netlist, original, text.splitlines())
    assert error is not None and "unproven" in error.lower()
