"""Read commands, and the words a memory owes for them, which no reset but its own forgets."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost

__all__ = ["ReadCommands", "command_layout"]


def command_layout(max_burst):
    """A read: byte address, a multiple of the word, and 1..max_burst words."""
    return data.StructLayout({"address": ADDRESS_BITS, "words": range(max_burst + 1)})


class ReadCommands(wiring.Component):
    """Gives the commands of a read host and hands on the words that come back.

    A reset cannot take back what the memory has been asked for, so what this knows of it is not
    reset: a command stays on the bus until it is accepted, and words asked for before the reset
    are dropped as they come. No new command is given before the last of them has come.

    A memory that is reset itself owes nothing: ``memory_rst`` clears all of that. While it is high
    no command is on the bus but for its first clock, and what comes is nobody's. It takes away what
    the parent waits for, so it goes with a reset of the parent, earlier or later by some clocks.

    Timing: a command reaches the bus 1 clock after it is taken; commands follow each other without
    a gap. A word is handed on in the clock of its ``readdatavalid``.

    Parameters
    ----------
    data_width, max_burst : int
        Bits of a word; words of one command, at most.
    limit : int
        Words asked for and not yet come, at most; who gives the commands keeps to it.

    Members
    -------
    i : ``In(stream.Signature(command_layout(max_burst)))``
    memory_rst : ``In(1)``
        The memory forgets all that it has accepted, up to and including this clock.
    valid, word : ``Out(1)``, ``Out(data_width)``
        A word has come, which cannot be refused.
    bus : ``Out(ReadHost(data_width, max_burst))``
    """

    latency = 1
    """Clocks from a command to the bus."""

    def __init__(self, data_width, max_burst, *, limit):
        self.max_burst, self.limit = max_burst, limit
        super().__init__({
            "i": In(stream.Signature(command_layout(max_burst))),
            "memory_rst": In(1),
            "valid": Out(1), "word": Out(data_width),
            "bus": Out(ReadHost(data_width, max_burst)),
        })

    def elaborate(self, platform):
        m = Module()
        bus = self.bus
        read = Signal(reset_less=True)                              # a command is on the bus
        address = Signal(ADDRESS_BITS, reset_less=True)             # its address
        words = Signal(range(self.max_burst + 1), reset_less=True)  # its words
        due = Signal(range(self.limit + 1), reset_less=True)        # words that the memory owes
        some = Signal(reset_less=True)                              # due != 0
        stale = Signal(init=1)      # what comes was asked for before the reset
        accepted = read & ~bus.waitrequest
        # Before the first reset of all the memory may say anything.
        came = bus.readdatavalid & some
        m.d.comb += [
            bus.read.eq(read), bus.address.eq(address), bus.burstcount.eq(words),
            self.valid.eq(came & ~stale), self.word.eq(bus.readdata),
            self.i.ready.eq(~stale & (~read | accepted)),
        ]
        # One addition: words less one are had early.
        m.d.sync += due.eq(due + Mux(accepted, words - came, 0 - came))
        with m.If(accepted):
            m.d.sync += some.eq(1)
        with m.Elif(came):
            m.d.sync += some.eq(due != 1)
        with m.If(self._nothing_due(read, due)):
            m.d.sync += stale.eq(0)
        with m.If(~read | accepted):
            m.d.sync += [read.eq(self.i.valid & self.i.ready), address.eq(self.i.p.address),
                         words.eq(self.i.p.words)]
        with m.If(self.memory_rst):
            m.d.sync += [read.eq(0), due.eq(0), some.eq(0), stale.eq(1)]
        return m

    @staticmethod
    def _nothing_due(read, due):
        """Whether the memory owes nothing, and no command stands on the bus.

        A method of its own only so that proofs and tests can break it.
        """
        return ~read & (due == 0)
