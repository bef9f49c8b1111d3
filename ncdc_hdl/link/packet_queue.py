"""A queue that sends only complete packets."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.link.layouts import BEAT, ENTRY

__all__ = ["PacketQueue"]


class PacketQueue(wiring.Component):
    """Stores the beats of packets, and sends a packet once it is complete.

    So no packet that has begun waits for a beat. The writer must put
    beats only while there is space.

    Timing: a beat leaves at least two clocks after the last one of its packet came; two
    clocks between two packets.

    Parameters
    ----------
    depth, packets : int
        Most beats, and most complete packets, in the queue.

    Members
    -------
    put, entry : ``In(1)``, ``In(ENTRY)``
    held : ``In(1)``
        No packet may begin.
    o : ``Out(stream.Signature(BEAT))``
    ended, ended_again : ``Out(1)``
        ``ended`` for one clock: a packet was sent; with it ``ended_again``: it was sent before.
    idle : ``Out(1)``
        No packet is being sent, and none waits.
    """

    def __init__(self, depth, packets):
        self.depth, self.packets = depth, packets
        super().__init__({
            "put": In(1), "entry": In(ENTRY), "held": In(1), "o": Out(stream.Signature(BEAT)),
            "ended": Out(1), "ended_again": Out(1), "idle": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.beats = beats = block_memory(ENTRY.size, self.depth)
        write, read = beats.write_port(), beats.read_port()
        oldest = data.View(ENTRY, read.data)
        whole = Signal(range(self.packets + 1))     # packets that have not begun
        came, begins = Signal(), Signal()           # one more of them, and one less
        step, taken = Signal(), Signal()            # the next beat is read; the last one was taken
        o = self.o
        m.d.comb += [
            write.data.eq(self.entry), write.en.eq(self.put), read.en.eq(step),
            o.payload.eq(oldest.beat), taken.eq(o.valid & o.ready),
            came.eq(self.put & self.entry.beat.last),
            begins.eq(~o.valid & self._may_begin(whole) & ~self.held),
            step.eq(begins | taken & ~oldest.beat.last),
            self.ended.eq(taken & oldest.beat.last), self.ended_again.eq(oldest.again),
            self.idle.eq(~o.valid & (whole == 0)),
        ]
        m.d.sync += [o.valid.eq(step | o.valid & ~taken), whole.eq(whole + came - begins)]
        for port, moves in ((write, self.put), (read, step)):
            with m.If(moves):
                m.d.sync += port.addr.eq(Mux(port.addr == self.depth - 1, 0, port.addr + 1))
        return m

    def _may_begin(self, whole):
        """Whether a packet is complete. A method of its own only so that tests can break it."""
        return whole != 0
