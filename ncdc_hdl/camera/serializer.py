"""A stream of samples, one per clock, of one that has several."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.camera.csi2.receiver import Receiver
from ncdc_hdl.camera.samples import samples
from ncdc_spec.sensors.level import SAMPLE_BITS

__all__ = ["SerialReceiver", "Serializer"]


class Serializer(wiring.Component):
    """Gives each sample in a clock of its own, for what takes one per clock, as the grid stage.

    A queue holds what comes faster: a row may have more samples than clocks, if it has fewer than
    there are clocks from row to row. What finds the queue full is lost. Its frame is bad then, or
    has no ``end``.

    Timing: free-running; the clock must run between rows.

    Parameters
    ----------
    count : int
        Samples per clock of the input.
    depth : int
        Clocks of the input that the queue holds.

    Members
    -------
    i : ``In(samples(count))``
    o : ``Out(samples(1))``
    """

    def __init__(self, count, depth=512):
        self.count, self.depth = count, depth
        super().__init__({"i": In(samples(count)), "o": Out(samples(1))})

    def elaborate(self, platform):
        m = Module()
        layout = data.StructLayout({
            "sample": data.ArrayLayout(SAMPLE_BITS, self.count), "valid": self.count, "first": 1,
            "last": 1, "end": 1, "bad": 1})
        m.submodules.queue = queue = SyncFIFOBuffered(width=layout.size, depth=self.depth)
        put, entry = Signal(layout), data.View(layout, queue.r_data)
        lost = Signal()                 # something of the frame, as the queue was full
        number = Signal(range(self.count))
        m.d.comb += [put[name].eq(getattr(self.i, name)) for name in layout.members]
        m.d.comb += [put.bad.eq(self.i.bad | lost), queue.w_data.eq(put),
                     queue.w_en.eq(self.i.valid[0] | self.i.end)]
        with m.If(queue.w_en):
            m.d.sync += lost.eq(~queue.w_rdy | (lost & ~self.i.first & ~self.i.end))

        more = (entry.valid >> 1 >> number)[0]      # samples after this one
        m.d.comb += queue.r_en.eq(~more)
        with m.If(queue.r_rdy):
            m.d.sync += number.eq(Mux(more, number + 1, 0))
        taken = queue.r_rdy & ~more
        m.d.sync += [
            self.o.valid.eq(queue.r_rdy & entry.valid[0]), self.o.sample[0].eq(
                entry.sample[number]),
            self.o.first.eq(queue.r_rdy & entry.first & (number == 0)),
            self.o.last.eq(taken & entry.last), self.o.end.eq(taken & entry.end),
            self.o.bad.eq(taken & entry.end & entry.bad)]
        return m


class SerialReceiver(wiring.Component):
    """A :class:`Receiver` whose samples leave one by one.

    Parameters
    ----------
    lanes, aligned
        As of :class:`Receiver`.

    Members
    -------
    i, settings, faults : as of :class:`Receiver`
    o : ``Out(samples(1))``
    """

    def __init__(self, lanes, aligned=False):
        self.receiver = Receiver(lanes, aligned)
        self.passed = wiring.Signature({
            name: member for name, member in self.receiver.signature.members.items()
            if name != "o"})
        super().__init__({**self.passed.members, "o": Out(samples(1))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.receiver = receiver = self.receiver
        m.submodules.serializer = serializer = Serializer(receiver.lanes)
        for inner, outer in zip(receiver.i, self.i):
            connect(m, inner, flipped(outer))
        m.d.comb += [receiver.settings.eq(self.settings), self.faults.eq(receiver.faults)]
        connect(m, receiver.o, serializer.i)
        connect(m, serializer.o, flipped(self.o))
        return m
