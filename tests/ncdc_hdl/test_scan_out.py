"""The scan-out: what a screen shows of frames in memory, whatever memory and store do."""

import numpy as np
import pytest
from amaranth.hdl import ClockDomain, Module
from amaranth.sim import Simulator

from ncdc_hdl.video.modes import VideoMode
from ncdc_hdl.video.pixel_words import PixelWords
from ncdc_hdl.video.scan_out import ScanOut

MODE = VideoMode((20, 3, 4, 5), (9, 1, 2, 6), True, (1, 2))
LINE, LINES = sum(MODE.horizontal), sum(MODE.vertical)
WIDTH, HEIGHT = 14, 7
BUFFER = 1024           # bytes of a frame's buffer


class Board:
    """A scan-out, a memory of random frames, and a store whose newest frame the test chooses.

    ``slow`` is the probability that the memory gives no word in a clock. Of the claim with number
    ``starved`` it gives but 20 words until the beam is below that frame.
    """

    def __init__(self, pixel_bytes=3, *, slow=0., starved=None, seed=1, ratio=1.):
        self.rng = np.random.default_rng(seed)
        self.pixel_bytes, self.slow, self.starved = pixel_bytes, slow, starved
        self.memory = self.rng.integers(1, 256, 4 * BUFFER, dtype=np.uint8)
        self.newest, self.claims, self.ratio = None, [], ratio
        self.dut = ScanOut(MODE, WIDTH, HEIGHT, pixel_bytes=pixel_bytes, depth=32, max_burst=8)
        self.seen, self.picture = [], 0

    def frame(self, buffer):
        """Pixels of a buffer, red first."""
        size = self.pixel_bytes
        data = self.memory[buffer * BUFFER:][:size * WIDTH * HEIGHT]
        return data.reshape(HEIGHT, WIDTH, size)[:, :, 2::-1]

    async def store(self, ctx):
        screen, held = self.dut.screen, False
        async for _, _, claim in ctx.tick().sample(screen.claim):
            if claim:
                held = self.newest is not None
                self.claims.append(self.newest)
                ctx.set(screen.held, held)
                ctx.set(screen.base, (self.newest or 0) * BUFFER)

    async def words(self, ctx):
        bus, queue = self.dut.bus, []
        gives, claims, given = False, 0, 0
        async for _, _, read, address, count, waits in ctx.tick().sample(
                bus.read, bus.address, bus.burstcount, bus.waitrequest):
            if read and not waits:
                queue += range(address, address + 4 * count, 4)
            ctx.set(bus.waitrequest, int(self.rng.random() < .3))
            given = given + 1 if gives else given
            if len(self.claims) != claims:
                claims, given = len(self.claims), 0
            below = (len(self.seen) - 3) // LINE >= (claims + 1) * LINES - 5
            starves = claims - 1 == self.starved and given >= 20 and not below
            gives = bool(queue) and not starves and self.rng.random() >= self.slow
            ctx.set(bus.readdatavalid, gives)
            if gives:
                at = queue.pop(0)
                ctx.set(bus.readdata, int.from_bytes(self.memory[at:at + 4].tobytes(), "little"))

    async def screen(self, ctx):
        picture = self.dut.picture
        async for _, _, b, g, r, visible, h, v in ctx.tick("pixel").sample(
                picture.b, picture.g, picture.r, picture.visible, picture.hsync, picture.vsync):
            self.seen.append((r, g, b, visible, h, v))
            self.picture = (len(self.seen) - 3) // (LINE * LINES)

    def run(self, pictures, choose):
        """Screens as arrays; ``choose(k)`` is the newest frame when picture k ends."""
        m = Module()
        m.domains.pixel = ClockDomain()
        m.submodules.dut = self.dut

        async def chooser(ctx):
            for k in range(pictures):
                self.newest = choose(k)
                while self.picture <= k:
                    await ctx.tick()
            self.counts = ctx.get(self.dut.shown), ctx.get(self.dut.underruns)

        simulator = Simulator(m)
        simulator.add_clock(1e-6)
        simulator.add_clock(self.ratio * 1e-6, phase=.3e-6, domain="pixel")
        for process in (self.store, self.words, self.screen):
            simulator.add_testbench(process, background=True)
        simulator.add_testbench(chooser)
        simulator.run()
        seen = np.array(self.seen[1:1 + LINE * LINES * pictures], np.int64)
        return seen.reshape(-1, LINES, LINE, 6)


def shown(screen):
    """The frame's part of a screen, after a check that all around it is black."""
    left, top = (20 - WIDTH) // 2, (9 - HEIGHT) // 2
    inner = screen[top:top + HEIGHT, left:left + WIDTH, :3]
    assert screen[:, :, :3].sum() == inner.sum()
    return inner


@pytest.mark.parametrize("pixel_bytes", [3, 4])
@pytest.mark.parametrize("slow,ratio", [
    (0, .9), pytest.param(.3, 2.7, marks=pytest.mark.longer), (.1, 1.01)])
def test_each_picture_is_the_newest_frame(pixel_bytes, slow, ratio):
    board = Board(pixel_bytes, slow=slow, ratio=ratio)
    choices = [None, 1, 1, 2, 0, 3, 3]
    screens = board.run(len(choices), lambda k: choices[k])
    assert board.claims == choices
    assert not shown(screens[0]).any() and not shown(screens[1]).any()
    for screen, choice in zip(screens[2:], choices[1:]):
        np.testing.assert_array_equal(shown(screen), board.frame(choice))
    assert board.counts[1] == 0


def test_sync_pulses_are_the_modes():
    screens = Board().run(2, lambda k: None)
    visible, hsync, vsync = (screens[1][:, :, k] for k in (3, 4, 5))
    at, line = np.arange(LINE), np.arange(LINES)
    np.testing.assert_array_equal(visible, (line[:, None] < 9) & (at < 20))
    np.testing.assert_array_equal(hsync, ((at >= 23) & (at < 27)) & (line[:, None] >= 0))
    np.testing.assert_array_equal(vsync, (line[:, None] >= 10) & (line[:, None] < 12) & (at >= 0))


def test_a_starved_picture_is_cut_counted_and_the_next_one_whole():
    board = Board(starved=2, ratio=1.01)
    screens = board.run(7, lambda k: k % 3)
    late = shown(screens[3]).reshape(-1, 3)
    right = board.frame(2).reshape(-1, 3)
    good = int((late != right).any(axis=1).argmax())
    assert 20 <= good < 30 and not late[good:].any()
    for k in (2, 5, 6):
        np.testing.assert_array_equal(shown(screens[k]), board.frame((k - 1) % 3))
    assert board.counts == (6, 1)


def test_pixels_out_of_words():
    """Four pixels of three words, with gaps on both sides; aligned anew in the middle of a word."""
    rng = np.random.default_rng(1)
    m = Module()
    m.domains.pixel = ClockDomain()
    m.submodules.dut = dut = PixelWords(3)
    data = rng.integers(0, 256, 4 * 90, dtype=np.uint8).tobytes()
    got = []

    async def bench(ctx):
        words = [data[k:k + 4] for k in range(0, len(data), 4)]
        for clock in range(200):
            align = clock == 100
            offered = bool(words) and rng.random() < .7
            ctx.set(dut.align, align)
            ctx.set(dut.i.valid, offered)
            ctx.set(dut.i.payload, int.from_bytes(words[0], "little") if words else 0)
            ctx.set(dut.o.ready, int(rng.random() < .7))
            if align:
                got.append(len(data) - 4 * len(words))
            if ctx.get(dut.o.valid & dut.o.ready):
                got.append(ctx.get(dut.o.payload).to_bytes(3, "little"))
            if ctx.get(dut.i.valid & dut.i.ready):
                words.pop(0)
            await ctx.tick("pixel")

    simulator = Simulator(m)
    simulator.add_clock(1e-6, domain="pixel")
    simulator.add_testbench(bench)
    simulator.run()
    cut = next(k for k, item in enumerate(got) if isinstance(item, int))
    before, after = b"".join(got[:cut]), b"".join(got[cut + 1:])
    assert len(before) > 60 and before == data[:len(before)]
    assert after and data[got[cut]:].startswith(after)
