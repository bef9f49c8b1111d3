"""The register agent: read-back, shadowing, frames, the table of valid rows."""

import numpy as np
import pytest

from ncdc_spec.registers.host_values import host_values, table_words
from ncdc_spec.registers.register_map import (
    CTRL_ABORT,
    CTRL_COMMIT,
    CTRL_START,
    ID,
    STATUS_ABORTED,
    STATUS_BANK,
    STATUS_BUSY,
    STATUS_COMMITTED,
    STATUS_DONE,
    STATUS_PENDING,
    STATUS_REFUSED,
    TABLE,
    registers,
)
from ncdc_spec.view_rows import ROWS_TABLE
from register_contract import (
    BY_NAME,
    ROWS,
    SHADOW_ROWS,
    Contract,
    D,
    RandomWrites,
    control,
    end_frame,
    run,
    status,
    wait,
)


def test_addresses_and_names_are_unique():
    assert len({r.address for r in ROWS}) == len(ROWS) == len(BY_NAME)
    assert max(r.address for r in registers(32, D.formats)) < TABLE


def test_reset_values_are_the_descriptor():
    async def bench(ctx, dut, host):
        assert await host.read(BY_NAME["ID"].address) == ID
        assert await host.read(BY_NAME["DIGEST"].address) == int(D.digest[:8], 16)
        assert await host.read(BY_NAME["NEURONS"].address) == 3
        for name, value in host_values(D).items():
            assert await host.read(BY_NAME[name].address) == value & 0xFFFFFFFF, name
        for address, value in table_words(D.valid):
            assert await host.read(address) == value, hex(address)

    run(bench)


def test_every_writable_register_keeps_every_bit():
    async def bench(ctx, dut, host):
        rng = np.random.default_rng(1)
        written = {}
        for r in ROWS:
            if r.access in ("rw", "shadow"):
                written[r.name] = int(rng.integers(0, 1 << 32))
                await host.write(r.address, written[r.name])
        for name, value in written.items():
            shape = BY_NAME[name].shape
            value &= (1 << shape.width) - 1
            if shape.signed and value >> (shape.width - 1):
                value -= 1 << shape.width
            assert await host.read(BY_NAME[name].address) == value & 0xFFFFFFFF, name

    run(bench)


def test_shadow_registers_change_at_a_commit_only():
    async def bench(ctx, dut, host):
        assert await status(host) == 0
        assert ctx.get(dut.active.CORRECTED_WIDTH) == D.geometry.corrected_width, "reset value"
        await host.write(BY_NAME["FILL"].address, 0xABCDEF)
        await control(ctx, host, CTRL_START)
        assert ctx.get(dut.active.FILL) == 0, "taken over without a commit"
        assert await status(host) == STATUS_BUSY
        await control(ctx, host, CTRL_COMMIT)
        assert ctx.get(dut.active.FILL) == 0, "changed in the middle of a frame"
        assert await status(host) == STATUS_BUSY | STATUS_COMMITTED
        await control(ctx, host, CTRL_START)
        assert await status(host) == STATUS_BUSY | STATUS_PENDING | STATUS_COMMITTED
        ctx.set(dut.counters.CLOCKS, 1234)
        await end_frame(ctx, dut)
        # No clock is lost: the waiting frame begins in the first clock without one.
        assert ctx.get(dut.begin) and ctx.get(dut.active.FILL) == 0
        await ctx.tick()
        assert ctx.get(dut.active.FILL) == 0xABCDEF and not ctx.get(dut.begin)
        assert await status(host) == STATUS_BUSY | STATUS_DONE
        assert await host.read(BY_NAME["CLOCKS"].address) == 1234
        assert await host.read(BY_NAME["FRAMES"].address) == 1
        assert not ctx.get(dut.irq)
        await host.write(BY_NAME["IRQ_ENABLE"].address, 1)
        assert ctx.get(dut.irq)
        await host.write(BY_NAME["STATUS"].address, STATUS_DONE)
        assert not ctx.get(dut.irq) and await status(host) == STATUS_BUSY

    run(bench)


def test_a_commit_without_a_frame_acts_at_once():
    async def bench(ctx, dut, host):
        await host.write(BY_NAME["FILL"].address, 5)
        await host.write(BY_NAME["VALID_BANK"].address, 1)
        await control(ctx, host, CTRL_COMMIT)
        assert ctx.get(dut.active.FILL) == 5 and not ctx.get(dut.begin)
        assert await status(host) == STATUS_BANK
        await host.write(BY_NAME["FILL"].address, 6)
        await host.write(BY_NAME["CTRL"].address, CTRL_COMMIT | CTRL_START)
        assert ctx.get(dut.active.FILL) == 6
        assert await status(host) == STATUS_BANK | STATUS_BUSY

    run(bench)


@pytest.mark.parametrize("name", [r.name for r in ROWS if r.access == "shadow"])
def test_a_committed_set_rejects_writes(name):
    """No register of the set can change between the commit and the frame boundary."""
    async def bench(ctx, dut, host):
        address = BY_NAME[name].address
        before = await host.read(address)
        await control(ctx, host, CTRL_START)
        await control(ctx, host, CTRL_COMMIT)
        await host.write(address, ~before)
        assert await host.read(address) == before
        assert await status(host) == STATUS_BUSY | STATUS_COMMITTED | STATUS_REFUSED
        await host.write(BY_NAME["STATUS"].address, STATUS_REFUSED)
        await end_frame(ctx, dut)
        await ctx.tick()
        assert await status(host) == STATUS_DONE
        await host.write(address, ~before)
        assert await host.read(address) != before
        assert await status(host) == STATUS_DONE

    run(bench)


def test_valid_rows_in_use_reject_writes():
    """A running frame holds one of the two banks, a committed set the other."""
    async def bench(ctx, dut, host):
        async def takes(bank, span):
            await host.write(BY_NAME["VALID_WINDOW"].address, bank)
            await host.write(TABLE + 6, span)
            taken = await host.read(TABLE + 6) == span
            assert bool(await status(host) & STATUS_REFUSED) != taken
            await host.write(BY_NAME["STATUS"].address, STATUS_REFUSED)
            return taken

        assert await takes(0, 1) and await takes(1, 2)
        await control(ctx, host, CTRL_START)
        assert not await takes(0, 3) and await takes(1, 4)
        await host.write(BY_NAME["VALID_BANK"].address, 1)
        assert not await takes(0, 5) and await takes(1, 6)
        await control(ctx, host, CTRL_COMMIT)
        assert not await takes(0, 7) and not await takes(1, 8)
        await end_frame(ctx, dut)
        await ctx.tick()
        assert await takes(0, 9) and await takes(1, 10)
        await control(ctx, host, CTRL_START)
        assert await takes(0, 11) and not await takes(1, 12)

    run(bench)


@pytest.mark.parametrize("lead", range(5))
def test_a_commit_at_the_frame_boundary_is_whole(lead):
    """Wherever a commit falls about the boundary, the frame has all of the set or nothing."""
    async def bench(ctx, dut, host):
        await control(ctx, host, CTRL_START)
        await control(ctx, host, CTRL_START)
        await host.write(BY_NAME["FILL"].address, 77)
        await host.write(BY_NAME["VALID_BANK"].address, 1)
        bus = dut.bus
        ctx.set(bus.address, BY_NAME["CTRL"].address)
        ctx.set(bus.writedata, CTRL_COMMIT)
        # A commit counts in the third clock of its write.
        for k in range(12):
            ctx.set(bus.write, lead <= k < lead + 6)
            ctx.set(dut.ended, k == 5)
            await ctx.tick()
        taken = ctx.get(dut.active.FILL) == 77
        assert taken == (ctx.get(dut.active.VALID_BANK) == 1) == (lead <= 2)
        assert bool(await status(host) & STATUS_COMMITTED) != taken
        await end_frame(ctx, dut)
        await ctx.tick()
        assert ctx.get(dut.active.FILL) == 77 and ctx.get(dut.active.VALID_BANK) == 1

    run(bench)


@pytest.mark.longer
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.regress)])
def test_random_host_and_the_contract(seed):
    """Writes, starts, commits and ends of frames in any order: what a frame sees is constant while
    it runs, and is a whole set as it was when committed; no valid row of its bank is written."""
    async def bench(ctx, dut, host):
        rng = np.random.default_rng(seed)
        writes = RandomWrites(rng)
        contract = Contract({r.name: ctx.get(dut.active[r.name]) for r in SHADOW_ROWS})
        for clock in range(6000):
            writes.choose(rest=clock >= 5990)
            ended = contract.busy and rng.random() < 0.02
            ctx.set(dut.ended, ended)
            under_way = writes.age > 0
            write = writes.drive(ctx, dut.bus, copying=False)
            assert ctx.get(dut.begin) == contract.begin
            row_taken = contract.step(write, writes.address, writes.value, ended, under_way)
            assert ctx.get(dut.valid_table.write) == row_taken
            await ctx.tick()
            assert {name: ctx.get(dut.active[name]) for name in contract.active} == contract.active
        ctx.set(dut.bus.write, 0)
        ctx.set(dut.ended, 0)
        assert bool(await status(host) & STATUS_REFUSED) == contract.rejected
        for name, value in contract.held.items():
            assert await host.read(BY_NAME[name].address) == value & 0xFFFFFFFF, name
        assert contract.commits > 10 and contract.rejected and contract.waits > 100

    run(bench)


def test_banks_of_the_table_are_separate():
    async def bench(ctx, dut, host):
        await host.write(BY_NAME["VALID_WINDOW"].address, 1)
        await host.write(TABLE + 2 * 5 + 1, 7 | 9 << 16)
        assert await host.read(TABLE + 2 * 5 + 1) == 7 | 9 << 16
        assert await host.read(TABLE + 2 * 5) == dict(table_words(D.valid))[TABLE + 10]
        await host.write(BY_NAME["VALID_WINDOW"].address, 0)
        assert await host.read(TABLE + 2 * 5 + 1) == dict(table_words(D.valid))[TABLE + 11]

    run(bench)


def test_a_table_of_matrices_is_written_whole():
    """A running frame holds one of its two banks, a committed set the other; each write of a number
    goes to its place."""
    rows = {r.name: r.address for r in registers(3, D.formats, view=True, view_rows=20)}

    async def bench(ctx, dut, host):
        seen = []

        async def takes(bank):
            await host.write(ROWS_TABLE + 1024 * bank + 16 * 19 + 4 * 2 + 1, -5)
            taken = bool(seen)
            if taken:
                assert seen.pop() == (bank, 19, 2, 1, -5) and not seen
            assert bool(await status(host) & STATUS_REFUSED) != taken
            await host.write(rows["STATUS"], STATUS_REFUSED)
            return taken

        writes = dut.row_writes
        tick = ctx.tick

        def watched():
            if ctx.get(writes.write):
                seen.append(tuple(ctx.get(getattr(writes, name)) for name in (
                    "bank", "matrix", "row", "column", "word")))
            return tick()

        ctx.tick = watched
        assert await takes(0) and await takes(1)
        await control(ctx, host, CTRL_START)
        assert not await takes(0) and await takes(1)
        await host.write(rows["VIEW_ROWS_BANK"], 1)
        await control(ctx, host, CTRL_COMMIT)
        assert not await takes(0) and not await takes(1)
        assert await host.read(rows["VIEW_ROWS_STATUS"]) == 20
        await end_frame(ctx, dut)
        await ctx.tick()
        assert await host.read(rows["VIEW_ROWS_STATUS"]) == 20 | 128
        await control(ctx, host, CTRL_START)
        assert await takes(0) and not await takes(1)
        assert await host.read(ROWS_TABLE + 16) == 0 == await host.read(rows["ALTERED"])

    run(bench, view_rows=20)


@pytest.mark.parametrize("address", [0x7F, 0x1F00])
def test_unused_addresses_read_zero(address):
    async def bench(ctx, dut, host):
        await host.write(address, 0xFFFFFFFF)
        assert await host.read(address) == 0

    run(bench)


def test_an_abort_right_after_the_start_counts():
    """The start's frame begins in the very clock in which the abort arrives."""
    async def bench(ctx, dut, host):
        await host.write(BY_NAME["CTRL"].address, CTRL_START)
        await host.write(BY_NAME["CTRL"].address, CTRL_ABORT)
        await wait(ctx, 3)
        assert ctx.get(dut.abort) and await status(host) == STATUS_BUSY

    run(bench)


def test_an_abort_concerns_the_frame_that_runs():
    """It is held until that frame has ended; without one, and for the next one, it is nothing."""
    async def bench(ctx, dut, host):
        async def control(value):
            await host.write(BY_NAME["CTRL"].address, value)
            await wait(ctx, 3)

        async def end(cut):
            ctx.set(dut.cut, cut)
            ctx.set(dut.ended, 1)
            await ctx.tick()
            ctx.set(dut.ended, 0)
            await wait(ctx, 3)

        async def status():
            return await host.read(BY_NAME["STATUS"].address)

        await control(CTRL_ABORT)
        assert not ctx.get(dut.abort)
        await control(CTRL_START | CTRL_ABORT)
        assert not ctx.get(dut.abort) and await status() == STATUS_BUSY
        await control(CTRL_START | CTRL_ABORT)
        assert ctx.get(dut.abort) and await status() == STATUS_BUSY | STATUS_PENDING
        await end(1)
        assert not ctx.get(dut.abort)
        assert await status() == STATUS_BUSY | STATUS_DONE | STATUS_ABORTED
        await end(0)
        assert await status() == STATUS_DONE

    run(bench)
