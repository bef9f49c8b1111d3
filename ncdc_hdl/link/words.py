"""Words of 32 bits from a memory with words of any length."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.avalon.bus import ReadHost
from ncdc_hdl.avalon.read_commands import ReadCommands, command_layout
from ncdc_hdl.lib.memory import Fifo

__all__ = ["WordReader"]


class WordReader(wiring.Component):
    """Reads bursts, and outputs them in words of 32 bits, the lowest first.

    Parameters
    ----------
    data_width : int
        Bits of a word of the memory: 32, 64 or 128.
    burst : int
        Most words of a command.
    limit : int
        As in :class:`ReadCommands`, with words of 32 bits; longer ones are limited here.

    Members
    -------
    i : ``In(stream.Signature(command_layout(burst)))``
    valid, word : ``Out(1)``, ``Out(32)``
        A word has come; there is no back-pressure.
    last : ``In(1)``
        With a word: the rest of its word of the memory is dropped.
    memory_rst, bus :
        As in :class:`ReadCommands`.
    """

    def __init__(self, data_width, burst, limit):
        self.data_width, self.burst, self.limit = data_width, burst, limit
        super().__init__({
            "i": In(stream.Signature(command_layout(burst))),
            "valid": Out(1), "word": Out(32), "last": In(1), "memory_rst": In(1),
            "bus": Out(ReadHost(data_width, burst))})

    def elaborate(self, platform):
        m = Module()
        limit = self.limit if self.data_width == 32 else 2 * self.burst
        m.submodules.commands = commands = ReadCommands(self.data_width, self.burst, limit=limit)
        connect(m, commands.bus, flipped(self.bus))
        m.d.comb += commands.memory_rst.eq(self.memory_rst)
        if self.data_width == 32:
            connect(m, flipped(self.i), commands.i)
            m.d.comb += [self.valid.eq(commands.valid), self.word.eq(commands.word)]
        else:
            self._parts(m, commands)
        return m

    def _parts(self, m, commands):
        """Long words come faster than they leave: two bursts of them wait."""
        m.submodules.queue = queue = Fifo(width=self.data_width, depth=2 * self.burst)
        parts = self.data_width // 32
        part = Signal(range(parts))
        claimed = Signal(range(2 * self.burst + 1))     # words requested and not taken
        space = Signal()                                # space for a burst, in addition to those
        asked = self.i.valid & self.i.ready
        following = claimed + Mux(asked, self.i.p.words, 0) - (queue.r_rdy & queue.r_en)
        m.d.sync += [claimed.eq(following), space.eq(following <= self.burst)]
        m.d.comb += [
            commands.i.payload.eq(self.i.payload), commands.i.valid.eq(self.i.valid & space),
            self.i.ready.eq(commands.i.ready & space),
            queue.w_data.eq(commands.word), queue.w_en.eq(commands.valid),
            self.valid.eq(queue.r_rdy), self.word.eq(queue.r_data.word_select(part, 32)),
            queue.r_en.eq(self.last | (part == parts - 1)),
        ]
        with m.If(queue.r_rdy):
            m.d.sync += part.eq(Mux(queue.r_en, 0, part + 1))
