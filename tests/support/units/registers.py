"""The corrector's registers alone: a host at their bus, and frames that begin and end."""

import numpy as np

from ncdc_spec.registers.register_map import (
    CTRL_ABORT,
    CTRL_COMMIT,
    CTRL_START,
    STATUS_ABORTED,
    STATUS_BANK,
    STATUS_BUSY,
    STATUS_COMMITTED,
    STATUS_DONE,
    STATUS_FAULT,
    STATUS_PENDING,
    STATUS_REFUSED,
    TABLE,
)
from ncdc_spec.view_list import ENTRY_WORDS, entry_register
from pipelines import run_bench
from register_contract import Host, cut

__all__ = ["check_registers"]

_ONES = 0xFFFFFFFF
_TIMEOUT = 400          # clocks until a frame begins
_COUNTS = 1, 3, 2, 0, 11, 3     # views of the passes; of a wrong number the first one is made


class _Session:
    """A host, what it has written, and what the registers must hold."""

    def __init__(self, ctx, dut, rng):
        self.ctx, self.dut, self.rng, self.host = ctx, dut, rng, Host(ctx, dut.bus)
        self.rows = {r.name: r for r in dut.table}
        self.set = [r for r in dut.table if r.access == "shadow"]
        self.held = {r.name: dut.values.get(r.name, 0) for r in dut.table
                     if r.access in ("rw", "shadow")}
        for view in range(dut.views):           # each the one of configuration
            self.held |= {entry_register(view, word): dut.values.get(of_set, 0)
                          for word, of_set in ENTRY_WORDS.items()}
        self.active = dict(self.held)
        self.table_writes = []          # (bank, row, span, start, stop) that reached the table

    async def write(self, name, value):
        """Write a register that takes it."""
        await self.host.write(self.rows[name].address, value)
        self.note(name, cut(self.rows[name], value))

    def note(self, name, value):
        """Keep a value, that of a set's word of the first view under both names."""
        of_first = {entry_register(0, word): of_set for word, of_set in ENTRY_WORDS.items()}
        pairs = of_first | {of_set: word for word, of_set in of_first.items()}
        self.held[name] = value
        if pairs.get(name) in self.held:
            self.held[pairs[name]] = value

    async def read(self, name):
        return await self.host.read(self.rows[name].address)

    async def control(self, bits):
        await self.host.write(self.rows["CTRL"].address, bits)
        await self.ctx.tick().repeat(3)

    async def status(self):
        """STATUS without the active bank, and without what the last pass lacked."""
        return await self.read("STATUS") & ~(STATUS_BANK | STATUS_ABORTED)

    async def clear(self, bits=STATUS_DONE | STATUS_REFUSED):
        await self.host.write(self.rows["STATUS"].address, bits)

    async def check_all(self, more=()):
        """All registers read what they hold; ``more``: (name, value) of others."""
        for name, value in (*self.held.items(), *dict(more).items()):
            assert await self.read(name) == value & _ONES, name

    async def begun(self):
        """Wait for a frame to begin."""
        for _ in range(_TIMEOUT):
            if self.ctx.get(self.dut.begin):
                await self.ctx.tick()
                return
            await self.ctx.tick()
        raise AssertionError("no frame begins")

    def check_active(self, view):
        """Whether ``active`` is the set as it was committed, with the words of a ``view``."""
        words = {of_set: self.active[entry_register(view, word)]
                 for word, of_set in ENTRY_WORDS.items()}
        for name, _ in self.dut.active.shape():
            expected = (self.active | words)[name]
            assert self.ctx.get(self.dut.active[name]) == expected, (name, view)

    async def end(self, lacks, over):
        """One view ends; whether the pass is ``over``, and lacks pixels."""
        ctx, dut = self.ctx, self.dut
        counted = {name: int(self.rng.integers(1 << self.rows[name].shape.width))
                   for name in dut.counting}
        ctx.set(dut.counters, counted)
        ctx.set(dut.ended, 1)
        ctx.set(dut.cut, lacks)
        await ctx.delay(1e-9)
        assert ctx.get(dut.over) == over
        await ctx.tick()
        ctx.set(dut.ended, 0)
        ctx.set(dut.cut, 0)
        await ctx.tick().repeat(3)
        ctx.set(dut.counters, dict.fromkeys(counted, 0))
        return counted


async def _rejected_writes(session, names):
    """While a set is committed no write to it counts, and each is reported."""
    for name in names:
        await session.host.write(session.rows[name].address, ~session.held[name])
        assert await session.status() & STATUS_REFUSED, name
        await session.clear(STATUS_REFUSED)
        assert not await session.status() & STATUS_REFUSED, name


async def _valid_rows(session, banks_in_use):
    """Writes to both banks of valid rows, of which some are in use."""
    rng, before = session.rng, len(session.table_writes)
    expected = []
    for bank in (0, 1, int(rng.integers(2))):
        await session.write("VALID_WINDOW", bank)
        word, row = int(rng.integers(1 << 32)), int(rng.integers(1 << 13))
        await session.host.write(TABLE + row, word)
        in_use = bank in banks_in_use
        assert bool(await session.status() & STATUS_REFUSED) == in_use, (bank, banks_in_use)
        await session.clear(STATUS_REFUSED)
        if not in_use:
            bits = len(session.dut.valid_table.start)
            expected.append((bank, row >> 1, row & 1, word & (1 << bits) - 1,
                             word >> 16 & (1 << bits) - 1))
    assert session.table_writes[before:] == expected


async def _new_set(session):
    """Write any values to all registers of the set, in any order, and read them."""
    rng = session.rng
    for k in rng.permutation(len(session.set)):
        await session.write(session.set[k].name, int(rng.integers(1 << 32)))


async def _pass(session, number):
    """Commit, start and make the views of a pass, with accesses of all kinds in the first one."""
    rng, dut, count = session.rng, session.dut, _COUNTS[number % len(_COUNTS)]
    await session.write("VIEWS", count)
    await session.write("IRQ_ENABLE", number & 1)
    if number % 2:
        await session.control(CTRL_ABORT)       # nothing runs: it must not end the next pass
    await session.control(CTRL_COMMIT)
    session.active = dict(session.held)
    await session.ctx.tick().repeat(2 * session.dut.store.words)
    assert await session.status() == 0
    by_pin = number % 3 == 2
    session.ctx.set(dut.running, by_pin)
    await session.control(CTRL_START)
    if by_pin:
        assert await session.status() == STATUS_REFUSED
        await session.clear()
        session.ctx.set(dut.start, 1)
        await session.ctx.tick()
        session.ctx.set(dut.start, 0)
        session.ctx.set(dut.running, 0)
    views, lacked = count if count in range(1, dut.views + 1) else 1, 0
    aborted = number % 4 == 3
    for view in range(views):
        await session.begun()
        session.check_active(view)
        assert session.ctx.get(dut.first) == (view == 0) and not session.ctx.get(dut.abort)
        if view == 0:
            await _first_view(session, number)
        if aborted:
            await session.control(CTRL_ABORT)
            assert session.ctx.get(dut.abort)
        lacks = int(rng.random() < .3)
        lacked |= lacks
        over = aborted or view == views - 1
        counted = await session.end(lacks, over)
        if over:
            break
    assert session.ctx.get(dut.irq) == number & 1 and not session.ctx.get(dut.abort)
    return counted, lacked, view + 1


async def _first_view(session, number):
    """What a host does while a view is made: the next set, rejected writes, valid rows."""
    rng = session.rng
    bank = session.active["VALID_BANK"]
    assert await session.read("STATUS") & ~STATUS_ABORTED == STATUS_BUSY | STATUS_BANK * bank
    await _valid_rows(session, {bank})
    await _new_set(session)
    assert await session.status() == STATUS_BUSY
    await session.control(CTRL_COMMIT)
    assert await session.status() == STATUS_BUSY | STATUS_COMMITTED
    names = [r.name for r in session.set]
    await _rejected_writes(session, names if number == 1 else rng.choice(names, 6))
    await _valid_rows(session, {bank, session.held["VALID_BANK"]})
    await session.check_all()
    assert await session.status() == STATUS_BUSY | STATUS_COMMITTED


async def _aliases(session):
    """Addresses next to those of registers are none themselves."""
    known = {r.address for r in session.rows.values()}
    for register in session.rows.values():
        for bit in range(TABLE.bit_length() - 1):
            address = register.address | 1 << bit
            if address not in known:
                assert await session.host.read(address) == 0, hex(address)


async def _table_reads(session):
    """Reads of valid rows: the bank, row and span that are asked for, and the answer."""
    ctx, table = session.ctx, session.dut.valid_table
    for _ in range(8):
        start, stop, row = (int(session.rng.integers(1 << 13)) for _ in range(3))
        ctx.set(table.read_start, start)
        ctx.set(table.read_stop, stop)
        assert await session.host.read(TABLE + row) == start | stop << 16


async def _fault_flags(session):
    """Each fault is stored until it is cleared, and is in STATUS."""
    ctx, dut = session.ctx, session.dut
    names = [name for name, _ in dut.faults.shape()]
    for k, name in enumerate(names):
        ctx.set(dut.faults[name], 1)
        await ctx.tick()
        ctx.set(dut.faults[name], 0)
        assert await session.read("FAULT") == 1 << k
        assert await session.status() & STATUS_FAULT
        await session.host.write(session.rows["FAULT"].address, _ONES ^ 1 << k)
        assert await session.read("FAULT") == 1 << k
        await session.host.write(session.rows["FAULT"].address, 1 << k)
        assert await session.read("FAULT") == 0


def check_registers(dut, passes=7, seed=1):
    """Registers, lists of views and valid rows, of passes one after the other.

    ``dut``: a :class:`ncdc_hdl.registers.agent.Registers` with all options.
    """
    async def bench(ctx):
        session = sessions[0] = _Session(ctx, dut, np.random.default_rng(seed))
        for r in dut.table:
            expected = dut.constants.get(r.name, session.held.get(r.name, 0))
            if r.name == "VIEWS_STATE":
                expected = dut.views
            assert await session.read(r.name) == expected & _ONES, r.name
        await _new_set(session)
        await session.check_all({"ALTERED": 1})
        await _fault_flags(session)
        for number in range(passes):
            counted, lacked, done = await _pass(session, number)
            session.active = dict(session.held)     # the next set was committed meanwhile
            assert await session.read("STATUS") & ~STATUS_BANK == (
                STATUS_DONE | STATUS_ABORTED * lacked)
            await session.check_all({
                "FRAMES": number + 1, "VIEWS_STATE": dut.views | done << 8,
                **counted})
            await _table_reads(session)
            await session.clear()
        await _aliases(session)
        await _pending(session)

    async def watch(ctx):
        table = dut.valid_table
        async for _, _, write, *row in ctx.tick().sample(
                table.write, table.bank, table.row, table.span, table.start, table.stop):
            if write:
                sessions[0].table_writes.append(tuple(map(int, row)))

    sessions = [None]
    run_bench(dut, bench, background=(watch,))


async def _pending(session):
    """A start while a frame runs waits for its end; so does its bank of valid rows."""
    await session.write("VIEWS", 1)
    await session.control(CTRL_COMMIT | CTRL_START)
    session.active = dict(session.held)
    for later in (CTRL_START, 0):
        await session.begun()
        session.check_active(0)
        await session.control(later)
        await _valid_rows(session, {session.active["VALID_BANK"]})
        assert await session.status() & ~STATUS_DONE == STATUS_BUSY | STATUS_PENDING * bool(later)
        await session.end(0, 1)
    assert await session.status() == STATUS_DONE
