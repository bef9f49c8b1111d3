"""What of the system is ours: camera, corrector and packetiser, with ports for LiteX."""

from amaranth import *
from amaranth.back import verilog
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import PENDING
from ncdc_hdl.avalon.native import NativePort, NativeReader, NativeWriter
from ncdc_hdl.avalon.wishbone import Wishbone, WishboneAgent
from ncdc_hdl.lib.ports import ports_as
from ncdc_hdl.link.packetiser import Packetiser
from ncdc_hdl.system import System
from ncdc_model.errors import InputError
from ncdc_model.interface.link_map import LINK_WORDS_BITS
from ncdc_model.interface.system_map import SYSTEM_WORDS_BITS

__all__ = ["ADDRESS_BITS", "FRAMES_BITS", "LINK_BASE", "READERS", "SocCore", "core_verilog",
           "memory_reader", "memory_writer"]

ADDRESS_BITS = SYSTEM_WORDS_BITS + 1    # of a register, in words
LINK_BASE = 1 << SYSTEM_WORDS_BITS      # word address of the packetiser's
READERS = 3                             # of frames: two for streams, one for MRAW packages
FRAMES_BITS = 26                        # of a word's address in the memory of frames: 256 MB
_WORD = 32          # bits of the memory ports, and of the processor
_PINS = ("sensor_clock", "sensor_frame_valid", "sensor_line_valid", "sensor_data", "scl", "sda",
         "scl_low", "sda_low")


class SocCore(wiring.Component):
    """Camera system and packetiser behind a Wishbone bus, on native ports of LiteDRAM.

    Parameters
    ----------
    descriptor : Descriptor
    hardware : Hardware
        With the bus "axi": its write host waits for answers, so that a frame is handed on only
        when the controller has all of it. Its corrected frames go to memory.
    readers : int
        That claim frames by registers.
    capacity : int
        Bytes that the packetiser reads ahead.

    Raises
    ------
    InputError
        If the memory has another width than the processor.

    Members
    -------
    bus : ``In(Wishbone(ADDRESS_BITS))``
        Registers of the system, and from ``LINK_BASE`` on those of the packetiser.
    frames : ``In(Wishbone(FRAMES_BITS))``
        The memory of the frames, to be read a word at a time; what is written is lost.
    port0, port1, .. : native ports
        That of the writes, that of the packetiser, that of ``frames``, those of the corrector's
        reads.
    frame_valid, frame_ready, frame_data, frame_empty, frame_last
        Ethernet frames without check sequence, as of :class:`Packetiser`.
    irq : ``Out(1)``
    others
        As of :class:`System`.
    """

    def __init__(self, descriptor, hardware, readers=READERS, capacity=4096):
        if hardware.data_width != _WORD:
            raise InputError(f"the memory has {hardware.data_width} bits, {_WORD} are needed: the "
                             "processor reads frames from it")
        self.system = System(descriptor, hardware, readers)
        self.packetiser = Packetiser(hardware.data_width, capacity=capacity)
        self.reads = [name.partition("_")[0] for name in self.system.signature.members
                      if name.startswith("read") and name.endswith("_readdata")]
        self.ports = 3 + len(self.reads)
        members = self.system.signature.members
        super().__init__({
            "bus": In(Wishbone(ADDRESS_BITS)), "frames": In(Wishbone(FRAMES_BITS)), "irq": Out(1),
            **{f"port{k}": Out(NativePort(hardware.data_width)) for k in range(self.ports)},
            **{name: members[name] for name in _PINS},
            "frame_valid": Out(1), "frame_ready": In(1), "frame_data": Out(32),
            "frame_empty": Out(2), "frame_last": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.system = system = self.system
        m.submodules.packetiser = packetiser = self.packetiser
        for name in _PINS:
            ours, inner = getattr(self, name), getattr(system, name)
            flow = system.signature.members[name].flow
            m.d.comb += ours.eq(inner) if flow is Out else inner.eq(ours)
        # One reset is LiteDRAM's and the bridges' too: they forget what they have accepted.
        m.d.comb += system.memory_rst.eq(ResetSignal())
        self._registers(m)
        self._memory(m)
        frame = packetiser.o
        m.d.comb += [
            self.irq.eq(system.irq | packetiser.irq), self.frame_valid.eq(frame.valid),
            frame.ready.eq(self.frame_ready), self.frame_data.eq(frame.p.data),
            self.frame_empty.eq(frame.p.empty), self.frame_last.eq(frame.p.last)]
        return m

    def _registers(self, m):
        """Two agents behind the bus; one access is under way at a time."""
        m.submodules.bridge = bridge = WishboneAgent(ADDRESS_BITS)
        connect(m, flipped(self.bus), bridge.host)
        system, link, agent = self.system, self.packetiser.csr, bridge.agent
        there = agent.address[-1]               # it is the packetiser's
        m.d.comb += [
            system.csr_address.eq(agent.address), link.address.eq(agent.address[:LINK_WORDS_BITS]),
            system.csr_writedata.eq(agent.writedata), link.writedata.eq(agent.writedata),
            system.csr_read.eq(agent.read & ~there), link.read.eq(agent.read & there),
            system.csr_write.eq(agent.write & ~there), link.write.eq(agent.write & there),
            agent.waitrequest.eq(Mux(there, link.waitrequest, system.csr_waitrequest)),
            agent.readdatavalid.eq(system.csr_readdatavalid | link.readdatavalid),
            agent.readdata.eq(Mux(link.readdatavalid, link.readdata, system.csr_readdata))]

    def _memory(self, m):
        """A bridge per host."""
        system, packets = self.system, self.packetiser.bus
        memory_writer(m, system, self.port0)
        reader = NativeReader(system.hardware.data_width, packets.signature.max_burst)
        m.submodules.reader0 = reader
        connect(m, packets, reader.bus)
        connect(m, reader.port, flipped(self.port1))
        self._frames(m)
        for k, name in enumerate(self.reads):
            memory_reader(m, system, name, getattr(self, f"port{k + 3}"))

    def _frames(self, m):
        """The processor's window to the memory."""
        m.submodules.window = window = WishboneAgent(FRAMES_BITS)
        m.submodules.window_reader = reader = NativeReader(_WORD, max_burst=1)
        connect(m, flipped(self.frames), window.host)
        connect(m, reader.port, flipped(self.port2))
        agent, bus = window.agent, reader.bus
        m.d.comb += [
            bus.address.eq(agent.address << exact_log2(_WORD // 8)), bus.burstcount.eq(1),
            bus.read.eq(agent.read), agent.waitrequest.eq(bus.waitrequest & agent.read),
            agent.readdata.eq(bus.readdata), agent.readdatavalid.eq(bus.readdatavalid)]


def memory_writer(m, host, port):
    """Let the write host of ``host``, ports called write_*, write through the native ``port`` of
    the component that elaborates ``m``. ``host`` has ``hardware`` with the bus "axi"."""
    m.submodules.writer = writer = NativeWriter(
        host.hardware.data_width, max_burst=_longest(host.write_burstcount), pending=PENDING)
    connect(m, ports_as(host, "write", writer.bus.signature.flip()), writer.bus)
    connect(m, writer.port, flipped(port))


def memory_reader(m, host, name, port):
    """Let the read host ``name`` of ``host`` read through the native ``port``, likewise."""
    burst = _longest(getattr(host, f"{name}_burstcount"))
    reader = NativeReader(host.hardware.data_width, burst)
    m.submodules[f"{name}_bridge"] = reader
    connect(m, ports_as(host, name, reader.bus.signature.flip()), reader.bus)
    connect(m, reader.port, flipped(port))


def _longest(burstcount):
    return (1 << len(burstcount)) // 2


def core_verilog(core):
    """Verilog of a :class:`SocCore`, as the module ``ncdc_core``."""
    return verilog.convert(core, name="ncdc_core")
