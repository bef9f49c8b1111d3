"""Camera in, straight picture out, with a processor's memory: a board without clocks and pins."""

from dataclasses import dataclass

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_boards.hps_board.ports import BURST_WORDS, DATA_WIDTH, SCREEN_WIDTH
from ncdc_hdl.avalon.bus import Agent, ReadHost, WriteHost
from ncdc_hdl.camera.layouts import PINS
from ncdc_hdl.lib.ports import ports_as
from ncdc_hdl.system import System
from ncdc_hdl.video.scan_out import PICTURE, ScanOut
from ncdc_spec.registers.system_map import SYSTEM_WORDS_BITS

__all__ = ["HpsCore", "HpsDesign", "LEDS", "READ", "SCREEN_READ", "WRITE"]

LEDS = 8
_BURST = 16             # words
READ = ReadHost(DATA_WIDTH, _BURST)
WRITE = WriteHost(DATA_WIDTH, _BURST)
SCREEN_READ = ReadHost(SCREEN_WIDTH, BURST_WORDS)
"""Hosts of the processor's ports; addresses count bytes."""


@dataclass(frozen=True)
class HpsDesign:
    """Parameters of a board's core.

    Parameters
    ----------
    board : ncdc_boards.hps_board.board.HpsBoard
    system : System
        With a screen and ports of 64 bits.
    mode : VideoMode
    pixel_bytes : int
        Bytes of a pixel in memory.
    clocks : ClockPlan
    sensor : (Setup, Crop)
    reset_us : int
        Microseconds from the clocks' lock until the sensor's reset ends. Linux configures the
        sensor long after its rest.
    """
    board: object
    system: System
    mode: object
    pixel_bytes: int
    clocks: object
    sensor: tuple
    reset_us: int = 5000

    processor = False       # of ours: the board has its own


class HpsCore(wiring.Component):
    """Joins sensor, corrector and screen to ports of a processor, which configures them.

    The core is in the domain ``sync``, its picture in ``pixel``. Its reset is also that of the
    ports, which drop earlier requests.

    Parameters
    ----------
    design : HpsDesign

    Members
    -------
    csr : ``In(Agent(...))``
        Registers, with word addresses.
    read0, write, screen : ``Out(READ)``, ``Out(WRITE)``, ``Out(SCREEN_READ)``
    irq : ``Out(1)``
    sensor_clock, sensor : ``In(1)``, ``In(PINS)``
    sensor_reset_n : ``Out(1)``
    scl, sda, scl_low, sda_low : ``In(1)``, ``Out(1)``
        Lines of the I2C bus to the sensor, and outputs that pull them low.
    hdmi_scl, hdmi_sda : ``In(1)``
        Lines to the HDMI transmitter, which are pulled low with the others.
    picture : ``Out(PICTURE)``
    leds : ``Out(8)``
        Bit 0: the clocks run and the processor is out of its reset. Bit 1: the sensor is out of its
        reset. Bit 2: the memory was too slow for the screen.
    """

    def __init__(self, design):
        self.design = design
        self.scan = ScanOut(design.mode, *design.system.descriptor.geometry.corrected,
                            pixel_bytes=design.pixel_bytes, max_burst=BURST_WORDS)
        super().__init__({
            "csr": In(Agent(SYSTEM_WORDS_BITS)), "read0": Out(READ), "write": Out(WRITE),
            "screen": Out(SCREEN_READ), "irq": Out(1),
            "sensor_clock": In(1), "sensor": In(PINS), "sensor_reset_n": Out(1),
            "scl": In(1), "sda": In(1), "scl_low": Out(1), "sda_low": Out(1),
            "hdmi_scl": In(1), "hdmi_sda": In(1), "picture": Out(PICTURE), "leds": Out(LEDS)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.system = system = self.design.system
        m.submodules.scan = scan = self.scan
        m.d.comb += [
            scan.screen.held.eq(system.screen_held), scan.screen.base.eq(system.screen_base),
            system.screen_claim.eq(scan.screen.claim),
            system.screen_shown.eq(scan.shown), system.screen_underruns.eq(scan.underruns),
            self.picture.eq(scan.picture), self.irq.eq(system.irq),
            system.memory_rst.eq(ResetSignal()), scan.memory_rst.eq(ResetSignal()),
        ]
        # Bursts of both are shorter than the ports take, so that the counts have fewer bits.
        for ours, theirs in (
                (ports_as(system, "csr", Agent(SYSTEM_WORDS_BITS)), self.csr),
                (ports_as(system, "read0", system.corrector.fetch.bus0.signature), self.read0),
                (ports_as(system, "write", WRITE), self.write), (scan.bus, self.screen)):
            self._join(m, ours, theirs)
        self._sensor(m)
        return m

    @staticmethod
    def _join(m, inner, outer):
        """Connect a port of a submodule to one of the core."""
        for name, member in outer.signature.members.items():
            ours, theirs = getattr(outer, name), getattr(inner, name)
            m.d.comb += ours.eq(theirs) if member.flow is Out else theirs.eq(ours)

    def _sensor(self, m):
        """The sensor, its reset, and the LEDs."""
        system, design = self.design.system, self.design
        m.d.comb += [
            system.sensor_clock.eq(self.sensor_clock),
            system.sensor_frame_valid.eq(self.sensor.frame_valid),
            system.sensor_line_valid.eq(self.sensor.line_valid),
            system.sensor_data.eq(self.sensor.data),
            # Two buses as one: a line is low if either one's is. A target without its address does
            # not need what targets of the other bus send.
            system.scl.eq(self.scl & self.hdmi_scl), system.sda.eq(self.sda & self.hdmi_sda),
            self.scl_low.eq(system.scl_low), self.sda_low.eq(system.sda_low),
        ]
        wait = round(design.reset_us * design.clocks.core_mhz)
        waited = Signal(range(wait + 1))
        running = Signal()          # low only in reset
        with m.If(waited != wait):
            m.d.sync += waited.eq(waited + 1)
        # A register: a pin with logic before it could end the sensor's reset too early.
        m.d.sync += [self.sensor_reset_n.eq(waited == wait), running.eq(1)]
        m.d.comb += self.leds.eq(Cat(running, self.sensor_reset_n, self.scan.underruns != 0))
