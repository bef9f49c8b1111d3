"""A system's whole USB side, from the chip's pins to registers and memory."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.avalon.bus import ReadHost
from ncdc_hdl.registers.access import Access
from ncdc_hdl.usb.commands import ByteCommands
from ncdc_hdl.usb.fifo import UsbFifo
from ncdc_hdl.usb.layouts import ChipPins, word_layout

__all__ = ["Splitter", "UsbLink"]


class Splitter(wiring.Component):
    """Splits words into bytes, the lowest first.

    Timing: one byte per clock.

    Parameters
    ----------
    lanes : int
        Bytes of a word.

    Members
    -------
    i : ``In(stream.Signature(word_layout(lanes)))``
    o : ``Out(stream.Signature(8))``
    """

    def __init__(self, lanes):
        self.lanes = lanes
        super().__init__({"i": In(stream.Signature(word_layout(lanes))),
                          "o": Out(stream.Signature(8))})

    def elaborate(self, platform):
        m = Module()
        index = Signal(range(max(2, self.lanes)))
        ends = Signal()                     # the byte is the word's last
        enable = Cat(self.i.p.enable, Const(0, 1))
        m.d.comb += [
            ends.eq(~enable.bit_select(index + 1, 1)),
            self.o.payload.eq(self.i.p.data.word_select(index, 8)),
            # A word without bytes outputs none.
            self.o.valid.eq(self.i.valid & self.i.p.enable[0]),
            self.i.ready.eq(self.i.valid & (~self.i.p.enable[0] | self.o.ready & ends)),
        ]
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += index.eq(Mux(ends, 0, index + 1))
        return m


class UsbLink(wiring.Component):
    """Serves a host at the other end of an FTDI chip.

    Parameters
    ----------
    chip : Chip
    view : SystemView
    sensor : Sensor
    data_width, burst : int
        Parameters of the memory port.
    address_bits : int
        Bits of a word address.

    Members
    -------
    pins : ``Out(ChipPins(chip.lanes))``
    accesses, memory_rst, bus :
        As in :class:`ByteCommands`.
    """

    def __init__(self, chip, view, sensor, data_width, burst, address_bits):
        self.chip = chip
        self.fifo = UsbFifo(chip)
        self.commands = ByteCommands(view, sensor, data_width, burst, address_bits)
        super().__init__({
            "pins": Out(ChipPins(chip.lanes)), "accesses": Out(Access(address_bits)).array(3),
            "memory_rst": In(1), "bus": Out(ReadHost(data_width, burst))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.fifo, m.submodules.commands = self.fifo, self.commands
        fifo, commands = self.fifo, self.commands
        m.submodules.requests = requests = Splitter(self.chip.lanes)
        connect(m, fifo.pins, flipped(self.pins))
        connect(m, fifo.o, requests.i)
        connect(m, requests.o, commands.i)
        connect(m, commands.bus, flipped(self.bus))
        for ours, theirs in zip(self.accesses, commands.accesses):
            connect(m, theirs, flipped(ours))
        m.d.comb += commands.memory_rst.eq(self.memory_rst)
        words = self._words(m, commands.o)
        if self.chip.lanes == 1:
            m.submodules.answers = answers = Splitter(4)
            connect(m, words, answers.i)
            m.d.comb += [fifo.i.valid.eq(answers.o.valid), fifo.i.p.data.eq(answers.o.payload),
                         fifo.i.p.enable.eq(1), answers.o.ready.eq(fifo.i.ready)]
        else:
            connect(m, words, fifo.i)
        return m

    @staticmethod
    def _words(m, beats):
        """Beats of answers as words of four bytes."""
        words = stream.Signature(word_layout(4)).create()
        m.d.comb += [words.valid.eq(beats.valid), words.p.data.eq(beats.p.data),
                     words.p.enable.eq(Const(0xF, 4) >> beats.p.empty),
                     beats.ready.eq(words.ready)]
        return words
