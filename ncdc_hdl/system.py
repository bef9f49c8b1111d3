"""A camera system: stores and corrects a sensor's frames, as one module."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import PENDING, Agent, WriteHost
from ncdc_hdl.avalon.write_arbiter import WriteArbiter
from ncdc_hdl.camera.cameras import camera_ports, source_of
from ncdc_hdl.camera.capture import Capture
from ncdc_hdl.camera.frame_store import FrameStore
from ncdc_hdl.camera.i2c import I2cController
from ncdc_hdl.camera.readers import StoreReader
from ncdc_hdl.camera.run_control import RunControl
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.lib.ports import flat, join, ports_as
from ncdc_hdl.registers.page import Page
from ncdc_hdl.video.frame_reader import SCREEN
from ncdc_spec.camera_port import CSI2, CameraPort
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import ADDRESS_WORDS_BITS
from ncdc_spec.registers.system_map import (
    EVENTS,
    GRID_ROW_MIN,
    LOCKED,
    STORES,
    SYSTEM_WORDS_BITS,
    system_registers,
)
from ncdc_spec.registers.system_values import stores_for, system_values
from ncdc_spec.sensors.level import PIECES

__all__ = ["System"]

_BURST = 16         # words of a burst of the camera and of the corrector


class System(wiring.Component):
    """Captures a sensor's frames, corrects each into a buffer of its own, and offers both.

    Registers: :mod:`ncdc_spec.registers.system_map`, after those of the corrector.

    Parameters
    ----------
    descriptor : ncdc_spec.descriptor.Descriptor
    hardware : ncdc_spec.hardware.Hardware
    readers : int
        Readers that claim frames by registers.
    screens : int
        Readers of corrected frames in gateware, 0 or 1.
    grid : int, optional
        Samples of the longest row that the sensor sends, from 8 on. Samples can be moved to
        an even Bayer grid as they come, see :class:`ncdc_hdl.camera.grid.Grid`; by default they are
        not moved.
    camera : CameraPort
        Kind of the camera, by default a parallel sensor.

    Members
    -------
    csr_* : Avalon-MM agent
    sensor_clock : ``In(1)``
        Clock of the camera's ports.
    sensor_* : of the camera
        ``frame_valid``, ``line_valid`` and ``data`` of a parallel sensor; members of
        :class:`AxisSource`, :class:`AvalonStSource`; ``lane0_data``, ``lane0_valid`` and
        ``lane0_active``, and so on, of :class:`Receiver`.
    scl_low, sda_low, scl, sda : ``Out(1)``, ``In(1)``
        The I2C bus: pull the line low; the line.
    read0_*, read1_*, read2_* : Avalon-MM read hosts, of the corrector
    write_* : Avalon-MM write host, of the camera and the corrector: see :class:`WriteArbiter`
    stream_*, memory_rst, front_end_idle
        As in :class:`Corrector`.
    screen_claim, screen_held, screen_base : ``SCREEN``, from a screen
    screen_shown, screen_underruns : ``In(32)``
        Its counters, for the registers. All five only with a screen.
    csi_settle, csi_phy, csi_eyes : ``Out(6)``, ``In(9)``, ``In(32)``
        Registers of the same names, of a PHY for CSI-2; only with one.
    irq : ``Out(1)``
        The corrector's, or one of the events that are enabled.

    Raises
    ------
    InputError
        If there is a screen, and corrected pixels leave as a stream; if ``grid`` is out of its
        range, or the camera has more than one sample per clock.
    """

    def __init__(self, descriptor, hardware=Hardware(), readers=2, screens=0, grid=None,
                 camera=CameraPort()):
        if screens and hardware.stream:
            raise InputError("corrected pixels leave as a stream, a screen shows those in memory")
        if grid is not None and not GRID_ROW_MIN <= grid <= MAX_SIZE:
            raise InputError(f"the longest row of the grid stage has {grid} samples, it must have "
                             f"{GRID_ROW_MIN} to {MAX_SIZE}")
        self.corrector = Corrector(descriptor, hardware, runs=True)
        self.descriptor, self.hardware = descriptor, self.corrector.hardware
        self.stores = stores_for(self.hardware, readers, screens)
        self.grid, self.camera = grid, camera
        self.table = system_registers(self.stores, grid, (camera.kind,), camera.phy)
        self.pending = PENDING if self.hardware.axi else 0
        self.capture = Capture(self.hardware.data_width, burst=_BURST, pending=self.pending,
                               grid=grid, source=source_of(camera))
        self.raw = FrameStore(1 + readers, looks=2)
        self.corrected = None if self.hardware.stream else FrameStore(readers + screens)
        ports = flat("csr", Agent(SYSTEM_WORDS_BITS), In) | {"sensor_clock": In(1)}
        ports |= {name: member for name, (member, _) in camera_ports(self.capture.camera).items()}
        ports |= {"scl_low": Out(1), "sda_low": Out(1), "scl": In(1), "sda": In(1)}
        ports |= {name: member for name, member in self.corrector.signature.members.items()
                  if name.startswith(("read", "stream_"))}
        ports |= flat("write", WriteHost(self.hardware.data_width, _BURST, self.pending), Out)
        if screens:
            ports |= flat("screen", SCREEN, In)
            ports |= {"screen_shown": In(32), "screen_underruns": In(32)}
        if camera.phy:
            ports |= {"csi_settle": Out(6), "csi_phy": In(9), "csi_eyes": In(32)}
        super().__init__(ports | {"memory_rst": In(1), "irq": Out(1), "front_end_idle": Out(1)})

    @property
    def options(self):
        """Options of ``ncdc generate`` for its camera."""
        return self.camera.options

    def page(self):
        """Its page of registers, made anew."""
        bases = [r.name for r in self.table if r.name.endswith("_BASE")]
        word_bits = exact_log2(self.hardware.data_width // 8)
        return Page(
            self.table, SYSTEM_WORDS_BITS,
            system_values(self.descriptor, self.hardware, self.stores, self.camera),
            [*LOCKED, *bases],
            dict.fromkeys([*bases, "RAW_PITCH", "RAW_BYTES", "CORRECTED_BYTES"], word_bits))

    def elaborate(self, platform):
        m = Module()
        m.submodules.corrector = corrector = self.corrector
        m.submodules.capture = capture = self.capture
        m.submodules.raw = self.raw
        m.submodules.i2c = i2c = I2cController()
        m.submodules.run_control = control = RunControl()
        m.submodules.page = page = self.page()
        for name in self.signature.members:
            if name.startswith(("read", "stream_")) or name in ("memory_rst", "front_end_idle"):
                self._pass(m, name)
        time = Signal(64)               # clocks since the reset
        m.d.sync += time.eq(time + 1)
        self._bus(m, page)
        self._writes(m)
        values = page.values
        m.d.comb += [capture.clock.eq(self.sensor_clock), capture.memory_rst.eq(self.memory_rst)]
        for name, (member, signal) in camera_ports(capture.camera).items():
            ours = getattr(self, name)
            m.d.comb += ours.eq(signal) if member.flow is Out else signal.eq(ours)
        self._settings(m, values)
        connect(m, control.corrector, corrector.run)
        if self.corrected is not None:
            m.submodules.corrected = self.corrected
        readers = self._readers(m, page)
        if self.stores.screens:
            self._screen(m, values)
        self._run(m, control, values, time)
        self._i2c(m, i2c, page)
        self._read(m, page, control, i2c, readers, time)
        return m

    def _pass(self, m, name):
        """Connect a port with the corrector's of the same name."""
        ours, inner = getattr(self, name), getattr(self.corrector, name)
        m.d.comb += ours.eq(inner) if self.signature.members[name].flow is Out else inner.eq(ours)

    def _bus(self, m, page):
        """The corrector's registers, and the page after them."""
        there = self.csr_address[ADDRESS_WORDS_BITS]    # the address is the page's
        corrector, bus = self.corrector, page.bus
        m.d.comb += [
            corrector.csr_address.eq(self.csr_address), bus.address.eq(self.csr_address),
            corrector.csr_writedata.eq(self.csr_writedata), bus.writedata.eq(self.csr_writedata),
            corrector.csr_read.eq(self.csr_read & ~there), bus.read.eq(self.csr_read & there),
            corrector.csr_write.eq(self.csr_write & ~there), bus.write.eq(self.csr_write & there),
            self.csr_waitrequest.eq(Mux(there, bus.waitrequest, corrector.csr_waitrequest)),
            self.csr_readdatavalid.eq(corrector.csr_readdatavalid | bus.readdatavalid),
            self.csr_readdata.eq(Mux(bus.readdatavalid, bus.readdata, corrector.csr_readdata)),
        ]

    def _writes(self, m):
        """Camera and corrector on one write port: the camera first when its queue fills."""
        capture, corrector = self.capture, self.corrector
        hosts = [capture.bus]
        if not self.hardware.stream:
            hosts.append(ports_as(corrector, "write", capture.bus.signature))
        m.submodules.writes = writes = WriteArbiter(self.hardware.data_width, _BURST, len(hosts),
                                                  self.pending)
        for k, host in enumerate(hosts):
            connect(m, host, writes.hosts[k])
        m.d.comb += [writes.memory_rst.eq(self.memory_rst), writes.urgent.eq(capture.half_full)]
        join(m, self, "write", writes.bus)

    def _settings(self, m, values):
        """Settings of the camera from its registers."""
        settings, capture = self.capture.settings, self.capture
        base = self._base(values, "RAW", self.raw.buffer)
        m.d.comb += [
            capture.enable.eq(values.CAMERA_ENABLE), capture.limit.eq(values.CLOCK_LIMIT),
            settings.sent_width.eq(values.SENT_WIDTH), settings.sent_height.eq(values.SENT_HEIGHT),
            settings.left.eq(values.WINDOW_LEFT), settings.top.eq(values.WINDOW_TOP),
            settings.width.eq(values.WINDOW_WIDTH), settings.height.eq(values.WINDOW_HEIGHT),
            settings.level.black.eq(values.BLACK_LEVEL),
            *(settings.level.curve[k].eq(values[f"CURVE{k}"]) for k in range(PIECES + 1)),
            Value.cast(capture.balance.gains).eq(values.CAPTURE_GAINS),
            capture.balance.phase.eq(self.corrector.bayer_phase),
            capture.area.pitch.eq(values.RAW_PITCH), capture.area.width.eq(values.WINDOW_WIDTH),
            capture.area.height.eq(values.WINDOW_HEIGHT),
            capture.area.base.eq(base), capture.area.limit.eq(base + values.RAW_BYTES),
        ]
        if self.camera.kind == CSI2:
            m.d.comb += [capture.camera.settings.channel.eq(values.CSI_CHANNEL),
                         capture.camera.settings.type.eq(values.CSI_TYPE)]
        if self.camera.phy:
            m.d.comb += self.csi_settle.eq(values.CSI_SETTLE)
        if self.grid is not None:
            m.d.comb += [capture.grid.weight.eq(values.GRID_WEIGHT),
                         capture.grid.binning.eq(values.GRID_BIN)]

    def _base(self, values, store, buffer):
        """Base address of the ``buffer`` of a store."""
        count = getattr(self.stores, store.lower())
        return Array(values[f"{store}{k}_BASE"] for k in range(count))[buffer]

    def _readers(self, m, page):
        """The readers by registers; return their states."""
        states = []
        for k in range(self.stores.readers):
            m.submodules[f"reader{k}"] = reader = StoreReader(len(self.raw.buffer))
            stores = [self.raw.readers[k + 1]]
            stores += [] if self.corrected is None else [self.corrected.readers[k]]
            for inner, store in zip(reader.stores, stores):
                m.d.comb += [store.claim.eq(inner.claim), store.release.eq(inner.release),
                             inner.held.eq(store.held), inner.lost.eq(store.lost),
                             inner.buffer.eq(store.buffer)]
            asked = page.written[f"READER{k}"]
            m.d.comb += [reader.claim_raw.eq(asked & page.word[0]),
                         reader.claim_corrected.eq(asked & page.word[1]),
                         reader.release.eq(asked & page.word[2])]
            states.append(reader.state)
        return states

    def _screen(self, m, values):
        """The screen, which is the last reader of corrected frames."""
        store = self.corrected.readers[-1]
        m.d.comb += [store.claim.eq(self.screen_claim), self.screen_held.eq(store.held),
                     self.screen_base.eq(self._base(values, "CORRECTED", store.buffer))]

    def _run(self, m, control, values, time):
        """Stores of frames, and the corrector between them."""
        raw, capture, first = self.raw, self.capture, self.raw.readers[0]
        begun = Signal()                # the raw store's writer has a frame since this clock
        over = Signal()                 # the frame with early start is complete
        m.d.sync += begun.eq(capture.begins)
        m.d.comb += [
            raw.begins.eq(capture.begins), raw.ends.eq(capture.ends), raw.good.eq(capture.good),
            raw.about.number.eq(raw.begun + 1), raw.about.time.eq(time),
            raw.limit.eq(values.READER_LIMIT), raw.follow.eq(control.claim_follow),
            first.claim.eq(control.claim), first.release.eq(control.release),
            control.run.eq(values.RUN), control.follow.eq(values.RUN_FOLLOW),
            control.raw_pitch.eq(values.RAW_PITCH), control.raw_width.eq(values.WINDOW_WIDTH),
            control.raw_height.eq(values.WINDOW_HEIGHT), control.raw_bytes.eq(values.RAW_BYTES),
            control.corrected_bytes.eq(values.CORRECTED_BYTES),
            control.came.eq(raw.came), control.begun.eq(begun), control.ended.eq(capture.ends),
            control.good.eq(capture.good), control.held.eq(first.held),
            control.raw_base.eq(self._base(values, "RAW", first.buffer)),
            raw.looks[1].buffer.eq(first.buffer), control.about.eq(raw.looks[1].frame),
        ]
        with m.If(capture.ends):
            m.d.sync += over.eq(1)
        with m.Elif(control.claim):
            m.d.sync += over.eq(0)
        # The rows of a frame that ended early never come: the corrector continues without them.
        m.d.comb += self.corrector.camera_rows.eq(
            Mux(over, values.WINDOW_HEIGHT, capture.rows))
        if self.corrected is not None:
            store = self.corrected
            m.d.comb += [
                store.begins.eq(control.target_begins), store.ends.eq(control.target_ends),
                store.good.eq(control.target_good), store.about.eq(control.about),
                store.limit.eq(values.READER_LIMIT),
                control.target_base.eq(self._base(values, "CORRECTED", store.buffer)),
            ]

    def _i2c(self, m, i2c, page):
        """A command per write of the register; one that comes too early is rejected."""
        m.d.comb += [
            i2c.quarter.eq(page.values.I2C_QUARTER), i2c.limit.eq(page.values.I2C_LIMIT),
            i2c.i.valid.eq(page.written.I2C_COMMAND), i2c.i.payload.eq(page.word),
            self.scl_low.eq(i2c.scl_low), self.sda_low.eq(i2c.sda_low),
            i2c.scl.eq(self.scl), i2c.sda.eq(self.sda),
        ]

    def _read(self, m, page, control, i2c, readers, time):
        """Values of the readable registers."""
        raw, corrected, capture, read = self.raw, self.corrected, self.capture, page.read
        events = self._events(m, page, control, i2c)
        result = i2c.result
        shown = {
            "CAMERA_STATUS": Cat(capture.active, control.corrector.active, Const(0, 6), events),
            **({} if self.grid is None else {"GRID_ROW": self.grid}),
            **({"CSI_PHY": self.csi_phy, "CSI_EYES": self.csi_eyes} if self.camera.phy else {}),
            **({"SOURCE_FAULTS": capture.counts.bad} if self.camera.faults else {}),
            **{register: capture.faults[name]
               for name, register in self.camera.fault_registers.items()},
            "CAMERA_ROWS": capture.rows, "LINE_FAULTS": capture.counts.lines,
            "FRAMES_CUT": capture.counts.cut, "OVERFLOWS": capture.counts.overflows,
            "FRAMES_MISSED": capture.counts.missed, "CLOCK_STOPS": capture.counts.stopped,
            "RAW_BEGUN": raw.begun, "RAW_ENDED_BAD": raw.bad, "RAW_TAKEN": raw.taken,
            "RAW_SKIPPED": control.skipped,
            "CORRECTED_BEGUN": control.begun_count, "CORRECTED_ENDED_BAD": control.bad_count,
            "CORRECTED_NUMBER": control.number,
            "CORRECTED_TAKEN": 0 if corrected is None else corrected.taken,
            "TIME_LOW": time[:32], "TIME_HIGH": time[32:], "I2C_COMMAND": 0,
            "I2C_RESULT": Cat(result.data, ~i2c.i.ready, result.nack, result.lost, result.timeout),
            **{f"READER{k}": Cat(Const(0, 8), state.held, state.lost, state.corrected, state.buffer)
               for k, state in enumerate(readers)},
        }
        # Each buffer has four words, which the address counts.
        index = page.looked - STORES
        stores = [("RAW", raw)] + ([("CORRECTED", corrected)] if corrected is not None else [])
        for name, store in stores:
            look = store.looks[0]
            m.d.comb += look.buffer.eq(index[2:2 + len(look.buffer)])
            for k in range(store.buffers):
                shown |= {f"{name}{k}_NUMBER": look.frame.number,
                          f"{name}{k}_TIME_LOW": look.frame.time[:32],
                          f"{name}{k}_TIME_HIGH": look.frame.time[32:]}
        if self.stores.screens:
            shown |= {"SCREEN_SHOWN": self.screen_shown, "SCREEN_UNDERRUNS": self.screen_underruns}
        m.d.comb += [read[name].eq(value) for name, value in shown.items()]
        m.d.comb += page.lock.eq(capture.active | control.corrector.active)

    def _events(self, m, page, control, i2c):
        """The flags of CAMERA_STATUS, and the interrupt."""
        raw, corrected = self.raw, self.corrected
        taken = [raw.taken] + ([corrected.taken] if corrected is not None else [])
        happens = {
            "RAW_FRAME": raw.came, "RAW_BAD": self.capture.ends & ~self.capture.good,
            "CORRECTED_FRAME": control.target_ends & control.target_good,
            "CORRECTED_BAD": control.target_ends & ~control.target_good,
            "TAKEN": Cat(count != _before(m, count, f"taken{k}")
                         for k, count in enumerate(taken)).any(),
            "I2C_DONE": i2c.done,
            "REFUSED": page.rejected | page.written.I2C_COMMAND & ~i2c.i.ready,
        }
        events = Signal(len(EVENTS))
        for k, (name, _) in enumerate(EVENTS):
            with m.If(page.written.CAMERA_STATUS & page.word[8 + k]):
                m.d.sync += events[k].eq(0)
            with m.If(happens[name]):
                m.d.sync += events[k].eq(1)
        m.d.comb += self.irq.eq(
            self.corrector.irq | (events & page.values.CAMERA_IRQ_ENABLE).any())
        return events


def _before(m, value, name):
    """``value`` in the clock before."""
    before = Signal.like(value, name=f"{name}_before")
    m.d.sync += before.eq(value)
    return before
