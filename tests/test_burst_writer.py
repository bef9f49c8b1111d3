"""Packer and burst writer: what lands in memory, and in which bursts."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.sim import Simulator
from memory import write_agent
from pipelines import put

from ncdc_hdl.avalon.burst_writer import BurstWriter
from ncdc_hdl.backend.packer import Packer


class Sink(Elaboratable):
    def __init__(self, data_width, burst):
        self.packer, self.writer = Packer(data_width), BurstWriter(data_width, burst=burst)

    def elaborate(self, platform):
        m = Module()
        m.submodules.packer, m.submodules.writer = self.packer, self.writer
        wiring.connect(m, self.packer.o, self.writer.i)
        return m


@pytest.mark.parametrize("data_width", [32, 64, 128])
@pytest.mark.parametrize("count", [1, 7, 64, 65, 131])
@pytest.mark.parametrize("gap,wait", [(0, 0), (.5, 0), (0, .6), (.4, .4)])
def test_two_frames(data_width, count, gap, wait):
    rng, word, burst = np.random.default_rng(count), data_width // 8, 8
    frames = rng.integers(0, 256, (2, count, 3))
    bases = [64, 4096]
    content, log, done = np.full(8192, 0xEE, np.uint8), [], []
    dut = Sink(data_width, burst)

    async def source(ctx):
        for base, pixels in zip(bases, frames):
            ctx.set(dut.writer.base, base)
            ctx.set(dut.writer.start, 1)
            await ctx.tick()
            ctx.set(dut.writer.start, 0)
            seen = len(done)
            items = [{"r": int(r), "g": int(g), "b": int(b), "first": k == 0, "last": k == count - 1}
                     for k, (r, g, b) in enumerate(pixels)]
            await put(ctx, dut.packer.i, items, lambda: rng.random() < gap)
            while len(done) == seen:
                await ctx.tick()

    async def watch(ctx):
        while True:
            if (await ctx.tick().sample(dut.writer.done))[2]:
                done.append(1)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(source)
    simulator.add_testbench(watch, background=True)
    simulator.add_testbench(write_agent(dut.writer.bus, content, word, rng, wait=wait, log=log),
                            background=True)
    simulator.run()

    expected = np.full(8192, 0xEE, np.uint8)
    for base, pixels in zip(bases, frames):
        stored = np.column_stack([pixels[:, ::-1], np.zeros(count)]).astype(np.uint8).ravel()
        expected[base:base + stored.size] = stored
    np.testing.assert_array_equal(content, expected)
    words = -(-count * 4 // word)
    assert [n for _, n in log] == 2 * ([burst] * (words // burst) + [words % burst] * (words % burst > 0))
    assert len(done) == 2
