"""Programs of register accesses, in a memory: configuration without a host."""

from amaranth import *
from amaranth.lib import data, enum, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.registers.access import Access

__all__ = ["Op", "ProgramRunner", "Step"]


class Op(enum.Enum, shape=3):
    """Operation of a step with its address and word."""
    END = 0             # the program is over
    WRITE = 1           # write the word
    PAUSE = 2           # wait for as many clocks as the word
    LOOK = 3            # record whether any bit of the register under the word is one
    WRITE_NOT = 4       # write 1 if the last LOOK found none, else 0
    UNTIL_ZERO = 5      # read until no bit of the register under the word is one
    GUARD = 6           # the same once; if any bit is one, the program begins anew


class Step:
    """Steps, as integers for the memory.

    Parameters
    ----------
    address_bits : int
        Bits of a word address.
    """

    def __init__(self, address_bits):
        self.layout = data.StructLayout({"op": Op, "address": address_bits, "word": 32})

    def __call__(self, op, address=0, word=0):
        """The integer of a step."""
        return self.layout.const({"op": op, "address": address,
                                  "word": word & 0xFFFFFFFF}).as_value().value


class ProgramRunner(wiring.Component):
    """Executes one of several programs at a time.

    Program 0 runs after a reset. A GUARD may restart a program without limit: it counts
    in ``failures``, and first waits for ``retry_clocks`` clocks .

    Timing: a step takes 3 clocks, and an access as long as its bus takes.

    Parameters
    ----------
    programs : sequence of sequence of (Op, address, word)
        Each program without its END.
    address_bits : int
        Bits of a word address.
    retry_clocks : int
        Clocks before a restart.

    Members
    -------
    access : ``Out(Access(address_bits))``
    start, which : ``In(1)``, ``In(range(len(programs)))``
        High for one clock: begin this program; ignored while ``busy``.
    busy : ``Out(1)``
    failures : ``Out(8)``
        Times that a program was begun anew since the reset; stays at 255.
    """

    def __init__(self, programs, address_bits, *, retry_clocks):
        self.retry_clocks = retry_clocks
        self.longest = max([retry_clocks, *(word for program in programs
                                            for op, _, word in program if op == Op.PAUSE)])
        step = Step(address_bits)
        self.layout = step.layout
        self.words, self.starts = [], []
        for program in programs:
            self.starts.append(len(self.words))
            self.words += [step(*one) for one in program] + [step(Op.END)]
        super().__init__({
            "access": Out(Access(address_bits)), "start": In(1),
            "which": In(range(max(2, len(programs)))), "busy": Out(1, init=1),
            "failures": Out(8)})

    def elaborate(self, platform):
        m = Module()
        depth = 1 << max(2, (len(self.words) - 1).bit_length())
        m.submodules.memory = memory = block_memory(
            self.layout.size, depth, self.words + [0] * (depth - len(self.words)))
        read = memory.read_port()
        index = Signal(range(depth))            # address of the next step
        begun = Signal(range(depth))            # address of the first step of the program
        left = Signal(range(self.longest + 1))  # clocks of a pause
        found = Signal()                        # result of the last LOOK
        step = Signal(self.layout)
        access = self.access
        m.d.comb += [
            read.addr.eq(index),
            access.address.eq(step.address),
            access.write.eq((step.op == Op.WRITE) | (step.op == Op.WRITE_NOT)),
            access.word.eq(Mux(step.op == Op.WRITE_NOT, ~found, step.word)),
        ]
        some = Signal()                         # a bit under the word is one
        m.d.comb += some.eq((access.answer & step.word).any())
        with m.FSM(init="READ"):
            with m.State("REST"):
                begins = Array(self.starts)[self.which]
                m.d.sync += [index.eq(begins), begun.eq(begins)]
                with m.If(self.start):
                    m.d.sync += self.busy.eq(1)
                    m.next = "READ"
            with m.State("READ"):
                m.next = "TAKE"
            with m.State("TAKE"):
                m.d.sync += [step.eq(read.data), index.eq(index + 1)]
                m.next = "DO"
            with m.State("DO"):
                m.d.sync += left.eq(step.word)
                m.next = "ASK"
                with m.If(step.op == Op.END):
                    m.d.sync += self.busy.eq(0)
                    m.next = "REST"
                with m.Elif(step.op == Op.PAUSE):
                    m.next = "PAUSE"
            with m.State("PAUSE"):
                m.d.sync += left.eq(left - 1)
                with m.If(left == 0):
                    m.next = "READ"
            with m.State("ASK"):
                m.d.comb += access.valid.eq(1)
                with m.If(access.done):
                    m.next = "READ"
                    with m.If(step.op == Op.LOOK):
                        m.d.sync += found.eq(some)
                    with m.If((step.op == Op.UNTIL_ZERO) & some):
                        m.next = "ASK"
                    with m.If((step.op == Op.GUARD) & some):
                        m.d.sync += [index.eq(begun), left.eq(self.retry_clocks),
                                     self.failures.eq(self.failures + (self.failures != 255))]
                        m.next = "PAUSE"
        return m
