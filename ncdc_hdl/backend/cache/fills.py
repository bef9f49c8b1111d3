"""Fetches claimed tiles from memory, in order, straight into their slots."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2, exact_log2

from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost
from ncdc_hdl.avalon.read_commands import ReadCommands
from ncdc_hdl.avalon.read_fence import ReadFence
from ncdc_hdl.backend.cache.layouts import slot_bits, tile_layout
from ncdc_hdl.backend.cache.raw_balance import RawBalance
from ncdc_hdl.backend.cache.requests import TileRequests
from ncdc_hdl.backend.cache.tiles import fill_layout
from ncdc_hdl.frontend.layouts import SIZE
from ncdc_hdl.lib.gains import BALANCE, NO_BALANCE
from ncdc_hdl.lib.memory import Fifo
from ncdc_hdl.lib.pipeline import delay
from ncdc_spec.cache_options import TILE_WIDTH

__all__ = ["Fills"]


class Fills(wiring.Component):
    """Reads each claimed tile, a burst per row, and writes it to its reserved slot.

    The credit for a tile is taken when it is claimed and comes back when its last word is
    written. So both queues always have space, and data from the memory always has a slot.

    Timing: the first command of a tile reaches the bus at least ``latency`` clocks after its
    claim. A word is written ``filled_latency`` clocks after its ``readdatavalid``, in the clock of
    ``filled`` if it is the last one.

    Parameters
    ----------
    options : CacheOptions
    data_width : int
        Bits of a memory word.
    banks : Banks
        Of the tile memory.
    raw_balance : bool
        Whether samples have gains on their way into the tile memory.

    Members
    -------
    base, limit, pitch, height : ``In``
        Byte address of the raw frame and of the end of its area, bytes from row to row, rows;
        constant during a frame. Nothing outside the area is read, see :class:`ReadFence`.
    balance : ``In(BALANCE)``
        Constant during a frame; only with ``raw_balance``.
    memory_rst : ``In(1)``
        As in :class:`ncdc_hdl.avalon.read_commands.ReadCommands`.
    claim, tile : ``In(1)``, ``In(tile_layout(options))``
        A tile is to be read; only while ``credit``.
    credit : ``Out(1)``
    fill : ``Out(fill_layout(...))``
        To the tile memory.
    filled : ``Out(1)``
        The oldest tile is complete.
    outside : ``Out(1)``
        A clock ago a row of the frame was requested that is outside the area.
    empty : ``Out(1)``
        As in :class:`ReadFence`.
    bus : ``Out(ReadHost(...))``
    """

    latency = 1 + Fifo.latency + TileRequests.latency + ReadFence.latency + ReadCommands.latency
    """Clocks from a claim to the tile's first command on the bus, a register before the rest."""

    def __init__(self, options, data_width, banks, raw_balance=False):
        self.options, self.data_width, self.banks = options, data_width, banks
        self.balanced = RawBalance(data_width) if raw_balance else None
        self.burst = 8 * TILE_WIDTH // data_width
        super().__init__({
            "base": In(ADDRESS_BITS), "limit": In(ADDRESS_BITS), "pitch": In(SIZE),
            "height": In(SIZE),
            **({"balance": In(BALANCE, init=NO_BALANCE)} if raw_balance else {}),
            "memory_rst": In(1), "outside": Out(1), "empty": Out(1),
            "claim": In(1), "tile": In(tile_layout(options)), "credit": Out(1, init=1),
            "fill": Out(fill_layout(options, banks)), "filled": Out(1),
            "bus": Out(ReadHost(data_width, self.burst)),
        })

    @property
    def filled_latency(self):
        """Clocks from a tile's last ``readdatavalid`` to ``filled``: gains if there are any, the
        word's register, its own."""
        return (self.balanced.latency if self.balanced else 0) + 2

    @property
    def credit_latency(self):
        """Clocks from a tile's last ``readdatavalid`` to ``credit``: the same."""
        return self.filled_latency

    def elaborate(self, platform):
        m = Module()
        limit = self.options.outstanding
        depth = max(limit, 2)
        # As many tiles as there is credit for are under way: neither queue can be full before.
        m.submodules.claimed = claimed = Fifo(width=tile_layout(self.options).size, depth=depth)
        m.submodules.slots = slots = Fifo(width=slot_bits(self.options), depth=depth)
        m.submodules.requests = requests = TileRequests(self.options)
        m.submodules.fence = fence = ReadFence(self.data_width, self.burst, shortest=self.burst)
        m.submodules.commands = commands = ReadCommands(
            self.data_width, self.burst, limit=limit * self.options.tile_height * self.burst)
        wiring.connect(m, commands.bus, wiring.flipped(self.bus))
        m.d.comb += commands.memory_rst.eq(self.memory_rst)
        claim = Signal()                                    # a tile was claimed a clock ago
        tile = Signal(self.tile.shape(), reset_less=True)   # that tile
        m.d.sync += [claim.eq(self.claim), tile.eq(self.tile)]
        m.d.comb += [
            claimed.w_data.eq(Value.cast(tile)), claimed.w_en.eq(claim),
            slots.w_data.eq(tile.slot), slots.w_en.eq(claim),
            requests.base.eq(self.base), requests.pitch.eq(self.pitch),
            Value.cast(requests.i.payload).eq(claimed.r_data),
            requests.i.valid.eq(claimed.r_rdy), claimed.r_en.eq(requests.i.ready),
            requests.height.eq(self.height),
            fence.base.eq(self.base), fence.limit.eq(self.limit), self.empty.eq(fence.empty),
            fence.i.p.address.eq(requests.o.payload), fence.i.p.words.eq(self.burst),
            fence.i.valid.eq(requests.o.valid), requests.o.ready.eq(fence.i.ready),
        ]
        m.d.sync += self.outside.eq(fence.moved & ~requests.beyond)
        wiring.connect(m, fence.o, commands.i)
        outstanding = Signal(range(limit + 1))   # tiles claimed and not yet complete
        complete = Signal()                     # the last word of a tile came a clock ago
        with m.If(self.claim != complete):
            m.d.sync += [outstanding.eq(Mux(complete, outstanding - 1, outstanding + 1)),
                         self.credit.eq(complete | self._credit(outstanding + 1, limit))]
        self._write(m, commands, slots, complete)
        return m

    @staticmethod
    def _credit(outstanding, limit):
        """Whether one more tile may be claimed.

        A method of its own only so that proofs and tests can break the count.
        """
        return outstanding != limit

    def _write(self, m, commands, slots, complete):
        """Words from the memory to words of the tile memory, with their addresses.

        A method of its own also so that a proof can take slots out of their queue too early.
        """
        beats = self.options.tile_height * self.burst
        coming = Signal(range(beats))   # the number of the next word among those of its tile
        valid, number, samples = self._samples(m, commands, coming)
        came = Signal()                                     # a word came in the clock before
        arrived = Signal(self.data_width, reset_less=True)  # that word
        beat = Signal(range(beats))                         # its number
        m.d.sync += [came.eq(valid), arrived.eq(samples)]
        with m.If(commands.valid):
            m.d.sync += coming.eq(coming + 1)
        m.d.sync += [beat.eq(number), complete.eq(valid & (number == beats - 1)),
                     self.filled.eq(complete)]
        m.d.comb += slots.r_en.eq(complete)

        fill, width = self.fill, 8 * self.banks.word_bytes
        parts = max(1, width // self.data_width)        # words from the memory in a word of a bank
        together = max(1, self.data_width // width)     # words of banks in a word from the memory
        groups = self.banks.across // together          # of banks that are written together
        part_bits, group_bits = exact_log2(parts), exact_log2(groups)
        word = beat[part_bits:ceil_log2(self.burst)]
        gathered = arrived
        if parts > 1:
            before = Signal(width - self.data_width)
            with m.If(came):
                m.d.sync += before.eq(Cat(before, arrived)[self.data_width:])
            gathered = Cat(before, arrived)
        last = came & (beat[:part_bits] == parts - 1)
        # Words along a row go to one group of banks after the other.
        m.d.sync += [
            fill.slot.eq(slots.r_data), fill.row.eq(beat >> ceil_log2(self.burst)),
            fill.enable.eq(Cat((last & (word[:group_bits] == group)).replicate(together)
                               for group in range(groups))),
            fill.word.eq(word[group_bits:]), Value.cast(fill.data).eq(gathered.replicate(groups))]

    def _samples(self, m, commands, coming):
        """(Whether a word comes, its number, its samples), after the gains if there are any."""
        valid, balanced = commands.valid, self.balanced
        if not balanced:
            return valid, coming, commands.word
        m.submodules.balanced = balanced
        # Tiles have an even number of rows: the word's row in its tile is odd if that in the frame.
        m.d.comb += [balanced.balance.eq(self.balance), balanced.i.eq(commands.word),
                     balanced.odd_row.eq(coming[ceil_log2(self.burst)])]
        return (delay(m, valid, balanced.latency, "valid", reset_less=False),
                delay(m, coming, balanced.latency, "coming"), balanced.o)
