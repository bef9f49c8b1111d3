"""Block RAM, and the queue that reads it through its output register."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

__all__ = ["Fifo", "block_memory"]


def block_memory(shape, depth, init=(), in_luts=False):
    """A memory of ``depth`` words of ``shape``; no word is used that is read when it is written.

    A word that is read in the clock of its write is undefined in block RAM. A user of this
    memory must not use such a word. Without this guarantee synthesis puts logic after the RAM
    to output the old word, and cannot use the RAM's output register. In simulation the old
    word is read. ``in_luts`` keeps it out of block RAM.
    """
    # The guarantee and the kind, as attributes of Yosys, of Vivado and of Quartus.
    kind = {"ram_style": "distributed"} if in_luts else {}
    return Memory(shape=shape, depth=depth, init=list(init), attrs={
        "no_rw_check": 1, "ramstyle": "MLAB, no_rw_check" if in_luts else "no_rw_check", **kind})


class Fifo(wiring.Component):
    """Queue in a memory that is read through two registers: its own output and one after it.

    Both belong to the RAM on common devices, so that an item leaves early in its clock.
    ``amaranth.lib.fifo.SyncFIFOBuffered`` has only the first, and the same members.

    Timing: an item can be taken at least ``latency`` clocks after it was written; one item
    per clock.

    Parameters
    ----------
    width : int
        Bits of an item.
    depth : int
        Items, at least 2.

    Members
    -------
    w_data, w_en, w_rdy : ``In(width)``, ``In(1)``, ``Out(1)``
        ``w_en`` writes an item; it must be low while ``w_rdy`` is, which is when the queue is full.
    r_data, r_rdy, r_en : ``Out(width)``, ``Out(1)``, ``In(1)``
        The oldest item, taken if both are high.
    level : ``Out(range(depth + 1))``
        Items in the queue, also those on the way to the output.

    Raises
    ------
    ValueError
        If ``depth`` is below 2.
    """

    latency = 3
    """Clocks from the write of an item to its appearance: the memory, its register, the output."""

    def __init__(self, *, width, depth):
        if depth < 2:
            raise ValueError(f"depth is {depth}, the limit is 2")
        self.width, self.depth = width, depth
        super().__init__({
            "w_data": In(width), "w_en": In(1), "w_rdy": Out(1),
            "r_data": Out(width), "r_rdy": Out(1), "r_en": In(1),
            "level": Out(range(depth + 1)),
        })

    @property
    def words(self):
        """Words of the memory, a power of two if possible: two items are in the registers whenever
        two are in the memory."""
        return min(self.depth, 1 << ceil_log2(max(2, self.depth - 2)))

    def elaborate(self, platform):
        m = Module()
        # A word is read at least a clock after its write, as block_memory requires.
        words = self.words
        m.submodules.storage = storage = block_memory(self.width, words)
        write, read = storage.write_port(), storage.read_port()
        produce = Signal(range(words))              # write address of the next item
        consume = Signal(range(words))              # read address of the next item
        stored = Signal(range(self.depth + 1))      # items in the memory that are not yet read
        some = Signal()                             # stored != 0
        read_valid = Signal()                       # an item is in the memory's own output register
        both = Signal()                             # also in the one after it
        oldest = Signal(self.width, reset_less=True)    # a RAM's register has no reset to share
        pop = Signal()                              # an item leaves the memory
        load = Signal()                             # the memory's output register may be loaded
        move = Signal()                             # the register after it may be loaded
        take = Signal()                             # the oldest item is taken
        m.d.comb += [
            self.r_data.eq(oldest),
            self.w_rdy.eq(self.level != self.depth),
            take.eq(self.r_rdy & self.r_en),
            write.addr.eq(produce),
            write.data.eq(self.w_data),
            write.en.eq(self.w_en),
            move.eq(~self.r_rdy | self.r_en),
            load.eq(~both | self.r_en),
            read.addr.eq(consume),
            read.en.eq(load),
            pop.eq(load & some),
        ]
        with m.If(self.w_en != pop):
            m.d.sync += [stored.eq(stored + Mux(self.w_en, 1, -1)),
                         some.eq(self.w_en | (stored != 1))]
        with m.If(self.w_en != take):
            m.d.sync += self.level.eq(self.level + Mux(self.w_en, 1, -1))
        for pointer, step in ((produce, self.w_en), (consume, pop)):
            with m.If(step):
                m.d.sync += pointer.eq(Mux(pointer == words - 1, 0, pointer + 1))
        m.d.sync += both.eq(~load | (some & (read_valid | ~move)))
        with m.If(load):
            m.d.sync += read_valid.eq(some)
        with m.If(move):
            m.d.sync += [self.r_rdy.eq(read_valid), oldest.eq(read.data)]
        return m
