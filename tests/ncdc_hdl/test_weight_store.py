"""Weights in memories: for the host the registers that they were, for frames whole sets."""

import numpy as np
import pytest
from amaranth import *

from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import (
    CTRL_COMMIT,
    CTRL_START,
    STATUS_BUSY,
    STATUS_COMMITTED,
    STATUS_DONE,
    STATUS_REFUSED,
)
from pipelines import run_bench
from register_contract import (
    BY_NAME,
    SHADOW_ROWS,
    Contract,
    D,
    Dut,
    Host,
    RandomWrites,
    control,
    end_frame,
    run,
    status,
    wait,
)

VALUES = host_values(D)
STORED = [BY_NAME[name] for name in Dut(2).names.values()]


async def banks_show(ctx, dut, values):
    """Each of the words in memories that frames use is that of ``values``."""
    for turn in range(dut.share):
        ctx.set(dut.turn, turn)
        await ctx.tick()
        shown = dut.shown(ctx, turn)
        assert shown and shown == {name: values[name] for name in shown}


def test_which_words_lie_in_memories():
    assert len(STORED) == 5 * 3 and not Dut(1).names
    assert all(r.name.startswith("HIDDEN") or "_WEIGHT" in r.name for r in STORED)


@pytest.mark.parametrize("share", [2, 3])
def test_every_word_keeps_every_bit_and_each_its_own(share):
    """After configuration that of the descriptor, then what is written, and nothing elsewhere."""
    async def bench(ctx, dut, host):
        rng = np.random.default_rng(1)
        for name in VALUES:
            assert await host.read(BY_NAME[name].address) == VALUES[name] & 0xFFFFFFFF, name
        written = {r.name: int(rng.integers(0, 1 << 32)) for r in SHADOW_ROWS}
        for name, word in written.items():
            await host.write(BY_NAME[name].address, word)
        for address in (0x103, 0x10C, 0x17C, 0x202, 0x20C, 0x300, 0x500, 0x180):
            await host.write(address, 0xFFFFFFFF)
            assert await host.read(address) == 0, hex(address)
        for name, value in written.items():
            shape = BY_NAME[name].shape
            value &= (1 << shape.width) - 1
            if shape.signed and value >> (shape.width - 1):
                value -= 1 << shape.width
            assert await host.read(BY_NAME[name].address) == value & 0xFFFFFFFF, name

    run(bench, share)


@pytest.mark.parametrize("r", STORED, ids=lambda r: r.name)
def test_a_committed_word_rejects_writes(r):
    async def bench(ctx, dut, host):
        before = VALUES[r.name] & 0xFFFFFFFF
        await control(ctx, host, CTRL_START)
        await control(ctx, host, CTRL_COMMIT)
        await host.write(r.address, ~before)
        assert await host.read(r.address) == before
        assert await status(host) == STATUS_BUSY | STATUS_COMMITTED | STATUS_REFUSED
        await end_frame(ctx, dut)
        await ctx.tick()
        await host.write(r.address, ~before)
        assert await host.read(r.address) != before
        assert await status(host) == STATUS_DONE | STATUS_REFUSED
        assert await host.read(BY_NAME["ALTERED"].address) == 1

    run(bench, 2)


@pytest.mark.longer
@pytest.mark.parametrize("share,seed", [
    (3, 2), *(pytest.param(2, seed, marks=pytest.mark.regress) for seed in (1, 3, 4))])
def test_random_host_and_the_contract(share, seed):
    """What a frame sees is constant while it runs and a whole set as it was when committed, word by
    word in every clock; the host's set is what it wrote, whatever is copied meanwhile."""
    dut = Dut(share)
    registers = dut.registers

    async def bench(ctx):
        rng = np.random.default_rng(seed)
        writes, contract = RandomWrites(rng), Contract(
            {r.name: VALUES[r.name] for r in SHADOW_ROWS}, registers.store.words)
        for clock in range(5000):
            writes.choose(rest=clock >= 4900)
            ended = contract.busy and rng.random() < 0.02
            ctx.set(registers.ended, ended)
            under_way, restored = writes.age > 0, contract.copies <= contract.words
            write = writes.drive(ctx, registers.bus, contract.copies > 0)
            assert ctx.get(registers.begin) == contract.begin
            turn, active = int(rng.integers(share)), contract.active
            ctx.set(dut.turn, turn)
            contract.step(write, writes.address, writes.value, ended, under_way)
            await ctx.tick()
            shown = dut.shown(ctx, turn) if restored and clock > 2 * contract.words else {}
            assert shown == {name: active[name] for name in shown}
        ctx.set(registers.bus.write, 0)
        host = Host(ctx, registers.bus)
        for name, value in contract.held.items():
            assert await host.read(BY_NAME[name].address) == value & 0xFFFFFFFF, name
        assert contract.commits > 10 and contract.rejected and contract.waits > 100

    run_bench(dut, bench)


@pytest.mark.parametrize("moment", [1, 2, 5, 30, 31, 32, 33, 34, 40])
@pytest.mark.parametrize("clocks", [1, pytest.param(7, marks=pytest.mark.regress)])
def test_a_reset_in_the_middle_of_a_copy(moment, clocks):
    """Every word is then that of configuration: the host's, the frames', and after a commit too."""
    dut = Dut(2)

    async def bench(ctx):
        host, registers = Host(ctx, dut.registers.bus), dut.registers
        for k in range(2):
            for r in STORED:
                await host.write(r.address, 0x12345 * (k + 1))
            await host.write(BY_NAME["CTRL"].address, CTRL_COMMIT)
            await wait(ctx, 3 + registers.store.words * (1 - k))
        await wait(ctx, moment)
        for _ in range(2):                  # the second one while the reset's values are copied
            ctx.set(dut.rst, 1)
            await wait(ctx, clocks)
            ctx.set(dut.rst, 0)
            await wait(ctx, moment)
        assert await status(host) == 0
        await banks_show(ctx, dut, VALUES)
        for r in STORED:
            assert await host.read(r.address) == VALUES[r.name] & 0xFFFFFFFF
        await control(ctx, host, CTRL_COMMIT)
        await banks_show(ctx, dut, VALUES)

    run_bench(dut, bench)


def test_one_word_of_a_later_set_changes_only_that():
    """What is not written keeps its value from set to set, although the banks alternate."""
    dut = Dut(2)

    async def bench(ctx):
        host, values = Host(ctx, dut.registers.bus), dict(VALUES)
        for k, r in enumerate(STORED):
            values[r.name] = k + 1
            await host.write(r.address, k + 1)
            await host.write(BY_NAME["CTRL"].address, CTRL_COMMIT | CTRL_START)
            await wait(ctx, 3)
            await banks_show(ctx, dut, values)
            await end_frame(ctx, dut.registers)

    run_bench(dut, bench)


def test_a_frame_begins_in_the_clock_after_the_last_one():
    """With a commit, as soon as the copy of the one before is over."""
    async def bench(ctx, dut, host):
        await control(ctx, host, CTRL_START)
        for _ in range(3):
            await host.write(STORED[0].address, 77)
            await control(ctx, host, CTRL_START | CTRL_COMMIT)
            assert not ctx.get(dut.begin)
            await end_frame(ctx, dut)
            bank = ctx.get(dut.writes.active)
            assert ctx.get(dut.begin)
            await ctx.tick()
            assert ctx.get(dut.writes.active) != bank

    run(bench, 2)


@pytest.mark.longer
def test_a_repeated_commit_at_the_boundary_costs_the_copy_only():
    """COMMIT is written again in the very clocks in which the first one is taken over."""
    for lead in range(8):
        async def bench(ctx, dut, host, lead=lead):
            await control(ctx, host, CTRL_START)
            await host.write(STORED[0].address, 5)
            await control(ctx, host, CTRL_COMMIT)
            ctx.set(dut.bus.address, BY_NAME["CTRL"].address)
            ctx.set(dut.bus.writedata, CTRL_COMMIT | CTRL_START)
            for k in range(9):
                ctx.set(dut.bus.write, k < 6)
                ctx.set(dut.ended, k == lead)
                await ctx.tick()
            await wait(ctx, 2 * dut.store.words)
            running = await status(host)
            assert running & STATUS_BUSY
            if running & STATUS_COMMITTED:
                await end_frame(ctx, dut)
                await wait(ctx, 3)
            assert not await status(host) & STATUS_COMMITTED
            assert await host.read(STORED[0].address) == 5

        run(bench, 2)


