"""The list of views in the register agent: entries, commits, a frame for each view of a pass."""

from dataclasses import replace

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring

from ncdc_hdl.frontend.valid import ValidTable
from ncdc_hdl.registers.agent import Registers
from ncdc_hdl.registers.view_store import ViewStore
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import (
    CTRL_ABORT,
    CTRL_COMMIT,
    CTRL_START,
    STATUS_ABORTED,
    STATUS_BUSY,
    STATUS_COMMITTED,
    STATUS_DONE,
    STATUS_REFUSED,
    listed,
    registers,
)
from ncdc_spec.view_list import ENTRY_WORDS, entry_register
from pipelines import run_bench
from register_contract import D as EVERY_PIXEL
from register_contract import Host, end_frame, wait

D = replace(EVERY_PIXEL, nodes=8)


class Dut(Elaboratable):
    """The registers of ``D`` with a list of so many ``views``, and the table of valid rows."""

    def __init__(self, views):
        self.views = views
        rows = registers(D.hidden_neurons, D.formats, D.nodes, view=True, views=views)
        self.rows = {r.name: r for r in rows}
        self.values = host_values(D, Hardware(view=True, views=views))
        self.registers = Registers(rows, self.values, {
            "DIGEST": 1, "NEURONS": 3, "NODES": 8, "CAPABILITIES": 7, "LARGEST": 9})
        self.table = ValidTable(D.valid, *D.geometry.corrected)
        self.rst = Signal()

    def elaborate(self, platform):
        m = Module()
        m.submodules.registers, m.submodules.table = self.registers, self.table
        wiring.connect(m, self.registers.valid_table, self.table.host)
        return ResetInserter(self.rst)(m)


class Driver:
    """A host with registers by name."""

    def __init__(self, ctx, dut):
        self.ctx, self.dut, self.host = ctx, dut, Host(ctx, dut.registers.bus)

    async def read(self, name):
        return await self.host.read(self.dut.rows[name].address)

    async def write(self, name, value):
        await self.host.write(self.dut.rows[name].address, value)

    async def begins(self):
        """Wait for the next frame; its words of the list."""
        registers = self.dut.registers
        for _ in range(200):
            if self.ctx.get(registers.begin):
                await self.ctx.tick()
                return self.active()
            await self.ctx.tick()
        raise AssertionError("no view begins")

    def active(self):
        return {word: self.ctx.get(self.dut.registers.active[name])
                for word, name in ENTRY_WORDS.items()}

    def stored(self, k, values):
        """What entry ``k`` keeps of register values."""
        kept = {}
        for word in ENTRY_WORDS:
            shape = self.dut.rows[entry_register(k, word)].shape
            value = values[entry_register(k, word)] & (1 << shape.width) - 1
            kept[word] = value - (1 << shape.width) * (shape.signed and value >> shape.width - 1)
        return kept


def run(bench, views=3):
    dut = Dut(views)

    async def testbench(ctx):
        await bench(ctx, dut, Driver(ctx, dut))

    run_bench(dut, testbench)


def configured(dut):
    """Values of all entries after configuration: those of the set, without offset and pitch."""
    return {entry_register(k, word): dut.values.get(name, 0)
            for k in range(dut.views) for word, name in ENTRY_WORDS.items()}


def random_list(rng, views):
    return {entry_register(k, word): int(rng.integers(0, 1 << 32))
            for k in range(views) for word in ENTRY_WORDS}


@pytest.mark.parametrize("views", [3, 8])
def test_every_entry_has_its_own_words_and_the_first_is_the_set(views):
    async def bench(ctx, dut, driver):
        for name, value in configured(dut).items():
            assert await driver.read(name) == value & 0xFFFFFFFF, name
        assert await driver.read("VIEWS") == 1 and await driver.read("VIEWS_STATE") == views
        words = random_list(np.random.default_rng(1), views)
        for name, value in words.items():
            await driver.write(name, value)
        for k in range(views):
            for word, value in driver.stored(k, words).items():
                assert await driver.read(entry_register(k, word)) == value & 0xFFFFFFFF
                if not k and word not in ("OFFSET", "PITCH"):
                    assert await driver.read(ENTRY_WORDS[word]) == value & 0xFFFFFFFF
        await driver.write("CORRECTED_WIDTH", 99)
        assert await driver.read("VIEW0_WIDTH") == 99
        for beyond in (0x400 + 16 * views, 0x480, 0xC00):
            await driver.host.write(beyond, 1)
            assert await driver.host.read(beyond) == 0
        assert not await driver.read("ALTERED")
        assert driver.active() == driver.stored(0, configured(dut)), "taken without a commit"
        # A reset gives the list its configuration, also the bank that no host has seen.
        ctx.set(dut.rst, 1)
        await ctx.tick()
        ctx.set(dut.rst, 0)
        await driver.write("VIEWS", views)
        await driver.write("CTRL", CTRL_COMMIT | CTRL_START)
        for k in range(views):
            assert await driver.begins() == driver.stored(k, configured(dut))
            await end_frame(ctx, dut.registers)
        assert await driver.read("VIEW1_WIDTH") == D.geometry.corrected_width

    run(bench, views)


def test_passes_of_random_lists():
    """While a pass runs the next list is written; each view has its own entry, of its own pass."""
    async def bench(ctx, dut, driver):
        rng, words, frames = np.random.default_rng(2), configured(dut), 0
        for number in range(12):
            count = int(rng.integers(1, dut.views + 1))
            changed = random_list(rng, dut.views)
            for name in rng.choice(list(changed), 20, replace=False).tolist():
                await driver.write(name, changed[name])
                words[name] = changed[name]
            await driver.write("VIEWS", count)
            assert number == 0 or await driver.read("STATUS") == STATUS_BUSY
            await driver.write("CTRL", CTRL_COMMIT | CTRL_START)
            if number:
                await end_frame(ctx, dut.registers)     # the last view of the pass before
            for k in range(count):
                assert await driver.begins() == driver.stored(k, words), (number, k)
                assert ctx.get(dut.registers.first) == (k == 0)
                if k + 1 < count:
                    await wait(ctx, int(rng.integers(3, 90)))
                    assert not ctx.get(dut.registers.irq)
                    await end_frame(ctx, dut.registers)
            frames += number > 0
            assert await driver.read("VIEWS_STATE") == dut.views | (count - 1) << 8
            assert await driver.read("FRAMES") == frames
            assert await driver.read("STATUS") == STATUS_BUSY | (STATUS_DONE if number else 0)
            await driver.write("STATUS", STATUS_DONE)

    run(bench)


@pytest.mark.parametrize("count,views", [(0, 1), (4, 1), (15, 1), (3, 3)])
def test_a_number_of_views_beyond_its_limits_has_one(count, views):
    async def bench(ctx, dut, driver):
        await driver.write("VIEWS", count)
        await driver.write("CTRL", CTRL_COMMIT | CTRL_START)
        for _ in range(views):
            await driver.begins()
            assert await driver.read("STATUS") == STATUS_BUSY
            await end_frame(ctx, dut.registers)
        assert await driver.read("STATUS") == STATUS_DONE

    run(bench)


def test_the_clocks_of_a_load():
    async def bench(ctx, dut, driver):
        await driver.write("VIEWS", 2)
        await driver.write("CTRL", CTRL_COMMIT | CTRL_START)
        await driver.begins()
        await wait(ctx, 100)
        await end_frame(ctx, dut.registers)
        clocks = 0
        while not ctx.get(dut.registers.begin):
            await ctx.tick()
            clocks += 1
        assert clocks == ViewStore.load_clocks

    run(bench)


def test_an_abort_ends_the_pass():
    async def bench(ctx, dut, driver):
        await driver.write("VIEWS", 3)
        await driver.write("CTRL", CTRL_COMMIT | CTRL_START)
        await driver.begins()
        await driver.write("CTRL", CTRL_ABORT)
        await wait(ctx, 3)
        assert ctx.get(dut.registers.abort)
        ctx.set(dut.registers.cut, 1)
        await end_frame(ctx, dut.registers)
        assert await driver.read("STATUS") == STATUS_DONE | STATUS_ABORTED
        assert await driver.read("VIEWS_STATE") == 3 | 1 << 8

    run(bench)


@pytest.mark.parametrize("lacking", range(3))
def test_a_view_that_lacks_pixels_marks_its_pass(lacking):
    async def bench(ctx, dut, driver):
        await driver.write("VIEWS", 3)
        for wrong in (lacking, None):
            await driver.write("CTRL", CTRL_COMMIT | CTRL_START)
            for k in range(3):
                await driver.begins()
                ctx.set(dut.registers.cut, k == wrong)
                await end_frame(ctx, dut.registers)
            assert await driver.read("STATUS") == STATUS_DONE | (
                0 if wrong is None else STATUS_ABORTED)
            await driver.write("STATUS", STATUS_DONE)

    run(bench)


def test_a_committed_list_rejects_writes():
    async def bench(ctx, dut, driver):
        await driver.write("CTRL", CTRL_START)
        await driver.begins()
        await driver.write("CTRL", CTRL_COMMIT)
        for name in ("VIEW2_PITCH", "VIEW_X_U"):
            before = await driver.read(name)
            await driver.write(name, ~before)
            assert await driver.read(name) == before
            assert await driver.read("STATUS") == STATUS_BUSY | STATUS_COMMITTED | STATUS_REFUSED
            await driver.write("STATUS", STATUS_REFUSED)

    run(bench)


@pytest.mark.parametrize("clock", range(12))
def test_a_write_is_kept_or_rejected_when_a_set_is_taken(clock):
    """However its clocks lie to those of the boundary, no write is lost without REFUSED."""
    async def bench(ctx, dut, driver):
        await driver.write("CTRL", CTRL_START)
        await driver.begins()
        await driver.write("CTRL", CTRL_COMMIT)

        ended = {"after": clock}
        bus, address = dut.registers.bus, dut.rows["VIEW1_WIDTH"].address
        ctx.set(bus.address, address)
        ctx.set(bus.writedata, 77)
        ctx.set(bus.write, 1)
        waits = True
        while waits or ended["after"] >= 0:
            ctx.set(dut.registers.ended, ended["after"] == 0)
            ended["after"] -= 1
            waits = (await ctx.tick().sample(bus.waitrequest))[2] and waits
            ctx.set(bus.write, waits)
        ctx.set(dut.registers.ended, 0)
        await wait(ctx, 3)
        rejected = await driver.read("STATUS") & STATUS_REFUSED
        assert await driver.read("VIEW1_WIDTH") == (D.geometry.corrected_width if rejected else 77)

    run(bench)


@pytest.mark.parametrize("clock", range(12))
def test_a_read_when_a_set_is_taken(clock):
    """It gives what was written, from whichever bank."""
    async def bench(ctx, dut, driver):
        await driver.write("CTRL", CTRL_START)
        await driver.begins()
        await driver.write("VIEW1_WIDTH", 77)
        await driver.write("CTRL", CTRL_COMMIT)
        bus, left, value = dut.registers.bus, clock, None
        ctx.set(bus.address, dut.rows["VIEW1_WIDTH"].address)
        ctx.set(bus.read, 1)
        while value is None or left >= 0:
            ctx.set(dut.registers.ended, left == 0)
            left -= 1
            _, _, waits, valid, data = await ctx.tick().sample(
                bus.waitrequest, bus.readdatavalid, bus.readdata)
            ctx.set(bus.read, ctx.get(bus.read) & waits)
            value = data if valid else value
        assert value == 77 and await driver.read("VIEW1_WIDTH") == 77

    run(bench)


def test_which_registers_the_list_holds():
    dut = Dut(3)
    names = [r.name for r in listed(dut.rows.values())]
    assert len(names) == 14 + 3 * 16 and {"VIEW_Z_0", "STRIP_WIDTH", "VIEW2_PITCH"} <= set(names)
    assert not listed(registers(3, D.formats, 8, view=True))
