"""From look-ups whose tiles have arrived to windows."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.cache.align import Align
from ncdc_hdl.backend.cache.layouts import window_place_layout
from ncdc_hdl.backend.cache.tiles import Tiles, box_layout, samples_layout
from ncdc_hdl.backend.layouts import window_layout
from ncdc_hdl.frontend.layouts import lanes_of
from ncdc_model.fetch.cache_options import TAG_BANKS

__all__ = ["Retire"]


class Retire(wiring.Component):
    """Queue of pending look-ups; each reads its samples once the tiles it claimed have arrived.

    Tiles arrive in the order in which they were claimed, so it is enough to count them: the oldest
    look-up leaves the queue when as many tiles have arrived, and belong to nobody yet, as it
    claimed. What it did not claim was claimed before, hence arrived before.

    Timing: ``latency`` clocks from the queue's end to ``o``, one look-up per clock; all stages
    stall while ``o`` does.

    Parameters
    ----------
    f_bits, options, lanes
        As of :class:`ncdc_hdl.backend.cache.cache.Cache`.
    word_bytes : int
        Bytes of a word of the tile memory.

    Members
    -------
    push, place, misses : ``In``
        From the tag stage.
    filled : ``In(1)``
        A tile has arrived.
    retire : ``Out(1)``
        The oldest look-up reads its samples in this clock: its tiles may be replaced.
    waiting : ``Out(1)``
        The oldest look-up waits for a tile.
    shift, enable, box, samples :
        To the tile memory, as of :class:`Tiles`.
    o : ``Out(stream.Signature(window_layout(f_bits, lanes)))``
    """

    latency = 1 + Tiles.latency + Align.latency

    def __init__(self, f_bits, options, word_bytes, lanes=1):
        self.f_bits, self.options = f_bits, options
        self.word_bytes, self.lanes = word_bytes, lanes
        self.place_shape = window_place_layout(f_bits, options, lanes)
        super().__init__({
            "push": In(1), "place": In(self.place_shape), "misses": In(range(TAG_BANKS + 1)),
            "filled": In(1), "retire": Out(1), "waiting": Out(1),
            "shift": Out(1), "enable": Out(1), "box": Out(box_layout(options, word_bytes)),
            "samples": In(samples_layout(word_bytes)),
            "o": Out(stream.Signature(window_layout(f_bits, lanes))),
        })

    def elaborate(self, platform):
        m = Module()
        m.submodules.queue = queue = SyncFIFOBuffered(
            width=self.place_shape.size + len(self.misses), depth=self.options.pending)
        # The oldest in registers of its own: a memory's output comes late in its clock.
        oldest_valid = Signal()
        oldest = Signal(self.place_shape, reset_less=True)
        misses = Signal.like(self.misses, reset_less=True)
        # Arrived tiles that belong to nobody yet: at most those of all pending look-ups and of
        # the one in the act stage.
        tokens = Signal(range(TAG_BANKS * (self.options.pending + 1) + 1))
        shift, pop, load, enough = Signal(), Signal(), Signal(), Signal()
        m.d.comb += [
            queue.w_data.eq(Cat(self.place, self.misses)), queue.w_en.eq(self.push),
            load.eq(~oldest_valid | pop), queue.r_en.eq(load),
            shift.eq(~self.o.valid | self.o.ready), self.shift.eq(shift),
            enough.eq(self._enough(tokens, misses)),
            pop.eq(oldest_valid & enough & shift), self.waiting.eq(oldest_valid & ~enough),
        ]
        with m.If(load):
            m.d.sync += [oldest_valid.eq(queue.r_rdy), Cat(oldest, misses).eq(queue.r_data)]
        m.d.sync += tokens.eq(tokens + self.filled - Mux(pop, misses, 0))

        # B: the box's address. M: the memory's output. S: samples. W: words. O: window.
        stages = [(Signal(name=f"{name}_valid"),
                   Signal(self.place_shape, name=name, reset_less=True)) for name in "bmsw"]
        before = (pop, oldest)
        for stage in stages:
            with m.If(shift):
                m.d.sync += [stage[0].eq(before[0]), stage[1].eq(before[1])]
            before = stage
        (b_valid, b), _, (_, s), (w_valid, w) = stages
        word, row, used = self._corner(b)
        m.d.comb += [
            self.retire.eq(b_valid & shift), self.enable.eq(b_valid & used),
            self.box.set.eq(b.set), self.box.odd_tile.eq(b.odd_tile),
            self.box.word.eq(word), self.box.row.eq(row),
        ]
        with m.If(shift):
            m.d.sync += [self.o.valid.eq(w_valid & (w.end if self.lanes > 1 else 1)),
                         self.o.p.first.eq(w.first), self.o.p.last.eq(w.last)]
        for k, out in enumerate(lanes_of(self.o.p)):
            # A group that took several look-ups is gathered in the output.
            take = w_valid & w.mask[k] if self.lanes > 1 else w_valid
            m.submodules[f"align{k}"] = align = Align(self.word_bytes)
            m.d.comb += [
                align.shift.eq(shift), align.take.eq(take), align.samples.eq(self.samples),
                align.x.eq(s.lane[k].x), align.y.eq(s.lane[k].y), out.samples.eq(align.o),
            ]
            with m.If(shift & take):
                m.d.sync += [
                    out.odd_column.eq(w.lane[k].x), out.odd_row.eq(w.lane[k].y),
                    out.fx.eq(w.lane[k].fx), out.fy.eq(w.lane[k].fy),
                    out.blank.eq(w.lane[k].blank)]
        return m

    @staticmethod
    def _enough(tokens, misses):
        """Whether all tiles of the oldest look-up have arrived; without a carry through all bits."""
        low = len(misses)
        return tokens[low:].any() | (tokens[:low] >= misses)

    def _corner(self, place):
        """Word and row of a look-up's first tile in which its box begins; whether it has any."""
        if self.lanes > 1:
            return place.word, place.row, place.used
        lane = place.lane[0]
        return lane.x[ceil_log2(self.word_bytes):], lane.y, ~lane.blank
