"""Packer and burst writer: what lands in memory, and in which bursts."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring

from memory import write_agent
from ncdc_hdl.avalon.burst_writer import BurstWriter
from ncdc_hdl.backend.packer import Packer
from ncdc_hdl.frontend.strips import Strips
from ncdc_spec.frames import BGR8, BGRX8, MONO8, OUTPUT_FORMATS
from ncdc_spec.geometry import scan_order
from pipelines import put, run_bench
from units.packers import groups

BURST = 8
SIZE = 1 << 15
BASES = [64 + 4096 * k for k in range(6)]


class Sink(Elaboratable):
    def __init__(self, data_width, lanes=1, placed=False):
        self.packer = Packer(data_width, lanes, placed)
        self.writer = BurstWriter(data_width, burst=BURST)
        self.domain = ClockDomain("sync")

    def elaborate(self, platform):
        m = Module()
        m.domains += self.domain
        m.submodules.packer, m.submodules.writer = self.packer, self.writer
        wiring.connect(m, self.packer.o, self.writer.i)
        return m


def stored(content, base, pixels, strip, upto=None, form=BGRX8):
    """Write the first ``upto`` of ``pixels`` into ``content`` where they belong."""
    height, width, _ = pixels.shape
    order = scan_order(np.arange(height * width).reshape(height, width), strip)[:upto]
    count = form.pixel_bytes
    frame = content[base:base + count * height * width].reshape(-1, count)
    red, green, blue = pixels.reshape(-1, 3).T
    bytes_of = np.column_stack({1: [green], 3: [blue, green, red],
                                4: [blue, green, red, np.zeros_like(red)]}[count])
    frame[order] = bytes_of[order]


def bursts(base, size, strip, word, form=BGRX8):
    """(address, words) of every burst of a frame."""
    (width, height), count = size, form.pixel_bytes
    rows = [(base, width * height)]
    if strip:
        rows = [(base + count * (v * width + left), min(strip, width - left))
                for left in range(0, width, strip) for v in range(height)]
    for start, pixels in rows:
        first, end = start // word, -(-(start + count * pixels) // word)
        yield from ((word * k, min(BURST, end - k)) for k in range(first, end, BURST))


async def begin(ctx, dut, base, size, strip, form=BGRX8):
    ctx.set(dut.packer.format, form.code)
    ctx.set(dut.packer.base, base)
    ctx.set(dut.packer.limit, base + -(-form.pixel_bytes * size[0] * size[1] // 16) * 16)
    ctx.set(dut.packer.order, {"width": size[0], "height": size[1], "strip": strip})
    ctx.set(dut.packer.start, 1)
    await ctx.tick()
    ctx.set(dut.packer.start, 0)
    for _ in range(Strips.latency - 1):
        await ctx.tick()


async def hand_over(ctx, packer, item):
    """Send a group of pixels as soon as the packer takes it."""
    ready = False
    while not ready:
        ctx.set(packer.i.payload, item)
        ctx.set(packer.i.valid, 1)
        _, _, ready = await ctx.tick().sample(packer.i.ready)
    ctx.set(packer.i.valid, 0)


def counter(dut, done):
    async def watch(ctx):
        while True:
            done.extend([1] * (await ctx.tick().sample(dut.writer.done))[2])

    return watch


SIZES = [((1, 1), 0, 1), ((13, 10), 0, 1), ((8, 8), 0, 1), ((72, 3), 32, 1),
         ((37, 3), 32, 1),          # rows that begin within a word
         ((65, 4), 64, 1),          # a strip of one column
         ((40, 3), 64, 1),          # one strip only: rows end all the same
         ((33, 2), 32, 1),          # a strip of one column and two rows
         ((38, 3), 32, 2), ((14, 5), 0, 2), ((34, 4), 32, 2), ((36, 4), 32, 4), ((12, 5), 0, 4),
         ((44, 3), 64, 4)]
FORMATS = list(OUTPUT_FORMATS.values())
EACH_FORMAT = pytest.mark.parametrize("form", FORMATS, ids=list(OUTPUT_FORMATS))


@pytest.mark.parametrize("data_width", [32, 64, 128])
@pytest.mark.parametrize("size,strip,lanes", SIZES)
@pytest.mark.parametrize("gap,wait", [
    pytest.param(0, 0, marks=pytest.mark.regress), (.2, .6)])
def test_frames_in_each_format(data_width, size, strip, lanes, gap, wait):
    """The memory's bytes, all others untouched, and the bursts, of a frame in each format."""
    rng, word = np.random.default_rng(size[0]), data_width // 8
    frames = rng.integers(0, 256, (len(FORMATS), size[1], size[0], 3))
    forms = rng.permutation(FORMATS)
    content, log, done = np.full(SIZE, 0xEE, np.uint8), [], []
    dut = Sink(data_width, lanes)

    async def source(ctx):
        for k, (base, pixels, one) in enumerate(zip(BASES, frames, forms)):
            await begin(ctx, dut, base, size, strip, one)
            await put(ctx, dut.packer.i, groups(pixels, strip, lanes), lambda: rng.random() < gap)
            while len(done) == k:
                await ctx.tick()

    agent = write_agent(dut.writer.bus, content, word, rng, wait=wait, log=log)
    run_bench(dut, source, background=(counter(dut, done), agent))
    expected = np.full(SIZE, 0xEE, np.uint8)
    for base, pixels, one in zip(BASES, frames, forms):
        stored(expected, base, pixels, strip, form=one)
    np.testing.assert_array_equal(content, expected)
    assert log == [burst for base, one in zip(BASES, forms)
                   for burst in bursts(base, size, strip, word, one)]
    assert len(done) == len(forms)


@pytest.mark.parametrize("data_width,lanes,size,strip", [
    (32, 1, (13, 5), 0), (64, 1, (37, 3), 32), (64, 2, (14, 4), 0), (128, 4, (44, 3), 32)])
def test_a_picture_at_any_word_of_a_larger_one(data_width, lanes, size, strip):
    """In each format, and with pitches from the least one on; no byte between rows is touched."""
    rng, word, (width, height) = np.random.default_rng(3), data_width // 8, size
    content, expected, done = np.full(SIZE, 0xEE, np.uint8), np.full(SIZE, 0xEE, np.uint8), []
    dut = Sink(data_width, lanes, placed=True)
    cases = [(base, form, (-(-width * form.pixel_bytes // word) + more) * word)
             for base, form, more in zip(BASES, FORMATS + FORMATS, (0, 1, 3, 9, 0, 2))]

    async def source(ctx):
        for k, (base, form, pitch) in enumerate(cases):
            pixels = rng.integers(0, 256, (height, width, 3))
            first = base + word * int(rng.integers(0, 9))
            ctx.set(dut.packer.origin, first)
            ctx.set(dut.packer.pitch, pitch)
            for v, row in enumerate(pixels):
                stored(expected, first + v * pitch, row[None], 0, form=form)
            await begin(ctx, dut, base, (width, height), strip, form)
            ctx.set(dut.packer.limit, base + 4096)
            await put(ctx, dut.packer.i, groups(pixels, strip, lanes), lambda: rng.random() < .2)
            while len(done) == k:
                await ctx.tick()

    agent = write_agent(dut.writer.bus, content, word, rng, wait=.6, log=[])
    run_bench(dut, source, background=(counter(dut, done), agent))
    np.testing.assert_array_equal(content, expected)


def clocks_to_pack(data_width, lanes, form, size, strip):
    """Clocks from the first group at the packer to the last one taken, nothing waiting."""
    dut, taken = Packer(data_width, lanes), []
    pixels = np.zeros((size[1], size[0], 3), int)

    class Bench:
        packer = dut

    async def source(ctx):
        ctx.set(dut.o.ready, 1)
        await begin(ctx, Bench, 0, size, strip, form)
        for item in groups(pixels, strip, lanes):
            ctx.set(dut.i.payload, item)
            ctx.set(dut.i.valid, 1)
            ready = False
            while not ready:
                _, _, ready = await ctx.tick().sample(dut.i.ready)
                taken.append(ready)

    run_bench(dut, source)
    return len(taken)


@pytest.mark.parametrize("data_width,lanes,strip", [
    (32, 1, 0), (32, 1, 32), (64, 1, 32), (32, 2, 0), (64, 4, 0), (32, 4, 32), (128, 4, 0)])
@EACH_FORMAT
def test_a_group_or_a_word_per_clock(data_width, lanes, strip, form):
    """A row of 44 pixels takes as many clocks as it has groups, or words if those are more; with
    strips a row of theirs may have one word more than groups complete."""
    size, word = (44, 4), data_width // 8
    clocks = clocks_to_pack(data_width, lanes, form, size, strip)
    words = sum(count for _, count in bursts(0, size, strip, word, form))
    rows = 2 * size[1] if strip else 1
    groups_ = 44 * 4 // lanes
    assert max(groups_, words) <= clocks <= max(groups_, words) + rows


@pytest.mark.parametrize("form", FORMATS[:2], ids=list(OUTPUT_FORMATS)[:2])
def test_a_word_per_clock(form):
    """Without waits the bus has no gap from the first word to the last, short bursts included."""
    dut, writes, rng = Sink(32, 2), [], np.random.default_rng(1)
    pixels = rng.integers(0, 256, (6, 44, 3))

    async def source(ctx):
        await begin(ctx, dut, 0, (44, 6), 32, form)
        await put(ctx, dut.packer.i, groups(pixels, 32, 2), lambda: False)
        for _ in range(40):
            await ctx.tick()

    async def watch(ctx):
        while True:
            writes.append((await ctx.tick().sample(dut.writer.bus.write))[2])

    run_bench(dut, source, background=(watch,))
    busy = np.flatnonzero(writes)
    words = 44 * 6 * form.pixel_bytes // 4
    assert len(busy) == words
    # Between strips of different rows: a burst of 8 begins when it is complete, 4 clocks more.
    assert busy[-1] - busy[0] + 1 <= words + BURST


@pytest.mark.parametrize("strip,lanes,data_width", [(0, 1, 32), (32, 1, 64), (32, 2, 128),
                                                    (0, 4, 32)])
@pytest.mark.parametrize("upto", [
    4, 100, *(pytest.param(upto, marks=pytest.mark.regress) for upto in (8, 36))])
def test_a_frame_that_ends_early(strip, lanes, data_width, upto):
    """The last pixel may come anywhere; the next frame is whole. In each format."""
    rng, size, done = np.random.default_rng(upto), (44, 6), []
    frames = rng.integers(0, 256, (len(BASES), size[1], size[0], 3))
    ends = [(form, end) for form in FORMATS for end in (upto, None)]
    content, dut = np.full(SIZE, 0xEE, np.uint8), Sink(data_width, lanes)
    expected = content.copy()

    async def source(ctx):
        for k, (base, pixels, (form, end)) in enumerate(zip(BASES, frames, ends)):
            await begin(ctx, dut, base, size, strip, form)
            stored(expected, base, pixels, strip, end, form)
            await put(ctx, dut.packer.i, groups(pixels, strip, lanes, end),
                      lambda: rng.random() < .2)
            while len(done) == k:
                await ctx.tick()

    agent = write_agent(dut.writer.bus, content, data_width // 8, rng, wait=.4)
    run_bench(dut, source, background=(counter(dut, done), agent))
    np.testing.assert_array_equal(content, expected)


@pytest.mark.parametrize("data_width,lanes", [(32, 1), (128, 1), (32, 2), (64, 4)])
@pytest.mark.parametrize("before,form", [(BGR8, MONO8), (MONO8, BGR8), (BGRX8, BGRX8)])
def test_nothing_is_left_of_a_frame_begun_before(before, form, data_width, lanes):
    """A start in the middle of a frame, at several positions in the word. The next frame ends with
    its first group, so that a word would show what is left."""
    dut, rng, size = Packer(data_width, lanes), np.random.default_rng(1), (16, 8)
    frames = rng.integers(0, 256, (16, size[1], size[0], 3))
    content, expected = np.full(SIZE, 0xEE, np.uint8), np.full(SIZE, 0xEE, np.uint8)

    class Bench:
        packer = dut

    async def source(ctx):
        ctx.set(dut.o.ready, 1)
        for k, pixels in enumerate(frames):
            await begin(ctx, Bench, 512 * k, size, 0, form if k % 2 else before)
            items = groups(pixels, 0, lanes, lanes) if k % 2 else groups(pixels, 0, lanes)[:k + 1]
            for item in items:
                await hand_over(ctx, dut, item)
            await ctx.tick().repeat(4)

    async def sink(ctx):
        while True:
            _, _, valid, word = await ctx.tick().sample(dut.o.valid, dut.o.payload)
            if valid and word.address // 512 % 2:
                for k in range(data_width // 8):
                    if word.enable >> k & 1:
                        content[word.address + k] = word.data >> 8 * k & 0xFF

    run_bench(dut, source, background=(sink,))
    for k in range(1, len(frames), 2):
        stored(expected, 512 * k, frames[k], 0, lanes, form)
    np.testing.assert_array_equal(content, expected)


@pytest.mark.parametrize("seed", [
    0, *(pytest.param(seed, marks=pytest.mark.regress) for seed in (1, 2, 3))])
@pytest.mark.parametrize("data_width,strip,form", [(32, 0, BGRX8), (64, 32, BGR8),
                                                   (128, 32, BGRX8), (32, 32, MONO8)])
def test_reset_completes_the_burst(data_width, strip, form, seed):
    """A reset at any moment, also while a word waits: the bus sees whole bursts, nothing wrong is
    written, and the next frame is right."""
    rng, size, done, log = np.random.default_rng(seed), (44, 12), [], []
    frames = rng.integers(0, 256, (2, size[1], size[0], 3))
    content, dut = np.full(SIZE, 0xEE, np.uint8), Sink(data_width)
    moment, length, word = int(rng.integers(20, 500)), int(rng.integers(1, 4)), data_width // 8

    async def source(ctx):
        await begin(ctx, dut, BASES[0], size, strip, form)
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
        await begin(ctx, dut, BASES[1], size, strip, form)
        await put(ctx, dut.packer.i, groups(frames[1], strip, 1), lambda: rng.random() < .1)
        while not done:
            await ctx.tick()

    agent = write_agent(dut.writer.bus, content, word, rng, wait=.6, log=log)
    run_bench(dut, source, background=(counter(dut, done), agent))
    expected = np.full(SIZE, 0xEE, np.uint8)
    stored(expected, BASES[0], frames[0], strip, form=form)
    stored(expected, BASES[1], frames[1], strip, form=form)
    end = BASES[0] + form.pixel_bytes * size[0] * size[1]
    wrong = (content != expected) & (content != 0xEE)
    assert not wrong.any()
    np.testing.assert_array_equal(content[end:], expected[end:])
    # Whole bursts: those of the frame that was cut, and all of the second.
    second = list(bursts(BASES[1], size, strip, word, form))
    assert log[-len(second):] == second
    assert log[:-len(second)] == list(
        bursts(BASES[0], size, strip, word, form))[:len(log) - len(second)]


@pytest.mark.parametrize("kind", ["whole", "rejected", "misaligned", "outside once"])
def test_the_packer_itself_keeps_a_wrong_frame_from_memory(kind):
    """Whatever lets it begin: of a frame that is rejected, or whose base is no word's, or that was
    outside its buffer once, it sends a void word for the end and nothing else."""
    dut, sent, size = Packer(32), [], (8, 4)
    pixels = np.random.default_rng(3).integers(0, 256, (size[1], size[0], 3))

    class Bench:
        packer = dut

    async def source(ctx):
        ctx.set(dut.o.ready, 1)
        await begin(ctx, Bench, 64 + 2 * (kind == "misaligned"), size, 0, BGRX8)
        if kind == "rejected":
            ctx.set(dut.reject, 1)
            await ctx.tick()
        if kind == "outside once":
            ctx.set(dut.limit, 64)
        for k, item in enumerate(groups(pixels, 0, 1)):
            ctx.set(dut.limit, 64 if kind == "outside once" and k == 0 else 4096)
            await hand_over(ctx, dut, item)
        await ctx.tick().repeat(4)

    async def sink(ctx):
        while True:
            _, _, valid, word = await ctx.tick().sample(dut.o.valid, dut.o.payload)
            if valid:
                sent.append((word.void, word.last))

    run_bench(dut, source, background=(sink,))
    if kind == "whole":
        assert sent == [(0, 0)] * (size[0] * size[1] - 1) + [(0, 1)]
    else:
        assert sent == [(1, 1)]
