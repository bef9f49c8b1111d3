"""Credits between a free-running pipeline and a consumer that may stall."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.memory import Fifo
from ncdc_hdl.lib.pipeline import register

__all__ = ["CreditQueue", "Credited"]

# Items that may still be issued after ``claimed`` reaches the limit: one in the clock of
# each of the two registers of ``space``, one in the producer's clock after them, and one in that of
# the register of ``issue``.
_MARGIN = 4


class Credited(wiring.Signature):
    """Items that do not wait: their receiver has space for each item before it is on its way.

    The source may announce one item, with ``issue``, in the clock after each in which ``space`` is
    high. The item is at ``payload`` with ``valid`` a fixed number of clocks later, for one clock.

    Members
    -------
    space, issue, valid, payload : ``In(1)``, ``Out(1)``, ``Out(1)``, ``Out(shape)``
    """

    def __init__(self, shape):
        super().__init__({"space": In(1), "issue": Out(1), "valid": Out(1),
                          "payload": Out(shape)})


class CreditQueue(wiring.Component):
    """Queue after a free-running pipeline, with credits that prevent its overflow.

    A producer may put one item into the pipeline, with ``issue``, in the clock after each in which
    ``space`` is high. The item arrives some clocks later with ``arrive``. ``space`` counts the
    items in pipeline and queue together, so that no stall has to reach into the
    pipeline. Once all slots but four are claimed, ``space`` goes low, until at most
    ``restart`` items are left. It is the paper's clock-gating controller as a rule on credits.

    Timing: there are registers on all paths between queue and pipeline, which may be far from each
    other. ``space`` goes low 4 clocks after the last issue but four. An item leaves at least
    4 clocks after its arrival; one item per clock.

    Parameters
    ----------
    shape : ShapeLike
        Shape of one item.
    depth : int
        Items in the pipeline and the queue together.
    restart : int
        Level at which a full queue accepts more, by default the highest one. It is at least the
        pipeline's latency and ``loop``, if the consumer must not wait for the pipeline to fill
        again.

    Members
    -------
    space : ``Out(1)``
        An item may be put into the pipeline in the next clock.
    issue : ``In(1)``
        An item is put into the pipeline in this clock.
    arrive, i : ``In(1)``, ``In(shape)``
        An item leaves the pipeline in this clock, and that item.
    o : ``Out(stream.Signature(shape))``
    drained : ``Out(1)``
        The pipeline is empty; some clocks late, but low from the first issue's next clock on.

    Raises
    ------
    ValueError
        If ``restart`` is not below ``depth - 4``.
    """

    latency = 1 + Fifo.latency
    """Clocks from an item's arrival to its appearance at ``o``: a register, the queue."""

    loop = 9
    """Clocks from an item taken to the next one in its slot, less the pipeline's."""

    @classmethod
    def min_depth(cls, latency):
        """The smallest depth with which a pipeline of ``latency`` clocks causes no wait."""
        return latency + cls.loop + _MARGIN + 1

    def __init__(self, shape, *, depth, restart=None):
        restart = depth - _MARGIN - 1 if restart is None else restart
        if not 0 <= restart < depth - _MARGIN:
            raise ValueError(f"restart is {restart}, the limits are 0 and {depth - _MARGIN - 1}")
        self.shape, self.depth, self.restart = shape, depth, restart
        super().__init__({
            "space": Out(1, init=1), "issue": In(1), "arrive": In(1), "i": In(shape),
            "o": Out(stream.Signature(shape)), "drained": Out(1, init=1),
        })

    def elaborate(self, platform):
        m = Module()
        width = Shape.cast(self.shape).width
        m.submodules.fifo = fifo = Fifo(width=width, depth=self.depth)
        issued, arrived, taken = (
            register(m, name, value, reset_less=False) for name, value in
            (("issued", self.issue), ("arrived", self.arrive),
             ("taken", self.o.valid & self.o.ready)))
        m.d.comb += [
            fifo.w_data.eq(register(m, "item", Value.cast(self.i))),
            fifo.w_en.eq(arrived),
            Value.cast(self.o.payload).eq(fifo.r_data),
            self.o.valid.eq(fifo.r_rdy),
            fifo.r_en.eq(self.o.ready),
        ]

        claimed = Signal(range(self.depth + 1))      # items in the pipeline or in the queue
        in_flight = Signal(range(self.depth + 1))    # items in the pipeline
        more = Signal(init=1)                        # ``space``, a clock before
        m.d.sync += [self.space.eq(more), self.drained.eq((in_flight == 0) & ~issued & ~self.issue)]
        with m.If(issued != taken):
            m.d.sync += claimed.eq(claimed + Mux(taken, -1, 1))
        with m.If(issued != arrived):
            m.d.sync += in_flight.eq(in_flight + Mux(arrived, -1, 1))
        with m.If(claimed >= self.depth - _MARGIN):
            m.d.sync += more.eq(0)
        with m.Elif(claimed <= self.restart):
            m.d.sync += more.eq(1)
        return m
