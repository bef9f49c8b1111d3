"""Block RAM as devices have it, not simulators."""

from contextlib import contextmanager
from unittest import mock

from amaranth import *
from amaranth.lib.memory import Memory

__all__ = ["undefined_collisions"]


class _Undefined(Memory):
    """A memory with one port each; what is read in the clock of its own write comes inverted."""

    def elaborate(self, platform):
        m = Module()
        shape = Shape.cast(self.shape)
        m.submodules.plain = plain = Memory(shape=shape, depth=self.depth, init=self.init)
        [outer_write], [outer_read] = self.write_ports, self.read_ports
        write, read = plain.write_port(), plain.read_port()
        clash = Signal(shape)
        m.d.comb += [
            write.addr.eq(outer_write.addr),
            Value.cast(write.data).eq(Value.cast(outer_write.data)), write.en.eq(outer_write.en),
            read.addr.eq(outer_read.addr), read.en.eq(outer_read.en),
            Value.cast(outer_read.data).eq(read.data ^ clash),
        ]
        with m.If(read.en):
            m.d.sync += clash.eq((write.en.any() & (write.addr == read.addr)).replicate(len(clash)))
        return m


@contextmanager
def undefined_collisions():
    """Memories of ``block_memory`` made meanwhile are :class:`_Undefined`;
    yields the list of them."""
    made = []

    def memory(**options):
        made.append(_Undefined(**options))
        return made[-1]
    with mock.patch("ncdc_hdl.lib.memory.Memory", memory):
        yield made
