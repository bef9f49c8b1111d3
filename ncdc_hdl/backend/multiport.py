"""The paper's fetcher: three burst readers, one per row of the window."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.avalon.burst_reader import BurstReader
from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost
from ncdc_hdl.avalon.read_fence import ReadFence
from ncdc_hdl.backend.layouts import request_layout, window_layout
from ncdc_hdl.frontend.layouts import SIZE
from ncdc_hdl.lib.credits import Credited
from ncdc_spec.interpolation import FAST

__all__ = ["Multiport"]

_MAX_BURST = 2  # most words that three bytes can be in


class Multiport(wiring.Component):
    """Three-port fetch of 3x3 windows with reuse, section III.C and Fig. 30 of the paper.

    Row r of a window is read by reader r in a burst of one or two words. A window at the same
    position as the one before it is not read again (Fig. 18). Byte (x, y) of the raw frame is at
    ``base + y pitch + x``. Windows leave in order; a blank request reads nothing.

    Timing: ``in_flight`` windows of two words, or twice as many of one, may be under way, which
    hides part of the memory's latency.

    Parameters
    ----------
    f_bits : int
        Fraction bits of the position in the window.
    data_width : int
        Bits of a memory word: 32, 64 or 128.
    in_flight : int
        Windows of two words for which each reader has space.

    Members
    -------
    base, limit, pitch : ``In``
        Byte address of the raw frame and of the end of its area, bytes from row to row;
        multiples of the word, constant during a frame. Nothing outside the area is read, see
        :class:`ReadFence`.
    height : ``In(SIZE)``
        Not used: no row below the frame is requested.
    memory_rst : ``In(1)``
        As in :class:`ncdc_hdl.avalon.read_commands.ReadCommands`.
    i : ``In(stream.Signature(request_layout(f_bits)))``
    o : ``Out(Credited(window_layout(f_bits)))``
        A window comes with its ``issue``.
    bus0, bus1, bus2 : ``Out(ReadHost(...))``
    outside, empty : ``Out(1)``
        A row of a window is requested that is outside the area; as in :class:`ReadFence`.
    fetched : ``Out(1)``
        High for one clock per window read from memory.
    waiting : ``Out(1)``
        The oldest window waits for the memory.
    """

    ports = FAST.window
    window_latency = 0
    """Clocks from ``o.issue`` to the window."""

    def __init__(self, f_bits, data_width, *, in_flight=4):
        self.f_bits, self.data_width, self.in_flight = f_bits, data_width, in_flight
        super().__init__({
            "base": In(ADDRESS_BITS), "limit": In(ADDRESS_BITS), "pitch": In(SIZE),
            "height": In(SIZE), "memory_rst": In(1), "outside": Out(1), "empty": Out(1),
            "i": In(stream.Signature(request_layout(f_bits))),
            "o": Out(Credited(window_layout(f_bits))),
            **{f"bus{r}": Out(ReadHost(data_width, _MAX_BURST)) for r in range(FAST.window)},
            "fetched": Out(1), "waiting": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        word_bytes = self.data_width // 8
        byte_bits = ceil_log2(word_bytes)

        readers, fences = [], []
        for r in range(FAST.window):
            reader = BurstReader(self.data_width, depth=_MAX_BURST * self.in_flight,
                                 max_burst=_MAX_BURST)
            m.submodules[f"reader{r}"] = reader
            wiring.connect(m, reader.bus, wiring.flipped(getattr(self, f"bus{r}")))
            m.d.comb += reader.memory_rst.eq(self.memory_rst)
            readers.append(reader)
            m.submodules[f"fence{r}"] = fence = ReadFence(self.data_width, _MAX_BURST)
            wiring.connect(m, fence.o, reader.i)
            m.d.comb += [fence.base.eq(self.base), fence.limit.eq(self.limit)]
            fences.append(fence)
        m.d.comb += [self.outside.eq(Cat(fence.moved for fence in fences).any()),
                     self.empty.eq(fences[0].empty)]

        token_layout = data.StructLayout({
            "fetch": 1, "two_words": 1, "offset": byte_bits,
            "odd_column": 1, "odd_row": 1, "fx": self.f_bits, "fy": self.f_bits,
            "blank": 1, "first": 1, "last": 1})
        m.submodules.tokens = tokens = SyncFIFOBuffered(width=token_layout.size,
                                                        depth=4 * self.in_flight)
        self._ask(m, fences, tokens, token_layout, byte_bits)
        self._answer(m, readers, tokens, token_layout)
        return m

    def _ask(self, m, fences, tokens, token_layout, byte_bits):
        """Requests to commands for the readers, and a token for each request, in order."""
        request = self.i.p
        # A: the offset of the row is known, and whether the window is that of the last one.
        a_valid = Signal()                  # there is a request in this stage
        a = Signal(request.shape())         # the request
        a_offset = Signal(ADDRESS_BITS)     # offset of its first row in the raw frame, in bytes
        a_reuse = Signal()                  # its window has the position of the last one
        # The position of the last window that was not blank, if there was one in this frame.
        last = Signal(data.StructLayout({"x0": len(request.x0), "y0": len(request.y0),
                                         "known": 1}))
        sent = Signal(FAST.window + 1)          # readers and tokens that have taken the request
        taken = Signal(FAST.window + 1)          # those that have at the end of this clock
        fetch = ~a.blank & ~a_reuse
        first_byte = Signal(ADDRESS_BITS)   # address of the window's first byte
        end = Signal(byte_bits + 1)         # the last byte, counted from the first byte's word
        token = Signal(token_layout)        # state for the window's answer
        m.d.comb += [
            first_byte.eq(self.base + a_offset + a.x0),
            end.eq(a.x0[:byte_bits] + FAST.window - 1),
            token.fetch.eq(fetch), token.two_words.eq(end[byte_bits]),
            token.offset.eq(a.x0), token.odd_column.eq(a.x0[0]), token.odd_row.eq(a.y0[0]),
            *(token[name].eq(a[name]) for name in ("fx", "fy", "blank", "first", "last")),
            tokens.w_data.eq(token),
            tokens.w_en.eq(a_valid & ~sent[FAST.window]),
            taken[FAST.window].eq(sent[FAST.window] | tokens.w_rdy),
        ]
        for r, fence in enumerate(fences):
            address = first_byte + (0, self.pitch, self.pitch << 1)[r]
            m.d.comb += [
                fence.i.p.address.eq(address), fence.i.p.words.eq(1 + token.two_words),
                fence.i.valid.eq(a_valid & fetch & ~sent[r]),
                taken[r].eq(sent[r] | ~fetch | fence.i.ready),
            ]
        done = Signal()
        m.d.comb += [done.eq(a_valid & taken.all()), self.fetched.eq(done & fetch)]
        with m.If(a_valid):
            m.d.sync += sent.eq(Mux(done, 0, taken))
        with m.If(done | ~a_valid):
            m.d.comb += self.i.ready.eq(1)
            same = last.known & (last.x0 == request.x0) & (last.y0 == request.y0)
            m.d.sync += [
                a_valid.eq(self.i.valid), a.eq(request), a_offset.eq(request.y0 * self.pitch),
                a_reuse.eq(same & ~request.first),
            ]
            with m.If(self.i.valid & ~request.blank):
                m.d.sync += [last.x0.eq(request.x0), last.y0.eq(request.y0), last.known.eq(1)]
            with m.Elif(self.i.valid & request.first):
                # Another frame: the window's samples are from the old one.
                m.d.sync += last.known.eq(0)

    def _answer(self, m, readers, tokens, token_layout):
        """Words of the readers to windows, in the tokens' order."""
        token = data.View(token_layout, tokens.r_data)
        offset = Signal(len(token.offset))      # offset of the window in the readers' words
        here = Signal(len(token.offset))        # offset of the window that is answered
        space = Signal(init=1)                  # there is space for the window
        m.d.sync += space.eq(self.o.space)
        answered = Signal()                     # the words of the oldest token are there
        complete = []
        for r, reader in enumerate(readers):
            words = Signal(2 * self.data_width, name=f"words{r}")       # the words received
            count = Signal(range(_MAX_BURST + 1), name=f"count{r}")     # their number
            needed = 1 + token.two_words
            m.d.comb += reader.o.ready.eq(tokens.r_rdy & token.fetch & (count != needed))
            with m.If(reader.o.valid & reader.o.ready):
                m.d.sync += [words.word_select(count[0], self.data_width).eq(reader.o.payload),
                             count.eq(count + 1)]
            with m.If(self.o.valid):
                m.d.sync += count.eq(0)
            complete.append(count == needed)
            row = (words >> (here << 3))[:8 * FAST.window]
            m.d.comb += [self.o.payload.samples[FAST.window * r + k].eq(row.word_select(k, 8))
                         for k in range(FAST.window)]
        m.d.comb += [
            here.eq(Mux(token.fetch, token.offset, offset)),
            answered.eq(~token.fetch | Cat(complete).all()),
            self.o.valid.eq(tokens.r_rdy & answered & space), self.o.issue.eq(self.o.valid),
            tokens.r_en.eq(self.o.valid),
            self.waiting.eq(tokens.r_rdy & ~answered),
            *(self.o.payload[name].eq(token[name]) for name in
              ("odd_column", "odd_row", "fx", "fy", "blank", "first", "last")),
        ]
        with m.If(self.o.valid & token.fetch):
            m.d.sync += offset.eq(token.offset)
