"""The design of a ULX3S: camera in, straight picture out."""

from dataclasses import dataclass

from amaranth import *
from amaranth.lib import io, wiring
from amaranth.lib.cdc import FFSynchronizer

from ncdc_boards.sdram.chips import ULX3S_32MB
from ncdc_boards.sdram.controller import SdramController
from ncdc_boards.ulx3s.buttons import Chooser
from ncdc_boards.ulx3s.clocks import DOMAINS, ClockPlan, Clocks
from ncdc_hdl.avalon.bus import Agent, WriteHost
from ncdc_hdl.lib.ports import ports_as
from ncdc_hdl.registers.access import RegisterAccess
from ncdc_hdl.registers.program import ProgramRunner
from ncdc_hdl.registers.serial_bridge import SerialBridge
from ncdc_hdl.system import System
from ncdc_hdl.video.dvi import Dvi
from ncdc_hdl.video.scan_out import ScanOut
from ncdc_model.interface.system_map import SYSTEM_WORDS_BITS

__all__ = ["DATA_WIDTH", "Design", "SCREEN_BURST", "Ulx3sTop"]

DATA_WIDTH = 32         # of the memory ports
SCREEN_BURST = 32       # words
_BAUD = 1_000_000
_WIRES_LATE = 2         # a register each in the pins' cells, on the way to the SDRAM and back


@dataclass(frozen=True)
class Design:
    """What a top is made of.

    Parameters
    ----------
    system : System
        With a screen.
    mode : VideoMode
    pixel_bytes : int
        Of a pixel in memory.
    clocks : ClockPlan
    programs : tuple
        Of :class:`ProgramRunner`: the set-up first, then one for each lens, the raw picture's last.
    lenses : int
        That the buttons choose from, without the raw picture.
    power_up_us : int
        Microseconds from the clocks' lock until the sensor's reset ends, and from there until
        the set-up begins.
    """
    system: System
    mode: object
    pixel_bytes: int
    clocks: ClockPlan
    programs: tuple
    lenses: int
    power_up_us: int = 2000

    @property
    def core_hz(self):
        """Of the core's clock."""
        return round(self.clocks.core_mhz * 1e6)


class Ulx3sTop(Elaboratable):
    """Joins the pins of the board to sensor, memory, corrector, screen, buttons and USB.

    Parameters
    ----------
    design : Design
    """

    def __init__(self, design):
        self.design = design
        g = design.system.descriptor.geometry
        self.screen = ScanOut(design.mode, *g.corrected, pixel_bytes=design.pixel_bytes,
                              max_burst=SCREEN_BURST)
        self.memory = SdramController(ULX3S_32MB, design.core_hz, DATA_WIDTH, reads=2,
                                      max_burst=SCREEN_BURST, late=_WIRES_LATE)

    def elaborate(self, platform):
        m = Module()
        oscillator = self._buffer(m, platform.request("clk25", dir="-"))
        m.domains += (ClockDomain(name) for name in DOMAINS)
        m.submodules.clocks = Clocks(self.design.clocks, oscillator.i)
        m.submodules.system = system = self.design.system
        m.submodules.screen = screen = self.screen
        m.submodules.memory = self.memory
        m.submodules.dvi = dvi = Dvi()
        m.d.comb += [
            screen.screen.held.eq(system.screen_held), screen.screen.base.eq(system.screen_base),
            system.screen_claim.eq(screen.screen.claim),
            system.screen_shown.eq(screen.shown), system.screen_underruns.eq(screen.underruns),
            dvi.picture.eq(screen.picture),
        ]
        self._memory(m, platform)
        self._gpdi(m, platform, dvi)
        ready = self._camera(m, platform)
        self._registers(m, platform, ready)
        # The ESP32 shares wires with the camera: it stays in reset.
        esp32 = platform.request("esp32", dir={name: "-" for name in (
            "en", "tx", "rx", "gpio0", "gpio5", "gpio16", "gpio17")})
        m.d.comb += self._buffer(m, esp32.en).o.eq(0)
        return m

    @staticmethod
    def _buffer(m, port, direction=None):
        """The buffer of a port."""
        name = port.p.name if hasattr(port, "p") else port.io.name
        m.submodules[f"{name}_buffer"] = buffer = io.Buffer(direction or port.direction, port)
        return buffer

    def _memory(self, m, platform):
        """System and screen at the controller's ports, and the controller at its pins."""
        memory, system = self.memory, self.design.system
        for bus, port in ((ports_as(system, "read0", system.corrector.fetch.bus0.signature),
                           memory.reads[0]), (self.screen.bus, memory.reads[1])):
            m.d.comb += [
                port.address.eq(bus.address), port.read.eq(bus.read),
                port.burstcount.eq(bus.burstcount), bus.waitrequest.eq(port.waitrequest),
                bus.readdata.eq(port.readdata), bus.readdatavalid.eq(port.readdatavalid)]
        bus, port = ports_as(system, "write", WriteHost(DATA_WIDTH, 1)), memory.write
        m.d.comb += [
            port.address.eq(bus.address), port.write.eq(bus.write),
            port.burstcount.eq(bus.burstcount), port.writedata.eq(bus.writedata),
            port.byteenable.eq(bus.byteenable), bus.waitrequest.eq(port.waitrequest)]
        pins, ports = memory.pins, platform.request("sdram", dir=dict.fromkeys((
            "clk", "clk_en", "cs", "we", "ras", "cas", "ba", "a", "dq", "dqm"), "-"))
        for name, value in (("clk_en", pins.cke), ("cs", ~pins.cs_n), ("we", ~pins.we_n),
                            ("ras", ~pins.ras_n), ("cas", ~pins.cas_n), ("ba", pins.ba),
                            ("a", pins.a), ("dqm", pins.dqm)):
            m.submodules[f"sdram_{name}"] = register = io.FFBuffer("o", getattr(ports, name))
            m.d.comb += register.o.eq(value)
        m.submodules.sdram_dq = dq = io.FFBuffer("io", ports.dq)
        m.d.comb += [dq.o.eq(pins.dq_o), dq.oe.eq(pins.dq_oe), pins.dq_i.eq(dq.i)]
        self._clock_out(m, "memory", ports.clk)

    def _clock_out(self, m, domain, port):
        """A clock at a pin, through the pin's cell, as late as what its registers send."""
        pin = self._buffer(m, port)
        m.submodules[f"{domain}_clock"] = Instance(
            "ODDRX1F", i_SCLK=ClockSignal(domain), i_RST=Const(0), i_D0=Const(1), i_D1=Const(0),
            o_Q=pin.o)

    def _gpdi(self, m, platform, dvi):
        """The lanes at the connector's pins."""
        lanes = platform.request("hdmi", dir={"cec": "-", "clk": "-", "d": "-", "eth": "-",
                                              "scl": "-", "sda": "-"})
        for name, port, pairs in (("d", lanes.d, dvi.pairs[:3]), ("clk", lanes.clk,
                                                                 dvi.pairs[3:])):
            pins = Signal(len(pairs), name=f"gpdi_{name}")
            for k, pair in enumerate(pairs):
                m.submodules[f"gpdi_{name}{k}"] = Instance(
                    "ODDRX1F", i_SCLK=ClockSignal("shift"), i_RST=Const(0), i_D0=pair[0],
                    i_D1=pair[1], o_Q=pins[k])
            m.d.comb += self._buffer(m, port).o.eq(pins)

    def _camera(self, m, platform):
        """The sensor at its pins; high once its reset and its rest behind it are over."""
        system = self.design.system
        wires = platform.request("camera", dir=dict.fromkeys((
            "d", "fval", "lval", "scl", "sda", "xclk", "reset_n", "standby", "pixclk"), "-"))
        pixclk = self._buffer(m, wires.pixclk).i
        m.d.comb += [
            system.sensor_clock.eq(pixclk),
            system.sensor_frame_valid.eq(self._buffer(m, wires.fval).i),
            system.sensor_line_valid.eq(self._buffer(m, wires.lval).i),
            system.sensor_data.eq(self._buffer(m, wires.d).i),
        ]
        for name in ("scl", "sda"):
            line = self._buffer(m, getattr(wires, name))
            m.d.comb += [line.o.eq(0), line.oe.eq(getattr(system, f"{name}_low")),
                         getattr(system, name).eq(line.i)]
        wait = self.design.power_up_us * self.design.core_hz // 10**6
        waited = Signal(range(2 * wait + 1))
        with m.If(waited != 2 * wait):
            m.d.sync += waited.eq(waited + 1)
        m.d.comb += [self._buffer(m, wires.reset_n).o.eq(waited >= wait),
                     self._buffer(m, wires.standby).o.eq(0)]
        self._clock_out(m, "sensor_reference", wires.xclk)
        return waited == 2 * wait

    def _registers(self, m, platform, ready):
        """Who writes registers: the programs, and a host at the serial port."""
        design, system = self.design, self.design.system
        m.submodules.access = access = RegisterAccess(SYSTEM_WORDS_BITS, 2)
        m.submodules.bridge = bridge = SerialBridge(design.core_hz // _BAUD, SYSTEM_WORDS_BITS)
        # Until the sensor may be talked to the programs are in reset.
        hold = Signal(init=1)
        m.d.sync += hold.eq(~(ready & self.memory.ready))
        m.submodules.programs = programs = ResetInserter(hold)(ProgramRunner(
            design.programs, SYSTEM_WORDS_BITS, patience=design.core_hz // 10))
        wiring.connect(m, programs.access, access.hosts[0])
        wiring.connect(m, bridge.access, access.hosts[1])
        bus = ports_as(system, "csr", Agent(SYSTEM_WORDS_BITS))
        for name, member in Agent(SYSTEM_WORDS_BITS).members.items():
            ours, theirs = getattr(access.bus, name), getattr(bus, name)
            m.d.comb += theirs.eq(ours) if member.flow is wiring.Out else ours.eq(theirs)
        uart = platform.request("uart", dir={"rx": "-", "tx": "-", "rts": "-", "dtr": "-"})
        m.d.comb += [bridge.receive.eq(self._buffer(m, uart.rx).i),
                     self._buffer(m, uart.tx).o.eq(bridge.send)]
        m.submodules.chooser = chooser = Chooser(design.lenses, design.core_hz)
        for name, pin in (("following", "button_right"), ("previous", "button_left"),
                          ("raw", "button_fire")):
            pressed = self._buffer(m, platform.request(pin, 0, dir="-")).i
            m.submodules[f"{name}_button"] = FFSynchronizer(pressed, getattr(chooser, name))
        m.d.comb += [chooser.busy.eq(programs.busy), programs.start.eq(chooser.start),
                     programs.which.eq(chooser.which)]
        lights = Cat(self.memory.ready, ~programs.busy, programs.failures != 0,
                     self.screen.underruns != 0, chooser.lens)
        for k in range(8):
            light = self._buffer(m, platform.request("led", k, dir="-"))
            m.d.comb += light.o.eq(lights[k] if k < len(lights) else 0)
