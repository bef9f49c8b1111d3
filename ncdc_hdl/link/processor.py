"""Ports of the camera system for a processor with an Ethernet MAC: registers, frames, packets."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import Agent, ReadHost
from ncdc_hdl.avalon.wishbone import Wishbone, WishboneAgent
from ncdc_hdl.link.packetiser import Packetiser
from ncdc_spec.errors import InputError
from ncdc_spec.registers.link_map import LINK_WORDS_BITS
from ncdc_spec.registers.system_map import SYSTEM_WORDS_BITS

__all__ = ["ADDRESS_BITS", "FRAMES_BITS", "LINK_BASE", "READERS", "ProcessorLink", "ProcessorPort"]

ADDRESS_BITS = SYSTEM_WORDS_BITS + 1    # bits of a register's word address
LINK_BASE = 1 << SYSTEM_WORDS_BITS      # word address of the packetiser's registers
FRAMES_BITS = 26                        # bits of a word's address in the memory of frames: 256 MB
READERS = 3                             # readers of frames: two for streams, one for MRAW packages
_WORD = 32                              # bits of the processor, and of the memory ports


class ProcessorPort(wiring.Signature):
    """Signals between the processor and the system, from the processor's side.

    ``registers``: the system's, and from ``LINK_BASE`` on the packetiser's. ``frames``: the
    memory of the frames, read a word at a time; writes are ignored. ``packet_*``:
    Ethernet frames without check sequence, as in :class:`Packetiser`.
    """

    def __init__(self):
        super().__init__({
            "registers": Out(Wishbone(ADDRESS_BITS)), "frames": Out(Wishbone(FRAMES_BITS)),
            "irq": In(1), "packet_valid": In(1), "packet_ready": Out(1), "packet_data": In(_WORD),
            "packet_empty": In(2), "packet_last": In(1)})


class ProcessorLink(wiring.Component):
    """The packetiser, and the bridges between a processor and the system's buses.

    Parameters
    ----------
    data_width : int
        Bits of the memory ports.
    capacity : int
        Most bytes of a packet's payload, as in :class:`Packetiser`.

    Members
    -------
    processor : ``In(ProcessorPort())``
    system : ``Out(Agent(SYSTEM_WORDS_BITS))``
        The system's registers.
    irq : ``In(1)``
        Interrupt of the system; the packetiser's is ORed with it.
    packets, window : ``Out(ReadHost(..))``
        Reads of the packetiser; reads of the processor.

    Raises
    ------
    InputError
        If the memory has another width than the processor.
    """

    def __init__(self, data_width, capacity):
        if data_width != _WORD:
            raise InputError(f"the memory has {data_width} bits, {_WORD} are needed: the processor "
                             "reads frames from it")
        self.packetiser = Packetiser(data_width, capacity=capacity)
        super().__init__({
            "processor": In(ProcessorPort()), "system": Out(Agent(SYSTEM_WORDS_BITS)),
            "irq": In(1), "packets": Out(self.packetiser.bus.signature),
            "window": Out(ReadHost(data_width, 1))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.packetiser = packetiser = self.packetiser
        connect(m, packetiser.bus, flipped(self.packets))
        self._registers(m)
        self._window(m)
        frame, processor = packetiser.o, self.processor
        m.d.comb += [
            processor.irq.eq(self.irq | packetiser.irq), processor.packet_valid.eq(frame.valid),
            frame.ready.eq(processor.packet_ready), processor.packet_data.eq(frame.p.data),
            processor.packet_empty.eq(frame.p.empty), processor.packet_last.eq(frame.p.last)]
        return m

    def _registers(self, m):
        """Two agents on the bus; one access is under way at a time."""
        m.submodules.bridge = bridge = WishboneAgent(ADDRESS_BITS)
        connect(m, flipped(self.processor.registers), bridge.host)
        system, link, agent = self.system, self.packetiser.csr, bridge.agent
        there = agent.address[-1]               # the address is the packetiser's
        m.d.comb += [
            system.address.eq(agent.address), link.address.eq(agent.address[:LINK_WORDS_BITS]),
            system.writedata.eq(agent.writedata), link.writedata.eq(agent.writedata),
            system.read.eq(agent.read & ~there), link.read.eq(agent.read & there),
            system.write.eq(agent.write & ~there), link.write.eq(agent.write & there),
            agent.waitrequest.eq(Mux(there, link.waitrequest, system.waitrequest)),
            agent.readdatavalid.eq(system.readdatavalid | link.readdatavalid),
            agent.readdata.eq(Mux(link.readdatavalid, link.readdata, system.readdata))]

    def _window(self, m):
        """The processor's window to the memory: a read is a burst of one word."""
        m.submodules.window_bridge = bridge = WishboneAgent(FRAMES_BITS)
        connect(m, flipped(self.processor.frames), bridge.host)
        agent, bus = bridge.agent, self.window
        m.d.comb += [
            bus.address.eq(agent.address << exact_log2(_WORD // 8)), bus.burstcount.eq(1),
            bus.read.eq(agent.read), agent.waitrequest.eq(bus.waitrequest & agent.read),
            agent.readdata.eq(bus.readdata), agent.readdatavalid.eq(bus.readdatavalid)]
