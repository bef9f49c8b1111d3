"""From look-ups whose tiles have arrived to windows."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.cache.align import align_for
from ncdc_hdl.backend.cache.layouts import lanes_layout, window_position_layout
from ncdc_hdl.backend.cache.tiles import Tiles, box_layout, samples_layout
from ncdc_hdl.backend.layouts import edges, window_layout
from ncdc_hdl.lib.credits import Credited
from ncdc_hdl.lib.groups import lanes_of
from ncdc_hdl.lib.memory import Fifo
from ncdc_hdl.lib.pipeline import register

__all__ = ["Retire"]


class Retire(wiring.Component):
    """Queue of pending look-ups, which read their samples once their claimed tiles have arrived.

    Tiles arrive in the order in which they were claimed, so counting them is enough. The oldest
    look-up leaves the queue when as many tiles have arrived, beyond those of the look-ups before
    it, as it claimed itself. Tiles claimed by earlier look-ups have arrived before.

    A group of several lanes waits in a queue of its own, from before its boxes are made until the
    last of them reads its samples. So no stage between holds its lanes.

    Timing: ``latency`` clocks from the queue's end to ``o``, one look-up per clock. A look-up
    leaves the queue only if its window has space; the stages after it run free.

    Parameters
    ----------
    f_bits, options, lanes
        As in :class:`ncdc_hdl.backend.cache.cache.Cache`.
    banks : Banks
        Of the tile memory.
    before : int
        Groups, at most, that have entered and whose last look-up is not pushed yet.
    shared : bool
        Whether the tile memory cannot be read in the clock after ``written``.

    Members
    -------
    enters, group : ``In(1)``, ``In(lanes_layout(f_bits, options, lanes))``
        A group has entered, and its lanes, no later than its first ``push`` (only with several
        lanes).
    push, position, missing : ``In``
        From the tag stage: a look-up is passed on, its position, and the tiles claimed for it.
    filled : ``In(1)``
        A tile has arrived.
    retire : ``Out(1)``
        The oldest look-up reads its samples in this clock: its tiles may be replaced.
    waiting : ``Out(1)``
        The oldest look-up waits for a tile.
    written : ``In(1)``
        Words are written into the tile memory in the clock after this one (only if ``shared``).
    odd_rows : ``In(1)``
        As of :class:`Tiles`, for windows with a margin.
    load, box, samples :
        As in :class:`Tiles`: the look-up at the queue's end becomes the oldest one.
    o : ``Out(Credited(window_layout(f_bits, lanes, ...)))``
    """

    push_to_retire = 1 + Fifo.latency + 1 + 1
    """Clocks from ``push`` to ``retire``: a register, the queue, the oldest look-up, B."""
    filled_to_retire = 1 + 1
    """Clocks from ``filled`` to ``retire`` of the look-up that waits for it: the balance, B."""

    def __init__(self, f_bits, options, banks, lanes=1, before=0, shared=False):
        self.f_bits, self.options = f_bits, options
        self.banks, self.lanes, self.before, self.shared = banks, lanes, before, shared
        self.position_shape = window_position_layout(f_bits, options, lanes)
        self.lanes_shape = lanes_layout(f_bits, options, lanes)
        # Of a look-up whose tiles have arrived.
        self.window_shape = data.StructLayout(
            self.position_shape.members | {"lane": self.lanes_shape})
        self.aligns = [align_for(banks.columns, options.interpolation) for _ in range(lanes)]
        super().__init__({
            "push": In(1),
            "position": In(self.position_shape),
            "missing": In(options.tag_banks),
            "filled": In(1),
            "retire": Out(1),
            "waiting": Out(1),
            "load": Out(1),
            "box": Out(box_layout(options, banks)),
            "samples": In(samples_layout(banks.columns, options.interpolation)),
            "o": Out(Credited(window_layout(f_bits, lanes, options.interpolation))),
        } | ({"enters": In(1), "group": In(self.lanes_shape)} if lanes > 1 else {})
            | ({"odd_rows": In(1)} if options.interpolation.margin else {})
            | ({"written": In(1)} if shared else {}))

    @property
    def retire_to_window(self):
        """Clocks from ``retire``, which is B, to the window at ``o``: M and S, the alignment."""
        return Tiles.latency - 2 + self.aligns[0].latency

    @property
    def latency(self):
        """Clocks from the oldest look-up, with ``o.issue``, to its window at ``o``."""
        return 1 + self.retire_to_window

    def elaborate(self, platform):
        m = Module()
        space = Signal(init=1)          # there is space for the oldest look-up's window
        enough = Signal()               # all tiles of the oldest look-up have arrived
        oldest_valid = Signal()         # there is an oldest look-up
        oldest = Signal(self.position_shape, reset_less=True)
        pop = Signal()                  # the oldest look-up goes on to the stages
        load = Signal()                 # the look-up at the queue's end becomes the oldest
        able = enough & space & ~self.written if self.shared else enough & space
        m.d.comb += [
            load.eq(~oldest_valid | able),
            pop.eq(oldest_valid & able),
            # The look-ups of a group have one window: the last one announces it.
            self.o.issue.eq(pop & (oldest.end if self.lanes > 1 else 1)),
            self.waiting.eq(oldest_valid & ~enough),
        ]
        m.d.sync += space.eq(self.o.space)
        following_valid, following, following_owed = self._queue(m, load)
        with m.If(load):
            m.d.sync += [oldest_valid.eq(following_valid), oldest.eq(following)]
        self._count(m, load & following_valid, following_owed, enough)
        stages = self._stages(m, pop, oldest)
        (b_valid, _), *_ = stages
        word, row = self._corner(following)
        m.d.comb += [
            self.retire.eq(b_valid), self.load.eq(load),
            self.box.set.eq(following.set), self.box.next_set.eq(following.next_set),
            self.box.odd_tile.eq(following.odd_tile),
            self.box.word.eq(word), self.box.row.eq(row),
        ]
        (_, in_m), *_ = stages[1:]
        self._windows(m, in_m, *stages[-2:])
        return m

    def _queue(self, m, load):
        """Queue look-ups in order; return (valid, position, ``owed``) of the one at the end.

        ``owed`` is the negated number of tiles that a look-up claimed: it is added to the balance.
        """
        push = Signal()                 # a look-up came in the clock before
        position = Signal(self.position_shape, reset_less=True)
        owed = Signal(range(-self.options.tag_banks, 1))
        following = Signal(self.position_shape)            # the position of the look-up at the end
        following_owed = Signal(owed.shape())           # its ``owed``
        m.submodules.queue = queue = Fifo(width=self.position_shape.size + len(owed),
                                          depth=self.options.pending)
        m.d.sync += [push.eq(self.push), position.eq(self.position), owed.eq(_owed(self.missing))]
        m.d.comb += [
            queue.w_data.eq(Cat(position, owed)), queue.w_en.eq(push), queue.r_en.eq(load),
            Cat(following, following_owed).eq(queue.r_data),
        ]
        return queue.r_rdy, following, following_owed

    def _groups(self, m, leaves):
        """Queue the lanes of groups; return those of the group whose look-up is in B.

        ``leaves``: its last look-up is.
        """
        # In the queue of look-ups, before it, the oldest one and the one in B.
        m.submodules.groups = groups = Fifo(width=self.lanes_shape.size,
                                            depth=self.options.pending + self.before + 2)
        m.d.comb += [
            groups.w_en.eq(register(m, "entered", self.enters, reset_less=False)),
            groups.w_data.eq(register(m, "entered_group", Value.cast(self.group))),
            groups.r_en.eq(leaves),
        ]
        return data.View(self.lanes_shape, groups.r_data)

    def _count(self, m, comes, owed, enough):
        """Count tiles that arrive, less those that the look-ups up to the oldest one claimed.

        ``comes``: a look-up with ``-owed`` claimed tiles becomes the oldest in this clock.
        """
        # Below 0 while the oldest look-up has to wait. The magnitude is at most the tiles of all
        # pending look-ups.
        limit = self.options.tag_banks * self.options.pending
        balance = Signal(signed(ceil_log2(limit + 1) + 1))
        m.d.comb += enough.eq(self._enough(balance))
        with m.If(comes):
            # A tile that arrives is a carry input: there is one adder after the queue.
            m.d.sync += balance.eq((Cat(1, balance) + Cat(self.filled, owed).as_signed())[1:])
        with m.Else():
            m.d.sync += balance.eq(balance + self.filled)

    def _stages(self, m, pop, oldest):
        """Registers of the stages after the oldest look-up, each (valid, position).

        B: the tile memory has the box's address, and the group's lanes leave their queue, which so
        waits for no balance. M: its banks output their words. S: they are samples. W, and as many
        more as the alignment has: each window is cut out of them; with the last stage of the
        alignment it is in the output.
        """
        stages, before = [], (pop, oldest)
        cuts = self.aligns[0].latency - 1
        for name in (*"bms", *(f"w{k}" if k else "w" for k in range(cuts))):
            valid, position = (register(m, f"{name}_valid", before[0], reset_less=False),
                               register(m, name, before[1]))
            stages.append((valid, position))
            before = stages[-1] if name != "b" else (valid, self._with_lanes(m, valid, position))
        return stages

    def _with_lanes(self, m, valid, position):
        """The state of the look-up in B, with its lanes."""
        if self.lanes == 1:
            return position
        window = Signal(self.window_shape)
        lanes = self._groups(m, valid & position.end)
        m.d.comb += [*(window[name].eq(position[name]) for name in self.position_shape.members),
                     window.lane.eq(lanes)]
        return window

    def _windows(self, m, ahead, before, end):
        """Cut the windows out of the samples.

        The position ``ahead`` is in the stage before theirs; ``before`` and ``end``, each (valid,
        position), are the last two stages.
        """
        several, o, (w_valid, w) = self.lanes > 1, self.o.payload, end
        # A group that took several look-ups is gathered in the output: it leaves with the last.
        m.d.sync += [self.o.valid.eq(w_valid & (w.end if several else 1)),
                     o.first.eq(w.first), o.last.eq(w.last)]
        odd_rows = self.odd_rows if self.options.interpolation.margin else None
        for k, out in enumerate(lanes_of(o)):
            # Known a clock early, as each one moves a few hundred flip-flops. Two of them, of which
            # synthesis does not make one: only one has a reset.
            take = Cat(register(m, f"take{k}{half}", before[0] & before[1].mask[k],
                                reset_less=bool(half))
                       for half in range(2)) if several else Const(3, 2)
            m.submodules[f"align{k}"] = align = self.aligns[k]
            m.d.comb += [
                align.take.eq(take), align.samples.eq(self.samples),
                align.x.eq(ahead.lane[k].x), align.y.eq(ahead.lane[k].y), out.samples.eq(align.o),
                *(getattr(align, edge).eq(ahead.lane[k][edge])
                  for edge in edges(self.options.interpolation)),
            ]
            if self.options.interpolation.margin:
                # From lane to lane, so that none of these registers has to reach them all.
                odd_rows = register(m, f"odd_rows{k}", odd_rows)
            with m.If(take[0]):
                m.d.sync += [
                    out.fx.eq(w.lane[k].fx), out.fy.eq(w.lane[k].fy),
                    out.blank.eq(w.lane[k].blank)]
                if self.options.interpolation.margin:
                    m.d.sync += [out.flipped.x.eq(w.lane[k].x),
                                 out.flipped.y.eq(w.lane[k].y[0] ^ odd_rows)]
                else:
                    m.d.sync += [out.odd_column.eq(w.lane[k].x), out.odd_row.eq(w.lane[k].y)]
            if self.options.interpolation.margin:
                m.d.comb += align.odd_rows.eq(odd_rows)

    @staticmethod
    def _enough(balance):
        """Whether all tiles of the oldest look-up have arrived.

        A method of its own only so that proofs and tests can break the count.
        """
        return balance >= 0

    def _corner(self, position):
        """Word and row of a look-up's first tile in which its box begins."""
        if "word" in self.position_shape.members:
            return position.word[-len(self.box.word):], position.row
        lane = position.lane[0]
        return lane.x[ceil_log2(self.banks.word_bytes):], lane.y


def _owed(missing):
    """The negated number of bits that are set, of four or eight, by tables instead of adders."""
    ones = [Array(Const(n.bit_count(), 3) for n in range(16))[missing[k:k + 4]]
            for k in range(0, len(missing), 4)]
    counts = range(1 << 3 * len(ones))
    return Array(Const(-(n % 8 + n // 8), 5) for n in counts)[Cat(ones)].as_signed()
