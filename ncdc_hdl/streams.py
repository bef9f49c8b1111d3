"""Credits between a free-running pipeline and a consumer that may stall."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.memory import Fifo

__all__ = ["CreditQueue"]


class CreditQueue(wiring.Component):
    """Queue behind a free-running pipeline, with the credits that keep it from overflowing.

    A producer may put one item into the pipeline in each clock in which ``room`` is high, and
    says so with ``issue``; the item arrives some clocks later with ``arrive``. ``room`` counts
    what is in the pipeline and in the queue together, so that no stall has to reach into the
    pipeline. Once all places but one are claimed, ``room`` goes low, a clock later as it is a
    register, until no more than ``restart`` items are left: the paper's clock-gating controller as
    a rule on credits.

    Timing: an item leaves 3 clocks after its arrival at the earliest; one item per clock.

    Parameters
    ----------
    shape : ShapeLike
        Of one item.
    depth : int
        Items in the pipeline and the queue together.
    restart : int
        Level at which a full queue asks for more; at least the pipeline's latency, if the
        consumer must not wait for the pipeline to fill again.

    Members
    -------
    room, issue : ``Out(1)``, ``In(1)``
    arrive, i : ``In(1)``, ``In(shape)``
    o : ``Out(stream.Signature(shape))``
    drained : ``Out(1)``
        Nothing is in the pipeline.

    Raises
    ------
    ValueError
        If ``restart`` is not below ``depth - 1``.
    """

    def __init__(self, shape, *, depth, restart):
        if not 0 <= restart < depth - 1:
            raise ValueError(f"restart is {restart}, the limits are 0 and {depth - 2}")
        self.shape, self.depth, self.restart = shape, depth, restart
        super().__init__({
            "room": Out(1), "issue": In(1), "arrive": In(1), "i": In(shape),
            "o": Out(stream.Signature(shape)), "drained": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        width = Shape.cast(self.shape).width
        m.submodules.fifo = fifo = Fifo(width=width, depth=self.depth)
        m.d.comb += [
            fifo.w_data.eq(Value.cast(self.i)),
            fifo.w_en.eq(self.arrive),
            Value.cast(self.o.payload).eq(fifo.r_data),
            self.o.valid.eq(fifo.r_rdy),
            fifo.r_en.eq(self.o.ready),
        ]

        claimed = Signal(range(self.depth + 1))      # in the pipeline or in the queue
        in_flight = Signal(range(self.depth + 1))    # in the pipeline
        room = Signal(init=1)
        m.d.comb += [self.room.eq(room), self.drained.eq(in_flight == 0)]
        m.d.sync += [
            claimed.eq(claimed + self.issue - (self.o.valid & self.o.ready)),
            in_flight.eq(in_flight + self.issue - self.arrive),
        ]
        # One more may be issued in the clock that this takes.
        with m.If(claimed >= self.depth - 1):
            m.d.sync += room.eq(0)
        with m.Elif(claimed <= self.restart):
            m.d.sync += room.eq(1)
        return m
