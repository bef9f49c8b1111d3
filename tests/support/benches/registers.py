"""The register agent: reset values, read-back, shadowing, interrupt."""

import random
from collections import deque

import cocotb
from cocotb.triggers import FallingEdge, ReadOnly

from benches.avalon import Host
from benches.common import clocks, settings, start
from ncdc_hdl.frontend.valid import ValidTable
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import (
    CTRL_COMMIT,
    CTRL_START,
    ID,
    STATUS_BUSY,
    STATUS_COMMITTED,
    STATUS_DONE,
    STATUS_REFUSED,
    TABLE,
    registers,
)

__all__ = ["every_bit_is_stored", "frame_boundary", "reset_values", "table_of_valid_rows"]


async def prepare(dut):
    """A host, the rows of the register table by name, and the values of the descriptor."""
    d = Descriptor.load(settings()["descriptor"])
    await start(dut, ended=0, cut=0, counters=0, faults=0, running=0, start=0,
                valid_table__read_start=0,
                valid_table__read_stop=0,
                bus__read=0, bus__write=0, bus__address=0, bus__writedata=0)
    rows = {r.name: r for r in registers(d.hidden_neurons, d.formats)}
    return Host(dut, "bus"), rows, host_values(d)


@cocotb.test()
async def reset_values(dut):
    """After reset every parameter has the descriptor's value."""
    host, rows, values = await prepare(dut)
    assert await host.read(rows["ID"].address) == ID
    for name, value in values.items():
        assert await host.read(rows[name].address) == value & 0xFFFFFFFF, name


@cocotb.test()
async def every_bit_is_stored(dut):
    """Written values are read back, cut to the register's width and extended by its sign."""
    host, rows, _ = await prepare(dut)
    rng = random.Random(1)
    written = {name: rng.getrandbits(32) for name, r in rows.items()
               if r.access in ("rw", "shadow")}
    for name, value in written.items():
        await host.write(rows[name].address, value)
    for name, value in written.items():
        shape = rows[name].shape
        value &= (1 << shape.width) - 1
        if shape.signed and value >> (shape.width - 1):
            value -= 1 << shape.width
        assert await host.read(rows[name].address) == value & 0xFFFFFFFF, name


@cocotb.test()
async def frame_boundary(dut):
    """A committed set takes effect at the next frame; the end of a frame interrupts."""
    host, rows, _ = await prepare(dut)

    async def control(value):
        await host.write(rows["CTRL"].address, value)
        await clocks(dut, 3)

    async def status():
        return await host.read(rows["STATUS"].address)

    await host.write(rows["IRQ_ENABLE"].address, 1)
    await control(CTRL_START)
    before = int(dut.active.value)
    await host.write(rows["FILL"].address, 0xABCDEF)
    await control(CTRL_COMMIT)
    assert await status() == STATUS_BUSY | STATUS_COMMITTED
    await host.write(rows["FILL"].address, 0x123456)
    assert await status() == STATUS_BUSY | STATUS_COMMITTED | STATUS_REFUSED
    assert await host.read(rows["FILL"].address) == 0xABCDEF
    await host.write(rows["STATUS"].address, STATUS_REFUSED)
    assert int(dut.active.value) == before, "changed in the middle of a frame"
    dut.ended.value = 1
    await clocks(dut, 1)
    dut.ended.value = 0
    await clocks(dut, 2)
    assert int(dut.irq.value) == 1
    assert int(dut.active.value) != before
    assert await status() == STATUS_DONE
    assert await host.read(rows["FRAMES"].address) == 1
    await host.write(rows["STATUS"].address, STATUS_DONE)
    await clocks(dut, 3)
    assert int(dut.irq.value) == 0


async def table(dut, entries):
    """The table's side of the registers: (row, span) to (start, stop), after its latency."""
    rng, asked = random.Random(2), deque([None] * (ValidTable.latency - 1))
    while True:
        await ReadOnly()
        at = int(dut.valid_table__row.value), int(dut.valid_table__span.value)
        write, read = bool(dut.valid_table__write.value), bool(dut.valid_table__read.value)
        if write:
            entries[at] = int(dut.valid_table__start.value), int(dut.valid_table__stop.value)
        await FallingEdge(dut.clk)
        # Between reads the scan uses the table's port: something else stands there.
        asked.append(at if read else None)
        first = asked.popleft()
        answer = entries[first] if first else (rng.getrandbits(13), rng.getrandbits(13))
        dut.valid_table__read_start.value, dut.valid_table__read_stop.value = answer


@cocotb.test()
async def table_of_valid_rows(dut):
    """Every span of the first, some and the last rows is written and read back."""
    host, _, _ = await prepare(dut)
    entries, rng = {}, random.Random(3)
    cocotb.start_soon(table(dut, entries))
    written = {(row, span): (rng.getrandbits(13), rng.getrandbits(13))
               for row in (0, 1, 5, 1000, 4095) for span in range(2)}
    for (row, span), (first, stop) in written.items():
        await host.write(TABLE + 2 * row + span, first | stop << 16)
    await clocks(dut, 2)
    assert entries == written
    for (row, span), (first, stop) in written.items():
        assert await host.read(TABLE + 2 * row + span) == first | stop << 16
