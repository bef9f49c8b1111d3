"""The tile memory: samples in eight banks, any window of them per clock."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.cache.layouts import row_bits, set_bits, slot_bits
from ncdc_hdl.lib.memory import block_memory
from ncdc_spec.cache_options import TILE_WIDTH

__all__ = ["COLUMNS", "Tiles", "box_layout", "fill_layout", "samples_layout"]

COLUMNS = 2     # banks side by side


def _words(word_bytes):
    """Words of one tile row that are in the same bank; of two tiles' rows side by side if a word
    is a whole row."""
    return max(1, TILE_WIDTH // (COLUMNS * word_bytes))


def fill_layout(options, word_bytes):
    """Words to write into ``row`` of the tile in ``slot``.

    ``data`` and ``enable`` have an element for each of the banks side by side; ``word`` counts the
    words of one bank along the row. Words of 16 bytes, whole rows of a tile, are the same in both
    banks; the tile's column selects one.
    """
    return data.StructLayout({
        "enable": COLUMNS, "slot": slot_bits(options), "row": range(options.tile_height),
        "word": ceil_log2(_words(word_bytes)),
        "data": data.ArrayLayout(8 * word_bytes, COLUMNS)})


def box_layout(options, word_bytes):
    """Start of a box.

    ``set`` is the set of its first tile, ``odd_tile`` that tile's column modulo 2 and row modulo R.
    ``next_set`` is the set of the next tiles to the right and below. ``row`` and ``word``, of
    ``word_bytes`` bytes, are those in the first tile.
    """
    return data.StructLayout({
        "set": set_bits(options), "next_set": set_bits(options),
        "odd_tile": data.StructLayout({"x": 1, "y": row_bits(options)}),
        "row": range(options.tile_height), "word": ceil_log2(TILE_WIDTH // word_bytes)})


def samples_layout(word_bytes, interpolation):
    """The samples of a box, as the banks output them.

    Row r is the one of the box whose y is r modulo ``interpolation.box_rows``, or r ^ 1 with
    ``odd_rows``, see :class:`Tiles`. Byte k of a row is the sample whose x is k modulo
    ``2 word_bytes``.
    """
    return data.ArrayLayout(data.ArrayLayout(8, COLUMNS * word_bytes), interpolation.box_rows)


class Tiles(wiring.Component):
    """Samples of all slots, in M x 2 banks by row modulo M and word modulo 2.

    M is ``box_rows`` of the interpolation: 4 of the fast one, 8 of the gradient-corrected one. A
    box of M rows and two words of ``word_bytes`` bytes has one word in each bank, in any tiles.
    Any window of at most M rows and ``word_bytes + 1`` columns is read in one clock. Word
    w of a row y of the frame is in bank (y mod M, w mod 2) at the address ``s n + w / 2``, with n =
    16 / (2 word_bytes) words per bank and row, and s the number of the tile's slot among those that
    have rows in that bank: all slots if a tile has M rows, else those whose tile's row has the
    same remainder. Words of 16 bytes are whole rows: w is a tile's column, n is 1, and s counts
    only the slots of every second column.

    Timing: ``samples`` follow a box after 4 clocks: box, address, memory, samples.

    Parameters
    ----------
    options : CacheOptions
    word_bytes : int
        Bytes of a word, which a bank outputs per clock.
    lut_tiles : bool
        The second column of banks, half of the memory, is made of LUTs instead of block RAM.

    Members
    -------
    split : ``In``
        log2 Kx of the index rule, constant during a frame.
    odd_rows : ``In(1)``
        Whether odd rows are in the banks of even ones, and these in theirs: of the bank, y mod M is
        exclusive-ored with it. Constant during a frame, for windows with a margin.
    fill : ``In(fill_layout(...))``
    load, box : ``In(1)``, ``In(box_layout(...))``
        A box, taken while ``load`` is high; its samples are read in each clock until the next one.
    samples : ``Out(samples_layout(word_bytes))``
    """

    latency = 4

    def __init__(self, options, word_bytes, lut_tiles=False):
        self.options, self.word_bytes, self.lut_tiles = options, word_bytes, lut_tiles
        super().__init__({
            "split": In(range(set_bits(options) + 1)),
            "fill": In(fill_layout(options, word_bytes)),
            "load": In(1), "box": In(box_layout(options, word_bytes)),
            "samples": Out(samples_layout(word_bytes, options.interpolation)),
        } | ({"odd_rows": In(1)} if options.interpolation.margin else {}))

    def elaborate(self, platform):
        m = Module()
        fill, box = self.fill, self.box
        sets, words = set_bits(self.options), _words(self.word_bytes)
        needs = self.options.interpolation
        # Bits of a tile's row that select the bank; the others are in the address.
        in_tile = ceil_log2(needs.tile_height)
        bank_bits = ceil_log2(needs.box_rows) - in_tile
        # Whether a word is a whole row of a tile: then the bank is the tile's column modulo 2.
        whole = self.word_bytes == TILE_WIDTH
        fill_column, fill_row = fill.slot[:sets + (not whole)], fill.slot[sets + 1:]
        # Of the box that is read: its sets, the tile's row, whether each row of banks is in the
        # next M rows, not in the box's first M rows of the frame.
        first, following = Signal.like(box.set), Signal.like(box.next_set)
        odd_y = Signal.like(box.odd_tile.y)
        lower = Signal(needs.box_rows)
        begin = Cat(box.row, box.odd_tile.y[:bank_bits])    # row modulo M in which it begins
        odd_rows = self.odd_rows if needs.margin else Const(0)
        fill_bank = Cat(fill.row ^ odd_rows, fill_row[:bank_bits])
        # Of each row modulo M, whether the box begins after it.
        passed = [*(begin > row for row in range(needs.box_rows - 1)), Const(0)]
        with m.If(self.load):
            m.d.sync += [first.eq(box.set), following.eq(box.next_set), odd_y.eq(box.odd_tile.y),
                         lower.eq(Cat(Mux(odd_rows, passed[row ^ 1], passed[row])
                                      for row in range(needs.box_rows)))]
        mask_x = Signal(sets)
        m.d.sync += mask_x.eq((1 << self.split) - 1)
        # Without reset, so that they may be the memories' own output registers.
        samples = Signal.like(self.samples, name="read_samples", reset_less=True)
        m.d.comb += self.samples.eq(samples)
        for column in range(COLUMNS):
            word, in_next_tile, odd_x = self._column(m, column, whole)
            for row in range(needs.box_rows):
                bank = f"bank{row}{column}"
                # A tile is not read before it is complete, nor written before it has been read.
                m.submodules[bank] = memory = block_memory(
                    8 * self.word_bytes, (self.options.tiles >> bank_bits + whole) * words,
                    in_luts=self.lut_tiles and column == COLUMNS - 1)
                write, read = memory.write_port(), memory.read_port()
                m.d.comb += [
                    write.addr.eq(Cat(fill.word, fill_column, fill_row[bank_bits:])),
                    write.data.eq(fill.data[column]),
                    write.en.eq(fill.enable[column] & (fill_bank == row)
                                & ((fill.slot[sets] == column) if whole else 1)),
                ]
                address = Signal(len(read.addr), reset_less=True, name=f"address{row}{column}")
                # A set has bits of the column, where the mask has ones, and bits of the row.
                chosen = Signal(sets, name=f"set{row}{column}")
                m.d.comb += [
                    chosen.eq(Cat(
                        Mux(Mux(is_x, in_next_tile, lower[row]), then, now)
                        for is_x, now, then in zip(mask_x, first, following))),
                    read.addr.eq(address)]
                m.d.sync += [
                    address.eq(Cat(word[1:], chosen, odd_x, odd_y[bank_bits:] ^ lower[row])
                               if bank_bits < len(odd_y) else
                               Cat(word[1:], chosen, odd_x)),
                    Value.cast(samples[row])[
                        8 * self.word_bytes * column:][:8 * self.word_bytes].eq(read.data)]
        return m

    def _column(self, m, column, whole):
        """Of the box that is read, for the banks of a column: their word in its tile, whether that
        is the next tile to the right, and its column modulo 2 if that is in the address."""
        box = self.box
        word = Signal.like(box.word, name=f"word{column}", reset_less=True)
        in_next_tile = Signal(name=f"next{column}", reset_less=True)
        odd_x = Signal(0 if whole else 1, name=f"odd_x{column}", reset_less=True)
        # This bank's word is the box's first, or the one after it.
        begins_in = box.odd_tile.x if whole else box.word[0]
        words_on = (box.word + (begins_in != column))[:len(word) + 1]
        with m.If(self.load):
            m.d.sync += [Cat(word, in_next_tile).eq(words_on),
                         odd_x.eq(box.odd_tile.x ^ words_on[-1])]
        return word, in_next_tile, odd_x
