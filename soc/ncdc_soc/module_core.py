"""The corrector with ports for LiteX: what :class:`ncdc_soc.module.NCDC` instantiates."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.avalon.native import NativePort
from ncdc_hdl.avalon.wishbone import Wishbone, WishboneAgent
from ncdc_hdl.corrector import Corrector
from ncdc_soc.core import memory_reader, memory_writer
from ncdc_spec.registers.register_map import ADDRESS_WORDS_BITS

__all__ = ["ModuleCore"]


class ModuleCore(wiring.Component):
    """A corrector on a Wishbone bus, with native ports of LiteDRAM.

    Parameters
    ----------
    descriptor : Descriptor
    hardware : Hardware
        With the bus "axi", so that a frame is done only when the memory's controller has all of it.

    Members
    -------
    bus : ``In(Wishbone(ADDRESS_WORDS_BITS))``
        The corrector's registers.
    port0, port1, .. : native ports
        Those of the corrector's reads, then that of its writes (output "memory").
    stream_valid, stream_ready, stream_data, stream_startofpacket, stream_endofpacket :
        As of :class:`Corrector` (output "stream").
    irq : ``Out(1)``
        Frame complete.

    Timing
    ------
    The latency of the bridges, see :class:`WishboneAgent`, :class:`NativeReader` and
    :class:`NativeWriter`; a stream takes no clock.
    """

    def __init__(self, descriptor, hardware):
        self.corrector = Corrector(descriptor, hardware)
        self.hardware = self.corrector.hardware
        members = self.corrector.signature.members
        self.reads = [name.partition("_")[0] for name in members
                      if name.startswith("read") and name.endswith("_readdata")]
        self.ports = len(self.reads) + (not hardware.stream)
        super().__init__({
            "bus": In(Wishbone(ADDRESS_WORDS_BITS)), "irq": Out(1),
            **{f"port{k}": Out(NativePort(hardware.data_width)) for k in range(self.ports)},
            **{name: members[name] for name in members
               if name.startswith("stream_") and name != "stream_endofline"}})

    def elaborate(self, platform):
        m = Module()
        m.submodules.corrector = corrector = self.corrector
        m.submodules.bridge = bridge = WishboneAgent(ADDRESS_WORDS_BITS)
        connect(m, flipped(self.bus), bridge.host)
        agent = bridge.agent
        # The reset is LiteDRAM's and the bridges' too: they drop the commands they have accepted.
        m.d.comb += [self.irq.eq(corrector.irq), corrector.memory_rst.eq(ResetSignal())]
        for name, member in agent.signature.members.items():
            inner, outer = getattr(agent, name), getattr(corrector, f"csr_{name}")
            m.d.comb += outer.eq(inner) if member.flow is Out else inner.eq(outer)
        for k, name in enumerate(self.reads):
            memory_reader(m, corrector, name, getattr(self, f"port{k}"))
        if not self.hardware.stream:
            memory_writer(m, corrector, getattr(self, f"port{self.ports - 1}"))
        for name in self.signature.members:
            if name.startswith("stream_"):
                ours, inner = getattr(self, name), getattr(corrector, name)
                m.d.comb += inner.eq(ours) if name == "stream_ready" else ours.eq(inner)
        return m
