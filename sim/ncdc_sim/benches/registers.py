"""The register agent: reset values, read-back, shadowing, interrupt."""

import random

import cocotb

from ncdc_hdl.avalon.register_table import (CTRL_START, ID, STATUS_BUSY, STATUS_DONE, host_values,
                                            registers)
from ncdc_model.descriptor import Descriptor
from ncdc_sim.benches.avalon import Host
from ncdc_sim.benches.common import clocks, settings, start

__all__ = ["every_bit_is_kept", "frame_boundary", "reset_values"]


async def prepare(dut):
    """A host, the rows of the register table by name, and the values of the descriptor."""
    d = Descriptor.load(settings()["descriptor"])
    await start(dut, ended=0, counters=0, table_span_start=0, table_span_stop=0,
                bus__read=0, bus__write=0, bus__address=0, bus__writedata=0)
    rows = {r.name: r for r in registers(d.hidden_neurons, d.formats)}
    return Host(dut, "bus"), rows, host_values(d, 32)


@cocotb.test()
async def reset_values(dut):
    """After reset every parameter has the descriptor's value."""
    host, rows, values = await prepare(dut)
    assert await host.read(rows["ID"].address) == ID
    for name, value in values.items():
        assert await host.read(rows[name].address) == value & 0xFFFFFFFF, name


@cocotb.test()
async def every_bit_is_kept(dut):
    """What is written is read, cut to the register's width and extended by its sign."""
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
    """A shadow register takes effect at the next frame; the end of a frame interrupts."""
    host, rows, _ = await prepare(dut)
    await host.write(rows["IRQ_ENABLE"].address, 1)
    await host.write(rows["CTRL"].address, CTRL_START)
    await clocks(dut, 3)
    before = int(dut.active.value)
    await host.write(rows["FILL"].address, 0xABCDEF)
    await clocks(dut, 5)
    assert int(dut.active.value) == before, "changed in the middle of a frame"
    assert await host.read(rows["STATUS"].address) == STATUS_BUSY
    dut.ended.value = 1
    await clocks(dut, 1)
    dut.ended.value = 0
    await clocks(dut, 2)
    assert int(dut.irq.value) == 1
    await host.write(rows["STATUS"].address, STATUS_DONE)
    await clocks(dut, 1)
    assert int(dut.irq.value) == 0
    await host.write(rows["CTRL"].address, CTRL_START)
    await clocks(dut, 3)
    assert int(dut.active.value) != before
