"""Keeps read commands inside an area of memory."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.avalon.read_commands import command_layout
from ncdc_hdl.lib.relay import Relay

__all__ = ["ReadFence"]


class ReadFence(wiring.Component):
    """Passes commands that read inside ``base`` .. ``limit`` - 1, and moves others to ``base``.

    A moved command returns as many words, so that no host waits for ever; they are not
    the words requested. For any ``i``, addresses at ``o`` are multiples of the word,
    and all words of a command are inside. The exception is an ``empty`` area: then no
    command may come.

    Timing: a command per clock, latency ``latency``. Whether it is inside is decided before a
    relay, and its address after it. Both in one clock would be too long, and ``o.ready`` would
    reach all earlier registers. A change of ``base`` or ``limit`` counts a clock later, and is
    allowed only while no command is under way.

    Parameters
    ----------
    data_width : int
        Bits of a word.
    max_burst, shortest : int
        Most and fewest words of one command.

    Members
    -------
    base, limit : ``In(32)``
        Byte address of the area, and of its end. Bits below the word are ignored.
    i, o : streams of ``command_layout(max_burst)``
    empty : ``Out(1)``
        The area is smaller than the longest command.
    moved : ``Out(1)``
        High in the clock in which a command is taken that will be moved.
    """

    latency = Relay.latency

    def __init__(self, data_width, max_burst, *, shortest=1):
        self.word_bits, self.sizes = exact_log2(data_width // 8), range(shortest, max_burst + 1)
        self.max_burst = max_burst
        super().__init__({
            "base": In(ADDRESS_BITS), "limit": In(ADDRESS_BITS),
            "i": In(stream.Signature(command_layout(max_burst))),
            "o": Out(stream.Signature(command_layout(max_burst))),
            "empty": Out(1), "moved": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        limit, number = self.limit[self.word_bits:], self.i.p.address[self.word_bits:]
        first = Signal.like(number)     # number of the area's first word
        # Number of the first word at which a command of this size no longer fits.
        ends = [Signal.like(number, name=f"end{words}") for words in self.sizes]
        m.d.sync += first.eq(self.base[self.word_bits:])
        for words, end in zip(self.sizes, ends):
            m.d.sync += end.eq(Mux(limit < words, 0, limit - (words - 1)))
        end = Signal.like(number)       # the same for the size of the command at ``i``
        m.d.comb += end.eq(ends[-1])
        for words, shorter in zip(self.sizes, ends[:-1]):
            with m.If(self.i.p.words == words):
                m.d.comb += end.eq(shorter)
        inside = self._inside(number, first, end)
        m.d.sync += self.empty.eq(first >= ends[-1])
        m.submodules.relay = relay = Relay(data.StructLayout({
            "command": command_layout(self.max_burst), "inside": 1}))
        m.d.comb += [
            relay.i.p.command.eq(self.i.p), relay.i.p.inside.eq(inside),
            relay.i.valid.eq(self.i.valid), self.i.ready.eq(relay.i.ready),
            self.moved.eq(self.i.valid & self.i.ready & ~inside),
            self.o.p.address.eq(Cat(Const(0, self.word_bits), Mux(
                relay.o.p.inside, relay.o.p.command.address[self.word_bits:], first))),
            self.o.p.words.eq(relay.o.p.command.words),
            self.o.valid.eq(relay.o.valid), relay.o.ready.eq(self.o.ready),
        ]
        return m

    @staticmethod
    def _inside(number, first, end):
        """Whether a command that begins at the word ``number`` is inside.

        A method of its own only so that proofs and tests can break it.
        """
        return (number >= first) & (number < end)
