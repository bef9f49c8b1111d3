"""Weights of neurons that one unit computes in turn: two banks in a memory, not registers."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.lib.memory import block_memory

__all__ = ["BANK_WRITES", "POSITION", "WeightBanks"]

# Position of a word in the network, as in its register's address. `role` of a hidden neuron: 0
# for the weight of x, 1 for that of y, 2 for the bias. In the output layer it is the output neuron,
# 0 for x', 1 for y', and the word the weight of the hidden `neuron`. Units may serve a few neurons
# more than the 32 of the largest network.
POSITION = data.StructLayout({"role": 2, "neuron": 6, "output": 1})

BANK_WRITES = wiring.Signature({
    "write": Out(1),            # ``word`` is written
    "bank": Out(1),             # to this bank
    "position": Out(POSITION),
    "word": Out(signed(32)),
    "active": Out(1),           # the bank that frames use; constant while one runs
})
"""From the registers to all memories of weights."""


class WeightBanks(wiring.Component):
    """One word of each neuron that a unit serves, twice: a bank for frames, one for the host.

    The unit's neurons are ``unit * share`` to ``unit * share + share - 1``, also where the network
    has fewer: their words must also be written, with zeros.

    Timing: ``o`` is the word of ``turn`` a clock later; a word is written in the clock of
    ``writes.write``.

    Parameters
    ----------
    shape : Shape
        Shape of a word; its lowest bits are stored.
    unit, share : int
        The neurons, see :func:`ncdc_hdl.neural.layers.served`.
    output, role : int
        Position of the neurons' word, as in :data:`POSITION`.

    Members
    -------
    writes : ``In(BANK_WRITES)``
    turn : ``In(range(share))``
    o : ``Out(shape)``
    """

    latency = 1
    """Clocks from ``turn`` to its word."""

    def __init__(self, shape, *, unit, share, output, role):
        self.first, self.share = unit * share, share
        self.output, self.role = output, role
        super().__init__({"writes": In(BANK_WRITES), "turn": In(range(share)), "o": Out(shape)})

    def elaborate(self, platform):
        m = Module()
        writes, position = self.writes, self.writes.position
        m.submodules.memory = memory = block_memory(self.o.shape(), 2 << ceil_log2(self.share))
        write, read = memory.write_port(), memory.read_port()
        slot = Signal.like(position.neuron)        # turn of the neuron whose word is written
        # No word is read when it is written: reads are of one bank and writes of the other, unless
        # no frame runs.
        m.d.comb += [
            slot.eq(position.neuron - self.first),
            write.addr.eq(Cat(slot[:ceil_log2(self.share)], writes.bank)),
            write.data.eq(writes.word),
            write.en.eq(writes.write & (slot < self.share) & (position.output == self.output)
                        & (position.role == self.role)),
            read.addr.eq(Cat(self.turn, writes.active)), self.o.eq(read.data),
        ]
        return m
