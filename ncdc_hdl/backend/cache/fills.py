"""Fetches claimed tiles from memory, in order, straight into their slots."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost
from ncdc_hdl.avalon.read_commands import ReadCommands
from ncdc_hdl.backend.cache.layouts import slot_bits, tile_layout
from ncdc_hdl.backend.cache.requests import TileRequests
from ncdc_hdl.backend.cache.tiles import fill_layout
from ncdc_hdl.frontend.layouts import SIZE
from ncdc_model.fetch.cache_options import TILE_HEIGHT, TILE_WIDTH

__all__ = ["Fills"]


class Fills(wiring.Component):
    """Reads each claimed tile, a burst per row, and writes it where it was promised a place.

    The credit for a tile is taken when it is claimed and comes back when its last word is
    written, so both queues always have room, and data from the memory always has a place.

    Timing: the first command of a tile reaches the bus 5 clocks after its claim at the earliest;
    a word is written 1 clock after its ``readdatavalid``, ``filled`` follows the last one's write
    by 1 clock.

    Parameters
    ----------
    options : CacheOptions
    data_width : int
        Bits of a memory word.
    word_bytes : int
        Bytes of a word of the tile memory.

    Members
    -------
    base, pitch : ``In``
        Of the raw frame in bytes, constant during a frame.
    claim, tile : ``In(1)``, ``In(tile_layout(options))``
        A tile is to be read; only while ``credit``.
    credit : ``Out(1)``
    fill : ``Out(fill_layout(...))``
        To the tile memory.
    filled : ``Out(1)``
        The oldest tile is complete.
    bus : ``Out(ReadHost(...))``
    """

    def __init__(self, options, data_width, word_bytes):
        self.options, self.data_width, self.word_bytes = options, data_width, word_bytes
        self.burst = 8 * TILE_WIDTH // data_width
        super().__init__({
            "base": In(ADDRESS_BITS), "pitch": In(SIZE),
            "claim": In(1), "tile": In(tile_layout(options)), "credit": Out(1),
            "fill": Out(fill_layout(options, word_bytes)), "filled": Out(1),
            "bus": Out(ReadHost(data_width, self.burst)),
        })

    def elaborate(self, platform):
        m = Module()
        most = self.options.outstanding
        # A queue of two would refuse the second of two writes in a row.
        depth = max(most, 3)
        m.submodules.claimed = claimed = SyncFIFOBuffered(width=tile_layout(self.options).size,
                                                          depth=depth)
        m.submodules.slots = slots = SyncFIFOBuffered(width=slot_bits(self.options), depth=depth)
        m.submodules.requests = requests = TileRequests(self.options)
        m.submodules.commands = commands = ReadCommands(
            self.data_width, self.burst, limit=most * TILE_HEIGHT * self.burst)
        wiring.connect(m, commands.bus, wiring.flipped(self.bus))
        m.d.comb += [
            claimed.w_data.eq(Value.cast(self.tile)), claimed.w_en.eq(self.claim),
            slots.w_data.eq(self.tile.slot), slots.w_en.eq(self.claim),
            requests.base.eq(self.base), requests.pitch.eq(self.pitch),
            Value.cast(requests.i.payload).eq(claimed.r_data),
            requests.i.valid.eq(claimed.r_rdy), claimed.r_en.eq(requests.i.ready),
            commands.i.p.address.eq(requests.o.payload), commands.i.p.words.eq(self.burst),
            commands.i.valid.eq(requests.o.valid), requests.o.ready.eq(commands.i.ready),
        ]
        outstanding = Signal(range(most + 1))
        complete = Signal()
        m.d.comb += self.credit.eq(self._credit(outstanding, most))
        m.d.sync += outstanding.eq(outstanding + self.claim - complete)
        self._write(m, commands, slots, complete)
        return m

    @staticmethod
    def _credit(outstanding, most):
        """Whether one more tile may be claimed."""
        return outstanding != most

    def _write(self, m, commands, slots, complete):
        """Words from the memory to words of the tile memory, and where they go."""
        beats = TILE_HEIGHT * self.burst
        beat = Signal(range(beats))
        with m.If(commands.valid):
            m.d.sync += beat.eq(beat + 1)
        m.d.comb += [complete.eq(commands.valid & (beat == beats - 1)), slots.r_en.eq(complete)]
        m.d.sync += self.filled.eq(complete)

        fill, width = self.fill, 8 * self.word_bytes
        m.d.sync += [fill.slot.eq(slots.r_data), fill.row.eq(beat >> ceil_log2(self.burst))]
        # Words of the tile memory along a row alternate between two banks.
        if self.data_width == 2 * width:
            word = beat[:ceil_log2(self.burst)]
            m.d.sync += [fill.enable.eq(commands.valid.replicate(2)), fill.word.eq(word),
                         fill.data[0].eq(commands.word[:width]),
                         fill.data[1].eq(commands.word[width:])]
        else:
            parts = width // self.data_width
            part_bits = ceil_log2(parts)
            word = beat[part_bits:ceil_log2(self.burst)]
            gathered = commands.word
            if parts > 1:
                before = Signal(width - self.data_width)
                with m.If(commands.valid):
                    m.d.sync += before.eq(Cat(before, commands.word)[self.data_width:])
                gathered = Cat(before, commands.word)
            last = beat[:part_bits] == parts - 1
            m.d.sync += [fill.enable.eq(Mux(commands.valid & last, 1 << word[0], 0)),
                         fill.word.eq(word[1:]),
                         fill.data[0].eq(gathered), fill.data[1].eq(gathered)]
