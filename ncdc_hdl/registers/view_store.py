"""The list of views: the host's set, the set in use, and the entry that a view loads."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2, exact_log2

from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.registers.register_map import ADDRESS_WORDS_BITS, VIEW_LIST
from ncdc_spec.view_list import ENTRY_WORDS, MAX_VIEWS

__all__ = ["ViewStore"]

_WORDS = len(ENTRY_WORDS)
_WORD_BITS = exact_log2(_WORDS)
_READ = 2               # clocks from an address to the memory's output register


class ViewStore(wiring.Component):
    """The registers of a list of views, in two banks of one memory.

    Views use one bank, the host reads and writes the other one. ``take`` exchanges them in one
    clock; then the bank in use is copied into the host's, word by word, so that both are equal
    again. After a reset both first get the values of configuration, which are in the same memory
    and never written. A load reads the bank in use while the other one is copied.

    Timing: ``read`` follows ``address`` after 2 clocks while ``held`` is high; ``mine`` after one.
    A write comes a clock after ``address`` and ``word`` or later. A copy takes a clock per word,
    the reset's two, an entry ``load_clocks``. Copies and loads wait while ``held`` is high. While
    ``busy`` is high no access may begin. ``take`` must not come during a copy.

    Parameters
    ----------
    rows : sequence of ncdc_spec.registers.register_map.Register
        Registers of the list: those of its entries, and those of the set that are entry 0.
    values : dict
        Values of entry 0 after configuration, by name; zero by default. All entries have them.
    views : int
        Entries.

    Members
    -------
    address, word : ``In(14)``, ``In(32)``
        Word address on the bus and the word to be written; constant during an access.
    held : ``In(1)``
        An access is under way.
    write : ``In(1)``
        ``word`` is written to ``address`` if that is ``mine``.
    mine, read : ``Out(1)``, ``Out(signed(32))``
        ``address`` is that of a row; content of the host's bank there, zero if it is not.
    take : ``In(1)``
    copying, busy : ``Out(1)``, ``Out(1)``
        The host's bank is not complete; nor may an access begin.
    load, entry : ``In(1)``, ``In(range(views))``
        Load this entry; both hold until ``loaded``.
    loads, position, value : ``Out(1)``, ``Out(range(16))``, ``Out(signed(32))``
        A word of the entry, and its number in ``ENTRY_WORDS``.
    loaded : ``Out(1)``
        All of them have come.
    """

    load_clocks = _WORDS + _READ + 1
    """Clocks of ``load``, that of ``loaded`` included."""

    def __init__(self, rows, values, views):
        self.rows, self.values, self.views = rows, values, views
        self.entry_bits = ceil_log2(views)
        self.words = _WORDS << self.entry_bits
        super().__init__({
            "address": In(ADDRESS_WORDS_BITS), "word": In(32), "held": In(1), "write": In(1),
            "mine": Out(1), "read": Out(signed(32)), "take": In(1),
            "copying": Out(1, init=1), "busy": Out(1),
            "load": In(1), "entry": In(range(views)), "loads": Out(1),
            "position": Out(range(_WORDS)), "value": Out(signed(32)), "loaded": Out(1)})

    def elaborate(self, platform):
        m = Module()
        # The banks, and the entry of configuration.
        contents = [0] * (2 * self.words) + [self.values.get(name, 0)
                                             for name in ENTRY_WORDS.values()]
        m.submodules.memory = memory = block_memory(signed(32), len(contents), contents)
        write, read = memory.write_port(), memory.read_port()
        index, value = self._decode(m)
        active = Signal()                           # the bank that views use
        host = Signal(init=1)                       # the one that an access uses, to its end
        count = Signal(range(self.words))           # number of the word that the copy reads
        configured = Signal()                       # the bank in use has the configuration
        copies = Signal()                           # the copy reads a word
        came = Signal(signed(32), reset_less=True)  # the word read
        reads, number = self._load(m, came, configured)
        m.d.comb += [copies.eq(self.copying & ~self.held & ~reads),
                     self.read.eq(Mux(self.mine, came, 0))]
        # The RAM's own output register, as in WeightStore.
        m.d.sync += came.eq(read.data)
        with m.If(self.held):
            m.d.comb += read.addr.eq(Cat(index, host))
        with m.Elif(reads):
            m.d.comb += read.addr.eq(Cat(number, self.entry, active))
        with m.Elif(configured):
            m.d.comb += read.addr.eq(Cat(count, active))
        with m.Else():
            m.d.comb += read.addr.eq(2 * self.words + count[:_WORD_BITS])
        with m.If(copies):
            m.d.sync += count.eq(count + 1)
            with m.If(count == self.words - 1):
                m.d.sync += [configured.eq(1), self.copying.eq(~configured)]
        with m.If(~self.held):
            m.d.sync += host.eq(~active)
        with m.If(self.take):
            m.d.sync += [active.eq(~active), self.copying.eq(1)]
        # The copy writes a word when it has come.
        coming = register(m, "coming", copies, reset_less=False)
        copied = register(m, "copied", coming, reset_less=False)
        target = delay(m, Cat(count, active ^ configured), _READ, "target")
        m.d.comb += [
            write.addr.eq(Mux(copied, target, Cat(index, host))),
            write.data.eq(Mux(copied, came, value)), write.en.eq(copied | self.write & self.mine),
            self.busy.eq(self.copying | coming | copied | self.load)]
        return m

    def _load(self, m, came, configured):
        """Give the words of an entry; return whether one is read, and its number."""
        number = Signal(_WORD_BITS + 1)             # its highest bit: all are read
        reads = Signal()
        m.d.comb += reads.eq(self.load & configured & ~self.held & ~number[-1])
        with m.If(~self.load):
            m.d.sync += number.eq(0)
        with m.Elif(reads):
            m.d.sync += number.eq(number + 1)
        m.d.comb += [
            self.loads.eq(delay(m, reads, _READ, "loads", reset_less=False)),
            self.position.eq(delay(m, number[:_WORD_BITS], _READ, "position")),
            self.value.eq(came),
            self.loaded.eq(self.load & delay(m, self.load & number[-1], _READ, "all_read",
                                             reset_less=False))]
        return reads, number[:_WORD_BITS]

    def _decode(self, m):
        """Set ``mine``, a clock later; return the number in the list of the word that is accessed,
        and ``word`` extended by the sign of its row, a clock later."""
        in_list = Signal()                          # the address is in the list, not in the set
        known = Signal()                            # it is that of a row
        position = Signal(_WORD_BITS)
        value = Signal(signed(32), reset_less=True)
        number = self.address[_WORD_BITS:_WORD_BITS + ceil_log2(MAX_VIEWS)]
        m.d.comb += in_list.eq(self.address >> _WORD_BITS + len(number)
                               == VIEW_LIST // (_WORDS * MAX_VIEWS))
        with m.If(in_list):
            m.d.comb += [position.eq(self.address), known.eq(number < self.views)]
        with m.Else():
            with m.Switch(self.address):
                for k, name in enumerate(ENTRY_WORDS.values()):
                    for row in self.rows:
                        if row.name == name:
                            with m.Case(row.address):
                                m.d.comb += [position.eq(k), known.eq(1)]
        with m.Switch(position):
            for row in self.rows[-_WORDS:]:
                with m.Case(row.address % _WORDS):
                    m.d.sync += value.eq(self.word[:row.shape.width].as_signed()
                                         if row.shape.signed else self.word[:row.shape.width])
        m.d.sync += self.mine.eq(known)
        return Cat(position, Mux(in_list, number, 0)[:self.entry_bits]), value
