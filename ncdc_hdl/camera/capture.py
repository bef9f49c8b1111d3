"""A camera's frames, from a source of samples and its clock into buffers in memory."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer, ResetSynchronizer
from amaranth.lib.fifo import AsyncFIFOBuffered
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.avalon.burst_writer import BurstWriter, word_layout
from ncdc_hdl.avalon.bus import WriteHost
from ncdc_hdl.camera.camera_side import CameraSide
from ncdc_hdl.camera.fault_counters import FaultCounters, counts_of
from ncdc_hdl.camera.frame_writer import AREA, COUNTS, FrameWriter
from ncdc_hdl.camera.layouts import ENTRY, GRID, SETTINGS, SIZE_BITS
from ncdc_hdl.lib.gains import BALANCE, NO_BALANCE
from ncdc_hdl.lib.ports import forward
from ncdc_hdl.lib.relay import Relay
from ncdc_hdl.lib.word_crossing import WordCrossing

__all__ = ["Capture"]


class Capture(wiring.Component):
    """Writes the frames of a camera to memory, while it is enabled.

    The sensor's clock, which may have any rate and stop at any time, has a domain of its own, with
    :class:`CameraSide`. A queue of ``depth`` entries of four samples leads out of it. A reset
    reaches it at once, and ends there with the second edge of its clock.

    Parameters
    ----------
    data_width : int
        Bits of a word of the memory.
    burst : int
        Most words of a burst.
    depth : int
        A power of two.
    pending : int
        As in :class:`BurstWriter`: rows and frames then wait for the memory's answers.
    grid, source
        As in :class:`CameraSide`. What is the domain ``sync`` of the source is the sensor's clock.

    Members
    -------
    clock : ``In(1)``
        Clock of the sensor and of the source.
    camera : ``Out``
        As in :class:`CameraSide`: ``camera.pins`` of a parallel sensor.
    faults : ``Out``
        Counts of the source's faults, see :class:`FaultCounters`; only if it has any.
    enable : ``In(1)``
        Frames that begin from now on are captured; one that is under way is captured to its end.
    settings : ``In(SETTINGS)``
        Constant while ``active``.
    grid : ``In(GRID)``
        Likewise; only with ``grid``.
    balance : ``In(BALANCE)``
        May change at any time, as a whole: frames that begin some clocks later have it.
    active : ``Out(1)``
        Enabled, or a frame is under way in the sensor's domain.
    area, limit, begins, ends, good, rows, counts
        As in :class:`FrameWriter`.
    half_full : ``Out(1)``
        The queue was half full a clock ago: writing is urgent.
    memory_rst : ``In(1)``
        As in :class:`BurstWriter`.
    bus : ``Out(WriteHost(data_width, burst, pending))``
    """
    def __init__(self, data_width, *, burst, depth=512, pending=0, grid=None, source=None):
        self.data_width, self.burst, self.depth = data_width, burst, depth
        self.pending, self.row = pending, grid
        self.side = CameraSide(source, grid)
        self.faults_layout = self.side.faults_layout
        super().__init__({
            **({"faults": Out(counts_of(self.faults_layout))} if self.faults_layout else {}),
            "clock": In(1), "camera": Out(self.side.outside), "enable": In(1),
            "settings": In(SETTINGS),
            **({} if grid is None else {"grid": In(GRID)}),
            "balance": In(BALANCE, init=NO_BALANCE), "active": Out(1),
            "area": In(AREA), "limit": In(32), "begins": Out(1), "ends": Out(1), "good": Out(1),
            "rows": Out(SIZE_BITS), "counts": Out(COUNTS), "half_full": Out(1),
            "memory_rst": In(1), "bus": Out(WriteHost(data_width, burst, pending)),
        })

    def elaborate(self, platform):
        m = Module()
        # The queue has no reset, so that its two sides never differ. Entries that it
        # still holds after one are no whole frame, and dropped.
        m.domains.camera = ClockDomain(local=True)
        m.domains.camera_queue = ClockDomain(local=True, reset_less=True)
        m.d.comb += [ClockSignal("camera").eq(self.clock),
                     ClockSignal("camera_queue").eq(self.clock)]
        m.submodules.reset = ResetSynchronizer(ResetSignal(), domain="camera")
        m.submodules.side = side = DomainRenamer("camera")(self.side)
        m.submodules.queue = queue = AsyncFIFOBuffered(
            width=ENTRY.size, depth=self.depth, r_domain="sync", w_domain="camera_queue")
        # Registers before the queue and after its block RAM.
        m.submodules.entries = entries = DomainRenamer("camera")(Relay(ENTRY))
        m.submodules.relay = relay = Relay(ENTRY)
        m.submodules.writer = writer = FrameWriter(self.data_width)
        m.submodules.words = words = Relay(word_layout(self.data_width))
        m.submodules.bursts = bursts = BurstWriter(self.data_width, burst=self.burst,
                                                     pending=self.pending)
        m.submodules.enable = FFSynchronizer(self.enable, side.enable, o_domain="camera")
        m.submodules.balance = balance = DomainRenamer({"there": "camera"})(
            WordCrossing(BALANCE, init=NO_BALANCE))
        # One register before it: a synchroniser must not see a glitch.
        active, active_there = Signal(), Signal()
        m.d.camera += active.eq(side.active)
        m.submodules.active = FFSynchronizer(active, active_there)
        m.d.comb += [balance.i.eq(self.balance), side.balance.eq(balance.o)]
        if self.row is not None:
            m.d.comb += side.grid.eq(self.grid)
        if self.faults_layout:
            m.submodules.faults = faults = FaultCounters(self.faults_layout)
            m.d.comb += [faults.faults.eq(side.faults), self.faults.eq(faults.counts)]
        # A register, as what is urgent decides in the same clock who has the memory's port.
        m.d.sync += self.half_full.eq(queue.r_level >= self.depth // 2)
        forward(m, self.side.outside, self.camera, side.camera)
        connect(m, relay.o, writer.i)
        connect(m, writer.o, words.i)
        connect(m, words.o, bursts.i)
        connect(m, bursts.bus, flipped(self.bus))
        m.d.comb += [
            self.active.eq(self.enable | active_there),
            side.settings.eq(self.settings),
            entries.i.payload.eq(side.entry), entries.i.valid.eq(side.push),
            side.space.eq(entries.i.ready), entries.o.ready.eq(queue.w_rdy),
            queue.w_data.eq(entries.o.payload), queue.w_en.eq(entries.o.valid),
            relay.i.payload.eq(queue.r_data), relay.i.valid.eq(queue.r_rdy),
            queue.r_en.eq(relay.i.ready),
            writer.area.eq(self.area), writer.limit.eq(self.limit),
            writer.done.eq(bursts.done), writer.failed.eq(bursts.failed),
            bursts.memory_rst.eq(self.memory_rst),
            self.begins.eq(writer.begins), self.ends.eq(writer.ends), self.good.eq(writer.good),
            self.rows.eq(writer.rows), self.counts.eq(writer.counts),
        ]
        return m
