"""From look-ups whose tiles have arrived to windows."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.cache.align import Align
from ncdc_hdl.backend.cache.layouts import window_place_layout
from ncdc_hdl.backend.cache.tiles import Tiles, box_layout, samples_layout
from ncdc_hdl.backend.layouts import window_layout
from ncdc_hdl.lib.groups import lanes_of
from ncdc_hdl.lib.memory import Fifo
from ncdc_hdl.lib.relay import Relay
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
    shift, box, samples :
        To the tile memory, as of :class:`Tiles`.
    o : ``Out(stream.Signature(window_layout(f_bits, lanes)))``
    """

    push_to_retire = 1 + Fifo.latency + 1 + 1
    """Clocks from ``push`` to ``retire``: a register, the queue, the oldest look-up, B."""
    filled_to_retire = 1 + 1
    """Clocks from ``filled`` to ``retire`` of the look-up that waits for it: the balance, B."""
    retire_to_window = Tiles.latency - 1 + Align.latency + Relay.latency
    """Clocks from ``retire``, which is B, to the window at ``o``: M and S, W and O, the relay."""
    latency = 1 + retire_to_window

    def __init__(self, f_bits, options, word_bytes, lanes=1):
        self.f_bits, self.options = f_bits, options
        self.word_bytes, self.lanes = word_bytes, lanes
        self.place_shape = window_place_layout(f_bits, options, lanes)
        super().__init__({
            "push": In(1), "place": In(self.place_shape), "misses": In(range(TAG_BANKS + 1)),
            "filled": In(1), "retire": Out(1), "waiting": Out(1),
            "shift": Out(1), "box": Out(box_layout(options, word_bytes)),
            "samples": In(samples_layout(word_bytes)),
            "o": Out(stream.Signature(window_layout(f_bits, lanes))),
        })

    def elaborate(self, platform):
        m = Module()
        push = Signal()
        place = Signal(self.place_shape, reset_less=True)
        # Of the tiles that a look-up claimed, the negated number: it is added to the balance.
        owed, following_owed = (Signal(signed(len(self.misses) + 1), name=name)
                                for name in ("owed", "following_owed"))
        m.d.sync += [push.eq(self.push), place.eq(self.place), owed.eq(-self.misses)]
        m.submodules.queue = queue = Fifo(width=self.place_shape.size + len(owed),
                                          depth=self.options.pending)
        oldest_valid = Signal()
        oldest = Signal(self.place_shape, reset_less=True)
        following = Signal(self.place_shape)
        # Arrived tiles less those that the oldest look-up and all before it claimed: below 0 as
        # long as it has to wait. At most those of all pending look-ups and of the one in the act
        # stage.
        balance = Signal(signed(ceil_log2(TAG_BANKS * (self.options.pending + 1) + 1) + 1))
        # All stages move if the windows behind them do; what follows is not asked.
        m.submodules.windows = windows = Relay(self.o.payload.shape())
        wiring.connect(m, windows.o, wiring.flipped(self.o))
        shift, pop, load, enough = Signal(), Signal(), Signal(), Signal()
        m.d.comb += [
            queue.w_data.eq(Cat(place, owed)), queue.w_en.eq(push),
            Cat(following, following_owed).eq(queue.r_data),
            load.eq(~oldest_valid | (enough & shift)), queue.r_en.eq(load),
            shift.eq(windows.i.ready), self.shift.eq(shift),
            enough.eq(self._enough(balance)),
            pop.eq(oldest_valid & enough & shift), self.waiting.eq(oldest_valid & ~enough),
        ]
        with m.If(load):
            m.d.sync += [oldest_valid.eq(queue.r_rdy), oldest.eq(following)]
        with m.If(load & queue.r_rdy):
            # A tile that arrives goes in as a carry: there is one adder behind the queue.
            m.d.sync += balance.eq((Cat(1, balance) + Cat(self.filled, following_owed).as_signed()
                                    )[1:])
        with m.Else():
            m.d.sync += balance.eq(balance + self.filled)

        # B: the box's address. M: the memory's output. S: samples. W: words. O: window.
        stages = [(Signal(name=f"{name}_valid"),
                   Signal(self.place_shape, name=name, reset_less=True)) for name in "bmsw"]
        before = (pop, oldest)
        for stage in stages:
            with m.If(shift):
                m.d.sync += [stage[0].eq(before[0]), stage[1].eq(before[1])]
            before = stage
        (b_valid, _), _, (_, s), (w_valid, w) = stages
        word, row = self._corner(oldest)
        m.d.comb += [
            self.retire.eq(b_valid & shift),
            self.box.set.eq(oldest.set), self.box.next_set.eq(oldest.next_set),
            self.box.odd_tile.eq(oldest.odd_tile),
            self.box.word.eq(word), self.box.row.eq(row),
        ]
        with m.If(shift):
            m.d.sync += [windows.i.valid.eq(w_valid & (w.end if self.lanes > 1 else 1)),
                         windows.i.p.first.eq(w.first), windows.i.p.last.eq(w.last)]
        for k, out in enumerate(lanes_of(windows.i.p)):
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
    def _enough(balance):
        """Whether all tiles of the oldest look-up have arrived."""
        return balance >= 0

    def _corner(self, place):
        """Word and row of a look-up's first tile in which its box begins."""
        if self.lanes > 1:
            return place.word, place.row
        lane = place.lane[0]
        return lane.x[ceil_log2(self.word_bytes):], lane.y
