"""Claims the tiles that look-ups miss, after the stages that found them missing."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.layouts import row_bits, tile_layout, tiles_layout
from ncdc_hdl.lib.choice import chosen
from ncdc_hdl.lib.relay import Relay

__all__ = ["Claims"]


class Claims(wiring.Component):
    """Claims the missing tiles of each look-up, one per clock by ascending bank.

    A tile is claimed in each clock in which there is a missing tile and credit. Three look-ups are
    under way here at most: one whose tiles are claimed, and two that wait, see :class:`Relay`.

    Timing: ``latency`` clocks from a look-up to its first claim; no clock is lost between two
    look-ups. ``claim`` follows ``credit`` at once.

    Parameters
    ----------
    options : CacheOptions

    Members
    -------
    i : ``In(stream.Signature(tiles_layout(options)))``
        The tiles of a look-up; ``need`` marks the missing ones, at least one.
    credit : ``In(1)``
        A tile may be claimed.
    claim, tile : ``Out(1)``, ``Out(tile_layout(options))``
        A tile is claimed in this clock.
    waiting : ``Out(1)``
        There is a tile to claim, and no credit.
    """

    latency = Relay.latency + 1
    """Clocks from a look-up to its first claim: the relay, ``left``."""

    def __init__(self, options):
        self.options = options
        self.relay = Relay(tiles_layout(options))
        super().__init__({
            "i": In(stream.Signature(tiles_layout(options))),
            "credit": In(1),
            "claim": Out(1),
            "tile": Out(tile_layout(options)),
            "waiting": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        m.submodules.relay = relay = self.relay
        wiring.connect(m, wiring.flipped(self.i), relay.i)
        # A look-up; ``need`` marks its tiles to be claimed after the next one.
        left = Signal(self.i.payload.shape(), reset_less=True)
        bank = Signal(self.options.tag_banks)   # the bit of the next one
        done = Signal(init=1)                   # there is none
        final = Signal()                        # it is the last one
        m.d.comb += [
            self.claim.eq(~done & self.credit),
            self.waiting.eq(~done & ~self.credit),
            relay.o.ready.eq(done | (final & self.credit)),
        ]
        with m.If(relay.o.valid & relay.o.ready):
            m.d.sync += [left.eq(relay.o.p), done.eq(0), final.eq(_is_one(relay.o.p.need)),
                         *self._take(relay.o.p.need, bank, left.need)]
        with m.Elif(self.claim):
            m.d.sync += [done.eq(final), final.eq(_is_one(left.need)),
                         *self._take(left.need, bank, left.need)]
        self._tile(m, left, bank)
        return m

    @staticmethod
    def _take(need, bank, others):
        """Assignments of the lowest bit of ``need``, alone, and of the other ones."""
        below = [need[:k].any() for k in range(len(need))]
        return [bank.eq(Cat(bit & ~lower for bit, lower in zip(need, below))),
                others.eq(Cat(bit & lower for bit, lower in zip(need, below)))]

    def _tile(self, m, left, bank):
        """The tile of the look-up ``left`` in ``bank``, and its slot."""
        # The number of the bank; its lowest bit is the column's.
        px, *rows = (Cat(bit for k, bit in enumerate(bank) if k >> n & 1).any()
                     for n in range(1 + row_bits(self.options)))
        py = Cat(rows)
        chosen_set = Mux(px, left.set_x[1], left.set_x[0]) | chosen(left.set_y, rows)
        m.d.comb += [
            self.tile.x.eq(Cat(px, Mux(px, left.pair_x[1], left.pair_x[0]))),
            self.tile.y.eq(Cat(py, chosen(left.pair_y, rows))),
            self.tile.slot.eq(Cat(chosen_set, px, py)),
        ]


def _is_one(bits):
    """Whether exactly one bit is set."""
    parts = [(bit, Const(0)) for bit in bits]
    while len(parts) > 1:
        parts = [(a | c, b | d | (a & c)) for (a, b), (c, d) in zip(parts[::2], parts[1::2])]
    [(one, two)] = parts
    return one & ~two
