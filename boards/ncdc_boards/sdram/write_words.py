"""Queue of words to be written."""

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
    """Collects bursts of a write host, and passes each on when its last word has come.

    So the memory never waits for a host in the middle of a burst. A reset of the host alone cancels
    nothing: the host continues its burst. A reset of this module drops all words.

    Timing: ``waitrequest`` is a register, high in the reset and in two clocks after each burst.

    Parameters
    ----------
    mapping : AddressMapping

    Members
    -------
    bus : ``In(WriteHost(mapping.data_width, mapping.max_burst))``
    o : ``Out(stream.Signature(mapping.burst))``
        A complete burst, in the clock in which its last word is accepted; ``ready``,
        a register, is high then, and until a burst is taken.
    take : ``In(1)``
        The oldest word is taken.
    word : ``Out(word_layout(mapping.data_width))``
        The word taken in the clock before.
    """

    def __init__(self, mapping):
        self.mapping = mapping
        # Two bursts, and two words that are accepted while waitrequest rises.
        self.depth = 2 * mapping.max_burst + 2
        super().__init__({
            "bus": In(WriteHost(mapping.data_width, mapping.max_burst)),
            "o": Out(stream.Signature(mapping.burst)),
            "take": In(1), "word": Out(word_layout(mapping.data_width)),
        })

    def elaborate(self, platform):
        m = Module()
        bus, mapping = self.bus, self.mapping
        words = Fifo(width=self.word.shape().size, depth=self.depth)
        m.submodules.words = words
        taken = Signal()                            # the oldest word was taken in the clock before
        waits = Signal(init=1)                      # waitrequest
        accepted = Signal()                         # a word is accepted
        left = Signal(mapping.words)                  # words of the burst to come
        begun = Signal(mapping.burst)                 # the burst
        first = Signal()                            # the word at the bus is its first
        now = Signal(mapping.burst)                   # the burst of the word at the bus
        skipped = exact_log2(mapping.data_width // 8)     # bits of a byte's position in a word
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
            # Space for a word of this clock and one of the next.
            waits.eq(self._full(words.level) | self.o.valid | ~self.o.ready),
        ]
        return m

    def _full(self, level):
        """Whether a word may lack space in the next clock.

        A method of its own only so that proofs and tests can break it.
        """
        return level > self.depth - 2
