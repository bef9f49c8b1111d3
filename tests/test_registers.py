"""The register agent: read-back, shadowing, frames, the table of valid rows."""

import numpy as np
import pytest
from amaranth import *
from cameras import barrel_descriptor
from pipelines import run_bench

from ncdc_hdl.avalon.register_table import (ID, STATUS_BUSY, STATUS_DONE, STATUS_PENDING, TABLE,
                                            host_values, registers, table_words)
from ncdc_hdl.avalon.registers import Registers
from ncdc_hdl.frontend.valid import ValidTable

D = barrel_descriptor(hidden_neurons=3)
ROWS = registers(3, D.formats)
BY_NAME = {r.name: r for r in ROWS}


class Dut(Elaboratable):
    def __init__(self):
        self.registers = Registers(ROWS, host_values(D, 32), digest=int(D.digest[:8], 16),
                                   hidden_neurons=3)
        self.table = ValidTable(D.valid, D.geometry.corrected_height)

    def elaborate(self, platform):
        m = Module()
        m.submodules.registers, m.submodules.table = r, t = self.registers, self.table
        m.d.comb += [
            t.host_bank.eq(r.window_bank), t.host_row.eq(r.table_row), t.host_span.eq(r.table_span),
            t.host_write.eq(r.table_write), t.host_read.eq(r.table_read),
            t.host_start.eq(r.table_start), t.host_stop.eq(r.table_stop),
            r.table_span_start.eq(t.host_span_start), r.table_span_stop.eq(t.host_span_stop)]
        return m


class Host:
    """Avalon-MM accesses in the Amaranth simulator."""

    def __init__(self, ctx, bus):
        self.ctx, self.bus = ctx, bus

    async def write(self, address, value):
        ctx, bus = self.ctx, self.bus
        ctx.set(bus.address, address)
        ctx.set(bus.writedata, value & 0xFFFFFFFF)
        ctx.set(bus.write, 1)
        while (await ctx.tick().sample(bus.waitrequest))[2]:
            pass
        ctx.set(bus.write, 0)

    async def read(self, address):
        ctx, bus = self.ctx, self.bus
        ctx.set(bus.address, address)
        ctx.set(bus.read, 1)
        while (await ctx.tick().sample(bus.waitrequest))[2]:
            pass
        ctx.set(bus.read, 0)
        while True:
            _, _, valid, value = await ctx.tick().sample(bus.readdatavalid, bus.readdata)
            if valid:
                return value


async def wait(ctx, clocks):
    for _ in range(clocks):
        await ctx.tick()


def run(bench):
    dut = Dut()

    async def testbench(ctx):
        await bench(ctx, dut.registers, Host(ctx, dut.registers.bus))

    run_bench(dut, testbench)


def test_addresses_and_names_are_unique():
    assert len({r.address for r in ROWS}) == len(ROWS) == len(BY_NAME)
    assert max(r.address for r in registers(32, D.formats)) < TABLE


def test_reset_values_are_the_descriptor():
    async def bench(ctx, dut, host):
        assert await host.read(BY_NAME["ID"].address) == ID
        assert await host.read(BY_NAME["DIGEST"].address) == int(D.digest[:8], 16)
        assert await host.read(BY_NAME["NEURONS"].address) == 3
        for name, value in host_values(D, 32).items():
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


def test_shadow_registers_change_at_a_frame_only():
    async def bench(ctx, dut, host):
        async def start():
            await host.write(BY_NAME["CTRL"].address, 1)
            await wait(ctx, 3)

        async def status():
            return await host.read(BY_NAME["STATUS"].address)

        assert await status() == 0
        await start()
        assert ctx.get(dut.active.FILL) == 0 and await status() == STATUS_BUSY
        await host.write(BY_NAME["FILL"].address, 0xABCDEF)
        await wait(ctx, 5)
        assert ctx.get(dut.active.FILL) == 0, "changed in the middle of a frame"
        await start()
        assert ctx.get(dut.active.FILL) == 0 and await status() == STATUS_BUSY | STATUS_PENDING
        ctx.set(dut.counters.CLOCKS, 1234)
        ctx.set(dut.ended, 1)
        await ctx.tick()
        ctx.set(dut.ended, 0)
        await wait(ctx, 2)
        assert ctx.get(dut.active.FILL) == 0xABCDEF
        assert await status() == STATUS_BUSY | STATUS_DONE
        assert await host.read(BY_NAME["CLOCKS"].address) == 1234
        assert await host.read(BY_NAME["FRAMES"].address) == 1
        assert not ctx.get(dut.irq)
        await host.write(BY_NAME["IRQ_ENABLE"].address, 1)
        await ctx.tick()
        assert ctx.get(dut.irq)
        await host.write(BY_NAME["STATUS"].address, STATUS_DONE)
        await ctx.tick()
        assert not ctx.get(dut.irq) and await status() == STATUS_BUSY

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


@pytest.mark.parametrize("address", [0x7F, 0x1F00])
def test_unused_addresses_read_zero(address):
    async def bench(ctx, dut, host):
        await host.write(address, 0xFFFFFFFF)
        assert await host.read(address) == 0

    run(bench)
