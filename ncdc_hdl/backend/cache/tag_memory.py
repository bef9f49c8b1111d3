"""The tag memory: the tile in each slot of the cache, and the look-up that used it last."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.layouts import (
    PAIR_X_BITS,
    bank_tile,
    pair_y_bits,
    set_bits,
    tiles_layout,
)
from ncdc_hdl.lib.memory import block_memory

__all__ = ["TagMemory", "entry_layout"]

_PARTS = 2      # parts of a comparison of two tags, each of few bits


def entry_layout(options):
    """An entry of the tag memory: whether it is valid, the pairs of its tile, its last user.

    The other coordinate bits of the tile are the bank that the entry is in. ``last_use`` is the
    number, as in ``Pending``, of the last look-up that touched the entry, valid or not.
    """
    return data.StructLayout({
        "valid": 1,
        "pair_x": PAIR_X_BITS,
        "pair_y": pair_y_bits(options),
        "last_use": options.sequence_bits,
    })


class TagMemory(wiring.Component):
    """Banks of entries, one entry per set; each look-up reads one of each bank.

    The entries of a look-up leave the memory while it is in stage R, reach registers near the
    logic while it is in stage L, and are compared with its tiles while it is in stage C. The result
    is there in stage D. A look-up in stage A writes all entries that it touches when it leaves.
    A write while an entry moves from the memory to stage D does not reach it. Then
    the earlier look-ups decide, see ``Forwarding``.

    Timing: ``last_use`` follows ``entering`` after 3 shifts, ``missing`` after 4; ``missing``
    follows ``known`` and ``hit`` after 1.

    Parameters
    ----------
    options : CacheOptions

    Members
    -------
    shift : ``In(1)``
        All look-ups move on by one stage in this clock, and the one in stage A leaves.
    entering : ``In(tiles_layout(options))``
        Tiles of the look-up that enters stage R with the next shift.
    compared : ``In(tiles_layout(options))``
        Tiles of the look-up in stage C.
    known, hit : ``In(tag_banks)``
        For the look-up in stage C, as in ``Forwarding``.
    leaving : ``In(tiles_layout(options))``
        Tiles of the look-up in stage A; ``need`` is zero if there is none.
    number : ``In(sequence_bits)``
        The number of the look-up in stage A.
    push : ``In(1)``
        A look-up leaves stage A in this clock.
    clearing, clear_set : ``In(1)``, ``In``
        The entries of this set are to be made invalid in this clock, as in ``Clearing``.
    last_use : ``Out(ArrayLayout(sequence_bits, tag_banks))``
        The last user of each entry of the look-up in stage C.
    missing : ``Out(tag_banks)``
        Whether each tile of the look-up in stage D is to be claimed; none that it does not
        need, and none if there is no look-up.
    """

    def __init__(self, options):
        self.options = options
        super().__init__({
            "shift": In(1),
            "entering": In(tiles_layout(options)),
            "compared": In(tiles_layout(options)),
            "known": In(options.tag_banks),
            "hit": In(options.tag_banks),
            "leaving": In(tiles_layout(options)),
            "number": In(options.sequence_bits),
            "push": In(1),
            "clearing": In(1),
            "clear_set": In(set_bits(options)),
            "last_use": Out(data.ArrayLayout(options.sequence_bits, options.tag_banks)),
            "missing": Out(options.tag_banks),
        })

    def elaborate(self, platform):
        m = Module()
        # The number of the last look-up that was passed on. Clearing writes it to all entries, so
        # that no tile replaces one that this look-up or an earlier one still has to read.
        written = Signal(self.options.sequence_bits)
        with m.If(self.push):
            m.d.sync += written.eq(self.number)
        for bank in range(self.options.tag_banks):
            read = self._memory(m, bank, written)
            self._compare(m, bank, read.data)
        return m

    def _memory(self, m, bank, written):
        """Add the entries of one bank, and return the port that reads them.

        A look-up that enters in the clock of a write to its entry reads an undefined word, but
        gets the entry's content from the look-up that writes.
        """
        m.submodules[f"entries{bank}"] = memory = block_memory(entry_layout(self.options),
                                                               self.options.sets)
        read, write = memory.read_port(), memory.write_port()
        leaving = bank_tile(self.leaving, bank)
        m.d.comb += [
            read.addr.eq(bank_tile(self.entering, bank).set),
            read.en.eq(self.shift),
            write.en.eq(self.clearing | (self.push & self.leaving.need[bank])),
            write.addr.eq(Mux(self.clearing, self.clear_set, leaving.set)),
            write.data.valid.eq(~self.clearing),
            write.data.pair_x.eq(leaving.pair_x),
            write.data.pair_y.eq(leaving.pair_y),
            write.data.last_use.eq(Mux(self.clearing, written, self.number)),
        ]
        return read

    def _compare(self, m, bank, r_entry):
        """Compare the entry of one bank with the tile that the look-up needs of it."""
        # L, C: the entry of the look-up in this stage.
        l_entry = Signal(entry_layout(self.options), name=f"l_entry{bank}", reset_less=True)
        c_entry = Signal(entry_layout(self.options), name=f"c_entry{bank}", reset_less=True)
        # D: whether each part of the entry's tag is that of the tile sought, or need not
        # be. Without a look-up, as after a reset, nothing is missing.
        d_same = Signal(_PARTS, name=f"d_same{bank}", init=-1)
        sought = bank_tile(self.compared, bank)
        pairs = zip(_parts(Cat(c_entry.pair_x, c_entry.pair_y, c_entry.valid)),
                    _parts(Cat(sought.pair_x, sought.pair_y, Const(1, 1))))
        with m.If(self.shift):
            m.d.sync += [
                l_entry.eq(r_entry),
                c_entry.eq(l_entry),
                d_same.eq(Cat(Mux(self.known[bank], self.hit[bank], held == wanted)
                              for held, wanted in pairs)),
            ]
        m.d.comb += [self.last_use[bank].eq(c_entry.last_use),
                     self.missing[bank].eq(~d_same.all())]


def _parts(bits):
    """``bits`` cut into ``_PARTS`` of nearly the same length."""
    length = -(-len(bits) // _PARTS)
    return [bits[at:at + length] for at in range(0, len(bits), length)]
