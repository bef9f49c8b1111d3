"""The register agent: every weight, bias and geometry value, written and read by a host."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import Agent
from ncdc_hdl.avalon.register_table import (ADDRESS_WORDS_BITS, CTRL_START, ID, STATUS_DONE, TABLE)

__all__ = ["Registers"]

COUNTERS = ("CLOCKS", "PIXELS", "FETCHES", "FRONT_END_STALLS")


class Registers(wiring.Component):
    """Avalon-MM agent with shadowed parameters and the control of frames.

    What the host writes to a "shadow" register is copied to ``active`` when a frame begins, all
    of it in one clock. A start while a frame runs is kept, one deep; what is written behind it may
    reach that frame or not, so that a set of parameters is to be written before its start.

    Timing: a write is taken at once; a read answers after 3 clocks, one at a time.

    Parameters
    ----------
    table : sequence of Register
    values : dict
        Values after configuration, by name; zero where absent.
    digest : int
        Read back as DIGEST.
    hidden_neurons : int
        Read back as NEURONS.

    Members
    -------
    bus : ``In(Agent(14))``
    active : ``Out(StructLayout)``
        The "shadow" registers by name, as the present frame sees them.
    window_bank, table_row, table_span, table_write, table_read, table_start, table_stop,
    table_span_start, table_span_stop :
        To the host's side of the table of valid rows.
    begin : ``Out(1)``
        High for one clock, the one before ``active`` is that of a new frame.
    ended : ``In(1)``
        The frame is complete.
    counters : ``In(StructLayout)``
        Of the frame, by name; copied when it ends.
    irq : ``Out(1)``
    """

    def __init__(self, table, values, *, digest, hidden_neurons):
        self.table, self.values = table, values
        self.constants = {"ID": ID, "DIGEST": digest, "NEURONS": hidden_neurons}
        shadow = {r.name: r.shape for r in table if r.access == "shadow"}
        part = 13
        super().__init__({
            "bus": In(Agent(ADDRESS_WORDS_BITS)),
            "active": Out(data.StructLayout(shadow)),
            "window_bank": Out(1), "table_row": Out(ADDRESS_WORDS_BITS - 2), "table_span": Out(1),
            "table_write": Out(1), "table_read": Out(1),
            "table_start": Out(part), "table_stop": Out(part),
            "table_span_start": In(part), "table_span_stop": In(part),
            "begin": Out(1), "ended": In(1),
            "counters": In(data.StructLayout({name: 32 for name in COUNTERS})),
            "irq": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        bus = self.bus
        kept = {r.name: Signal(r.shape, name=r.name.lower(), init=self.values.get(r.name, 0))
                for r in self.table if r.access in ("rw", "shadow")}
        counted = {name: Signal(32, name=name.lower()) for name in (*COUNTERS, "FRAMES")}
        busy, done, pending = Signal(), Signal(), Signal()

        # Reads take three clocks, during which the agent waits.
        r0, r1, r2 = Signal(), Signal(), Signal()
        address = Signal(ADDRESS_WORDS_BITS)
        accept = Signal()
        in_table = bus.address >= TABLE
        m.d.comb += [
            bus.waitrequest.eq(r0 | r1 | r2),
            accept.eq(bus.write & ~bus.waitrequest),
            bus.readdatavalid.eq(r2),
            self.window_bank.eq(kept["VALID_WINDOW"]),
            self.table_row.eq(Mux(r0, address, bus.address)[1:]),
            self.table_span.eq(Mux(r0, address, bus.address)[0]),
            self.table_write.eq(accept & in_table),
            self.table_read.eq(r0),
            self.table_start.eq(bus.writedata[:16]), self.table_stop.eq(bus.writedata[16:]),
        ]
        with m.If(bus.read & ~bus.waitrequest):
            m.d.sync += address.eq(bus.address)
        m.d.sync += [r0.eq(bus.read & ~bus.waitrequest), r1.eq(r0), r2.eq(r1)]

        readable = {**self.constants, **kept, **counted, "CTRL": 0,
                    "STATUS": Cat(busy, done, pending)}
        value = Signal(signed(32))
        with m.Switch(address):
            for register in self.table:
                with m.Case(register.address):
                    m.d.sync += value.eq(readable[register.name])
            with m.Default():
                m.d.sync += value.eq(0)
        span = Cat(self.table_span_start, Const(0, 3), self.table_span_stop, Const(0, 3))
        m.d.sync += bus.readdata.eq(Mux(address >= TABLE, span, value))

        with m.If(accept):
            with m.Switch(bus.address):
                for register in self.table:
                    if register.name in kept:
                        with m.Case(register.address):
                            m.d.sync += kept[register.name].eq(bus.writedata)

        action = {r.name: accept & (bus.address == r.address)
                  for r in self.table if r.access == "action"}
        m.d.comb += [self.begin.eq(pending & ~busy),
                     self.irq.eq(done & kept["IRQ_ENABLE"])]
        with m.If(action["STATUS"] & ((bus.writedata & STATUS_DONE) != 0)):
            m.d.sync += done.eq(0)
        with m.If(self.begin):
            m.d.sync += [busy.eq(1), pending.eq(0)]
            m.d.sync += [self.active[name].eq(kept[name]) for name, _ in self.active.shape()]
        with m.If(action["CTRL"] & ((bus.writedata & CTRL_START) != 0)):
            m.d.sync += pending.eq(1)
        with m.If(self.ended):
            m.d.sync += [busy.eq(0), done.eq(1), counted["FRAMES"].eq(counted["FRAMES"] + 1)]
            m.d.sync += [counted[name].eq(self.counters[name]) for name in COUNTERS]
        return m
