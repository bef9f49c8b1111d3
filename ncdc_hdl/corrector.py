"""The corrector: front end, back end, registers, as one module with Avalon ports."""

from itertools import pairwise

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.burst_writer import BurstWriter
from ncdc_hdl.avalon.bus import PENDING, Agent
from ncdc_hdl.backend.cache.cache import Cache
from ncdc_hdl.backend.interpolator import Interpolator
from ncdc_hdl.backend.layouts import request_layout
from ncdc_hdl.backend.multiport import Multiport
from ncdc_hdl.backend.packer import Packer
from ncdc_hdl.backend.row_gate import RowGate
from ncdc_hdl.backend.window import WindowAddress
from ncdc_hdl.camera.layouts import RUN
from ncdc_hdl.frontend.backmap import BackMap
from ncdc_hdl.frontend.layouts import SIZE, coordinate_layout
from ncdc_hdl.frontend.node_backmap import NodeBackMap
from ncdc_hdl.frontend.valid import FixedValidTable, ValidTable
from ncdc_hdl.frontend.view_table import ViewTable
from ncdc_hdl.lib.credits import CreditQueue
from ncdc_hdl.lib.groups import lanes_of
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_hdl.lib.ports import flat, join
from ncdc_hdl.lib.relay import Relay
from ncdc_hdl.registers.agent import Registers
from ncdc_hdl.registers.checks import Checks
from ncdc_hdl.registers.weight_store import in_memory
from ncdc_hdl.video.vip_packets import VipPackets
from ncdc_model.planner.corrector_timing import CorrectorTiming
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import (
    ADDRESS_WORDS_BITS,
    COUNTERS,
    RAW_GAINS,
    absent,
    capabilities,
    network_registers,
    registers,
)
from ncdc_spec.tone import NODE_POSITIONS
from ncdc_spec.view import NAMES as VIEW_NAMES
from ncdc_spec.view import PLANE_HEIGHT
from ncdc_spec.view_rows import ROWS_BANK, ROWS_COUNT, ROWS_STEP

__all__ = ["Corrector"]

_WRITE_BURST = 16  # words


class Corrector(wiring.Component):
    """Corrects one frame per start: raw Bayer frame in memory to corrected pixels.

    Equal bit for bit to ``ncdc_model.golden.corrector.correct``. After configuration all parameters
    have the descriptor's values; a host may change any of them for the next frame.

    Parameters
    ----------
    descriptor : ncdc_spec.descriptor.Descriptor
    runs : bool
        Whether it belongs to a :class:`System`, with a camera's capture: a :class:`RunControl` can
        start it, besides the host.
    hardware : ncdc_spec.hardware.Hardware
        With the output "memory" a burst writer stores pixels in the format that a register
        chooses, row after row without a gap, or where a list of views has them. With "stream" it
        has a video stream source instead.

    Members
    -------
    csr_* : Avalon-MM agent, see the register table
    read0_*, read1_*, read2_* : Avalon-MM read hosts; the cache has only the first
    write_* : Avalon-MM write host (output "memory")
    stream_valid, stream_ready, stream_data, stream_startofpacket, stream_endofpacket :
        video stream, red in the top byte of 24 bits per pixel, the leftmost pixel in the lowest
        (output "stream"); for the video "vip" see :class:`VipPackets`
    stream_endofline : ``Out(1)``
        The last group of a row, or of a frame; only for AXI with the output "stream".
    read_failed : ``In(1)``
        The memory answers a read with an error; only for AXI. Its write host expects an
        answer to each burst.
    memory_rst : ``In(1)``
        The memory or the bus is in reset and drops all accepted requests. It must be
        high together with the corrector's own reset. Either may come and go first, as long as
        no request accepted until the last clock of ``memory_rst`` is answered.
    irq : ``Out(1)``
        Frame complete.
    camera_rows : ``In(SIZE)``
        Rows of the raw frame that are in memory; counts if the register FOLLOW is 1.
    run : ``In(RUN)``
        Starts frames with buffers of their own; only if it ``runs`` by itself.
    bayer_phase : ``Out(3)``
        The active set's; likewise.
    front_end_idle : ``Out(1)``
        The network is idle. A board with a separate clock for the neurons may gate it with
        this; scan, queue and registers need their clock.

    Raises
    ------
    InputError
        If the hardware does not fit the camera, see :meth:`Hardware.made_for`.
    """

    def __init__(self, descriptor, hardware=Hardware(), runs=False):
        self.descriptor, self.hardware = descriptor, hardware.made_for(descriptor)
        self.runs = runs
        data_width, lanes = hardware.data_width, hardware.lanes
        formats = descriptor.formats
        if descriptor.nodes == 1:
            self.backmap = BackMap(descriptor.hidden_neurons, formats, variant=descriptor.variant,
                                   hardware=self.hardware)
        else:
            self.backmap = NodeBackMap(descriptor.hidden_neurons, formats, descriptor.nodes,
                                       variant=descriptor.variant, hardware=self.hardware)
        table = descriptor.valid, *descriptor.geometry.corrected
        self.table = (ViewTable(*table, lanes) if hardware.view
                      else (FixedValidTable if hardware.fixed_lens else ValidTable)(*table))
        needs = descriptor.geometry.interpolation
        f_bits = formats.coordinate.f_bits
        # Without relays the gate's comparison would stall the windows' stages, and these the
        # memory of the front end's queue, all in one clock.
        self.to_window = Relay(coordinate_layout(formats, lanes))
        self.window = WindowAddress(formats, lanes, needs)
        self.to_gate = Relay(request_layout(f_bits, lanes, needs))
        self.row_gate = RowGate(f_bits, lanes, needs) if hardware.follow else None
        self.fetch = (Cache(f_bits, data_width, self.hardware.cache, lanes, hardware.raw_balance,
                            hardware.tile_memory)
                      if hardware.cached else Multiport(f_bits, data_width))
        self.interpolator = Interpolator(f_bits, lanes, needs, hardware.colour,
                                         self.fetch.window_latency)
        rows = registers(descriptor.hidden_neurons, formats, descriptor.nodes, hardware.colour,
                         hardware.raw_balance, hardware.view, hardware.views, hardware.view_rows)
        constants = {"DIGEST": int(descriptor.digest[:8], 16),
                     "NEURONS": descriptor.hidden_neurons, "NODES": descriptor.nodes,
                     **capabilities(self.hardware, *self.table.largest, capture=runs)}
        self.registers = Registers(
            rows, host_values(descriptor, self.hardware), constants,
            in_memory=in_memory(rows, self.hardware),
            neurons=self.hardware.served(descriptor.hidden_neurons),
            constant=absent(rows, self.hardware))
        self.checks = Checks(self.hardware, *self.table.largest,
                             self.registers.active.shape())
        ports = flat("csr", Agent(ADDRESS_WORDS_BITS), In)
        for r in range(self.fetch.ports):
            ports |= flat(f"read{r}", getattr(self.fetch, f"bus{r}").signature, Out)
        if not hardware.stream:
            self.writer = BurstWriter(data_width, burst=_WRITE_BURST,
                                      pending=PENDING if hardware.axi else 0)
            ports |= flat("write", self.writer.bus.signature, Out)
        else:
            ports |= {"stream_valid": Out(1), "stream_ready": In(1), "stream_data": Out(24 * lanes),
                      "stream_startofpacket": Out(1), "stream_endofpacket": Out(1)}
            ports |= {"stream_endofline": Out(1)} if hardware.axi else {}
        if hardware.axi:
            ports |= {"read_failed": In(1)}
        if runs:
            ports |= {"run": In(RUN), "bayer_phase": Out(3)}
        super().__init__(ports | {"memory_rst": In(1), "irq": Out(1), "camera_rows": In(SIZE),
                                  "front_end_idle": Out(1)})

    @property
    def start_latency(self):
        """Clocks from a frame's start to its first window request at the fetcher: front end, window
        address, row gate, a relay before either."""
        return (self.backmap.start_latency + self.to_window.latency + self.window.latency
                + self.to_gate.latency + self._gate_latency)

    @property
    def _gate_latency(self):
        """Clocks of the row gate, if there is one."""
        return self.row_gate.latency if self.row_gate else 0

    @property
    def end_latency(self):
        """Clocks from a window at the fetcher's output to its pixel: interpolator and its queue."""
        return self.interpolator.latency + CreditQueue.latency

    @property
    def timing(self):
        """:class:`CorrectorTiming` of a corrector with a tile cache."""
        fetch, settling = self.fetch, 0
        if self.hardware.view_rows:
            width = self.descriptor.geometry.corrected_width
            settling = self.backmap.settling(min(self.hardware.strip or width, width))
        return CorrectorTiming(
            start=settling + self.start_latency + fetch.start_latency,
            end=fetch.retire.retire_to_window + self.end_latency,
            claim_to_command=fetch.fills.latency,
            fill_to_claim=fetch.fills.credit_latency,
            fill_to_retire=fetch.fills.filled_latency + fetch.retire.filled_to_retire,
            push_to_retire=fetch.retire.push_to_retire,
            retire_to_push=fetch.tags.retire_to_push,
            retire_to_replace=fetch.tags.retire_to_replace,
            push_to_claim=fetch.tags.push_to_claim,
            pixel_to_bus=Packer.latency + BurstWriter.latency,
            row_to_lookup=(RowGate.rows_latency + self._gate_latency + fetch.start_latency),
            end_to_interrupt=self.registers.interrupt_latency,
            write_burst=_WRITE_BURST, queued_words=BurstWriter.queued(_WRITE_BURST),
            queued_pixels=self.interpolator.queued * self.hardware.lanes,
            nodes=self.descriptor.nodes, node_clocks=self.backmap.interval,
            lead=self.backmap.lead)

    def elaborate(self, platform):
        m = Module()
        for name in ("backmap", "table", "to_window", "window", "to_gate", "row_gate", "fetch",
                     "interpolator", "registers", "checks"):
            if (part := getattr(self, name)) is not None:
                m.submodules[name] = part
        registers, active = self.registers, self._active(m)
        begun = Signal()
        m.d.sync += begun.eq(registers.begin)

        join(m, self, "csr", registers.bus)
        for r in range(self.fetch.ports):
            join(m, self, f"read{r}", getattr(self.fetch, f"bus{r}"))
        m.d.comb += [self.irq.eq(registers.irq), self.front_end_idle.eq(self.backmap.idle)]
        if self.hardware.view:
            for lane, table in zip(self.backmap.table, self.table.scan):
                wiring.connect(m, scan=lane, table=table)
        else:
            wiring.connect(m, scan=self.backmap.table, table=self.table.scan)
        if not self.hardware.fixed_lens:
            m.d.comb += self.table.bank.eq(active.VALID_BANK)
            wiring.connect(m, host=registers.valid_table, table=self.table.host)
        self._parameters(m, active)
        reject = self._reject(m, begun, active)
        m.d.comb += [self.backmap.start.eq(begun), self.backmap.abort.eq(registers.abort | reject),
                     registers.cut.eq(self.backmap.cut)]
        gate = [self.row_gate] if self.row_gate else []
        way = (self.backmap, self.to_window, self.window, self.to_gate, *gate, self.fetch)
        for source, sink in pairwise(way):
            wiring.connect(m, source.o, sink.i)
        if self.row_gate:
            self._follow(m, active, begun)
        wiring.connect(m, self.fetch.o, self.interpolator.i)
        m.d.comb += self.fetch.memory_rst.eq(self.memory_rst)
        pixels = self.interpolator.o
        if not self.hardware.stream:
            self._store(m, active, begun, reject)
        else:
            self._stream(m, active, pixels)
            # A register: the end of a frame reaches many registers, and the sink's `ready` is late.
            m.d.sync += registers.ended.eq(pixels.valid & pixels.ready & pixels.p.last)
        failed = self._axi(m, active, pixels) if self.hardware.axi else Const(0)
        running = self._counters(m, begun, pixels)
        dropped = Signal()              # the memory was in reset a clock ago
        m.d.sync += dropped.eq(self.memory_rst)
        m.d.comb += registers.faults.memory.eq(failed | (running & self.memory_rst & ~dropped))
        if self.hardware.colour:
            self._colour(m, active, begun)
        return m

    def _follow(self, m, active, begun):
        """Windows wait for their rows, if the set says so."""
        gate, registers = self.row_gate, self.registers
        # All views of a list are of one raw frame: its rows are counted from the first view on.
        anew = begun & registers.first if self.hardware.views else begun
        # A register: the gate's `ready` would go on from the abort. The next frame's first group
        # comes later than that.
        aborts = delay(m, registers.abort, 1, "aborts", reset_less=False)
        m.d.comb += [gate.start.eq(anew), gate.abort.eq(aborts),
                     gate.camera_rows.eq(self.camera_rows), gate.follow.eq(active.FOLLOW),
                     gate.height.eq(active.DISTORTED_HEIGHT)]

    def _store(self, m, active, begun, reject):
        """Pixels to memory; those of a list of views each in its part of the target."""
        m.submodules.packer = packer = Packer(
            self.hardware.data_width, self.hardware.lanes, self.hardware.views > 0)
        m.submodules.writer = writer = self.writer
        wiring.connect(m, self.interpolator.o, packer.i)
        wiring.connect(m, packer.o, writer.i)
        join(m, self, "write", writer.bus)
        m.d.comb += writer.memory_rst.eq(self.memory_rst)
        m.d.comb += [
            packer.start.eq(begun), packer.base.eq(active.TARGET_BASE),
            packer.limit.eq(active.TARGET_LIMIT), packer.reject.eq(reject),
            packer.format.eq(active.OUTPUT_FORMAT),
            self.registers.faults.target.eq(packer.outside),
            packer.order.width.eq(active.CORRECTED_WIDTH),
            packer.order.height.eq(active.CORRECTED_HEIGHT),
            packer.order.strip.eq(active.STRIP_WIDTH), self.registers.ended.eq(writer.done),
        ]
        if self.hardware.views:
            m.d.sync += packer.origin.eq(active.TARGET_BASE + active.TARGET_OFFSET)
            m.d.comb += packer.pitch.eq(active.TARGET_PITCH)

    def _stream(self, m, active, pixels):
        """Pixels as video, in packets of Intel's suite if the hardware has them."""
        colours = Cat(Cat(p.b, p.g, p.r) for p in lanes_of(pixels.p))
        if self.hardware.video == "vip":
            m.submodules.packets = packets = VipPackets()
            join(m, self, "stream", packets.o)
            m.d.comb += [
                packets.width.eq(active.CORRECTED_WIDTH),
                packets.height.eq(active.CORRECTED_HEIGHT),
                packets.i.valid.eq(pixels.valid), pixels.ready.eq(packets.i.ready),
                packets.i.p.data.eq(colours), packets.i.p.first.eq(pixels.p.first),
                packets.i.p.last.eq(pixels.p.last)]
        else:
            m.d.comb += [
                self.stream_valid.eq(pixels.valid), pixels.ready.eq(self.stream_ready),
                self.stream_data.eq(colours), self.stream_startofpacket.eq(pixels.p.first),
                self.stream_endofpacket.eq(pixels.p.last)]

    def _axi(self, m, active, pixels):
        """Add AXI's ends of lines; return the errors of the memory."""
        failed = self.read_failed
        if not self.hardware.stream:
            failed = failed | self.writer.failed
        else:
            # Groups of a row after this one: a frame's size is constant until its last pixel.
            left, of_row = Signal(range(MAX_SIZE)), Signal(range(MAX_SIZE))
            m.d.sync += of_row.eq((active.CORRECTED_WIDTH >> exact_log2(self.hardware.lanes)) - 1)
            following = Mux(pixels.p.first, of_row, left)
            m.d.comb += self.stream_endofline.eq((following == 0) | pixels.p.last)
            with m.If(pixels.valid & pixels.ready):
                m.d.sync += left.eq(Mux(following == 0, of_row, following - 1))
        return failed

    def _active(self, m):
        """The registers of a frame, with buffers of its own if it is started by `run`."""
        if not self.runs:
            return self.registers.active
        active = Signal.like(self.registers.active, name="active")
        run, registers = self.run, self.registers
        m.d.comb += active.eq(registers.active)
        with m.If(run.assigned):
            m.d.comb += [
                active.SOURCE_BASE.eq(run.buffers.source),
                active.SOURCE_LIMIT.eq(run.buffers.source_limit),
                active.SOURCE_PITCH.eq(run.buffers.pitch), active.FOLLOW.eq(run.buffers.follow),
                active.TARGET_BASE.eq(run.buffers.target),
                active.TARGET_LIMIT.eq(run.buffers.target_limit),
            ]
        over, lacks = ((registers.over, registers.lacks) if self.hardware.views else
                       (registers.ended, registers.cut))
        m.d.comb += [
            registers.running.eq(run.active), registers.start.eq(run.start),
            run.idle.eq(registers.idle), run.over.eq(over), run.cut.eq(lacks),
            run.fault.eq(registers.faults.as_value().any()),
            self.bayer_phase.eq(active.BAYER_PHASE),
        ]
        return active

    def _reject(self, m, begun, active):
        """Whether the frame's set is rejected: the frame then is one blank group, not written."""
        checks, faults = self.checks, self.registers.faults
        reject = Signal()
        m.d.comb += checks.active.eq(active)
        mismatch = 0                    # the raw frame has another size than the lens
        if self.runs:
            buffers = self.run.buffers
            mismatch = self.run.assigned & ((buffers.width != active.DISTORTED_WIDTH)
                                          | (buffers.height != active.DISTORTED_HEIGHT))
        # The fetcher decides after two clocks; the scan needs the result some clocks later.
        begins = delay(m, begun, max(2, checks.latency), "begun", reset_less=False)
        with m.If(begun):
            m.d.sync += reject.eq(0)
        with m.Elif(begins):
            m.d.sync += reject.eq(checks.faults.as_value().any() | self.fetch.empty | mismatch)
        m.d.comb += [faults.alignment.eq(begins & checks.faults.alignment),
                     faults.size.eq(begins & (checks.faults.size | mismatch)),
                     faults.format.eq(begins & checks.faults.format),
                     faults.source.eq(begins & self.fetch.empty | self.fetch.outside)]
        return reject

    def _parameters(self, m, active):
        scan, network = self.backmap.scan, self.backmap.network
        m.d.comb += [
            scan.width.eq(active.CORRECTED_WIDTH), scan.height.eq(active.CORRECTED_HEIGHT),
            scan.strip.eq(0 if self.hardware.stream else active.STRIP_WIDTH),
            scan.origin_x.eq(active.SCAN_ORIGIN_X), scan.step_x.eq(active.SCAN_STEP_X),
            scan.origin_y.eq(active.SCAN_ORIGIN_Y), scan.step_y.eq(active.SCAN_STEP_Y),
            self.window.width.eq(active.DISTORTED_WIDTH),
            self.window.height.eq(active.DISTORTED_HEIGHT),
            self.fetch.base.eq(active.SOURCE_BASE), self.fetch.limit.eq(active.SOURCE_LIMIT),
            self.fetch.pitch.eq(active.SOURCE_PITCH),
            self.fetch.height.eq(active.DISTORTED_HEIGHT),
            self.interpolator.phase.eq(active.BAYER_PHASE[:2]),
            self.interpolator.fill.eq(active.FILL),
        ]
        if "mono" in self.interpolator.signature.members:
            m.d.comb += self.interpolator.mono.eq(active.BAYER_PHASE[2])
        if "crest" in self.interpolator.signature.members:
            m.d.comb += self.interpolator.crest.eq(active.CREST)
        if self.hardware.cached:
            m.d.comb += self.fetch.split.eq(active.CACHE_SPLIT)
        if self.hardware.raw_balance:
            m.d.comb += [self.fetch.balance.phase.eq(active.BAYER_PHASE),
                         *(self.fetch.balance.gains[c].eq(active[name])
                           for c, name in enumerate(RAW_GAINS))]
        if self.hardware.view:
            m.d.comb += [self.backmap.view.matrix[row][column].eq(active[name])
                         for row, names in enumerate(VIEW_NAMES)
                         for column, name in enumerate(names)]
            m.d.comb += self.backmap.view.plane_height.eq(active[PLANE_HEIGHT])
        if self.hardware.view_rows:
            rows = self.backmap.rows
            m.d.comb += [rows.count.eq(active[ROWS_COUNT]), rows.step.eq(active[ROWS_STEP]),
                         rows.bank.eq(active[ROWS_BANK])]
            wiring.connect(m, self.registers.row_writes, self.backmap.row_writes)
        if "phase" in self.fetch.signature.members:
            m.d.comb += self.fetch.phase.eq(active.BAYER_PHASE[:2])
        if "writes" in self.backmap.signature.members:
            wiring.connect(m, self.registers.writes, self.backmap.writes)
        for row in network_registers(self.descriptor.hidden_neurons, self.descriptor.formats):
            if row.name not in active.shape().members:
                continue
            target = network
            for step in row.parameter:
                target = target[step]
            m.d.comb += target.eq(active[row.name])

    def _colour(self, m, active, begun):
        """Join white balance, tone and sums with their registers."""
        colour, sums = self.interpolator.colour, self.interpolator.sums
        counters = self.registers.counters
        for c, name in enumerate(("RED", "GREEN", "BLUE")):
            m.d.comb += [colour.gains[c].eq(active[f"GAIN_{name}"]),
                         counters[f"{name}_SUM"].eq(sums[name.lower()])]
        for k in range(len(NODE_POSITIONS)):
            m.d.comb += colour.tone[k].eq(active[f"TONE{k}"])
        m.d.comb += [counters.VALID_PIXELS.eq(sums.pixels), self.interpolator.begin.eq(begun)]

    def _counters(self, m, begun, pixels):
        """Events that are counted in a frame; returns whether one runs."""
        counters = self.registers.counters
        running = Signal()
        values = {name: Signal(32, name=name.lower())
                  for name in (COUNTERS if self.hardware.counters else ())}
        events = {
            "CLOCKS": running, "PIXELS": Mux(pixels.valid & pixels.ready, self.hardware.lanes, 0),
            "FETCHES": self.fetch.fetched, "FRONT_END_STALLS": self.backmap.stalled,
            "SINK_STALLS": pixels.valid & ~pixels.ready, "DATA_STALLS": self.fetch.waiting}
        if self.hardware.cached:
            stalls = self.fetch.stalls
            events |= {"INTERLOCK_STALLS": stalls.interlock, "CREDIT_STALLS": stalls.credit,
                       "PENDING_STALLS": stalls.pending}
        # With a list of views they count on from view to view.
        first, over = ((begun & self.registers.first, self.registers.over) if self.hardware.views
                       else (begun, self.registers.ended))
        with m.If(begun):
            m.d.sync += running.eq(1)
        with m.Elif(over):
            m.d.sync += running.eq(0)
        # Counted a clock late, so that long sums begin at registers. Those of a frame's last clock
        # are valid two clocks after its end, when the registers copy them.
        anew = register(m, "count_anew", first, reset_less=False)
        for name, value in values.items():
            m.d.comb += counters[name].eq(value)
            if name in events:
                event = register(m, f"{name.lower()}_event", events[name], reset_less=False)
                m.d.sync += value.eq(Mux(anew, 0, value + event))
        return running
