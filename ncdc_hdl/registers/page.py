"""A page of registers, made from its table."""

from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import Agent
from ncdc_hdl.lib.pipeline import register

__all__ = ["Page"]


class Page(wiring.Component):
    """Avalon-MM agent of the registers of a table, without shadowing.

    Timing: one access at a time; a written value is valid two clocks after its acceptance, and
    data follow a read after ``latency`` clocks.

    Parameters
    ----------
    table : sequence of Register
        Registers with the access "rw", "ro" and "action".
    address_bits : int
        Bits of the word address that the page decodes.
    values : dict
        Values after a reset, by name; zero by default.
    locked : sequence of str
        Registers that are not written while ``lock`` is high.
    aligned : dict
        Lowest bits that a register, by name, does not store: they read as zero.

    Members
    -------
    bus : ``In(Agent(address_bits))``
    values : ``Out(StructLayout)``
        The "rw" registers by name.
    read : ``In(StructLayout)``
        The others by name, "action" registers whole. ``looked`` is the word address that is read,
        one clock before the value of the register must be valid.
    looked : ``Out(address_bits)``
    written : ``Out(StructLayout)``
        A bit for each "action" register by name, high for one clock; the word is ``word``.
    word : ``Out(32)``
    lock, rejected : ``In(1)``, ``Out(1)``
        ``rejected`` is high for one clock when a write is ignored.
    """

    latency = 4
    """Clocks from a read on the bus to its data."""

    def __init__(self, table, address_bits, values, locked=(), aligned=None):
        self.table, self.locked, self.aligned = table, locked, aligned or {}
        stored = {r.name: r.shape.width for r in table if r.access == "rw"}
        other = {r.name: r.shape.width for r in table if r.access != "rw"}
        super().__init__({
            "bus": In(Agent(address_bits)),
            "values": Out(data.StructLayout(stored),
                          init={name: values.get(name, 0) for name in stored}),
            "read": In(data.StructLayout(other)), "looked": Out(address_bits),
            "written": Out(data.StructLayout({r.name: 1 for r in table if r.access == "action"})),
            "word": Out(32), "lock": In(1), "rejected": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        bus = self.bus
        busy = Signal()                     # an access is under way
        accept = Signal()                   # the bus may end it
        begun = (bus.read | bus.write) & ~busy
        m.d.comb += bus.waitrequest.eq(~accept)
        with m.If(begun):
            m.d.sync += [busy.eq(1), self.looked.eq(bus.address), self.word.eq(bus.writedata)]
        with m.If(accept):
            m.d.sync += busy.eq(0)
        write = register(m, "write0", bus.write & begun, reset_less=False)
        read = register(m, "read0", bus.read & begun, reset_less=False)
        m.d.sync += accept.eq(write | read)
        meant = {r.name: register(m, f"{r.name.lower()}_meant", self.looked == r.address)
                 for r in self.table}
        write = register(m, "write1", write, reset_less=False)
        ignored = Signal()
        for r in self.table:
            written = write & meant[r.name]
            if r.access == "rw":
                lock = self.lock if r.name in self.locked else Const(0)
                low = self.aligned.get(r.name, 0)
                with m.If(written & ~lock):
                    m.d.sync += self.values[r.name].eq(Cat(Const(0, low), self.word[low:]))
                with m.If(written & lock):
                    m.d.comb += ignored.eq(1)
            elif r.access == "action":
                m.d.comb += self.written[r.name].eq(written)
        m.d.sync += self.rejected.eq(ignored)
        # A register that is read a clock after its address is known.
        words = [Mux(meant[r.name], self.values[r.name] if r.access == "rw" else self.read[r.name],
                     0) for r in self.table]
        eights = [register(m, f"word{k}", reduce(or_, words[k:k + 8]), 32)
                  for k in range(0, len(words), 8)]
        m.d.sync += bus.readdata.eq(reduce(or_, eights))
        read = register(m, "read1", read, reset_less=False)
        read = register(m, "read2", read, reset_less=False)
        m.d.sync += bus.readdatavalid.eq(read)
        return m
