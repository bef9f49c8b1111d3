"""A camera system with USB: registers, pictures and Table I over an FTDI chip."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import Out, connect

from ncdc_hdl.avalon.bus import Agent, ReadHost
from ncdc_hdl.lib.ports import flat, join, ports_as
from ncdc_hdl.registers.access import RegisterAccess
from ncdc_hdl.registers.agent_access import AgentAccess
from ncdc_hdl.usb.layouts import ChipPins
from ncdc_hdl.usb.link import UsbLink
from ncdc_hdl.usb.view import SystemView
from ncdc_spec.registers.system_map import SYSTEM_WORDS_BITS

__all__ = ["UsbSystem"]

_PREFIX = "usb"


class UsbSystem(wiring.Component):
    """A :class:`System` with a :class:`UsbLink`, whose frames are those of one of its readers.

    Parameters
    ----------
    system : System
    chip : Chip
    sensor : Sensor
        Sensor on the I2C bus, for Table I.
    reader : int
        Number of the link's reader.
    clock_mhz : int
        Clock of the system in MHz.

    Members
    -------
    All members of the system, and
    usb_* : of :class:`ChipPins`
    read<n>_* : Avalon-MM read host of the link, after those of the corrector
    """

    def __init__(self, system, chip, sensor, reader=1, clock_mhz=100):
        self.system, self.chip = system, chip
        self.corrector, self.hardware = system.corrector, system.hardware
        self.descriptor, self.stores, self.table = system.descriptor, system.stores, system.table
        self.camera = system.camera
        self.options = [f"--usb {chip.name.lower()}", f"--sensor {sensor.name}", *system.options]
        burst = _burst_of(system)
        self.link = UsbLink(chip, SystemView.of(system, reader, clock_mhz), sensor,
                            self.hardware.data_width, burst, SYSTEM_WORDS_BITS)
        members = system.signature.members
        count = sum(name.startswith("read") and name.endswith("_address") for name in members)
        self.port = f"read{count}"
        super().__init__(dict(members) | flat(_PREFIX, ChipPins(chip.lanes), Out)
                         | flat(self.port, ReadHost(self.hardware.data_width, burst), Out))

    def elaborate(self, platform):
        m = Module()
        system, link = self.system, self.link
        m.submodules.system, m.submodules.link = system, link
        m.submodules.access = access = RegisterAccess(SYSTEM_WORDS_BITS, 4)
        m.submodules.agent = agent = AgentAccess(SYSTEM_WORDS_BITS)
        for name, member in system.signature.members.items():
            ours, theirs = getattr(self, name), getattr(system, name)
            if not name.startswith("csr_"):
                m.d.comb += ours.eq(theirs) if member.flow is Out else theirs.eq(ours)
        join(m, self, "csr", agent.bus)
        connect(m, agent.access, access.hosts[0])
        for host, ours in zip(list(access.hosts)[1:], link.accesses):
            connect(m, ours, host)
        registers = ports_as(system, "csr", Agent(SYSTEM_WORDS_BITS))
        for name, member in Agent(SYSTEM_WORDS_BITS).members.items():
            ours, theirs = getattr(access.bus, name), getattr(registers, name)
            m.d.comb += theirs.eq(ours) if member.flow is Out else ours.eq(theirs)
        join(m, self, _PREFIX, link.pins)
        join(m, self, self.port, link.bus)
        m.d.comb += link.memory_rst.eq(self.memory_rst)
        return m


def _burst_of(system):
    """Most words of a burst at the memory's read ports."""
    return system.corrector.fetch.bus0.signature.max_burst
