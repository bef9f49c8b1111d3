"""What a processor gets of the camera system: a window to its memory, two sets of registers."""

import pytest
from amaranth.sim import Simulator

from ncdc_hdl.link.processor import LINK_BASE, ProcessorLink
from ncdc_spec.errors import InputError
from ncdc_spec.registers.link_map import LINK

WORDS = {0x40: 0x11223344, 0x44: 0xAABBCCDD}        # of the memory, by byte address
REGISTERS = {5: 0x55, 9: 0x99}                      # of the system


def test_another_width_of_the_memory_is_rejected():
    with pytest.raises(InputError, match="the memory has 64 bits, 32 are needed"):
        ProcessorLink(64, 3840)


async def access(ctx, bus, address, value=None):
    """A cycle of the processor: the word that is read, or "err"."""
    ctx.set(bus.cyc, 1)
    ctx.set(bus.stb, 1)
    ctx.set(bus.adr, address)
    ctx.set(bus.we, value is not None)
    ctx.set(bus.sel, 0xF)
    ctx.set(bus.dat_w, value or 0)
    *_, ack, word = await ctx.tick().sample(bus.ack, bus.dat_r).until(bus.ack | bus.err)
    ctx.set(bus.cyc, 0)
    ctx.set(bus.stb, 0)
    await ctx.tick()
    return word if ack else "err"


def test_each_address_reaches_its_own():
    link = ProcessorLink(32, 3840)
    delay = next(r for r in LINK if r.name == "LINK_DELAY").address
    written, read_from = [], []

    async def system(ctx):
        bus = link.system
        while True:
            *_, reads, writes, address, word = await ctx.tick().sample(
                bus.read, bus.write, bus.address, bus.writedata)
            ctx.set(bus.readdatavalid, reads)
            ctx.set(bus.readdata, REGISTERS.get(address, 0))
            if writes:
                written.append((address, word))

    async def memory(ctx):
        bus = link.window
        while True:
            *_, reads, address, count = await ctx.tick().sample(bus.read, bus.address,
                                                                bus.burstcount)
            if reads:
                assert count == 1
                read_from.append(address)
                await ctx.tick().repeat(5)
                ctx.set(bus.readdata, WORDS[address])
                ctx.set(bus.readdatavalid, 1)
                await ctx.tick()
                ctx.set(bus.readdatavalid, 0)

    async def processor(ctx):
        registers, frames = link.processor.registers, link.processor.frames
        assert [await access(ctx, frames, address >> 2) for address in WORDS] == [*WORDS.values()]
        assert [await access(ctx, registers, address) for address in REGISTERS] == [
            *REGISTERS.values()]
        await access(ctx, registers, 7, 0x77)
        await access(ctx, registers, LINK_BASE + delay, 1234)
        assert await access(ctx, registers, LINK_BASE + delay) == 1234
        await access(ctx, frames, 0, 1)             # lost

    simulator = Simulator(link)
    simulator.add_clock(1e-8)
    simulator.add_process(system)
    simulator.add_process(memory)
    simulator.add_testbench(processor)
    simulator.run_until(1e-5)
    assert written == [(7, 0x77)] and read_from == [*WORDS]
