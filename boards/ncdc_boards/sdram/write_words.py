"""Words to be written, kept until the memory takes them."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import WriteHost
from ncdc_hdl.lib.memory import Fifo

__all__ = ["WriteWords", "word_layout"]


def word_layout(data_width):
    """A word, and which of its bytes are written."""
    return data.StructLayout({"data": data_width, "enable": data_width // 8})


class WriteWords(wiring.Component):
    """Gathers bursts of a write host, and hands each on when its last word has come.

    So the memory never waits for a host in the middle of a burst. A reset of the host alone takes
    nothing back: it goes on with its burst. A reset of this forgets all.

    Timing: ``waitrequest`` is a register, high in the reset and in two clocks behind each burst.

    Parameters
    ----------
    place : Place

    Members
    -------
    bus : ``In(WriteHost(place.data_width, place.max_burst))``
    o : ``Out(stream.Signature(place.burst))``
        A complete burst, in the clock in which its last word is accepted; ``ready`` is high then,
        being a register that stays high until something is taken.
    take : ``In(1)``
        The oldest word is taken.
    word : ``Out(word_layout(place.data_width))``
        The word taken in the clock before.
    """

    def __init__(self, place):
        self.place = place
        # Two bursts, and two words that are accepted while waitrequest rises.
        self.depth = 2 * place.max_burst + 2
        super().__init__({
            "bus": In(WriteHost(place.data_width, place.max_burst)),
            "o": Out(stream.Signature(place.burst)),
            "take": In(1), "word": Out(word_layout(place.data_width)),
        })

    def elaborate(self, platform):
        m = Module()
        bus, place = self.bus, self.place
        words = Fifo(width=self.word.shape().size, depth=self.depth, checked=False)
        m.submodules.words = words
        taken = Signal()                            # the oldest one was taken in the clock before
        waits = Signal(init=1)                      # waitrequest
        accepted = Signal()                         # a word is
        left = Signal(place.words)                  # words of the burst to come
        begun = Signal(place.burst)                 # the burst
        first = Signal()                            # the word at the bus is its first
        now = Signal(place.burst)                   # the burst of the word at the bus
        skipped = exact_log2(place.data_width // 8)     # bits of a byte's place in a word
        m.d.comb += [
            bus.waitrequest.eq(waits), accepted.eq(bus.write & ~waits), first.eq(left == 0),
            words.w_en.eq(accepted), words.w_data.eq(Cat(bus.writedata, bus.byteenable)),
            words.r_en.eq(taken), self.word.eq(words.r_data),
            now.eq(begun), self.o.p.eq(now),
            self.o.valid.eq(accepted & (Mux(first, bus.burstcount, left) == 1)),
        ]
        with m.If(first):
            m.d.comb += [now.word.eq(bus.address[skipped:]), now.words.eq(bus.burstcount)]
        with m.If(accepted):
            m.d.sync += [begun.eq(now), left.eq(Mux(first, bus.burstcount, left) - 1)]
        m.d.sync += [
            taken.eq(self.take),
            # Room for a word of this clock and one of the next.
            waits.eq(self._full(words.level) | self.o.valid | ~self.o.ready),
        ]
        return m

    def _full(self, level):
        """Whether a word may lack room in the next clock.

        A method of its own only so that proofs and tests can break it.
        """
        return level > self.depth - 2
