"""A corrector, or a camera system, with AXI ports instead of Avalon's."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.axi.bus import Lite, ReadPort, VideoStream, WritePort
from ncdc_hdl.axi.lite_bridge import LiteBridge
from ncdc_hdl.axi.read_bridge import ReadBridge
from ncdc_hdl.axi.write_bridge import WriteBridge
from ncdc_hdl.lib.ports import flat, join, ports_as

__all__ = ["AxiTop"]

_PLAIN = ("irq", "camera_rows", "front_end_idle", "scl_low", "sda_low", "scl", "sda")


class AxiTop(wiring.Component):
    """Bridges between the Avalon ports of ``core`` and AXI, all in the clock of ``aclk``.

    The pixels of the stream have green lowest, then blue, then red, as in AMD's video blocks
    (UG934). The leftmost of several is in the lowest bits.

    Parameters
    ----------
    core : Corrector or System
        A core of hardware with the bus "axi".

    Members
    -------
    aclk, aresetn : ``In(1)``, ``In(1)``
        Clock and reset of all ports but a sensor's. While ``aresetn`` is low everything is reset,
        also what is between it and the memory.
    core_rst : ``In(1)``
        Resets only the core: requests to the memory are completed, and an access to a
        register is still answered.
    s_axi_* : AXI4-Lite subordinate, registers
    m_axi_read0_*, m_axi_read1_*, m_axi_read2_* : AXI4 managers that read
    m_axi_write_* : AXI4 manager that writes
    m_axis_* : AXI4-Stream source of video
    others
        As in the core.

    Raises
    ------
    ValueError
        If the core's hardware has another bus.
    """

    def __init__(self, core):
        if not core.hardware.axi:
            raise ValueError(f"the core's bus is {core.hardware.bus}, axi is needed")
        self.core, self.hardware, self.descriptor = core, core.hardware, core.descriptor
        members, width = core.signature.members, core.hardware.data_width
        self.readers = [name.partition("_")[0] for name in members if name.endswith("_readdata")
                        and name.startswith("read")]
        self.writes = "write_write" in members
        self.address_bits = members["csr_address"].shape
        ports = {"aclk": In(1), "aresetn": In(1), "core_rst": In(1)}
        ports |= flat("s_axi", Lite(self.address_bits + 2), In)
        for reader in self.readers:
            ports |= flat(f"m_axi_{reader}", ReadPort(width), Out)
        if self.writes:
            ports |= flat("m_axi_write", WritePort(width), Out)
        if self.hardware.stream:
            ports |= flat("m_axis", VideoStream(self.hardware.lanes), Out)
        self.plain = [name for name in members if name in _PLAIN or name.startswith("sensor_")]
        super().__init__(ports | {name: members[name] for name in self.plain})

    def elaborate(self, platform):
        m = Module()
        m.domains.sync = ClockDomain()
        m.submodules.core = core = self.core
        # A register: asynchronous uses of the core's reset must not see a glitch.
        rst = Signal(reset_less=True, init=1)           # reset of the core
        bus_rst_before = Signal(reset_less=True, init=1)
        m.d.sync += [rst.eq(~self.aresetn | self.core_rst), bus_rst_before.eq(~self.aresetn)]
        bus_rst = ~self.aresetn | bus_rst_before        # overlaps with the core's reset
        m.d.comb += [ClockSignal().eq(self.aclk), ResetSignal().eq(rst),
                     core.memory_rst.eq(bus_rst)]
        width, failed = self.hardware.data_width, []
        for reader in self.readers:
            host = ports_as(core, reader, getattr(core, "corrector", core).fetch.bus0.signature)
            bridge = ReadBridge(width, host.signature.max_burst)
            m.submodules[f"{reader}_bridge"] = bridge
            self._attach(m, bridge, host, f"m_axi_{reader}", bus_rst)
            failed.append(bridge.failed)
        m.d.comb += core.read_failed.eq(Cat(failed).any())
        if self.writes:
            writer = core.capture if hasattr(core, "capture") else core.writer
            host = ports_as(core, "write", writer.bus.signature)
            m.submodules.write_bridge = bridge = WriteBridge(width, host.signature.max_burst)
            self._attach(m, bridge, host, "m_axi_write", bus_rst)
        m.submodules.register_bridge = registers = LiteBridge(self.address_bits)
        m.d.comb += registers.memory_rst.eq(bus_rst)
        join(m, self, "s_axi", registers.axi)
        wiring.connect(m, registers.bus, ports_as(core, "csr", registers.bus.signature.flip()))
        if self.hardware.stream:
            self._stream(m)
        for name in self.plain:
            ours, inner = getattr(self, name), getattr(core, name)
            out = self.signature.members[name].flow is Out
            m.d.comb += ours.eq(inner) if out else inner.eq(ours)
        return m

    def _attach(self, m, bridge, host, prefix, bus_rst):
        """Connect a ``bridge`` with the core's ``host``, its ports and the bus's reset."""
        wiring.connect(m, host, bridge.host)
        join(m, self, prefix, bridge.axi)
        m.d.comb += bridge.memory_rst.eq(bus_rst)

    def _stream(self, m):
        core = self.core
        for lane in range(self.hardware.lanes):
            blue, green, red = (core.stream_data[24 * lane + 8 * c:][:8] for c in range(3))
            m.d.comb += self.m_axis_tdata[24 * lane:][:24].eq(Cat(green, blue, red))
        m.d.comb += [
            self.m_axis_tvalid.eq(core.stream_valid), core.stream_ready.eq(self.m_axis_tready),
            self.m_axis_tuser.eq(core.stream_startofpacket),
            self.m_axis_tlast.eq(core.stream_endofline),
        ]
