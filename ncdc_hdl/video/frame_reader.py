"""Reads the newest corrected frame from memory for each frame of a screen."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.burst_reader import BurstReader
from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost

__all__ = ["SCREEN", "FrameReader", "marked"]

SCREEN = wiring.Signature({
    "claim": Out(1),                # for one clock: claim the newest corrected frame
    "held": In(1),                  # a buffer is claimed, from the clock after the claim on
    "base": In(ADDRESS_BITS),       # byte address of that buffer
})
"""From a reader in gateware to the store of corrected frames."""


def marked(data_width):
    """A word, and whether it is the first of a frame."""
    return data.StructLayout({"word": data_width, "first": 1})


class FrameReader(wiring.Component):
    """Streams the words of the newest frame, claimed each time the screen is about to begin.

    A frame that is not complete by then is abandoned. Words requested are still
    passed on, so that its reader must search for the next first word. The claim holds the frame's
    buffer until the next claim, so that no frame is torn.

    Timing: the first word of a frame is requested at least 4 clocks after ``begin``.

    Parameters
    ----------
    data_width : int
        Bits of a word.
    words : int
        Words of a frame.
    depth, max_burst : int
        As in :class:`BurstReader`; the latter a power of two.

    Members
    -------
    begin : ``In(1)``
        High for one clock: the screen is about to begin a frame.
    some : ``Out(1)``
        There is a frame to be shown; changes only within some clocks of ``begin``.
    screen : ``Out(SCREEN)``
    o : ``Out(stream.Signature(marked(data_width)))``
    memory_rst : ``In(1)``
        As in :class:`ReadCommands`.
    bus : ``Out(ReadHost(data_width, max_burst))``
    """

    def __init__(self, data_width, words, *, depth=128, max_burst=32):
        self.data_width, self.words = data_width, words
        self.depth, self.max_burst = depth, max_burst
        super().__init__({
            "begin": In(1), "some": Out(1), "screen": Out(SCREEN),
            "o": Out(stream.Signature(marked(data_width))), "memory_rst": In(1),
            "bus": Out(ReadHost(data_width, max_burst))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.reader = reader = BurstReader(self.data_width, depth=self.depth,
                                                   max_burst=self.max_burst)
        wiring.connect(m, reader.bus, wiring.flipped(self.bus))
        address = Signal(ADDRESS_BITS)          # address of the next command
        left = Signal(range(self.words + 1))    # words of the frame not yet in a command
        owed = Signal(range(self.depth + 1))    # words requested and not yet passed on
        first = Signal()                        # the next word passed on is the first
        waiting = Signal()                      # a frame is to begin when no word is due
        claimed = Signal()                      # the claim's answer is valid in this clock
        pending = Signal()                      # there is a command
        words = Signal(range(self.max_burst + 1))       # words of the next command
        command, asked = reader.i, reader.i.valid & reader.i.ready
        handed = self.o.valid & self.o.ready
        burst = exact_log2(self.max_burst)
        m.d.comb += [
            reader.memory_rst.eq(self.memory_rst), command.valid.eq(pending),
            words.eq(Mux(left[burst:].any(), self.max_burst, left[:burst])),
            self.o.valid.eq(reader.o.valid), reader.o.ready.eq(self.o.ready),
            self.o.p.word.eq(reader.o.payload), self.o.p.first.eq(first),
            self.screen.claim.eq(waiting & ~pending & (owed == 0) & ~claimed),
        ]
        m.d.sync += [owed.eq(owed + Mux(asked, command.p.words, 0) - handed),
                     claimed.eq(self.screen.claim)]
        # A command is computed in one clock and offered in the next: the sums are short.
        with m.If(asked):
            m.d.sync += pending.eq(0)
        with m.Elif(~pending & ~waiting & (left != 0)):
            m.d.sync += [pending.eq(1), command.p.address.eq(address), command.p.words.eq(words),
                         left.eq(left - words),
                         address.eq(address + words * (self.data_width // 8))]
        with m.If(handed):
            m.d.sync += first.eq(0)
        with m.If(claimed):
            m.d.sync += [waiting.eq(0), self.some.eq(self.screen.held), first.eq(1),
                         address.eq(self.screen.base),
                         left.eq(Mux(self.screen.held, self.words, 0))]
        with m.If(self.begin):
            m.d.sync += waiting.eq(1)
        return m
