"""The queue with credits after a free-running pipeline."""

from amaranth import *
from amaranth.lib.wiring import In

from formal.properties import always, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_hdl.lib.credits import CreditQueue

__all__ = ["Credits"]


class Credits(Wrapper):
    """``CreditQueue`` after a pipeline of any latency, even a varying one, in front of any reader.

    Asserts that the queue never overflows, that credits are what is on the way, and that all of
    it comes out. ``credit_error`` items too many are issued.
    """

    def __init__(self, depth=6, restart=1, credit_error=0):
        self.credit_error = credit_error
        self.dut = CreditQueue(4, depth=depth, restart=restart)
        super().__init__({"issue": In(1), "arrive": In(1), "ready": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        fragment = self.design(m, dut)
        [queue] = self.queues
        under_way = Signal(range(2 * dut.depth + 1))
        late = Signal(range(self.credit_error + 1))   # issued without leave
        may = Signal()                                # there was space in the clock before
        m.d.sync += [may.eq(dut.space), late.eq(late + (self.issue & ~may))]
        m.d.comb += [dut.issue.eq(self.issue), dut.arrive.eq(self.arrive),
                     dut.o.ready.eq(self.ready)]
        given(m, ~self.issue | may | (late != self.credit_error))
        given(m, ~self.arrive | (under_way != 0))
        m.d.sync += under_way.eq(under_way + self.issue - self.arrive)
        claimed, in_flight, issued, arrived, taken, more = (
            inner(fragment, name)
            for name in ("claimed", "in_flight", "issued", "arrived", "taken", "more"))
        always(m, in_flight + issued == under_way + arrived, "in_flight")
        always(m, claimed + issued == under_way + arrived + queue.level + taken, "claimed")
        always(m, claimed + issued <= dut.depth, "depth")
        for k, (signal, name) in enumerate([(may, "may"), (dut.space, "space"), (more, "more")]):
            always(m, ~signal | (claimed + issued < dut.depth - k), name)
        always(m, ~dut.drained | (under_way == 0), "drained")
        reached(m, queue.level == dut.depth, "full")
        reached(m, ~dut.space & (claimed == dut.restart), "restart")
        reached(m, dut.drained & (queue.level != 0), "at_rest")
        return m
