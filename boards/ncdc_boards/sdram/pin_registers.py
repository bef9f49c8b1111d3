"""Registers between commands and the chip's pins, and between the pins and words."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_boards.sdram.layouts import SdramPins, command_layout
from ncdc_boards.sdram.write_words import word_layout

__all__ = ["PinRegisters"]

# RAS, CAS and WE of the commands, active low; none is NOP.
_PINS = {"active": 0b011, "read": 0b101, "write": 0b100, "precharge": 0b010,
         "precharge_all": 0b010, "refresh": 0b001, "mode": 0b000}
_ALL = 10       # bit of the address that makes a PRECHARGE close all banks


class PinRegisters(wiring.Component):
    """Gives commands and data to the pins and takes read data from them, all through registers.

    Each register at a pin drives or is driven by that pin alone, so that it fits into the pin's
    cell. The chip works in bursts of ``mapping.beats``, a word of the host each.

    Timing: a command is at the pins 2 clocks after it was given; its word is output ``latency``
    clocks after it.

    Parameters
    ----------
    mapping : AddressMapping
    clocks : SdramTiming
    hosts : int
        Number of readers.
    late : int
        Clocks by which read data are later than with the chip's clock in phase and
        no delays, as the board requires. With a late clock and short delays it is -1.

    Members
    -------
    command, tag : ``In(command_layout(mapping))``, ``In(hosts)``
        A command, and the host of a READ.
    ready : ``In(1)``
        The memory is initialised: DQM may be low.
    word : ``In(word_layout(mapping.data_width))``
        The word of the WRITE of the clock before.
    pins : ``Out(SdramPins(mapping.chip))``
    valid, data : ``Out(hosts)``, ``Out(mapping.data_width)``
        A word has been read for this host.
    """

    def __init__(self, mapping, clocks, *, hosts, late=0):
        self.mapping, self.clocks, self.hosts, self.late = mapping, clocks, hosts, late
        super().__init__({
            "command": In(command_layout(mapping)), "tag": In(hosts), "ready": In(1),
            "word": In(word_layout(mapping.data_width)), "pins": Out(SdramPins(mapping.chip)),
            "valid": Out(hosts), "data": Out(mapping.data_width),
        })

    @property
    def latency(self):
        """Clocks: register, pins, CAS latency, board's delays, DQ's register, the word's beats."""
        return 1 + 1 + self.clocks.cas + self.late + 1 + self.mapping.beats

    @property
    def mode(self):
        """Value of the chip's mode register: burst length, sequential, CAS latency."""
        return self.mapping.beats.bit_length() - 1 | self.clocks.cas << 4

    def elaborate(self, platform):
        m = Module()
        command = Signal(self.command.shape())      # of the clock before
        m.d.sync += command.eq(self.command)
        self._command(m, command)
        self._write(m, command.write)
        self._read(m)
        return m

    def _command(self, m, command):
        """Registers of command and address."""
        pins = self.pins
        ras_cas_we = Signal(3, init=0b111)
        none = Signal(init=1)
        address = Signal(pins.a.shape(), init=0)
        bank = Signal(pins.ba.shape())
        m.d.comb += [
            pins.cke.eq(1), pins.cs_n.eq(none), pins.a.eq(address), pins.ba.eq(bank),
            Cat(pins.we_n, pins.cas_n, pins.ras_n).eq(ras_cas_we),
        ]
        m.d.sync += [ras_cas_we.eq(0b111), none.eq(1), bank.eq(command.bank)]
        for name, value in _PINS.items():
            with m.If(command[name]):
                m.d.sync += [ras_cas_we.eq(value), none.eq(0)]
        # First of a word's columns.
        first = command.column << self.mapping.beats.bit_length() - 1
        with m.If(command.active):
            m.d.sync += address.eq(command.row)
        with m.Elif(command.mode):
            m.d.sync += [address.eq(self.mode), bank.eq(0)]
        with m.Else():
            m.d.sync += address.eq(first | command.precharge_all << _ALL)

    def _write(self, m, begins):
        """Registers of DQ's drivers and DQM: the beats of a word, the lowest first."""
        pins, width, beats = self.pins, self.mapping.chip.data_bits, self.mapping.beats
        rest = Signal(self.word.shape())        # the word, without the beats already at the pins
        goes_on = Signal(beats)                 # a one for each of the beats left
        beat = Signal(self.word.shape())        # the word, from the next beat on
        now = Signal()                          # a beat comes next
        dq = Signal(width)
        drives = Signal()
        mask = Signal(pins.dqm.shape(), init=-1)
        m.d.comb += [
            beat.eq(Mux(begins, self.word.as_value(), rest.as_value())),
            now.eq(begins | goes_on[0]),
            pins.dq_o.eq(dq), pins.dq_oe.eq(drives), pins.dqm.eq(mask),
        ]
        m.d.sync += [
            rest.data.eq(beat.data >> width), rest.enable.eq(beat.enable >> width // 8),
            goes_on.eq(Mux(begins, (1 << beats - 1) - 1, goes_on >> 1)),
            dq.eq(beat.data), drives.eq(now),
            # Before the initialisation DQM is high, as the data sheets require.
            mask.eq(Mux(now, ~beat.enable, Mux(self.ready, 0, -1))),
        ]

    def _read(self, m):
        """Register of DQ, and the words assembled from it."""
        width = self.mapping.chip.data_bits
        dq = Signal(width)
        word = Signal(self.mapping.data_width)
        whose = [Signal(self.hosts, name=f"whose{k}") for k in range(self.latency)]
        m.d.sync += [dq.eq(self.pins.dq_i), word.eq(Cat(word, dq)[width:]),
                     whose[0].eq(Mux(self.command.read, self.tag, 0)),
                     *(after.eq(before) for before, after in zip(whose, whose[1:]))]
        m.d.comb += [self.valid.eq(whose[-1]), self.data.eq(word)]
