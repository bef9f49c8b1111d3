"""The queue of whole packets."""

from functools import reduce
from operator import add

from amaranth import *
from amaranth.hdl import Fragment
from amaranth.lib import data
from amaranth.lib.wiring import In

from formal.properties import always, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_hdl.link.layouts import ENTRY
from ncdc_hdl.link.packet_queue import PacketQueue

__all__ = ["WholePackets"]


class WholePackets(Wrapper):
    """``queue`` between any writer that keeps to its space and any receiver.

    Asserts that a packet that has begun has a beat in each clock until its end, and that no beat is
    read that is not there.
    """

    def __init__(self, queue=PacketQueue, depth=4, packets=2):
        self.dut = queue(depth, packets)
        super().__init__({"put": In(1), "entry": In(ENTRY), "held": In(1), "ready": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        within = dut.elaborate(platform)
        # The memory itself, for induction.
        ports = [within.submodules.beats.read_port(domain="comb") for _ in range(dut.depth)]
        within.d.comb += [port.addr.eq(row) for row, port in enumerate(ports)]
        m.submodules.dut = fragment = Fragment.get(within, platform)
        whole, read = inner(fragment, "whole"), within.submodules.beats.read_ports[0]
        step, consume = read.en, read.addr
        produce = within.submodules.beats.write_ports[0].addr
        level = Signal(range(dut.depth + 1))        # beats that are not read
        m.d.sync += level.eq(level + self.put - step)
        m.d.comb += [dut.put.eq(self.put), dut.entry.eq(self.entry), dut.held.eq(self.held),
                     dut.o.ready.eq(self.ready)]
        given(m, ~self.put | (level != dut.depth))
        given(m, ~(self.put & self.entry.beat.last) | (whole != dut.packets))
        oldest = data.View(ENTRY, read.data)
        going, going_on = Signal(), Signal()
        m.d.comb += going.eq(dut.o.valid & ~oldest.beat.last)
        m.d.sync += going_on.eq(going)
        ends = [data.View(ENTRY, port.data).beat.last
                & ((row + dut.depth - consume) % dut.depth < level)
                for row, port in enumerate(ports)]
        always(m, ~going_on | dut.o.valid, "no_pause")
        always(m, ~step | (level != 0), "there")
        always(m, (level <= dut.depth) & (consume < dut.depth) & (produce < dut.depth)
               & ((consume + level) % dut.depth == produce), "pointers")
        always(m, (whole <= dut.packets) & (reduce(add, ends) == whole + going), "ends")
        reached(m, going & (whole == dut.packets), "full")
        reached(m, going_on & dut.ended & (consume == 0), "around")
        return m
