"""Several write hosts on one port of a memory."""


from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import WriteHost

__all__ = ["WriteArbiter"]


class WriteArbiter(wiring.Component):
    """Grants the port to one host after the other, for whole bursts.

    Between two bursts the first ``urgent`` host with a request is granted. Without one,
    it is the next host after the one served last. A command on the bus stays
    there. A reset clears neither the grant nor the burst. Answers to bursts, if
    the memory gives them, go to the hosts of these bursts.

    Timing: no latency; only multiplexers between hosts and bus.

    Parameters
    ----------
    data_width, burst : int
        Bits of a word; most words of a burst.
    hosts : int
    pending : int
        Bursts that may wait for an answer; 0: the memory does not answer.

    Members
    -------
    hosts : ``In(WriteHost(data_width, burst, pending)).array(hosts)``
    urgent : ``In(hosts)``
        A bit for each host.
    memory_rst : ``In(1)``
        The memory and the hosts drop the burst that has begun.
    bus : ``Out(WriteHost(data_width, burst, pending))``
    """

    latency = 0

    def __init__(self, data_width, burst, hosts, pending=0):
        self.count, self.burst, self.pending = hosts, burst, pending
        bus = WriteHost(data_width, burst, pending)
        super().__init__({"hosts": In(bus).array(hosts), "urgent": In(hosts), "memory_rst": In(1),
                          "bus": Out(bus)})

    def elaborate(self, platform):
        m = Module()
        count, bus = self.count, self.bus
        # At least one bit, also for one host: Verilog has no numbers without bits.
        owner = Signal(range(max(2, count)), reset_less=True)   # the host that had the port last
        held = Signal(reset_less=True)                      # it still has the port
        left = Signal(range(self.burst), reset_less=True)   # words of its burst to come
        served = Signal(range(max(2, count)))               # the host that has the port now
        following = Signal(range(self.burst))               # words to come after this clock
        m.d.comb += served.eq(self._chosen(held, owner, self._choice(m, owner)))
        hosts = Array(self.hosts)
        space = self._answers(m, served, left)
        for name, member in bus.signature.members.items():
            if member.flow is Out:
                m.d.comb += getattr(bus, name).eq(getattr(hosts[served], name))
        with m.If(~space):
            m.d.comb += bus.write.eq(0)
        for k, host in enumerate(self.hosts):
            m.d.comb += host.waitrequest.eq(bus.waitrequest | (served != k) | ~space)
        accepted = bus.write & ~bus.waitrequest
        first = left == 0
        m.d.comb += following.eq(Mux(accepted, Mux(first, bus.burstcount, left) - 1, left))
        m.d.sync += [owner.eq(served), left.eq(following),
                     held.eq(bus.write & bus.waitrequest | (following != 0))]
        with m.If(self.memory_rst):
            m.d.sync += [held.eq(0), left.eq(0)]
        return m

    def _chosen(self, held, owner, choice):
        """The host that has the port now. A method of its own only so that proofs can break it."""
        return Mux(held, owner, choice)

    def _choice(self, m, owner):
        """The host that gets the port if it is free."""
        choice = Signal(range(max(2, self.count)))
        wants = [host.write for host in self.hosts]
        # The last assignment wins: hence from the last choice to the first.
        with m.Switch(owner):
            for last in range(self.count):
                with m.Case(last):
                    m.d.comb += choice.eq(last)
                    for step in reversed(range(1, self.count + 1)):
                        k = (last + step) % self.count
                        with m.If(wants[k]):
                            m.d.comb += choice.eq(k)
        for k in reversed(range(self.count)):
            with m.If(self.urgent[k] & wants[k]):
                m.d.comb += choice.eq(k)
        return choice

    def _answers(self, m, served, left):
        """Pass each answer to its burst's host; return whether a word may go to the bus now."""
        if not self.pending:
            return Const(1)
        bus = self.bus
        due = Signal(range(self.pending + 1), reset_less=True)      # answers that are owed
        # Hosts of these bursts, the oldest lowest.
        owners = [Signal(range(max(2, self.count)), name=f"owner{k}", reset_less=True)
                  for k in range(self.pending)]
        first = bus.write & ~bus.waitrequest & (left == 0)
        answered = bus.writeresponsevalid & (due != 0)
        after = Signal.like(due)            # answers that are due after this clock
        m.d.comb += after.eq(due - answered)
        m.d.sync += due.eq(after + first)
        with m.If(answered):
            m.d.sync += [owners[k].eq(owners[k + 1]) for k in range(self.pending - 1)]
        with m.If(first):
            for k in range(self.pending):
                with m.If(after == k):
                    m.d.sync += owners[k].eq(served)
        with m.If(self.memory_rst):
            m.d.sync += due.eq(0)
        for k, host in enumerate(self.hosts):
            m.d.comb += [host.writeresponsevalid.eq(answered & (owners[0] == k)),
                         host.response.eq(bus.response)]
        return (left != 0) | (due != self.pending)
