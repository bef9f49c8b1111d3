"""The SDRAM controller: readers and a writer on one SDR SDRAM."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import exact_log2

from ncdc_boards.sdram.arbiter import SdramArbiter
from ncdc_boards.sdram.chips import clocks_of
from ncdc_boards.sdram.layouts import AddressMapping, SdramPins
from ncdc_boards.sdram.pin_registers import PinRegisters
from ncdc_boards.sdram.segments import Segments
from ncdc_boards.sdram.sequencer import Sequencer
from ncdc_boards.sdram.write_words import WriteWords
from ncdc_hdl.avalon.bus import ReadHost, WriteHost
from ncdc_spec.errors import InputError

__all__ = ["SdramController"]

_BEATS = (1, 2, 4, 8)       # the chip's burst lengths
_CHOICE = 2                 # clocks: the arbiter's choice, the segment's register


class SdramController(wiring.Component):
    """Pipelined burst reads of several hosts and burst writes of one, on an SDR SDRAM.

    The last reader is the video's: it comes before the writer, and the writer before the other
    readers, within the limits of :class:`SdramArbiter`. A read returns its words' content at a time
    between its acceptance and its data. It includes each write burst whose last word was accepted
    before, and may include later ones. Bursts of one port are carried out in order.

    Addresses beyond the memory wrap around to its start; bits below the word are ignored.

    A reset drops all reads and writes and initialises the memory anew. The content stays if
    the reset is short. A reset of a host alone cancels nothing.

    Timing: a word of a row that is open comes ``latency`` clocks after its read was accepted, if
    no other host is served before. Words of the burst follow each ``beats`` clocks. Each
    ``waitrequest`` is a register. All pins have registers at them. ``bounds`` gives how
    long a command waits at most.

    Parameters
    ----------
    chip : SdramChip
    clock_hz : number
    data_width : int
        Bits of a word of the hosts: 1, 2, 4 or 8 times the chip's.
    reads : int
        Read ports, that of the video included.
    max_burst : int
        Most words of a burst.
    cas, late : int or None, int
        CAS latency, see :func:`clocks_of`; see :class:`PinRegisters`.

    Members
    -------
    reads : ``In(ReadHost(data_width, max_burst)).array(reads)``
    write : ``In(WriteHost(data_width, max_burst))``
    pins : ``Out(SdramPins(chip))``
    ready : ``Out(1)``
        The memory is initialised. Before, each port accepts one command, which waits.

    Raises
    ------
    InputError
        If a parameter is out of its range.
    """

    def __init__(self, chip, clock_hz, data_width, reads, max_burst, *, cas=None, late=0):
        _check(chip, data_width, reads, max_burst, late)
        self.chip, self.clocks = chip, clocks_of(chip, clock_hz, cas)
        self.mapping = AddressMapping(chip, data_width, max_burst)
        self.count = reads
        self.sequencer = Sequencer(self.mapping, self.clocks, tag_bits=reads)
        self.registers = PinRegisters(self.mapping, self.clocks, hosts=reads, late=late)
        super().__init__({
            "reads": In(ReadHost(data_width, max_burst)).array(reads),
            "write": In(WriteHost(data_width, max_burst)),
            "pins": Out(SdramPins(chip)), "ready": Out(1),
        })

    @property
    def latency(self):
        """Clocks from a read's acceptance to its first word, at best."""
        return Segments.latency + _CHOICE + Sequencer.latency + self.registers.latency

    @property
    def bounds(self):
        """{host: clocks from acceptance to the last word read or written, at most}
        of a port without other commands under way. Hosts are "video", "write" and "read".

        A host waits for turns of others, each of which may be a segment. A burst
        may be two, each with its turn. A reader waits for two bursts written as well, see
        :meth:`_wants`. Four segments are under way before it, two in the sequencer and two before
        that. A refresh comes once in each of its periods.
        """
        turns, sequencer = SdramArbiter.others(self.count), self.sequencer
        written = 4 * (turns["write"] + 1)      # turns until the bursts of two writes are over
        refresh = sequencer.delay + self.clocks.rfc + 1

        def clocks(others, before=0):
            segments = 4 + before + 2 * (others + 1)
            plain = segments * sequencer.segment_clocks + self.latency
            share = sequencer.period - refresh      # clocks between two refreshes
            return plain + -(-plain // share) * refresh

        return {"video": clocks(turns["video"], written), "write": clocks(turns["write"]),
                "read": clocks(turns["read"], written)}

    def elaborate(self, platform):
        m = Module()
        m.submodules.sequencer = sequencer = self.sequencer
        m.submodules.registers = registers = self.registers
        m.submodules.write_words = words = WriteWords(self.mapping)
        m.submodules.turns = turns = SdramArbiter(self.count)
        ports = []
        for k in range(self.count + 1):
            m.submodules[f"segments{k}"] = port = Segments(self.mapping)
            ports.append(port)
        connect(m, words.o, ports[-1].i)
        connect(m, words.bus, flipped(self.write))
        connect(m, registers.pins, flipped(self.pins))
        m.d.comb += [
            turns.wants.eq(self._wants(m, ports, turns)), self.ready.eq(sequencer.ready),
            registers.command.eq(sequencer.command), registers.tag.eq(sequencer.tag),
            registers.ready.eq(sequencer.ready), registers.word.eq(words.word),
            words.take.eq(sequencer.command.write),
        ]
        for k, (bus, port) in enumerate(zip(self.reads, ports)):
            m.d.comb += [
                port.i.valid.eq(bus.read), bus.waitrequest.eq(~port.i.ready),
                port.i.p.word.eq(bus.address[exact_log2(self.mapping.data_width // 8):]),
                port.i.p.words.eq(bus.burstcount),
                bus.readdatavalid.eq(registers.valid[k]), bus.readdata.eq(registers.data),
            ]
        self._choose(m, ports, turns)
        return m

    def _wants(self, m, ports, turns):
        """Which ports may have a turn: a reader waits for the bursts written before its command."""
        writer = ports[-1]
        written = Signal()          # the last segment of a burst is taken to be written
        m.d.comb += written.eq(writer.o.valid & writer.o.ready & writer.o.p.last)
        wants = []
        for k, port in enumerate(ports[:-1]):
            owed = Signal(2, name=f"owed{k}")   # bursts to be written before
            with m.If(port.loads):
                m.d.sync += owed.eq(self._owed(writer.bursts, written))
            with m.Elif(written & (owed != 0)):
                m.d.sync += owed.eq(owed - 1)
            wants.append(port.o.valid & (owed == 0))
        return Cat(*wants, writer.o.valid)

    def _owed(self, bursts, written):
        """Bursts to be written that are accepted and not complete at the end of this clock.

        A method of its own only so that tests can break it.
        """
        return bursts - written

    def _choose(self, m, ports, turns):
        """Take segments to the sequencer: first the choice of the port, then its segment."""
        turn = Signal.like(turns.grant)             # port whose segment is taken next
        decided = Signal()                          # there is such a port
        chosen = Signal()                           # there is a segment
        job = Signal(self.sequencer.job)            # that segment
        i = self.sequencer.i
        m.d.comb += [turns.take.eq(~decided), i.valid.eq(chosen), i.p.eq(job)]
        with m.If(~decided):
            m.d.sync += [turn.eq(turns.grant), decided.eq(turns.grant.any())]
        with m.Elif(~chosen):
            m.d.sync += [turn.eq(0), decided.eq(0)]
        with m.If(i.valid & i.ready):
            m.d.sync += chosen.eq(0)
        with m.If(~chosen):
            m.d.sync += [chosen.eq(decided), job.write.eq(turn[-1]), job.tag.eq(turn[:-1])]
            for k, port in enumerate(ports):
                with m.If(turn[k]):
                    m.d.sync += [job[name].eq(port.o.p[name])
                                 for name in self.mapping.segment.members]
        for k, port in enumerate(ports):
            m.d.comb += port.o.ready.eq(~chosen & turn[k])


def _check(chip, data_width, reads, max_burst, late):
    """Raise InputError unless a controller can have these parameters."""
    if data_width not in [beats * chip.data_bits for beats in _BEATS]:
        raise InputError(f"data_width is {data_width}, not 1, 2, 4 or 8 times the "
                         f"{chip.data_bits} bits of {chip.name}")
    if reads < 1:
        raise InputError(f"reads is {reads}, the controller needs 1 read port or more")
    if chip.column_bits > _PRECHARGE_BIT:
        raise InputError(f"{chip.name} has {chip.column_bits} column bits, the controller has "
                         f"{_PRECHARGE_BIT} at most")
    row = (chip.data_bits << chip.column_bits) // data_width
    if not 1 <= max_burst <= row:
        raise InputError(f"max_burst is {max_burst}, the limits are 1 and the {row} words of a row")
    if late < -1:
        raise InputError(f"late is {late}, the limit is -1: a clock early")


_PRECHARGE_BIT = 10         # of the address; columns are below it
