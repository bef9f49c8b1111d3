"""The packetiser as a module of its own, with Avalon's ports."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import Agent
from ncdc_hdl.lib.ports import flat, join
from ncdc_hdl.link.packetiser import Packetiser
from ncdc_spec.registers.link_map import LINK_WORDS_BITS

__all__ = ["PACKETISER", "PacketiserTop"]

PACKETISER = "ncdc_packetiser"


class PacketiserTop(wiring.Component):
    """A :class:`Packetiser`, its packets as an Avalon-ST source.

    Parameters
    ----------
    data_width, capacity : int
        As in :class:`Packetiser`.

    Members
    -------
    csr_* : Avalon-MM agent
    read_* : Avalon-MM read host
    stream_* : Avalon-ST source, 32 bits, the first byte highest as in MACs, with ``empty``
    memory_rst, irq :
        As in the packetiser.
    """

    def __init__(self, data_width=32, capacity=3840):
        self.packetiser = Packetiser(data_width, capacity=capacity)
        super().__init__(
            flat("csr", Agent(LINK_WORDS_BITS), In)
            | flat("read", self.packetiser.bus.signature, Out)
            | {"stream_valid": Out(1), "stream_ready": In(1), "stream_data": Out(32),
               "stream_startofpacket": Out(1), "stream_endofpacket": Out(1),
               "stream_empty": Out(2), "memory_rst": In(1), "irq": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.packetiser = packetiser = self.packetiser
        join(m, self, "csr", packetiser.csr)
        join(m, self, "read", packetiser.bus)
        beat, begins = packetiser.o, Signal(init=1)     # the next beat is a packet's first
        with m.If(beat.valid & beat.ready):
            m.d.sync += begins.eq(beat.p.last)
        m.d.comb += [
            self.stream_valid.eq(beat.valid), beat.ready.eq(self.stream_ready),
            self.stream_data.eq(Cat(beat.p.data.word_select(3 - k, 8) for k in range(4))),
            self.stream_empty.eq(beat.p.empty),
            self.stream_startofpacket.eq(begins), self.stream_endofpacket.eq(beat.p.last),
            packetiser.memory_rst.eq(self.memory_rst), self.irq.eq(packetiser.irq)]
        return m
