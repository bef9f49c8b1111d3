"""An Avalon-MM write host's bursts as AXI4 bursts."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import ADDRESS_BITS, PENDING, WriteHost
from ncdc_hdl.axi.bus import PAGE_BITS, WritePort, burst_values

__all__ = ["WriteBridge"]


class WriteBridge(wiring.Component):
    """Makes one burst of each of the host's, or two if it would cross the end of a page.

    The host gets one answer to each of its bursts, with the last answer of AXI to it. It
    reports an error if one of them does. Address and first word are offered in the same clock, and
    no word waits for the acceptance of its address.

    A reset of the design cancels nothing; the host completes its burst. ``memory_rst`` is the
    bus's own reset: from the next clock on nothing is offered and nothing expected.

    Timing: a word is offered 1 clock after the host gives it, and words follow each other without a
    gap. An answer reaches the host in the clock in which it comes.

    Parameters
    ----------
    data_width, max_burst : int
        Bits of a word; most words of a burst.
    pending : int
        Most bursts offered or accepted and not yet answered.

    Members
    -------
    host : ``In(WriteHost(data_width, max_burst, pending))``
    memory_rst : ``In(1)``
    axi : ``Out(WritePort(data_width))``
    """

    latency = 1
    """Clocks from a word to the bus."""

    def __init__(self, data_width, max_burst, pending=PENDING):
        self.data_width, self.max_burst, self.pending = data_width, max_burst, pending
        super().__init__({
            "host": In(WriteHost(data_width, max_burst, pending)), "memory_rst": In(1),
            "axi": Out(WritePort(data_width)),
        })

    def elaborate(self, platform):
        m = Module()
        host, axi = self.host, self.axi
        named = Signal(reset_less=True)                     # an address is offered
        address = Signal(ADDRESS_BITS, reset_less=True)     # that address
        beats = Signal(8, reset_less=True)                  # its burst's words less one
        offered = Signal(reset_less=True)                   # a word is offered
        word = Signal(self.data_width, reset_less=True)     # that word
        enable = Signal(self.data_width // 8, reset_less=True)      # its bytes that count
        last = Signal(reset_less=True)                      # it is its burst's last
        left = Signal(range(self.max_burst + 1), reset_less=True)   # host's words to come
        piece = Signal(range(self.max_burst + 1), reset_less=True)  # those of this burst
        page = Signal(ADDRESS_BITS - PAGE_BITS, reset_less=True)    # page after its first word's
        words = Signal.like(piece)          # words left of this burst, with this clock's
        total = Signal.like(left)           # words left of the host's burst, likewise
        taken = Signal()                    # the host's word is taken
        opens = Signal()                    # it is a burst's first
        to_end = self._to_end(host.address)
        m.d.comb += [
            opens.eq(piece == 0), total.eq(Mux(left == 0, host.burstcount, left)),
            words.eq(Mux(~opens, piece, Mux((left == 0) & (total > to_end), to_end, total))),
        ]
        space = self._answers(m, taken & opens, words == total)
        m.d.comb += [
            host.waitrequest.eq((offered & ~axi.wready)
                                | opens & (named & ~axi.awready | ~space)),
            taken.eq(host.write & ~host.waitrequest),
            axi.awvalid.eq(named), axi.awaddr.eq(address), axi.awlen.eq(beats),
            *(getattr(axi, f"aw{name}").eq(value)
              for name, value in burst_values(self.data_width).items()),
            axi.wvalid.eq(offered), axi.wdata.eq(word), axi.wstrb.eq(enable), axi.wlast.eq(last),
        ]
        with m.If(axi.awready):
            m.d.sync += named.eq(0)
        with m.If(axi.wready):
            m.d.sync += offered.eq(0)
        with m.If(taken):
            m.d.sync += [offered.eq(1), word.eq(host.writedata), enable.eq(host.byteenable),
                         last.eq(words == 1), piece.eq(words - 1), left.eq(total - 1)]
            with m.If(left == 0):
                m.d.sync += page.eq(host.address[PAGE_BITS:] + 1)
            with m.If(opens):
                m.d.sync += [named.eq(1), beats.eq(words - 1),
                             address.eq(Mux(left == 0, host.address,
                                            Cat(Const(0, PAGE_BITS), page)))]
        with m.If(self.memory_rst):
            m.d.sync += [named.eq(0), offered.eq(0), left.eq(0), piece.eq(0)]
        return m

    def _answers(self, m, begun, whole):
        """Count due answers and pass them on; return whether one more burst may begin.

        ``begun``: a burst begins in this clock; ``whole``: with it the host's burst is complete.
        """
        host, axi = self.host, self.axi
        owed = Signal(range(self.pending + 1), reset_less=True)     # bursts counted by `pending`
        finals = Signal(self.pending, reset_less=True)  # those that end a host's, oldest lowest
        spoiled = Signal(reset_less=True)               # the one before in the same host's failed
        answered = axi.bvalid & (owed != 0)
        after = Signal.like(owed)                       # answers due after this clock
        m.d.comb += [
            axi.bready.eq(1), after.eq(owed - answered),
            host.writeresponsevalid.eq(answered & finals[0]),
            host.response.eq(Mux(spoiled, 0b10, axi.bresp)),
        ]
        m.d.sync += [owed.eq(after + begun),
                     finals.eq((finals >> answered) | Mux(begun & whole, 1 << after, 0))]
        with m.If(answered):
            m.d.sync += spoiled.eq(~finals[0] & (spoiled | axi.bresp[1]))
        with m.If(self.memory_rst):
            m.d.sync += [owed.eq(0), finals.eq(0), spoiled.eq(0)]
        return owed != self.pending

    def _to_end(self, address):
        """Words from ``address`` to the end of its page.

        A method of its own only so that proofs and tests can break it.
        """
        word_bits = exact_log2(self.data_width // 8)
        return (1 << (PAGE_BITS - word_bits)) - address[word_bits:PAGE_BITS]
