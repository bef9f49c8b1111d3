"""The register agent: every weight, bias and geometry value, written and read by a host."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import Agent
from ncdc_hdl.avalon.register_table import ADDRESS_WORDS_BITS, ID, TABLE

__all__ = ["COUNTERS", "Registers"]

COUNTERS = ("CLOCKS", "PIXELS", "FETCHES", "FRONT_END_STALLS", "SINK_STALLS", "DATA_STALLS",
            "INTERLOCK_STALLS", "CREDIT_STALLS", "PENDING_STALLS")


class Registers(wiring.Component):
    """Avalon-MM agent with shadowed parameters and the control of frames.

    The host writes "shadow" registers one by one; a commit marks the set complete. At the next
    frame boundary, which is at once if no frame runs, the whole set is copied to ``active`` in one
    clock. Until then writes to the set, and to the bank of valid rows that it names, are refused;
    so are, at any time, writes to the bank that a running or waiting frame uses. A refused write
    changes nothing and is remembered in STATUS, so that no frame ever sees half a set.
    A start while a frame runs is kept, one deep; without a commit it uses the set in use. An
    abort concerns the frame that runs, not the one that waits.

    Timing: a write is taken at once; a read answers after 4 clocks, one at a time. The clock after
    ``ended`` is that of the next ``begin``, with or without a commit.

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
        The "shadow" registers by name, as the present frame sees them; constant while one runs.
    window_bank, table_row, table_span, table_write, table_read, table_start, table_stop,
    table_span_start, table_span_stop :
        To the host's side of the table of valid rows.
    begin : ``Out(1)``
        High for one clock, the one before ``active`` is that of a new frame.
    ended : ``In(1)``
        The frame is complete.
    abort : ``Out(1)``
        The frame is to end early; until it has ``ended``.
    cut : ``In(1)``
        The frame lacks pixels; when it has ``ended``.
    counters : ``In(StructLayout)``
        Of the frame, by name; copied when it ends.
    irq : ``Out(1)``
    """

    def __init__(self, table, values, *, digest, hidden_neurons):
        self.table, self.values = table, values
        self.constants = {"ID": ID, "DIGEST": digest, "NEURONS": hidden_neurons}
        shadow = {r.name: r.shape for r in table if r.access == "shadow"}
        initial = {name: values.get(name, 0) for name in shadow}
        part = 13
        super().__init__({
            "bus": In(Agent(ADDRESS_WORDS_BITS)),
            "active": Out(data.StructLayout(shadow), init=initial),
            "window_bank": Out(1), "table_row": Out(ADDRESS_WORDS_BITS - 2), "table_span": Out(1),
            "table_write": Out(1), "table_read": Out(1),
            "table_start": Out(part), "table_stop": Out(part),
            "table_span_start": In(part), "table_span_stop": In(part),
            "begin": Out(1), "ended": In(1), "abort": Out(1), "cut": In(1),
            "counters": In(data.StructLayout({name: 32 for name in COUNTERS})),
            "irq": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        bus = self.bus
        kept = {r.name: Signal(r.shape, name=r.name.lower(), init=self.values.get(r.name, 0))
                for r in self.table if r.access in ("rw", "shadow")}
        counted = {name: Signal(32, name=name.lower()) for name in (*COUNTERS, "FRAMES")}
        action = {r.name: r for r in self.table if r.access == "action"}
        status = {flag.name: Signal(name=flag.name.lower()) for flag in action["STATUS"].flags}
        busy, pending, committed = (status[name] for name in ("BUSY", "PENDING", "COMMITTED"))

        # Reads take four clocks, during which the agent waits: two for the table of valid rows.
        r0, r1, r2, r3 = (Signal(name=f"r{k}") for k in range(4))
        address = Signal(ADDRESS_WORDS_BITS)
        accept = Signal()
        in_table = bus.address >= TABLE
        table_held, window = Signal(), kept["VALID_WINDOW"]
        m.d.comb += table_held.eq((busy | pending) & (window == self.active.VALID_BANK)
                                  | committed & (window == kept["VALID_BANK"]))
        m.d.comb += [
            bus.waitrequest.eq(r0 | r1 | r2 | r3),
            accept.eq(bus.write & ~bus.waitrequest),
            bus.readdatavalid.eq(r3),
            self.window_bank.eq(kept["VALID_WINDOW"]),
            self.table_row.eq(Mux(r0, address, bus.address)[1:]),
            self.table_span.eq(Mux(r0, address, bus.address)[0]),
            self.table_write.eq(accept & in_table & ~table_held),
            self.table_read.eq(r0),
            self.table_start.eq(bus.writedata[:16]), self.table_stop.eq(bus.writedata[16:]),
        ]
        with m.If(bus.read & ~bus.waitrequest):
            m.d.sync += address.eq(bus.address)
        m.d.sync += [r0.eq(bus.read & ~bus.waitrequest), r1.eq(r0), r2.eq(r1),
                     r3.eq(r2)]

        readable = {**self.constants, **kept, **counted, "CTRL": 0,
                    "STATUS": Cat(status[flag.name] for flag in action["STATUS"].flags)}
        value = Signal(signed(32))
        with m.Switch(address):
            for register in self.table:
                with m.Case(register.address):
                    m.d.sync += value.eq(readable[register.name])
            with m.Default():
                m.d.sync += value.eq(0)
        span = Cat(self.table_span_start, Const(0, 3), self.table_span_stop, Const(0, 3))
        m.d.sync += bus.readdata.eq(Mux(address >= TABLE, span, value))

        refused = Signal()
        m.d.comb += refused.eq(accept & in_table & table_held)
        with m.If(accept):
            with m.Switch(bus.address):
                for register in self.table:
                    if register.name in kept:
                        with m.Case(register.address):
                            if register.access == "shadow":
                                m.d.comb += refused.eq(committed)
                                with m.If(~committed):
                                    m.d.sync += kept[register.name].eq(bus.writedata)
                            else:
                                m.d.sync += kept[register.name].eq(bus.writedata)

        def written(register, flag):
            return accept & (bus.address == register.address) & ((bus.writedata & flag.mask) != 0)

        control = {flag.name: written(action["CTRL"], flag) for flag in action["CTRL"].flags}
        boundary = Signal()
        m.d.comb += [boundary.eq(~busy), self.begin.eq(pending & boundary),
                     self.irq.eq(status["DONE"] & kept["IRQ_ENABLE"]),
                     status["BANK"].eq(self.active.VALID_BANK)]
        for flag in action["STATUS"].flags:
            if flag.access == "w1c":
                with m.If(written(action["STATUS"], flag)):
                    m.d.sync += status[flag.name].eq(0)
        with m.If(refused):
            m.d.sync += status["REFUSED"].eq(1)
        self._take_over(m, committed & boundary, kept)
        with m.If(boundary):
            m.d.sync += committed.eq(0)
        with m.If(self.begin):
            m.d.sync += [busy.eq(1), pending.eq(0)]
        with m.If(control["START"]):
            m.d.sync += pending.eq(1)
        with m.If(control["COMMIT"]):
            m.d.sync += committed.eq(1)
        with m.If(control["ABORT"]):
            m.d.sync += self.abort.eq(busy | self.begin)
        with m.If(self.ended):
            m.d.sync += [busy.eq(0), status["DONE"].eq(1), self.abort.eq(0),
                         status["ABORTED"].eq(self.cut),
                         counted["FRAMES"].eq(counted["FRAMES"] + 1)]
            m.d.sync += [counted[name].eq(self.counters[name]) for name in COUNTERS]
        return m

    def _take_over(self, m, when, kept):
        """Copy the whole set to ``active`` in the clocks in which ``when`` is high."""
        with m.If(when):
            m.d.sync += [self.active[name].eq(kept[name]) for name, _ in self.active.shape()]
