"""Alignment of the lanes of a burst with each other."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.csi2.layouts import BYTES, words
from ncdc_hdl.lib.pipeline import register
from ncdc_spec.sensors.csi2 import MAX_SKEW

__all__ = ["LaneAligner"]


class LaneAligner(wiring.Component):
    """Delays each lane so that the first bytes of a burst leave in the same clock.

    A burst begins with the first lane that is active and ends with the last one. If a lane has no
    byte within ``MAX_SKEW`` clocks of another lane's first one, the burst is dropped. Each burst
    that is dropped, or has no byte at all, is reported at its end. A burst that is under way at the
    end of a reset is ignored.

    Timing: free-running. A byte of the last lane leaves ``latency`` clocks later. Between two
    bursts no lane is active for at least ``min_gap`` clocks.

    Parameters
    ----------
    lanes : int

    Members
    -------
    i : ``In(BYTES).array(lanes)``
    o : ``Out(words(lanes))``
    unaligned : ``Out(1)``
        High for a clock after a burst that was dropped.
    """

    latency = 1

    min_gap = 2
    """Clocks without an active lane, after which the next burst may begin."""

    def __init__(self, lanes):
        self.lanes = lanes
        super().__init__({"i": In(BYTES).array(lanes), "o": Out(words(lanes)),
                          "unaligned": Out(1)})

    def elaborate(self, platform):
        m = Module()
        burst = Signal()                # a lane is active
        started = Signal(init=1)        # all lanes have begun, or this burst is ignored
        running = Signal()              # words leave
        waits = [Signal(range(MAX_SKEW + 2), name=f"wait{k}") for k in range(self.lanes)]
        active = Cat(lane.active for lane in self.i).any()
        late = Cat(wait == MAX_SKEW + 1 for wait in waits).any()
        start = Signal()
        m.d.comb += start.eq(Cat(lane.valid for lane in self.i).all() & ~started & ~late)
        delayed = [self._delayed(m, k, wait) for k, wait in enumerate(waits)]
        # Lane 0 has the last byte of a burst, alone or with others.
        valid = delayed[0][8]

        m.d.sync += [burst.eq(active), running.eq((start | running) & valid)]
        with m.If(start):
            m.d.sync += started.eq(1)
        with m.Elif(~active):
            m.d.sync += [started.eq(0), *(wait.eq(0) for wait in waits)]
        with m.Elif(~started):
            for wait, lane in zip(waits, self.i):
                with m.If(lane.valid & (wait != MAX_SKEW + 1)):
                    m.d.sync += wait.eq(wait + 1)
        m.d.comb += [
            self.o.data.eq(register(m, "data", Cat(lane[:8] for lane in delayed))),
            self.o.valid.eq(running),
            self.unaligned.eq(register(m, "unaligned_", burst & ~active & ~started,
                                       reset_less=False))]
        return m

    def _delayed(self, m, number, wait):
        """Data and valid of a lane as they were ``wait`` clocks ago."""
        lane = self.i[number]
        now = Cat(lane.data, lane.valid)
        history = [now]
        for k in range(MAX_SKEW):
            history.append(register(m, f"lane{number}_d{k}", history[-1], reset_less=False))
        near = Mux(wait[1], Mux(wait[0], history[3], history[2]),
                   Mux(wait[0], history[1], history[0]))
        return Mux(wait[2], history[4], near)
