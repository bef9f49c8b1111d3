"""An accumulator with a memory of words, and its program."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.link.program import CONDITIONS, ORDERS, STEP, WORDS, Index, assembled

__all__ = ["Engine"]

_OWN = ("always", "zero", "negative", "borrow", "uneven")     # conditions of the sum


class Engine(wiring.Component):
    """Executes the program of :mod:`ncdc_hdl.link.program`, from its beginning after a reset.

    Timing: two clocks for a step. The first one reads the step's word, the second one
    executes the step.

    Parameters
    ----------
    constants : dict
        Constant words by name.

    Members
    -------
    conditions : ``In(StructLayout)``
        A bit for each of ``CONDITIONS``, without those of the sum.
    orders : ``Out(StructLayout)``
        A bit for each of ``ORDERS``, high for one clock.
    again, bank, host, steps : ``In(1)``, ``In(1)``, ``In(4)``, ``In(4)``
        Parts of addresses, selected by ``Index``.
    stamp, word, waited : ``In(32)``, ``In(32)``, ``In(8)``
        Operands of ``Source`` other than the memory.
    mask : ``In(32)``
        Bits of ``word`` that are used.
    sum : ``Out(32)``
    """

    def __init__(self, constants):
        self.constants = constants
        super().__init__({
            "conditions": In(data.StructLayout({n: 1 for n in CONDITIONS if n not in _OWN})),
            "orders": Out(data.StructLayout(dict.fromkeys(ORDERS, 1))),
            "again": In(1), "bank": In(1), "host": In(4), "steps": In(4),
            "stamp": In(32), "word": In(32), "waited": In(8), "mask": In(32),
            "sum": Out(32)})

    def elaborate(self, platform):
        m = Module()
        init = [0] * 32
        for name, value in self.constants.items():
            init[WORDS[name]] = value
        program = assembled()
        m.submodules.program = rom = block_memory(STEP.size, len(program), program)
        m.submodules.words = words = block_memory(32, len(init), init)
        fetch, read, write = rom.read_port(), words.read_port(), words.write_port()
        read_step, step = data.View(STEP, fetch.data), Signal(STEP)
        index = Signal(5)                       # address of the step's word
        done = Signal(init=1)                   # the step is done in this clock
        begun = Signal()                        # there is a step
        at, following = Signal(8, init=255), Signal(8)      # its address, and the next one's
        borrow = Signal()
        own = {"always": 1, "zero": self.sum == 0, "negative": self.sum[-1], "borrow": borrow,
               "uneven": self.sum[:4] != 0}
        holds = Cat(own.get(name, self.conditions[name] if name not in own else 0)
                    for name in CONDITIONS).bit_select(step.condition, 1)
        m.d.sync += [done.eq(~done), begun.eq(1)]
        m.d.comb += [
            following.eq(Mux(begun & (holds ^ step.inverted), step.target, at + 1)),
            fetch.en.eq(done), fetch.addr.eq(following), read.en.eq(~done),
            read.addr.eq(self._address(read_step)), write.addr.eq(index), write.data.eq(self.sum),
            write.en.eq(done & begun & step.stores),
        ]
        with m.If(done):
            m.d.sync += at.eq(following)
        with m.Else():
            # Block RAM gives its word late in a clock.
            m.d.sync += [step.eq(read_step), index.eq(read.addr)]
        # The carry into the lowest bit completes a subtraction.
        total = Signal(34)
        m.d.comb += total.eq(Cat(1, self.sum) + Cat(step.subtracts, self._operand(step, read)))
        with m.If(done & begun & step.clears):
            m.d.sync += self.sum.eq(0)
        with m.Elif(done & begun & step.adds):
            m.d.sync += [self.sum.eq(total[1:33]), borrow.eq(~total[33])]
        with m.If(done & begun):
            for number, name in enumerate(ORDERS):
                m.d.comb += self.orders[name].eq(step.order == number)
        return m

    def _address(self, step):
        pairs = Mux(step.index == Index.AGAIN, self.again, (step.index == Index.BANK) & self.bank)
        return Cat(Mux(step.index == Index.HOST, self.host,
                       Mux(step.index == Index.STEPS, self.steps,
                           step.address[:4] | pairs)), step.address[4])

    def _operand(self, step, read):
        """The operand; for a subtraction, with all bits inverted."""
        bits = []
        for k in range(32):
            # Bits of the host's word that the register lacks are 0.
            given = [read.data[k], self.stamp[k], self.word[k] & self.mask[k],
                     self.waited[k] if k < 8 else 0]
            bits.append(Array(given)[step.source])
        return Cat(bits) ^ step.subtracts.replicate(32)
