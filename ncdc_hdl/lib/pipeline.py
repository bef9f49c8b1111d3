"""Registers of free-running pipelines."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

__all__ = ["DelayMemory", "delay", "register"]


def register(m, name, value, shape=None, reset_less=True):
    """``value`` one clock later, of its own shape unless ``shape`` is given.

    Data needs no reset: nothing reads it before it is written.
    """
    r = Signal(shape or value.shape(), name=name, reset_less=reset_less)
    m.d.sync += r.eq(value)
    return r


def delay(m, value, clocks, name, reset_less=True):
    """``value`` as it was ``clocks`` clocks ago, through a chain of registers."""
    for k in range(clocks):
        value = register(m, f"{name}_d{k}", value, reset_less=reset_less)
    return value


class DelayMemory(wiring.Component):
    """``i`` as it was ``clocks`` clocks ago, through a memory: for long delays.

    Parameters
    ----------
    shape : Shape
    clocks : int
        At least 2, so that no word is read in the clock that writes it.

    Members
    -------
    i, o : ``In(shape)``, ``Out(shape)``

    Raises
    ------
    ValueError
        If ``clocks`` is below 2.
    """

    def __init__(self, shape, clocks):
        if clocks < 2:
            raise ValueError(f"clocks is {clocks}, a memory delays by at least 2")
        self.clocks = clocks
        super().__init__({"i": In(shape), "o": Out(shape)})

    def elaborate(self, platform):
        m = Module()
        i, o = Value.cast(self.i), Value.cast(self.o)
        m.submodules.memory = memory = Memory(shape=len(i), depth=self.clocks, init=[])
        write, read = memory.write_port(), memory.read_port()
        # Any address may be the first one: no reset.
        index = Signal(range(self.clocks), reset_less=True)     # at which this word is written
        following = Signal(range(self.clocks))      # address of the next one: the oldest word
        m.d.sync += index.eq(following)
        m.d.comb += [
            following.eq(Mux(index == self.clocks - 1, 0, index + 1)),
            write.addr.eq(index), write.data.eq(i), write.en.eq(1),
            read.addr.eq(following), o.eq(read.data),
        ]
        return m
