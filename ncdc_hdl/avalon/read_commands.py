"""Read commands, and the words due for them, which only a reset of the memory clears."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost

__all__ = ["ReadCommands", "command_layout"]


def command_layout(max_burst):
    """A read: byte address, a multiple of the word, and 1..max_burst words."""
    return data.StructLayout({"address": ADDRESS_BITS, "words": range(max_burst + 1)})


class ReadCommands(wiring.Component):
    """Sends the commands of a read host and passes on the words that come back.

    A reset cannot cancel requests to the memory, so their state here is not
    reset. A command stays on the bus until it is accepted, and words requested before the reset
    are dropped when they come. No new command is given before the last of them has come.

    A memory in reset owes no words: ``memory_rst`` clears that state. While it is high
    no command is on the bus except in its first clock, and words that come are dropped. It also
    drops words for the parent, so it comes with the parent's reset, some clocks earlier or later.

    Timing: a command reaches the bus 1 clock after it is taken; commands follow each other without
    a gap. A word is passed on in the clock of its ``readdatavalid``.

    Parameters
    ----------
    data_width, max_burst : int
        Bits of a word; most words of one command.
    limit : int
        Most words requested and not yet received; the parent observes this limit.

    Members
    -------
    i : ``In(stream.Signature(command_layout(max_burst)))``
    memory_rst : ``In(1)``
        The memory drops all requests accepted up to and including this clock.
    valid, word : ``Out(1)``, ``Out(data_width)``
        A word has come; there is no back-pressure.
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
        stale = Signal(init=1)      # words that come were requested before the reset
        accepted = read & ~bus.waitrequest
        # Before the first reset the memory's outputs are undefined.
        came = bus.readdatavalid & some
        m.d.comb += [
            bus.read.eq(read), bus.address.eq(address), bus.burstcount.eq(words),
            self.valid.eq(came & ~stale), self.word.eq(bus.readdata),
            self.i.ready.eq(~stale & (~read | accepted)),
        ]
        # One addition: the number of words less one is known early.
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
        """Whether no word is due from the memory, and no command is on the bus.

        A method of its own only so that proofs and tests can break it.
        """
        return ~read & (due == 0)
