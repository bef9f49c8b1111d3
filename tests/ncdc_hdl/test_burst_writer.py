"""Packer and burst writer: what lands in memory, and in which bursts."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring

from memory import write_agent
from ncdc_hdl.avalon.burst_writer import BurstWriter
from ncdc_hdl.backend.packer import Packer
from ncdc_hdl.frontend.strips import Strips
from ncdc_model.geometry import scan_order
from pipelines import put, run_bench

BURST = 8
SIZE = 1 << 15
BASES = (64, SIZE // 2)


class Sink(Elaboratable):
    def __init__(self, data_width, lanes=1):
        self.packer, self.writer = Packer(data_width, lanes), BurstWriter(data_width, burst=BURST)
        self.domain = ClockDomain("sync")

    def elaborate(self, platform):
        m = Module()
        m.domains += self.domain
        m.submodules.packer, m.submodules.writer = self.packer, self.writer
        wiring.connect(m, self.packer.o, self.writer.i)
        return m


def groups(pixels, strip, lanes, upto=None):
    """Items of the packer's stream: ``pixels`` (height, width, 3), the last one at ``upto``."""
    order = scan_order(pixels, strip)[:upto].tolist()
    items = []
    for k in range(0, len(order), lanes):
        lane = [{"r": r, "g": g, "b": b} for r, g, b in order[k:k + lanes]]
        items.append((lane[0] if lanes == 1 else {"lane": lane})
                     | {"first": k == 0, "last": k + lanes == len(order)})
    return items


def stored(content, base, pixels, strip, upto=None):
    """Write the first ``upto`` of ``pixels`` into ``content`` where they belong."""
    height, width, _ = pixels.shape
    place = scan_order(np.arange(height * width).reshape(height, width), strip)[:upto]
    frame = content[base:base + 4 * height * width].reshape(-1, 4)
    bytes_of = np.column_stack([pixels.reshape(-1, 3)[:, ::-1], np.zeros(height * width)])
    frame[place] = bytes_of[place]


def bursts(base, size, strip, word):
    """(address, words) of every burst of a frame."""
    width, height = size
    rows = [(base, width * height)]
    if strip:
        rows = [(base + 4 * (v * width + left), min(strip, width - left))
                for left in range(0, width, strip) for v in range(height)]
    for start, pixels in rows:
        first, end = start // word, -(-(start + 4 * pixels) // word)
        yield from ((word * k, min(BURST, end - k)) for k in range(first, end, BURST))


async def begin(ctx, dut, base, size, strip):
    ctx.set(dut.packer.base, base)
    ctx.set(dut.packer.limit, base + -(-4 * size[0] * size[1] // 16) * 16)
    ctx.set(dut.packer.order, {"width": size[0], "height": size[1], "strip": strip})
    ctx.set(dut.packer.start, 1)
    await ctx.tick()
    ctx.set(dut.packer.start, 0)
    for _ in range(Strips.latency - 1):
        await ctx.tick()


def counter(dut, done):
    async def watch(ctx):
        while True:
            done.extend([1] * (await ctx.tick().sample(dut.writer.done))[2])

    return watch


@pytest.mark.parametrize("data_width", [32, 64, 128])
@pytest.mark.parametrize("size,strip,lanes", [
    ((1, 1), 0, 1), ((13, 10), 0, 1), ((8, 8), 0, 1), ((72, 3), 32, 1),
    ((37, 3), 32, 1),           # rows that begin within a word
    ((65, 4), 64, 1),           # a strip of one column
    ((40, 3), 64, 1),           # one strip only: rows end all the same
    ((38, 3), 32, 2), ((14, 5), 0, 2), ((36, 4), 32, 4), ((12, 5), 0, 4)])
@pytest.mark.parametrize("gap,wait", [
    pytest.param(0, 0, marks=pytest.mark.regress), (.2, .6)])
def test_two_frames(data_width, size, strip, lanes, gap, wait):
    rng, word = np.random.default_rng(size[0]), data_width // 8
    frames = rng.integers(0, 256, (2, size[1], size[0], 3))
    content, log, done = np.full(SIZE, 0xEE, np.uint8), [], []
    dut = Sink(data_width, lanes)

    async def source(ctx):
        for k, (base, pixels) in enumerate(zip(BASES, frames)):
            await begin(ctx, dut, base, size, strip)
            await put(ctx, dut.packer.i, groups(pixels, strip, lanes), lambda: rng.random() < gap)
            while len(done) == k:
                await ctx.tick()

    agent = write_agent(dut.writer.bus, content, word, rng, wait=wait, log=log)
    run_bench(dut, source, background=(counter(dut, done), agent), results=(content, log, done))
    expected = np.full(SIZE, 0xEE, np.uint8)
    for base, pixels in zip(BASES, frames):
        stored(expected, base, pixels, strip)
    np.testing.assert_array_equal(content, expected)
    assert log == [burst for base in BASES for burst in bursts(base, size, strip, word)]
    assert len(done) == 2


def test_a_word_per_clock():
    """Without waits the bus has no gap from the first word to the last, short bursts included."""
    dut, writes, rng = Sink(32), [], np.random.default_rng(1)
    pixels = rng.integers(0, 256, (6, 44, 3))

    async def source(ctx):
        await begin(ctx, dut, 0, (44, 6), 32)
        await put(ctx, dut.packer.i, groups(pixels, 32, 1), lambda: False)
        for _ in range(40):
            await ctx.tick()

    async def watch(ctx):
        while True:
            writes.append((await ctx.tick().sample(dut.writer.bus.write))[2])

    run_bench(dut, source, background=(watch,), results=(writes,))
    busy = np.flatnonzero(writes)
    assert len(busy) == 44 * 6
    # Between strips of different rows: a burst of 8 begins when it is complete, 4 clocks more.
    assert busy[-1] - busy[0] + 1 <= 44 * 6 + BURST


@pytest.mark.parametrize("strip,lanes,data_width", [(0, 1, 32), (32, 1, 64), (32, 2, 128),
                                                    (0, 4, 32)])
@pytest.mark.parametrize("upto", [4, 8, 36, 100])
def test_a_frame_that_ends_early(strip, lanes, data_width, upto):
    """The last pixel may come anywhere; the next frame is whole."""
    rng, size, done = np.random.default_rng(upto), (44, 6), []
    frames = rng.integers(0, 256, (2, size[1], size[0], 3))
    content, dut = np.full(SIZE, 0xEE, np.uint8), Sink(data_width, lanes)
    expected = content.copy()

    async def source(ctx):
        for k, (base, pixels, end) in enumerate(zip(BASES, frames, (upto, None))):
            await begin(ctx, dut, base, size, strip)
            stored(expected, base, pixels, strip, end)
            await put(ctx, dut.packer.i, groups(pixels, strip, lanes, end),
                      lambda: rng.random() < .2)
            while len(done) == k:
                await ctx.tick()

    agent = write_agent(dut.writer.bus, content, data_width // 8, rng, wait=.4)
    run_bench(dut, source, background=(counter(dut, done), agent), results=(content, expected))
    np.testing.assert_array_equal(content, expected)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("data_width,strip", [(32, 0), (64, 32), (128, 32)])
def test_reset_completes_the_burst(data_width, strip, seed):
    """A reset at any moment, also while a word waits: the bus sees whole bursts, nothing wrong is
    written, and the next frame is right."""
    rng, size, done, log = np.random.default_rng(seed), (44, 12), [], []
    frames = rng.integers(0, 256, (2, size[1], size[0], 3))
    content, dut = np.full(SIZE, 0xEE, np.uint8), Sink(data_width)
    moment, length, word = int(rng.integers(20, 500)), int(rng.integers(1, 4)), data_width // 8

    async def source(ctx):
        await begin(ctx, dut, BASES[0], size, strip)
        items = groups(frames[0], strip, 1)
        for clock in range(moment):
            ctx.set(dut.packer.i.payload, items[0])
            ctx.set(dut.packer.i.valid, 1)
            _, _, ready = await ctx.tick().sample(dut.packer.i.ready)
            del items[:ready]
        ctx.set(dut.packer.i.valid, 0)
        ctx.set(dut.domain.rst, 1)
        for _ in range(length):
            await ctx.tick()
        ctx.set(dut.domain.rst, 0)
        assert not done
        for _ in range(int(rng.integers(1, 30))):
            await ctx.tick()
        await begin(ctx, dut, BASES[1], size, strip)
        await put(ctx, dut.packer.i, groups(frames[1], strip, 1), lambda: rng.random() < .1)
        while not done:
            await ctx.tick()

    agent = write_agent(dut.writer.bus, content, word, rng, wait=.6, log=log)
    run_bench(dut, source, background=(counter(dut, done), agent), results=(content, log))
    expected = np.full(SIZE, 0xEE, np.uint8)
    stored(expected, BASES[0], frames[0], strip)
    stored(expected, BASES[1], frames[1], strip)
    end = BASES[0] + 4 * size[0] * size[1]
    wrong = (content != expected) & (content != 0xEE)
    assert not wrong.any()
    np.testing.assert_array_equal(content[end:], expected[end:])
    # Whole bursts: those of the frame that was cut, and all of the second.
    second = list(bursts(BASES[1], size, strip, word))
    assert log[-len(second):] == second
    assert log[:-len(second)] == list(bursts(BASES[0], size, strip, word))[:len(log) - len(second)]
