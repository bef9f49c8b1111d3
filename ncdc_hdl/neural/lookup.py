"""A table of constants in logic instead of block RAM."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.pipeline import delay, register

__all__ = ["Lookup"]

_ENTRIES = 6        # log2 of those that a table of six inputs holds, the usual one
_CHOICES = 2        # log2 of those among which one of six inputs can choose


class Lookup(wiring.Component):
    """``o`` = ``table[i]``, for a table that would fill block RAMs badly.

    Entries in blocks of 64, of each of which one is looked up; then the block is chosen, among
    four in each clock. Bits in which all entries of a block agree cost nothing.
    Timing: free-running, one value per clock, ``latency`` clocks.

    Parameters
    ----------
    table : sequence of int
        Filled up with zeros to a power of two, 64 at least.
    width : int
        Bits of an entry.

    Members
    -------
    i : ``In(ceil_log2(len(table)))``
    o : ``Out(width)``
    """

    def __init__(self, table, width):
        bits = max(_ENTRIES, ceil_log2(len(table)))
        self.table, self.width = [*table, *[0] * ((1 << bits) - len(table))], width
        super().__init__({"i": In(bits), "o": Out(width)})

    @property
    def latency(self):
        """Clocks: blocks, choices among them."""
        return 1 - (_ENTRIES - len(self.i)) // _CHOICES

    def elaborate(self, platform):
        m = Module()
        size = 1 << _ENTRIES
        chosen = self.i[_ENTRIES:]
        blocks = [register(m, f"block{start}", self._block(self.table[start:start + size]))
                  for start in range(0, len(self.table), size)]
        chosen = delay(m, chosen, 1, "chosen")
        level = 0
        while len(blocks) > 1:
            count = 1 << _CHOICES
            choice, chosen = chosen[:_CHOICES], delay(m, chosen[_CHOICES:], 1, f"chosen{level}")
            blocks = [register(m, f"choice{level}_{k}", Array(blocks[k:k + count])[choice])
                      for k in range(0, len(blocks), count)]
            level += 1
        m.d.comb += self.o.eq(blocks[0])
        return m

    def _block(self, entries):
        """One of ``entries``, each bit by itself: as a memory it would become block RAM again."""
        columns = [sum((entry >> k & 1) << j for j, entry in enumerate(entries))
                   for k in range(self.width)]
        return Cat(Const(column, len(entries)).bit_select(self.i[:_ENTRIES], 1)
                   for column in columns)
