"""The register agent: every weight, bias and geometry value, written and read by a host."""

from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import Agent
from ncdc_hdl.frontend.layouts import ROW_WRITES
from ncdc_hdl.frontend.signatures import TableAccess
from ncdc_hdl.frontend.valid import ValidTable
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_hdl.neural.banks import BANK_WRITES
from ncdc_hdl.registers.view_pass import ViewPass
from ncdc_hdl.registers.view_store import ViewStore
from ncdc_hdl.registers.weight_store import WeightStore
from ncdc_spec.registers.register_map import (
    ADDRESS_WORDS_BITS,
    COLOUR_COUNTERS,
    COUNTERS,
    ID,
    OUTSIDE_DIGEST,
    TABLE,
    listed,
)
from ncdc_spec.view_list import ENTRY_WORDS
from ncdc_spec.view_rows import MAX_MATRICES, ROWS_BANK, ROWS_STATUS, ROWS_TABLE

__all__ = ["Registers"]

_VALID = 5      # of the clocks of a read, that in which its word is on the bus


class Registers(wiring.Component):
    """Avalon-MM agent with shadowed parameters and the control of frames.

    The host writes "shadow" registers one by one; a commit marks the set complete. At the next
    frame boundary, which is at once if no frame runs, the whole set is copied to ``active`` in one
    clock. Until then writes to the set, and to the bank of valid rows that it names, are rejected.
    So are always writes to the bank that a running or waiting frame uses. The same holds of the
    banks of a view's table of matrices, which a host cannot read. A rejected write
    changes nothing and sets a flag in STATUS, so that no frame ever uses half a set.
    One start while a frame runs is queued; without a commit it uses the set in use. An
    abort applies to the frame that runs, not the one that waits.

    Weights of neurons that share a unit are not in ``active`` but in memories, see
    :class:`WeightStore`, which copies them after a commit and after a reset.

    With a list of views a start makes a pass, a frame for each of its views. What an entry of the
    list has is in a :class:`ViewStore`, and in ``active`` while its view is made.

    Timing: one access at a time; it is accepted after 5 clocks of waiting, when all changes
    are complete, and data follow a clock later. An access during a copy of weights or of the
    list, or a load of an entry, waits until its end. The clock after ``ended`` is that of the next
    ``begin``, with or without a commit; with a list ``ViewStore.load_clocks`` come between. Only a
    commit during the copy of the last one's weights or list waits, with its frame.

    Parameters
    ----------
    table : sequence of Register
    values : dict
        Values after configuration, by name; zero where absent.
    constants : dict
        What DIGEST, NEURONS, NODES, CAPABILITIES and LARGEST read, by these names, and
        VIEW_ROWS_STATUS if there is such.
    in_memory : sequence of Register
        Registers of ``table`` that are in memories, the same for each hidden neuron.
    neurons : int
        Neurons that the network's units could serve, if there are any ``in_memory``.
    constant : container of str
        Names of registers that do not exist. Those of the set are constants of ``active`` with
        their ``values``. Writes to them are ignored, and they read 0. With VALID_BANK among them
        the table of valid rows cannot be accessed, and the lens is always DIGEST's.

    Members
    -------
    bus : ``In(Agent(14))``
    active : ``Out(StructLayout)``
        The "shadow" registers by name, for the present frame; constant while one runs.
        Without those in memories.
    writes : ``Out(BANK_WRITES)``
        Writes to the memories, if there are any.
    valid_table : ``Out(TableAccess())``
        To the host's side of the table of valid rows, which answers ``ValidTable.latency`` clocks
        after ``read``.
    row_writes : ``Out(ROW_WRITES)``
        Writes to a view's table of matrices, if there is one.
    begin : ``Out(1)``
        High for one clock, the one before ``active`` is that of a new frame. A frame is one view
        of a list.
    ended : ``In(1)``
        The frame is complete.
    first, over, lacks : ``Out(1)``, ``Out(1)``, ``Out(1)``
        Only with a list of views: the first view of a pass is made; the pass is over, in the clock
        of its last ``ended``; a view of it lacks pixels.
    abort : ``Out(1)``
        The frame must end early; high until it has ``ended``.
    cut : ``In(1)``
        The frame lacks pixels; valid when it has ``ended``.
    counters : ``In(StructLayout)``
        Counters of the frame by name; copied two clocks after ``ended``, when they are complete.
    running, start : ``In(1)``
        While ``running`` the host's START is rejected, and ``start`` replaces it.
    idle : ``Out(1)``
        No frame runs, and none waits.
    faults : ``In(StructLayout)``
        Sets each bit of FAULT, by its name in lower case.
    irq : ``Out(1)``
    """

    interrupt_latency = 1
    """Clocks from ``ended`` to ``irq``."""

    def __init__(self, table, values, constants, *, in_memory=(), neurons=0, constant=()):
        self.table, self.values = table, values
        self.constant, self.fixed = constant, "VALID_BANK" in constant
        of_list = listed(table)
        # Rows with a register of their own.
        self.rows = [r for r in table
                     if r not in in_memory and r not in of_list and r.name not in constant]
        self.store = WeightStore(in_memory, values, neurons) if in_memory else None
        self.views = len(of_list) // len(ENTRY_WORDS)
        self.entries = ViewStore(of_list, values, self.views) if of_list else None
        self.passes = ViewPass(self.views) if of_list else None
        self.constants = {"ID": ID, **constants}
        self.view_rows = constants.get(ROWS_STATUS, 0)          # matrices of a view's table
        present = [r.name for r in self.rows]
        self.counting = tuple(name for name in COUNTERS + COLOUR_COUNTERS if name in present)
        [fault] = [r for r in table if r.name == "FAULT"]
        shadow = {r.name: Shape(r.shape.width, r.shape.signed)
                  for r in table if r.access == "shadow" and (r in self.rows or r.name in constant)}
        shadow |= {name: Shape(r.shape.width, r.shape.signed)
                   for name, r in zip(ENTRY_WORDS.values(), of_list[-len(ENTRY_WORDS):])}
        initial = {name: values.get(name, 0) for name in shadow}
        super().__init__({
            "bus": In(Agent(ADDRESS_WORDS_BITS)),
            "active": Out(data.StructLayout(shadow), init=initial),
            "begin": Out(1), "ended": In(1), "abort": Out(1), "cut": In(1),
            "counters": In(data.StructLayout({name: 32 for name in self.counting})),
            "faults": In(data.StructLayout({flag.name.lower(): 1 for flag in fault.flags})),
            "running": In(1), "start": In(1), "idle": Out(1),
            "irq": Out(1),
        } | ({} if self.fixed else {"valid_table": Out(TableAccess())})
          | ({"writes": Out(BANK_WRITES)} if in_memory else {})
          | ({"first": Out(1), "over": Out(1), "lacks": Out(1)} if of_list else {})
          | ({"row_writes": Out(ROW_WRITES)} if self.view_rows else {}))

    def elaborate(self, platform):
        m = Module()
        held = {r.name: Signal(Shape(r.shape.width, r.shape.signed), name=r.name.lower(),
                               init=self.values.get(r.name, 0))
                for r in self.rows if r.access in ("rw", "shadow")}
        counted = {name: Signal(32, name=name.lower()) for name in (*self.counting, "FRAMES")}
        action = {r.name: r for r in self.rows if r.access == "action"}
        status = {flag.name: Signal(name=flag.name.lower()) for flag in action["STATUS"].flags}
        fault = {flag.name: Signal(name=f"fault_{flag.name.lower()}")
                 for flag in action["FAULT"].flags}

        copying = Signal()                          # weights are copied: no access begins
        address, word, under_way, write, read = self._accesses(m, copying)
        altered = Signal()                          # the lens may not be the one of DIGEST
        take = Signal()                             # the committed set is taken over in this clock
        stored, store_written, list_rejected = self._memories(
            m, (address, word, under_way, write), take, status["COMMITTED"], copying)
        meant = {r.name: register(m, f"{r.name.lower()}_meant", address == r.address)
                 for r in self.rows}
        self._read(m, address, meant, stored, {
            **self.constants, **held, **counted, **self._state(), "CTRL": 0,
            "STATUS": Cat(status[flag.name] for flag in action["STATUS"].flags),
            "FAULT": Cat(fault[flag.name] for flag in action["FAULT"].flags),
            "ALTERED": altered})

        written = {r.name: write[1] & meant[r.name] for r in self.rows if r.access != "ro"}
        for name, signals in (("STATUS", status), ("FAULT", fault)):
            for flag in action[name].flags:
                if flag.access == "w1c":
                    with m.If(written[name] & word[flag.bit]):
                        m.d.sync += signals[flag.name].eq(0)
        for flag in action["FAULT"].flags:
            with m.If(self.faults[flag.name.lower()]):
                m.d.sync += fault[flag.name].eq(1)
        self._keep(m, written, word, held, status["COMMITTED"])
        rejected = Const(0) if self.fixed else self._table(
            m, address, (write[0], read[_VALID - 1 - ValidTable.latency]), word, held, status)
        if self.entries:
            rejected |= list_rejected
        if self.view_rows:
            rejected |= self._rows(m, address, write[0], word, held, status)
        of_set = Cat(store_written, *(written[r.name] for r in self.rows
                                      if r.access == "shadow")).any()
        with m.If(self._rejected(m, of_set, rejected, status["COMMITTED"])):
            m.d.sync += status["REFUSED"].eq(1)
        control = {flag.name: written["CTRL"] & word[flag.bit] for flag in action["CTRL"].flags}
        with m.If(control["START"] & self.running):
            m.d.sync += status["REFUSED"].eq(1)
        control["START"] = control["START"] & ~self.running | self.start
        flow = self._passes(m) if self.entries else (self.begin, self.ended, self.cut)
        self._frames(m, flow, take, copying, control, held, status)
        self._count(m, flow[1], counted)
        if not self.fixed:
            self._altered(m, written, store_written, altered)
        m.d.comb += [self.irq.eq(status["DONE"] & held["IRQ_ENABLE"]),
                     status["BANK"].eq(self.active.VALID_BANK),
                     status["FAULT"].eq(Cat(fault.values()).any())]
        return m

    def _accesses(self, m, copying):
        """Take one access of the bus at a time, none while ``copying``.

        It is registered first, then goes to its register: address and word are held
        until its end. Returns both, whether an access is under way, and its clocks as flags.
        """
        bus = self.bus
        address = Signal(ADDRESS_WORDS_BITS)        # address of the word that is accessed
        word = Signal(32)                           # the word to be written
        under_way = Signal()                        # an access has begun and is not over
        accept = Signal()                           # the bus may end the access
        free = ~under_way & ~copying
        with m.If(free):
            m.d.sync += [address.eq(bus.address), word.eq(bus.writedata),
                         under_way.eq(bus.write | bus.read)]
        write = self._steps(m, "write", bus.write & free)
        read = self._steps(m, "read", bus.read & free)
        m.d.sync += accept.eq(write[3] | read[3])
        m.d.comb += [bus.waitrequest.eq(~accept), bus.readdatavalid.eq(read[_VALID])]
        with m.If(accept):
            m.d.sync += under_way.eq(0)
        return address, word, under_way, write, read

    @staticmethod
    def _steps(m, name, begun):
        """The clocks of an access, as flags: that after ``begun`` and five more."""
        steps = [begun]
        for k in range(6):
            steps.append(register(m, f"{name}{k}", steps[-1], reset_less=False))
        return steps[1:]

    def _memories(self, m, access, take, committed, copying):
        """Join the words in memories to an ``access`` of the bus, with all its clocks of a write.

        Returns their read data, whether a weight is written, and whether a write to the list of
        views is ignored.
        """
        address, word, under_way, write = access
        stored, written, ignored = Const(0, signed(32)), Const(0), Const(0)
        if self.store:
            stored, written = self._store(m, write[2], committed)
        if self.entries:
            stored, ignored = self._entries(m, write[1], committed, stored)
        stores = [store for store in (self.store, self.entries) if store]
        for store in stores:
            m.d.comb += [store.address.eq(address), store.word.eq(word), store.held.eq(under_way),
                         store.take.eq(take)]
        if stores:
            m.d.comb += copying.eq(reduce(or_, (store.busy for store in stores)))
        return stored, written, ignored

    def _store(self, m, write, committed):
        """Connect the weights in memories; return their read data, and whether one is written."""
        m.submodules.store = store = self.store
        wiring.connect(m, store.writes, wiring.flipped(self.writes))
        m.d.comb += store.write.eq(write & ~committed)
        return store.read, write & store.mine

    def _entries(self, m, write, committed, stored):
        """Connect the list of views; return read data that include its own, and whether a write
        to it is ignored."""
        m.submodules.entries = entries = self.entries
        ready = ~(committed | entries.copying)
        m.d.comb += entries.write.eq(write & ready)
        with m.If(entries.loads):
            with m.Switch(entries.position):
                for k, name in enumerate(ENTRY_WORDS.values()):
                    with m.Case(k):
                        m.d.sync += self.active[name].eq(entries.value)
        return stored | entries.read, write & entries.mine & ~ready

    def _passes(self, m):
        """Make a pass of each frame; return when it begins, when it is over, and what it lacks."""
        m.submodules.views = views = self.passes
        begin = Signal(name="pass_begin")
        m.d.comb += [
            views.start.eq(begin), views.count.eq(self.active.VIEWS),
            self.entries.load.eq(views.load), self.entries.entry.eq(views.entry),
            views.loaded.eq(self.entries.loaded), self.begin.eq(views.begin),
            self.first.eq(views.first), views.ended.eq(self.ended), views.cut.eq(self.cut),
            views.abort.eq(self.abort), self.over.eq(views.over), self.lacks.eq(views.lacks)]
        return begin, views.over, views.lacks

    def _read(self, m, address, meant, stored, readable):
        """Select the word addressed: all others are masked, ``stored`` already is."""
        words = [Mux(meant[r.name], readable[r.name], 0) for r in self.rows] + [stored]
        fours = [register(m, f"word{k}", reduce(or_, words[k:k + 4]), signed(32))
                 for k in range(0, len(words), 4)]
        value = register(m, "value", reduce(or_, fours))
        if self.fixed:
            m.d.sync += self.bus.readdata.eq(value)
            return
        table = self.valid_table
        span = Cat(table.read_start, Const(0, 3), table.read_stop, Const(0, 3))
        m.d.sync += self.bus.readdata.eq(Mux(address >= TABLE, span, value))

    def _state(self):
        """States of the list of views and of the table of matrices by name, where they are."""
        state = {}
        if self.passes:
            state["VIEWS_STATE"] = Cat(Const(self.views, 8), self.passes.done)
        if self.view_rows:
            limit = Const(self.view_rows, range(MAX_MATRICES + 1))
            state[ROWS_STATUS] = Cat(limit, self.active[ROWS_BANK])
        return state

    def _keep(self, m, written, word, held, committed):
        """Write registers, unless the set is committed."""
        for r in self.rows:
            if r.name in held:
                with m.If(written[r.name] & ~(committed & (r.access == "shadow"))):
                    m.d.sync += held[r.name].eq(word)

    def _table(self, m, address, access, word, held, status):
        """The host's side of the table of valid rows, of which frames may use both banks.

        ``access``: the clocks of a write and of a read in which they reach it. Returns whether a
        write is rejected.
        """
        write, read = access
        written = register(m, "table_written", write & (address >= TABLE), reset_less=False)
        window = held["VALID_WINDOW"]
        in_use = self._bank_held(window, "VALID_BANK", held, status)
        table = self.valid_table
        m.d.comb += [
            table.bank.eq(window),
            Cat(table.span, table.row).eq(address),
            table.write.eq(written & ~in_use),
            table.read.eq(read),
            table.start.eq(word[:16]),
            table.stop.eq(word[16:]),
        ]
        return written & in_use

    def _rows(self, m, address, write, word, held, status):
        """Write to a view's table of matrices; returns whether a write is rejected."""
        in_rows = register(m, "rows_written", write & (
            address[exact_log2(ROWS_TABLE):] == 1), reset_less=False)
        writes = self.row_writes
        in_use = self._bank_held(writes.bank, ROWS_BANK, held, status)
        m.d.comb += [Cat(writes.column, writes.row, writes.matrix, writes.bank).eq(address),
                     writes.word.eq(word), writes.write.eq(in_rows & ~in_use)]
        return in_rows & in_use

    def _bank_held(self, bank, name, held, status):
        """Whether frames use a ``bank``; ``name``: the register that chooses it."""
        return ((status["BUSY"] | status["PENDING"]) & (bank == self.active[name])
                | status["COMMITTED"] & (bank == held[name]))

    def _altered(self, m, written, store_written, altered):
        """Whether the lens may be another one than DIGEST's; a reset keeps the valid rows."""
        of_lens = Cat(store_written, *(
            written[r.name] for r in self.rows
            if r.access == "shadow" and r.name not in OUTSIDE_DIGEST))
        set_altered = Signal()                      # a register of the lens was written
        rows_altered = Signal(2, reset_less=True)   # a valid row was written, for each bank
        with m.If(of_lens.any()):
            m.d.sync += set_altered.eq(1)
        with m.If(self.valid_table.write):
            m.d.sync += rows_altered.bit_select(self.valid_table.bank, 1).eq(1)
        m.d.comb += altered.eq(
            set_altered | rows_altered.bit_select(self.active.VALID_BANK, 1))

    def _rejected(self, m, of_set, of_table, committed):
        """Whether a write was ignored, two clocks later."""
        of_set = register(m, "shadow_written", of_set, reset_less=False)
        was_committed = register(m, "was_committed", committed, reset_less=False)
        return register(m, "ignored", of_set & was_committed, reset_less=False) \
            | delay(m, of_table, 2, "table_ignored", reset_less=False)

    def _frames(self, m, flow, take, copying, control, held, status):
        """Begin and end frames; a committed set becomes active between two of them."""
        begin, ended, cut = flow
        busy, pending, committed = (status[name] for name in ("BUSY", "PENDING", "COMMITTED"))
        asked = Signal()        # an abort was requested while a frame ran or waited
        # A frame may begin, or a set become active, in the next clock.
        boundary = (~busy | ended) & ~begin & ~(committed & copying)
        m.d.sync += [begin.eq(pending & boundary), take.eq(committed & boundary & ~take)]
        self._take_over(m, take, held)
        m.d.comb += [self.abort.eq(asked & busy), self.idle.eq(~busy & ~pending)]
        with m.If(take):
            m.d.sync += committed.eq(0)
        with m.If(begin):
            m.d.sync += [busy.eq(1), pending.eq(0)]
        with m.If(control["START"]):
            m.d.sync += pending.eq(1)
        with m.If(control["COMMIT"]):
            m.d.sync += committed.eq(1)
        with m.If(control["ABORT"]):
            m.d.sync += asked.eq(busy | pending)
        with m.If(ended):
            m.d.sync += [busy.eq(0), status["DONE"].eq(1), asked.eq(0),
                         status["ABORTED"].eq(cut)]

    def _count(self, m, ended, counted):
        """Store the counters of the frame that has ended."""
        ended = delay(m, ended, 2, "ended", reset_less=False)
        with m.If(ended):
            m.d.sync += counted["FRAMES"].eq(counted["FRAMES"] + 1)
            m.d.sync += [counted[name].eq(self.counters[name]) for name in self.counting]

    def _take_over(self, m, when, held):
        """Copy the whole set to ``active`` in the clocks in which ``when`` is high."""
        with m.If(when):
            m.d.sync += [self.active[name].eq(held[name]) for name, _ in self.active.shape()
                         if name in held]
