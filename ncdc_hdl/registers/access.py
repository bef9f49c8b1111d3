"""Several hosts of one register agent, all in gateware."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import Agent

__all__ = ["Access", "RegisterAccess"]


class Access(wiring.Signature):
    """One register access at a time.

    ``valid`` and the request are held until ``done``, which is high for one clock, with the
    ``answer`` of a read.

    Parameters: ``address_bits`` of a word address.
    """

    def __init__(self, address_bits):
        super().__init__({
            "valid": Out(1), "write": Out(1), "address": Out(address_bits), "word": Out(32),
            "done": In(1), "answer": In(32)})


class RegisterAccess(wiring.Component):
    """Serves several hosts at one Avalon-MM agent, access by access, the first host first.

    Parameters
    ----------
    address_bits : int
    hosts : int

    Members
    -------
    hosts : ``In(Access(address_bits)).array(hosts)``
    bus : ``Out(Agent(address_bits))``
    """

    def __init__(self, address_bits, hosts):
        super().__init__({"hosts": In(Access(address_bits)).array(hosts),
                          "bus": Out(Agent(address_bits))})

    def elaborate(self, platform):
        m = Module()
        bus, count = self.bus, len(self.hosts)
        served = Signal(range(count))       # the host whose access is under way
        done = Signal()
        reads = Signal()
        with m.FSM():
            with m.State("IDLE"):
                for k in reversed(range(count)):
                    host = self.hosts[k]
                    with m.If(host.valid):
                        m.d.sync += [
                            served.eq(k), bus.address.eq(host.address), reads.eq(~host.write),
                            bus.writedata.eq(host.word), bus.write.eq(host.write),
                            bus.read.eq(~host.write)]
                        m.next = "ASK"
            with m.State("ASK"):
                with m.If(~bus.waitrequest):
                    m.d.sync += [bus.read.eq(0), bus.write.eq(0)]
                    m.d.comb += done.eq(~reads | bus.readdatavalid)
                    m.next = "WAIT"
                    with m.If(done):
                        m.next = "DONE"
            with m.State("WAIT"):
                m.d.comb += done.eq(bus.readdatavalid)
                with m.If(done):
                    m.next = "DONE"
            with m.State("DONE"):           # its host sees ``done`` and may make another access
                m.next = "IDLE"
        answers = Signal(32)
        m.d.sync += answers.eq(bus.readdata)
        over = Signal()
        m.d.sync += over.eq(done)
        for k in range(count):
            m.d.comb += [self.hosts[k].done.eq(over & (served == k)),
                         self.hosts[k].answer.eq(answers)]
        return m
