"""A Wishbone bus of 32 bits on an Avalon-MM agent."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import Agent

__all__ = ["Wishbone", "WishboneAgent"]


class Wishbone(wiring.Signature):
    """Classic cycles of 32 bits, from the host's side; ``adr`` counts words."""

    def __init__(self, address_bits):
        super().__init__({
            "adr": Out(address_bits), "dat_w": Out(32), "sel": Out(4), "cyc": Out(1),
            "stb": Out(1), "we": Out(1), "dat_r": In(32), "ack": In(1), "err": In(1),
        })


class WishboneAgent(wiring.Component):
    """Does one access after the other. A write of a part of a word is rejected with ``err``:
    registers are whole words.

    A cycle that its host aborts after the agent has accepted a read is not answered. Its word is
    dropped, and the next access waits for it.

    Timing: the agent is accessed in the clock in which ``stb`` rises. ``ack`` comes in that in
    which it accepts a write or sends the word.

    Parameters
    ----------
    address_bits : int
        Bits of a word address.
    """

    def __init__(self, address_bits):
        super().__init__({"host": In(Wishbone(address_bits)), "agent": Out(Agent(address_bits))})

    def elaborate(self, platform):
        m = Module()
        host, agent = self.host, self.agent
        waiting = Signal()      # a read was accepted, its word has not come
        given_up = Signal()     # its host has aborted it
        asked = host.cyc & host.stb
        partial = host.we & (host.sel != 0xF)
        m.d.comb += [
            agent.address.eq(host.adr), agent.writedata.eq(host.dat_w),
            agent.read.eq(asked & ~host.we & ~waiting),
            agent.write.eq(asked & host.we & ~partial & ~waiting),
            host.dat_r.eq(agent.readdata),
            host.err.eq(asked & partial & ~waiting),
            host.ack.eq(agent.write & ~agent.waitrequest
                        | asked & waiting & ~given_up & agent.readdatavalid),
        ]
        with m.If(agent.read & ~agent.waitrequest):
            m.d.sync += [waiting.eq(1), given_up.eq(0)]
        with m.If(waiting & ~asked):
            m.d.sync += given_up.eq(self._remembered())
        with m.If(waiting & agent.readdatavalid):
            m.d.sync += waiting.eq(0)
        return m

    @staticmethod
    def _remembered():
        """Remember that a host has aborted; a method of its own so that a proof can break it."""
        return 1
