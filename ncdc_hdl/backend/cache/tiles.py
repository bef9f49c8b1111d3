"""The tile memory: samples in banks, any window of them per clock."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2, exact_log2

from ncdc_hdl.backend.cache.layouts import row_bits, set_bits, slot_bits
from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.lib.pipeline import register
from ncdc_spec.cache_options import TILE_MEMORIES, TILE_WIDTH

__all__ = ["Tiles", "box_layout", "fill_layout", "samples_layout"]


def _words(banks):
    """Words of one tile row that are in the same bank."""
    return TILE_WIDTH // banks.columns


def fill_layout(options, banks):
    """Words to write into ``row`` of the tile in ``slot``.

    ``data`` and ``enable`` have an element for each of the banks side by side; ``word`` counts the
    words of one bank along the row.
    """
    return data.StructLayout({
        "enable": banks.across, "slot": slot_bits(options), "row": range(options.tile_height),
        "word": ceil_log2(_words(banks)),
        "data": data.ArrayLayout(8 * banks.word_bytes, banks.across)})


def box_layout(options, banks):
    """Start of a box.

    ``set`` is the set of its first tile, ``odd_tile`` that tile's column modulo 2 and row modulo R.
    ``next_set`` is the set of the next tiles to the right and below. ``row`` and ``word`` are
    those in the first tile.
    """
    return data.StructLayout({
        "set": set_bits(options), "next_set": set_bits(options),
        "odd_tile": data.StructLayout({"x": 1, "y": row_bits(options)}),
        "row": range(options.tile_height), "word": ceil_log2(TILE_WIDTH // banks.word_bytes)})


def samples_layout(columns, interpolation):
    """The samples of a box, as the banks output them.

    Row r is the one of the box whose y is r modulo ``interpolation.box_rows``, or r ^ 1 with
    ``odd_rows``, see :class:`Tiles`. Byte k of a row is the sample whose x is k modulo
    ``columns``.
    """
    return data.ArrayLayout(data.ArrayLayout(8, columns), interpolation.box_rows)


class Tiles(wiring.Component):
    """Samples of all slots, in M x C banks by row modulo M and word modulo C.

    M is ``box_rows`` of the interpolation: 4 of the fast one, 8 of those with 6x6 windows. A
    box of M rows and C words has one word in each bank, in any tiles. So any window of at most M
    rows and ``(C - 1) word_bytes + 1`` columns is read in one clock. Word w of a row y of the
    frame is in bank (y mod M, w mod C) at the address ``s n + (w div C) mod n``. There are n = 16 /
    (C word_bytes) words per bank and row. s is the number of the tile's slot among those that
    have rows in that bank: all slots if a tile has M rows, else those whose tile's row has the
    same remainder.

    Timing: ``samples`` follow a box after 4 clocks: box, address, memory, samples. A word is in
    the memory 2 clocks after its ``fill``: no later than a box of it, taken in the clock of the
    ``fill``, is at the memory. Shared banks take no box's address in the clock of a ``fill``:
    ``samples`` 3 clocks later are of no box.

    Parameters
    ----------
    options : CacheOptions
    banks : Banks
        C, and the bytes of a word.
    memory : str
        One of :data:`ncdc_spec.cache_options.TILE_MEMORIES`. With "luts" the last C / 2 columns of
        banks, half of the memory, are made of LUTs instead of block RAM. With "shared" each of
        these columns is in the block RAM of one of the first C / 2. Each bank then has one port,
        to read or to write.

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
    samples : ``Out(samples_layout(banks.columns, options.interpolation))``
    """

    latency = 4

    def __init__(self, options, banks, memory=TILE_MEMORIES[0]):
        self.options, self.banks, self.memory = options, banks, memory
        super().__init__({
            "split": In(range(set_bits(options) + 1)),
            "fill": In(fill_layout(options, banks)),
            "load": In(1), "box": In(box_layout(options, banks)),
            "samples": Out(samples_layout(banks.columns, options.interpolation)),
        } | ({"odd_rows": In(1)} if options.interpolation.margin else {}))

    @property
    def shared(self):
        """Whether two banks share a block RAM."""
        return self.memory == "shared"

    def elaborate(self, platform):
        m = Module()
        box = self.box
        sets, words = set_bits(self.options), _words(self.banks)
        needs = self.options.interpolation
        # Bits of a tile's row that select the bank; the others are in the address.
        in_tile = ceil_log2(needs.tile_height)
        bank_bits = ceil_log2(needs.box_rows) - in_tile
        # Of the box that is read: its sets, the tile's row, whether each row of banks is in the
        # next M rows, not in the box's first M rows of the frame.
        first, following = Signal.like(box.set), Signal.like(box.next_set)
        odd_y = Signal.like(box.odd_tile.y)
        lower = Signal(needs.box_rows)
        begin = Cat(box.row, box.odd_tile.y[:bank_bits])    # row modulo M in which it begins
        odd_rows = self.odd_rows if needs.margin else Const(0)
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
        width, across = 8 * self.banks.word_bytes, self.banks.across
        ports = self._ports(m, (self.options.tiles >> bank_bits) * words)
        fill_addresses, fill_words, enables = self._fill(m, bank_bits, odd_rows)
        for column in range(across):
            word, in_next_tile, odd_x = self._column(m, column)
            second = column >= across // 2      # this column is in the second half of them
            for row in range(needs.box_rows):
                below = across > 2 and row >= needs.box_rows // 2
                fill_address = fill_addresses[below, second]
                write, read, base = ports[row, column]
                m.d.comb += [write.data.eq(fill_words[column]), write.en.eq(enables[column, row])]
                # A set has bits of the column, where the mask has ones, and bits of the row.
                chosen = Signal(sets, name=f"set{row}{column}")
                m.d.comb += chosen.eq(Cat(
                    Mux(Mux(is_x, in_next_tile, lower[row]), then, now)
                    for is_x, now, then in zip(mask_x, first, following)))
                wanted = Cat(word, chosen, odd_x)
                if bank_bits < len(odd_y):
                    wanted = Cat(wanted, odd_y[bank_bits:] ^ lower[row])
                wanted = ~wanted if second else wanted
                name = f"address{row}{column}"
                if self.shared:
                    # One register for both: the port has one address.
                    wanted = Mux(self.fill.enable.any(), fill_address, wanted)
                    address = Cat(register(m, name, wanted), base)
                    m.d.comb += [write.addr.eq(address), read.addr.eq(address)]
                else:
                    m.d.comb += [write.addr.eq(fill_address),
                                 read.addr.eq(register(m, name, wanted))]
                m.d.sync += Value.cast(samples[row]).word_select(column, width).eq(read.data)
        return m

    def _ports(self, m, depth):
        """By row and column, the ports of the banks of ``depth`` words, to write and to read, and
        what precedes the address.

        A tile is not read before it is complete, nor written before it has been read.
        """
        width, half, ports = 8 * self.banks.word_bytes, self.banks.across // 2, {}
        for row in range(self.options.interpolation.box_rows):
            for column in range(half if self.shared else self.banks.across):
                m.submodules[f"bank{row}{column}"] = memory = block_memory(
                    width, depth << self.shared,
                    in_luts=self.memory == "luts" and column >= half)
                for bank in range(1 + self.shared):
                    ports[row, column + bank * half] = (
                        memory.write_port(), memory.read_port(), Const(bank, self.shared))
        return ports

    def _fill(self, m, bank_bits, odd_rows):
        """Addresses by half of the rows and half of the columns, and words by column, of what is
        written; by column and row whether it is.

        All are registers, half-way from the memory's port to the banks, which may be far apart;
        but the addresses of shared banks are not, as each has a register there. The rows have two
        halves only if there are more than two columns. Synthesis would make one register of
        several that are equal. So of the second half of the columns the address is the complement,
        and of that of the rows it has a reset. Columns may be written together: whether they are
        has a reset in the first half of them. A word written in a reset is in no tile after it.
        """
        fill, sets = self.fill, set_bits(self.options)
        column_of_tile, row_of_tile = fill.slot[:sets + 1], fill.slot[sets + 1:]
        bank = Cat(fill.row ^ odd_rows, row_of_tile[:bank_bits])
        address = Cat(fill.word, column_of_tile, row_of_tile[bank_bits:])
        addresses = {
            (below, second): value if self.shared else register(
                m, f"fill_address{below}{second}", value, reset_less=not below)
            for below in range(1 + (self.banks.across > 2))
            for second, value in enumerate((address, ~address))}
        columns = range(self.banks.across)
        words = [register(m, f"fill_word{column}", fill.data[column]) for column in columns]
        enables = {(column, row): register(
            m, f"enable{row}{column}", fill.enable[column] & (bank == row),
            reset_less=column >= self.banks.across // 2)
            for column in columns for row in range(self.options.interpolation.box_rows)}
        return addresses, words, enables

    def _column(self, m, column):
        """Of the box that is read, for the banks of a column: their word's number, among those of
        the bank, in its tile, whether that is the next tile to the right, and that tile's column
        modulo 2."""
        box, bank_bits = self.box, exact_log2(self.banks.across)
        word = Signal(len(box.word) - bank_bits, name=f"word{column}", reset_less=True)
        in_next_tile = Signal(name=f"next{column}", reset_less=True)
        odd_x = Signal(name=f"odd_x{column}", reset_less=True)
        # This bank's word is one of the first words of the box, one for each column of banks.
        words_on = (box.word + (column - box.word)[:bank_bits])[:len(box.word) + 1]
        with m.If(self.load):
            m.d.sync += [Cat(word, in_next_tile).eq(words_on[bank_bits:]),
                         odd_x.eq(box.odd_tile.x ^ words_on[-1])]
        return word, in_next_tile, odd_x
