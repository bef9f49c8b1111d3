"""Connects a bus agent as one of several hosts of registers."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import Agent
from ncdc_hdl.registers.access import Access

__all__ = ["AgentAccess"]


class AgentAccess(wiring.Component):
    """Passes accesses at an Avalon-MM agent on, one at a time.

    Timing: the data of a read follow one clock after ``waitrequest`` has fallen.

    Parameters
    ----------
    address_bits : int
        Bits of a word address.

    Members
    -------
    bus : ``In(Agent(address_bits))``
    access : ``Out(Access(address_bits))``
    """

    def __init__(self, address_bits):
        super().__init__({"bus": In(Agent(address_bits)), "access": Out(Access(address_bits))})

    def elaborate(self, platform):
        m = Module()
        bus, access = self.bus, self.access
        m.d.comb += [
            access.valid.eq(bus.read | bus.write), access.write.eq(bus.write),
            access.address.eq(bus.address), access.word.eq(bus.writedata),
            bus.waitrequest.eq(~access.done)]
        m.d.sync += [bus.readdatavalid.eq(bus.read & access.done),
                     bus.readdata.eq(access.answer)]
        return m
