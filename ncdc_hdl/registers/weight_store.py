"""The host's side of weights in memories: its set, and the copies of that set."""

from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2, exact_log2

from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_hdl.neural.banks import BANK_WRITES
from ncdc_spec.registers.register_map import ADDRESS_WORDS_BITS

__all__ = ["WeightStore", "in_memory"]

# Bits of the address of a network's register: the one that is high for the output layer,
# and those of the neuron's number.
_OUTPUT, _NEURON = 0x200, 31 << 2
_READ = 2               # clocks from an address to the memory's output register


def in_memory(rows, hardware):
    """Those of the registers ``rows`` that ``hardware`` has in memories."""
    return [r for r in rows if r.parameter and hardware.in_memory(r.parameter[0])
            and (r.parameter[0] == "hidden" or r.parameter[2] == "weights")]


class WeightStore(wiring.Component):
    """The weights that a host reads and writes word by word, before the network's two banks.

    Writes of a host go into the set and into the bank that no frame uses. ``take`` makes that
    whole bank active in one clock. Then the set is copied into the other bank, word by
    word, so that both are equal again. After a reset the set and the active bank first
    get the values of configuration, which are in the set's memory too and never written.

    Timing: ``read`` follows ``address`` after 2 clocks while ``held`` is high. A written word is
    in the set and in the bank 2 clocks after ``write``, which follows ``address`` and ``word`` by
    at least two. A copy takes ``words`` clocks, the reset's ``2 * words``, in all of which ``busy``
    is high; it waits while ``held`` is high. ``write``, reads and ``take`` must not come while it
    is under way.

    Parameters
    ----------
    rows : sequence of ncdc_spec.registers.register_map.Register
        Registers of the network that are in memories.
    values : dict
        Values after configuration, by name; zero by default.
    neurons : int
        Neurons that the network's units could serve: at least its own.

    Members
    -------
    address : ``In(14)``
        Word address on the bus; constant during an access.
    word : ``In(32)``
        The word to be written.
    held : ``In(1)``
        An access is under way.
    write : ``In(1)``
        ``word`` is written to ``address`` if that is ``mine``.
    mine : ``Out(1)``
        ``address`` is that of a row, two clocks later.
    read : ``Out(signed(32))``
        Content of the set there; zero if the address is not ``mine``.
    take : ``In(1)``
    busy : ``Out(1)``
    writes : ``Out(BANK_WRITES)``
    """

    def __init__(self, rows, values, neurons):
        self.rows, self.values = rows, values
        self.neuron_bits = ceil_log2(neurons)
        self.words = 1 << (2 + self.neuron_bits + 1)
        super().__init__({
            "address": In(ADDRESS_WORDS_BITS), "word": In(32), "held": In(1), "write": In(1),
            "mine": Out(1), "read": Out(signed(32)), "take": In(1), "busy": Out(1, init=1),
            "writes": Out(BANK_WRITES),
        })

    def _index(self, address):
        """Number in the set of the word of an ``address``, both integers."""
        low = 2 + self.neuron_bits
        return address & ((1 << low) - 1) | (address // _OUTPUT & 1) << low

    def _contents(self):
        """Content of the memory: the set, then the values after configuration."""
        contents = [0] * (2 * self.words)
        for r in self.rows:
            contents[self.words + self._index(r.address)] = self.values.get(r.name, 0)
        return contents

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = block_memory(signed(32), 2 * self.words, self._contents())
        write, read = memory.write_port(), memory.read_port()
        value = self._decode(m)                     # ``word`` in the format of its row
        index = Signal(range(self.words))           # number of the accessed word in the set
        count = Signal(range(self.words))           # number of the word that the copy reads
        configured = Signal()                       # the set has the values of configuration
        step = Signal()                             # the copy reads a word
        came = Signal(signed(32), reset_less=True)  # the word read
        m.d.comb += [
            index.eq(Cat(self.address[:2 + self.neuron_bits], self.address[exact_log2(_OUTPUT)])),
            step.eq(self.busy & ~self.held),
            read.addr.eq(Mux(self.held, index, Cat(count, ~configured))),
            self.read.eq(Mux(self.mine, came, 0)),
        ]
        # The RAM's own output register: without it the output takes half a period and more.
        m.d.sync += came.eq(read.data)
        with m.If(step):
            m.d.sync += count.eq(count + 1)
            with m.If(count == self.words - 1):
                m.d.sync += [configured.eq(1), self.busy.eq(~configured)]
        with m.If(self.take):
            m.d.sync += [self.writes.active.eq(~self.writes.active), self.busy.eq(1)]
        # The copy writes a word when it has come.
        copied = delay(m, step, _READ, "copied", reset_less=False)
        position = delay(m, count, _READ, "position")
        restored = copied & ~delay(m, configured, _READ, "of_set")  # from those of configuration
        of_host = self.write & self.mine
        target = Signal(range(self.words))          # number of the word that is written
        m.d.comb += target.eq(Mux(copied, position, index))
        # The set is written a clock later, with the bank's registers.
        writes = self.writes
        written = register(m, "written", target)
        m.d.comb += [write.addr.eq(written), write.data.eq(writes.word),
                     write.en.eq(register(m, "stored", of_host | restored, reset_less=False))]
        # The values of configuration go to the active bank first, as no frame runs.
        m.d.sync += [
            writes.write.eq(of_host | copied), writes.word.eq(Mux(copied, came, value)),
            writes.bank.eq(writes.active ^ ~restored),
        ]
        m.d.comb += [
            writes.position.role.eq(written[:2]), writes.position.neuron.eq(written[2:-1]),
            writes.position.output.eq(written[-1]),
        ]
        return m

    def _decode(self, m):
        """Set ``mine``; returns the word that is accessed, extended by the sign of its row, both
        two clocks later."""
        kinds = {r.address & ~_NEURON: r.shape for r in self.rows}
        # Of each kind of row whether the address is that of one: nothing but these go on, as the
        # address is a register near the bus.
        hits = {kind: register(m, f"hit{kind:x}", (self.address & ~_NEURON) == kind)
                for kind in kinds}
        exists = register(m, "exists", self.address[2:7] < len(self.rows) // len(kinds))
        value = Signal(signed(32), reset_less=True)
        extended = (Mux(hits[kind], self.word[:shape.width].as_signed(), 0)
                    for kind, shape in kinds.items())
        m.d.sync += [value.eq(reduce(or_, extended)),
                     self.mine.eq(Cat(hits.values()).any() & exists)]
        return value
