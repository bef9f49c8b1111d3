"""Camera in, straight picture out: a board without its clocks and pins."""

from dataclasses import dataclass

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_boards.camera_board.buttons import Chooser
from ncdc_boards.camera_board.pattern import PatternSensor
from ncdc_boards.camera_board.waking import Times, Waker
from ncdc_boards.sdram.controller import SdramController
from ncdc_boards.sdram.layouts import SdramPins
from ncdc_hdl.avalon.bus import Agent, WriteHost
from ncdc_hdl.camera.csi2.layouts import LANE
from ncdc_hdl.camera.layouts import PINS
from ncdc_hdl.lib.ports import ports_as
from ncdc_hdl.link.processor import ProcessorLink, ProcessorPort
from ncdc_hdl.registers.access import RegisterAccess
from ncdc_hdl.registers.agent_access import AgentAccess
from ncdc_hdl.registers.jtag_bridge import JtagBridge, Scan
from ncdc_hdl.registers.program import ProgramRunner
from ncdc_hdl.registers.serial_bridge import SerialBridge
from ncdc_hdl.system import System
from ncdc_hdl.video.scan_out import PICTURE, ScanOut
from ncdc_spec.registers.system_map import SYSTEM_WORDS_BITS

__all__ = ["BUTTONS", "CAPACITY", "LEDS", "BoardCore", "Design"]

BUTTONS = ("following", "previous", "raw")
LEDS = 8
CAPACITY = 3840         # most bytes of a packet's payload
_BURST = 16             # most words per burst of hosts other than the screen
_WIRES_LATE = 2         # a register each in the pins' cells, on the way to the SDRAM and back


@dataclass(frozen=True)
class Design:
    """Parameters of a board's core.

    Parameters
    ----------
    board : CameraBoard
    system : System
        With a screen if the board has one.
    mode : VideoMode or None
        None: without a screen.
    pixel_bytes : int
        Bytes of a pixel in memory.
    clocks : object
        The board's clocks, as its ``clock_plan`` makes them.
    sensor : (Setup, Crop)
    programs : tuple
        Programs of :class:`ProgramRunner`: the configuration first. With a screen, one for each
        lens comes next; the raw picture's is the last.
    lenses : int
        Number of lenses that the buttons choose from, without the raw picture.
    screen_burst : int
        Most words per burst of the screen; 0 without one.
    times : Times
        Times of the sensor's reset, its rest, and the watch over its frames.
    time_scale : int
        The reset, the rest and the pause before another attempt are so many times shorter: 1,
        or more in simulations. The watch is unchanged.
    processor : bool
        There is a processor with Ethernet.
    pattern : PatternSensor or None
        Stands for the sensor, whose pins are then not used.
    """
    board: object
    system: System
    mode: object
    pixel_bytes: int
    clocks: object
    sensor: tuple
    programs: tuple
    lenses: int
    screen_burst: int
    times: Times
    time_scale: int = 1
    processor: bool = False
    pattern: PatternSensor = None

    @property
    def link(self):
        """The :class:`~ncdc_spec.sensors.sensor.Link` of a sensor with CSI-2, else None."""
        return self.sensor[0].link

    @property
    def core_hz(self):
        """Frequency of the core's clock in Hz."""
        return round(self.clocks.core_mhz * 1e6)


class BoardCore(wiring.Component):
    """Joins sensor, memory, corrector, screen, buttons, a serial port, JTAG, a processor.

    Parts that the board or the design lacks are left out; buttons come with the screen. The
    core is in the domain ``sync``, its picture in ``pixel``, its JTAG register in ``jtag``.

    Parameters
    ----------
    design : Design

    Members
    -------
    sensor_clock, sensor : ``In(1)``, ``In(PINS)``
        At the sensor's pins.
    lanes : ``In(LANE).array(lanes)``
        Of a sensor with CSI-2, instead of ``sensor``; ``sensor_clock`` is that of their bytes.
    csi_settle, csi_phy, csi_eyes : ``Out(6)``, ``In(9)``, ``In(32)``
        As of :class:`System`, with ``lanes``.
    sensor_reset_n : ``Out(1)``
    scl, sda, scl_low, sda_low : ``In(1)``, ``Out(1)``
        Lines of the I2C bus to the sensor, and outputs that pull them low.
    sdram : ``Out(SdramPins(chip))``
        Connected to registers in the pins' cells.
    picture : ``Out(PICTURE)``
        With a screen.
    receive, send : ``In(1)``, ``Out(1)``
        A serial port.
    scan : ``In(Scan())``
        Present if the board has ``jtag``.
    processor : ``In(ProcessorPort())``
        Present if the design has a ``processor``.
    following, previous, raw : ``In(1)``
        Buttons, high while pressed, at any time; with a screen.
    again : ``In(1)``
        A button, likewise, that wakes the sensor and sets it up anew.
    leds : ``Out(8)``
        From bit 0: the memory is ready; the configuration is over; the sensor does not answer, or
        is configured again as no good frame came. With a screen: it ran dry; the lens's number.
    """

    def __init__(self, design):
        self.design, board = design, design.board
        g, screen = design.system.descriptor.geometry, design.mode is not None
        self.screen = ScanOut(design.mode, *g.corrected, pixel_bytes=design.pixel_bytes,
                              max_burst=design.screen_burst) if screen else None
        self.link = ProcessorLink(self._width, CAPACITY) if design.processor else None
        self.memory = SdramController(board.chip, design.core_hz, self._width,
                                      reads=1 + screen + 2 * design.processor,
                                      max_burst=max(design.screen_burst, _BURST),
                                      late=_WIRES_LATE)
        super().__init__({
            "sensor_clock": In(1), "sensor_reset_n": Out(1),
            **({"lanes": In(LANE).array(design.link.lanes), "csi_settle": Out(6),
                "csi_phy": In(9), "csi_eyes": In(32)} if design.link else {"sensor": In(PINS)}),
            "scl": In(1), "sda": In(1), "scl_low": Out(1), "sda_low": Out(1), "again": In(1),
            "sdram": Out(SdramPins(board.chip)), "receive": In(1), "send": Out(1),
            **({"picture": Out(PICTURE), **dict.fromkeys(BUTTONS, In(1))} if screen else {}),
            "leds": Out(LEDS), **({"scan": In(Scan())} if board.jtag else {}),
            **({"processor": In(ProcessorPort())} if design.processor else {})})

    @property
    def _width(self):
        """Width of the memory ports in bits."""
        return self.design.system.hardware.data_width

    def elaborate(self, platform):
        m = Module()
        m.submodules.system = system = self.design.system
        m.submodules.memory = self.memory
        if self.link:
            m.submodules.link = link = self.link
            connect(m, flipped(self.processor), link.processor)
            m.d.comb += link.irq.eq(system.irq)
        connect(m, self.memory.pins, flipped(self.sdram))
        self._ports(m)
        waker = self._sensor(m)
        programs = self._registers(m, waker.ready)
        m.d.comb += [waker.busy.eq(programs.busy), waker.failed.eq(programs.failures != 0)]
        shown = Const(0, 0)
        if self.screen:
            self._screen(m)
            shown = Cat(self.screen.underruns != 0, self._buttons(m, programs))
        m.d.comb += self.leds.eq(Cat(self.memory.ready, ~programs.busy, waker.trouble, shown))
        return m

    def _screen(self, m):
        """The screen between the frame store and the pins."""
        m.submodules.screen = screen = self.screen
        system = self.design.system
        m.d.comb += [
            screen.screen.held.eq(system.screen_held), screen.screen.base.eq(system.screen_base),
            system.screen_claim.eq(screen.screen.claim),
            system.screen_shown.eq(screen.shown), system.screen_underruns.eq(screen.underruns),
            self.picture.eq(screen.picture),
        ]

    def _ports(self, m):
        """System, processor and screen at the controller's ports; the screen's is the last.

        Without a screen the last one is the processor's window, which reads a word at a time.
        """
        memory, system = self.memory, self.design.system
        readers = [ports_as(system, "read0", system.corrector.fetch.bus0.signature)]
        readers += [self.link.packets, self.link.window] if self.link else []
        readers += [self.screen.bus] if self.screen else []
        for bus, port in zip(readers, memory.reads, strict=True):
            m.d.comb += [
                port.address.eq(bus.address), port.read.eq(bus.read),
                port.burstcount.eq(bus.burstcount), bus.waitrequest.eq(port.waitrequest),
                bus.readdata.eq(port.readdata), bus.readdatavalid.eq(port.readdatavalid)]
        bus, port = ports_as(system, "write", WriteHost(self._width, 1)), memory.write
        m.d.comb += [
            port.address.eq(bus.address), port.write.eq(bus.write),
            port.burstcount.eq(bus.burstcount), port.writedata.eq(bus.writedata),
            port.byteenable.eq(bus.byteenable), bus.waitrequest.eq(port.waitrequest)]

    def _sensor(self, m):
        """The sensor and its :class:`Waker`."""
        system = self.design.system
        if self.design.link:
            for k, lane in enumerate(self.lanes):
                m.d.comb += [getattr(system, f"sensor_lane{k}_{name}").eq(getattr(lane, name))
                             for name in LANE.members]
            m.d.comb += [self.csi_settle.eq(system.csi_settle), system.csi_phy.eq(self.csi_phy),
                         system.csi_eyes.eq(self.csi_eyes)]
        else:
            m.d.comb += [getattr(system, f"sensor_{name}").eq(getattr(self.sensor, name))
                         for name in PINS.members]
        m.d.comb += [
            system.sensor_clock.eq(self.sensor_clock),
            system.scl.eq(self.scl), system.sda.eq(self.sda),
            self.scl_low.eq(system.scl_low), self.sda_low.eq(system.sda_low),
        ]
        times, time_scale = self.design.times, self.design.time_scale
        times = Times(times.reset_us // time_scale, times.rest_us // time_scale, times.watch_us)
        m.submodules.waker = waker = Waker(times, self.design.core_hz)
        # The pixel clock, divided so that the core's clock can sample it.
        m.domains.pixel_clock = ClockDomain(local=True, reset_less=True)
        m.d.comb += ClockSignal("pixel_clock").eq(self.sensor_clock)
        count = Signal(4, name="pixel_clocks")
        m.d.pixel_clock += count.eq(count + 1)
        m.submodules.pixel_clock_cdc = FFSynchronizer(count[-1], waker.edge)
        m.submodules.again_cdc = FFSynchronizer(self.again, waker.again)
        m.d.comb += [
            waker.came.eq(system.raw.came), waker.bad.eq(system.capture.ends
                                                         & ~system.capture.good),
            waker.enabled.eq(system.capture.enable), self.sensor_reset_n.eq(waker.reset_n)]
        return waker

    def _registers(self, m, ready):
        """Hosts of the registers: the programs, the serial port, JTAG, and the processor.
        """
        design, system = self.design, self.design.system
        m.submodules.access = access = RegisterAccess(
            SYSTEM_WORDS_BITS, 2 + design.board.jtag + design.processor)
        m.submodules.bridge = bridge = SerialBridge(design.core_hz // design.board.baud,
                                                    SYSTEM_WORDS_BITS)
        # The programs are in reset until the sensor accepts accesses.
        hold = Signal(init=1)
        m.d.sync += hold.eq(~(ready & self.memory.ready))
        m.submodules.programs = programs = ResetInserter(hold)(ProgramRunner(
            design.programs, SYSTEM_WORDS_BITS,
            retry_clocks=design.core_hz // 10 // design.time_scale))
        connect(m, programs.access, access.hosts[0])
        connect(m, bridge.access, access.hosts[1])
        if design.board.jtag:
            m.submodules.jtag = jtag = JtagBridge(SYSTEM_WORDS_BITS)
            connect(m, flipped(self.scan), jtag.scan)
            connect(m, jtag.access, access.hosts[2])
        if self.link:
            m.submodules.agent = agent = AgentAccess(SYSTEM_WORDS_BITS)
            connect(m, self.link.system, agent.bus)
            connect(m, agent.access, access.hosts[-1])
        bus = ports_as(system, "csr", Agent(SYSTEM_WORDS_BITS))
        for name, member in Agent(SYSTEM_WORDS_BITS).members.items():
            ours, theirs = getattr(access.bus, name), getattr(bus, name)
            m.d.comb += theirs.eq(ours) if member.flow is Out else ours.eq(theirs)
        m.d.comb += [bridge.receive.eq(self.receive), self.send.eq(bridge.send)]
        return programs

    def _buttons(self, m, programs):
        """Buttons that choose the programs; the number of the chosen lens."""
        m.submodules.chooser = chooser = Chooser(self.design.lenses, self.design.core_hz)
        for name in BUTTONS:
            m.submodules[f"{name}_button"] = FFSynchronizer(getattr(self, name),
                                                            getattr(chooser, name))
        m.d.comb += [
            chooser.busy.eq(programs.busy), programs.start.eq(chooser.start),
            programs.which.eq(chooser.which)]
        return chooser.lens
