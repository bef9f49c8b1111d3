"""Burst reads from memory into a word stream."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ReadHost
from ncdc_hdl.avalon.read_commands import ReadCommands, command_layout

__all__ = ["BurstReader"]


class BurstReader(wiring.Component):
    """Turns (address, words) commands into Avalon-MM bursts and streams the words in order.

    Read data cannot be stalled. So a command waits until the queue has space for all of its words
    and for those requested and not yet taken. Commands follow each other without a gap. Several
    may be outstanding. Words requested before a reset are dropped, see :class:`ReadCommands`.

    Timing: a command reaches the bus 1 clock after it is taken; a word leaves 2 or more clocks
    after its ``readdatavalid``.

    Parameters
    ----------
    data_width : int
        Bits of a word.
    depth : int
        Most words requested and not yet taken.
    max_burst : int
        Most words of one command.

    Members
    -------
    i : ``In(stream.Signature(command_layout(max_burst)))``
        Byte address (a multiple of the word) and 1..max_burst words.
    o : ``Out(stream.Signature(data_width))``
    memory_rst : ``In(1)``
        As in :class:`ReadCommands`.
    bus : ``Out(ReadHost(data_width, max_burst))``

    Raises
    ------
    ValueError
        If ``max_burst`` exceeds ``depth``.
    """

    def __init__(self, data_width, *, depth, max_burst):
        if not 1 <= max_burst <= depth:
            raise ValueError(f"max_burst is {max_burst}, the limits are 1 and the depth {depth}")
        self.data_width, self.depth, self.max_burst = data_width, depth, max_burst
        super().__init__({
            "i": In(stream.Signature(command_layout(max_burst))),
            "o": Out(stream.Signature(data_width)),
            "memory_rst": In(1),
            "bus": Out(ReadHost(data_width, max_burst)),
        })

    def elaborate(self, platform):
        m = Module()
        # A queue of two would not accept the second of two writes in a row.
        m.submodules.fifo = fifo = SyncFIFOBuffered(width=self.data_width,
                                                    depth=max(self.depth, 3))
        m.submodules.commands = commands = ReadCommands(self.data_width, self.max_burst,
                                                        limit=self.depth)
        wiring.connect(m, commands.bus, wiring.flipped(self.bus))
        m.d.comb += commands.memory_rst.eq(self.memory_rst)
        m.d.comb += [
            fifo.w_data.eq(commands.word), fifo.w_en.eq(commands.valid),
            self.o.payload.eq(fifo.r_data), self.o.valid.eq(fifo.r_rdy),
            fifo.r_en.eq(self.o.ready),
        ]
        claimed = Signal(range(self.depth + 1))      # words requested and not yet taken
        taken = self.o.valid & self.o.ready
        may_ask = claimed + self.i.p.words <= self.depth
        m.d.comb += [
            commands.i.payload.eq(self.i.payload), commands.i.valid.eq(self.i.valid & may_ask),
            self.i.ready.eq(commands.i.ready & may_ask),
        ]
        asked = self.i.valid & self.i.ready
        m.d.sync += claimed.eq(claimed + Mux(asked, self.i.p.words, 0) - taken)
        return m
