"""The project's part of the system: camera, corrector and packetiser, with ports for LiteX."""

from amaranth import *
from amaranth.back import verilog
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.avalon.bus import PENDING, Agent
from ncdc_hdl.avalon.native import NativePort, NativeReader, NativeWriter
from ncdc_hdl.lib.ports import ports_as
from ncdc_hdl.link.processor import READERS, ProcessorLink, ProcessorPort
from ncdc_hdl.system import System
from ncdc_spec.camera_port import CameraPort
from ncdc_spec.registers.system_map import SYSTEM_WORDS_BITS

__all__ = ["SocCore", "core_verilog", "memory_reader", "memory_writer"]

_BUS_PINS = "scl", "sda", "scl_low", "sda_low"


class SocCore(wiring.Component):
    """Camera system and packetiser at a processor's port, on native ports of LiteDRAM.

    Parameters
    ----------
    descriptor : Descriptor
    hardware : Hardware
        With the bus "axi". Its write host waits for answers: a frame is complete only when the
        controller has all of it. Its corrected frames go to memory.
    readers : int
        That claim frames by registers.
    capacity : int
        Bytes of a packet's payload, at most: as of :class:`Packetiser`.
    grid : int, optional
        As of :class:`System`.
    camera : CameraPort
        Likewise.

    Attributes
    ----------
    pins : dict
        Members that are the sensor's, by name.

    Raises
    ------
    InputError
        As :class:`ProcessorLink`.

    Members
    -------
    processor : ``In(ProcessorPort())``
    port0, port1, .. : native ports
        That of the writes, that of the packetiser, that of the processor, those of the
        corrector's reads.
    others
        As of :class:`System`.
    """

    def __init__(self, descriptor, hardware, readers=READERS, capacity=3840, grid=None,
                 camera=CameraPort()):
        self.link = ProcessorLink(hardware.data_width, capacity)
        self.system = System(descriptor, hardware, readers, grid=grid, camera=camera)
        self.reads = [name.partition("_")[0] for name in self.system.signature.members
                      if name.startswith("read") and name.endswith("_readdata")]
        self.ports = 3 + len(self.reads)
        self.pins = {name: member for name, member in self.system.signature.members.items()
                     if name.startswith("sensor_") or name in _BUS_PINS}
        super().__init__({
            "processor": In(ProcessorPort()),
            **{f"port{k}": Out(NativePort(hardware.data_width)) for k in range(self.ports)},
            **self.pins})

    @property
    def packetiser(self):
        """The :class:`Packetiser`."""
        return self.link.packetiser

    def elaborate(self, platform):
        m = Module()
        m.submodules.system = system = self.system
        m.submodules.link = link = self.link
        for name, member in self.pins.items():
            ours, inner = getattr(self, name), getattr(system, name)
            m.d.comb += ours.eq(inner) if member.flow is Out else inner.eq(ours)
        # The reset is LiteDRAM's and the bridges' too: they drop the commands they have accepted.
        m.d.comb += [system.memory_rst.eq(ResetSignal()), link.irq.eq(system.irq)]
        connect(m, flipped(self.processor), link.processor)
        connect(m, link.system, ports_as(system, "csr", Agent(SYSTEM_WORDS_BITS).flip()))
        memory_writer(m, system, self.port0)
        for name, bus, port in (("packets", link.packets, self.port1),
                                ("window", link.window, self.port2)):
            m.submodules[f"{name}_bridge"] = reader = NativeReader(
                system.hardware.data_width, _longest(bus.burstcount))
            connect(m, bus, reader.bus)
            connect(m, reader.port, flipped(port))
        for k, name in enumerate(self.reads):
            memory_reader(m, system, name, getattr(self, f"port{k + 3}"))
        return m


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
