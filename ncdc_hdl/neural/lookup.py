"""A table of constants in logic instead of block RAM."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.lib.pipeline import delay, register

__all__ = ["Lookup"]

_ENTRIES = 6        # log2 of the entries of a six-input LUT
_CHOICES = 2        # log2 of the inputs of a multiplexer in a six-input LUT
_BLOCKS = 1         # log2 of the blocks that share an index; more would share too much logic


class Lookup(wiring.Component):
    """``o`` = ``table[i]``, for a table that would use block RAMs badly.

    Entries are in blocks of 64, each of which looks up one. Then a block of each pair is chosen,
    and the pair, among four in each clock. Pairs get ``i`` one after the other, a clock apart, so
    that no register drives the whole table. Bits in which all entries of a block agree cost
    nothing.
    Timing: free-running, one value per clock, ``latency`` clocks.

    Parameters
    ----------
    table : sequence of int
        Filled with zeros to a power of two, at least 64.
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
        self.groups = 1 << max(0, bits - _ENTRIES - _BLOCKS)
        super().__init__({"i": In(bits), "o": Out(width)})

    @property
    def latency(self):
        """Clocks: a block, choice of a pair's, pairs before the last one, choices among them."""
        bits = len(self.i) - _ENTRIES
        return 1 + (bits > 0) + (self.groups - 1) - (_BLOCKS - max(bits, _BLOCKS)) // _CHOICES

    def elaborate(self, platform):
        m = Module()
        size = len(self.table) // self.groups
        results = []
        for group in range(self.groups):
            index = delay(m, self.i[:_ENTRIES + _BLOCKS], group, f"i{group}")
            result = self._group(m, group, index, self.table[group * size:(group + 1) * size])
            results.append(delay(m, result, self.groups - 1 - group, f"result{group}"))
        chosen = delay(m, self.i[_ENTRIES + _BLOCKS:], self.groups + 1, "group")
        m.d.comb += self.o.eq(self._choose(m, "result", results, chosen))
        return m

    def _group(self, m, group, index, entries):
        """One of the blocks of ``entries``, two clocks later; a clock if there is only one."""
        size = 1 << _ENTRIES
        blocks = [register(m, f"block{group}_{start}", self._block(entries[start:start + size],
                                                                   index[:_ENTRIES]))
                  for start in range(0, len(entries), size)]
        return self._choose(m, f"choice{group}", blocks, delay(m, index[_ENTRIES:], 1,
                                                               f"chosen{group}"))

    @staticmethod
    def _choose(m, name, values, chosen):
        """``values[chosen]``, a clock later for each choice among four."""
        level, count = 0, 1 << _CHOICES
        while len(values) > 1:
            values = [register(m, f"{name}_{level}_{k}",
                               Array(values[k:k + count])[chosen[:_CHOICES]])
                      for k in range(0, len(values), count)]
            chosen = delay(m, chosen[_CHOICES:], 1, f"{name}_rest{level}")
            level += 1
        return values[0]

    def _block(self, entries, index):
        """One of ``entries``, bit by bit: as a memory it would become block RAM again."""
        columns = [sum((entry >> k & 1) << j for j, entry in enumerate(entries))
                   for k in range(self.width)]
        return Cat(Const(column, len(entries)).bit_select(index, 1) for column in columns)
