"""Several write hosts on one port."""

from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib.wiring import In

from formal.properties import always, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_hdl.avalon.write_arbiter import WriteArbiter

__all__ = ["Arbiter"]

_BURST = 3


class Arbiter(Wrapper):
    """``WriteArbiter`` between hosts that keep to the protocol and any memory, reset at any time.

    The hosts go through a reset as if nothing had happened, as burst writers do. Asserts that a
    word reaches the bus if and only if one host's word is accepted; that a burst is one host's from
    its first word to its last; that a command stands while it waits; that an urgent host does not
    wait for more than the burst under way.
    """

    def __init__(self, kind=WriteArbiter, hosts=2):
        self.count = hosts
        self.dut = kind(8, _BURST, hosts)
        super().__init__({"write": In(hosts), "words": In(2 * hosts), "urgent": In(hosts),
                          "waitrequest": In(1), "memory_rst": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut, bus = self.dut, self.dut.bus
        fragment = self.design(m, dut)
        served, left, held, owner = (inner(fragment, name)
                                     for name in ("served", "left", "held", "owner"))
        m.d.comb += [bus.waitrequest.eq(self.waitrequest), dut.urgent.eq(self.urgent),
                     dut.memory_rst.eq(self.memory_rst)]
        lefts = [self._host(m, k) for k in range(self.count)]
        accepted = [host.write & ~host.waitrequest for host in dut.hosts]
        always(m, sum(accepted) <= 1, "one_host")
        always(m, (bus.write & ~bus.waitrequest) == reduce(or_, accepted), "no_word_lost")
        # Words of the burst on the bus still to come, of the host that began it.
        for k, here in enumerate(lefts):
            always(m, (here == 0) | ((owner == k) & (left == here) & held), f"burst_is_one{k}")
        always(m, (left == 0) | held, "held_in_burst")
        always(m, (left == 0) | reduce(or_, (here != 0 for here in lefts)), "burst_of_a_host")
        always(m, owner < self.count, "owner")

        waits = Signal(reset_less=True)
        command = Signal(len(bus.address) + len(bus.burstcount), reset_less=True)
        now = Cat(bus.address, bus.burstcount)
        m.d.sync += [waits.eq(bus.write & bus.waitrequest & ~self.memory_rst), command.eq(now)]
        always(m, ~waits | bus.write & (command == now), "command_held")
        always(m, ~waits | held, "held_while_waiting")
        standing = dut.hosts[0].write & self.urgent[0]
        always(m, held | ~standing | (served == 0), "urgent_first")
        always(m, held | bus.write | ~reduce(or_, (host.write for host in dut.hosts)),
               "one_host_is_served")
        reached(m, (lefts[1] == 1) & dut.hosts[0].write & self.urgent[0], "urgent_waits")
        reached(m, (lefts[0] == 1) & dut.hosts[1].write & ~self.urgent.any(), "other_waits")
        return m

    def _host(self, m, k):
        """Drive a host; words of its burst that are still to come."""
        host = self.dut.hosts[k]
        left = Signal(2, name=f"left_of_{k}", reset_less=True)
        stands = Signal(name=f"stands_{k}", reset_less=True)     # it waited in the clock before
        count = Signal(2, name=f"count_of_{k}", reset_less=True)
        address = Signal(8, name=f"address_of_{k}", reset_less=True)
        words = self.words.word_select(k, 2)
        m.d.comb += [host.write.eq(self.write[k]), host.burstcount.eq(words),
                     host.address.eq(address)]
        given(m, ~host.write | (words != 0))
        given(m, (left == 0) & ~stands | (words == count))
        given(m, ~stands | host.write)
        m.d.sync += [stands.eq(host.write & host.waitrequest), count.eq(words)]
        with m.If(host.write & ~host.waitrequest):
            m.d.sync += [left.eq(Mux(left == 0, words, left) - 1), address.eq(address + 1)]
        with m.If(self.memory_rst):
            m.d.sync += [left.eq(0), stands.eq(0)]
        return left
