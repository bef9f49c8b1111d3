"""A parallel sensor's pins, and the whole capture of its frames with both clocks."""

import numpy as np

from pipelines import run_bench
from sensor_ports import pins_of
from units.sensor_entries import Scene

__all__ = ["check_capture", "check_parallel_source"]

_WORD = 8                   # bytes of a word of memory
_LIMIT = 900                # clocks without an entry, in which a clock has not yet stopped
_TALL = 5                   # number of the scene with many rows
_EVEN = 3                   # number of a scene that is moved far to an even grid
_STALL = 5200               # clocks in which the queue of a capture fills


def check_parallel_source(dut, clocks=5000, seed=19):
    """Pins that do anything: each sample of a row, its beginning and end; a frame's end.

    ``dut``: :class:`simulations.traces.Alone` with a parallel source.
    """
    rng, seen = np.random.default_rng(seed), []

    async def bench(ctx):
        frame, rates = 0, (.9, .7)
        for clock in range(clocks):
            if clock % 200 == 0:
                rates = rng.choice([.02, .3, .5, .9]), rng.choice([.3, .5, .7, .95])
            frame ^= int(rng.random() < rates[0] / (9 if frame else 2))
            line, data = int(rng.random() < rates[1]), int(rng.integers(4096))
            reset = int(rng.random() < .01)
            for name, value in (("frame_valid", frame), ("line_valid", line), ("data", data)):
                ctx.set(getattr(dut.pins, name), value)
            ctx.set(dut.reset, reset)
            _, _, *out = await ctx.tick().sample(
                dut.o.valid, dut.o.sample[0], dut.o.first, dut.o.last, dut.o.end)
            seen.append((reset, frame, line, data, out))

    run_bench(dut, bench)
    _compare_samples(seen)


def _compare_samples(seen):
    """Compare what leaves two clocks after its pins with their meaning, up to each reset."""
    armed, fresh, last = False, True, (0, 0, 0)
    for (reset, frame, line, data, _), (again, *_), (_, _, _, _, out) in zip(
            seen, seen[1:], seen[2:]):
        sample = int(frame and line and armed)
        armed |= not frame
        if reset or again:
            armed, fresh, last = False, True, (0, 0, 0)
            continue
        valid, value, first, _, _ = out
        assert valid == sample and (not valid or value == data)
        assert first == (sample and fresh)
        fresh = last[0] and not frame or fresh and not sample
        last = frame, line, data


class _Memory:
    """What the words are written to: bytes by address, whole bursts."""

    def __init__(self):
        self.bytes, self.left, self.address = {}, 0, 0

    def take(self, address, count, data, enable):
        """A word that is accepted."""
        if self.left == 0:
            self.left, self.address = count, address
        for k in range(_WORD):
            if enable >> k & 1:
                self.bytes[self.address + k] = data >> 8 * k & 0xFF
        self.left, self.address = self.left - 1, self.address + _WORD


class _Clocks:
    """A capture's inputs, clock by clock, and the frames that come.

    The sensor's clock is an input that changes between clocks of the core, at most in each of them.
    What crosses without a register changes when it falls.
    """

    def __init__(self, dut, rng):
        self.dut, self.rng, self.memory = dut, rng, _Memory()
        self.level, self.left, self.half = 0, 1, 1
        self.pins, self.area, self.good, self.bad = [], {}, 0, 0
        self.wait, self.running, self.sent, self.scene = 0.0, True, [], None
        self.resets = 0
        self.frames = []            # of the scene; ``sent`` are their golden pictures
        self.memory_rst = 0

    def _sensor(self, ctx):
        """Move the sensor's clock."""
        self.left -= 1
        if self.left > 0 or not self.running:
            return
        self.left = self.half if self.half else int(self.rng.integers(1, 4))
        self.level ^= 1
        if not self.level:
            clock = self.pins.pop(0) if self.pins else (0, 0, 5)
            pins = self.dut.camera.pins
            for signal, value in zip((pins.frame_valid, pins.line_valid, pins.data), clock):
                ctx.set(signal, value)
        ctx.set(self.dut.clock, self.level)

    async def clock(self, ctx):
        """A clock of the core."""
        dut, bus = self.dut, self.dut.bus
        self._sensor(ctx)
        ctx.set(bus.waitrequest, int(self.rng.random() < self.wait))
        ctx.set(dut.memory_rst, self.memory_rst)
        _, _, begins, ends, good, write, wait, *beat = await ctx.tick().sample(
            dut.begins, dut.ends, dut.good, bus.write, bus.waitrequest, bus.address,
            bus.burstcount, bus.writedata, bus.byteenable)
        if self.memory_rst:
            self.memory.left = 0
        elif write and not wait:
            self.memory.take(*beat)
        if begins:
            self._begin(ctx)
        if ends:
            self._end(good)

    def _begin(self, ctx):
        """Choose the area of a frame."""
        rng, (width, height) = self.rng, self.scene.size
        pitch = -(-width // _WORD) * _WORD + _WORD * int(rng.integers(3))
        base = int(rng.integers((1 << 32) // _WORD - pitch * height)) * _WORD
        self.area = {"base": base, "pitch": pitch, "width": width, "height": height,
                     "limit": base + pitch * height}
        self.memory.bytes = {}
        ctx.set(self.dut.area, self.area)

    def _end(self, good):
        """A good frame is one that was sent; no byte is written outside of its rows."""
        self.good, self.bad = self.good + good, self.bad + (not good)
        (width, height), area, found = self.scene.size, self.area, self.memory.bytes
        rows = [area["base"] + y * area["pitch"] for y in range(height)]
        inside = {row + x for row in rows for x in range(-(-width // 4) * 4)}
        assert found.keys() <= inside
        if good:
            picture = [[found[row + x] for x in range(width)] for row in rows]
            assert picture in self.sent, "a frame that was not sent"

    async def falling(self, ctx):
        """Go on until the sensor's clock is low, and let it stand in the next clock."""
        while self.level:
            await self.clock(ctx)
        self.left += 1

    async def settle(self, ctx, scene):
        """Let the last frame end, and set what a scene says."""
        dut = self.dut
        self.running, self.wait, self.memory_rst = True, 0.0, 0
        await self.falling(ctx)
        ctx.set(dut.enable, 0)
        for _ in range(20000):
            await self.clock(ctx)
            if not ctx.get(dut.active) and not self.pins:
                break
        for _ in range(200):
            await self.clock(ctx)
        await self.falling(ctx)
        self.scene, self.sent, self.frames = scene, [], []
        ctx.set(dut.settings, scene.settings)
        ctx.set(dut.grid, {"weight": scene.weight, "binning": scene.binning})
        ctx.set(dut.balance, {"gains": scene.gains, "phase": scene.phase})
        ctx.set(dut.enable, 1)
        for _ in range(60):
            await self.clock(ctx)

    def send(self, frames, change=lambda y, row: row):
        """Let the sensor send frames of a scene."""
        rng = self.rng
        for _ in range(frames):
            frame = rng.integers(0, 4096, self.scene.sent[::-1])
            self.frames.append(frame)
            self.sent.append(self.scene.golden(frame))
            pauses = int(rng.integers(3)), int(rng.integers(1, 4)), int(rng.integers(3))
            self.pins += pins_of(frame, pauses, change)


def check_capture(dut, scenes=9, seed=20):
    """Frames into areas anywhere, with a memory that stalls, and resets of each side or both.

    Each good frame is the golden model's of one that was sent. ``dut``:
    :class:`simulations.traces.Alone` with a capture of a parallel sensor, with a grid stage.
    """
    rng = np.random.default_rng(seed)
    clocks = _Clocks(dut, rng)

    async def bench(ctx):
        for number in range(scenes):
            scene = Scene(rng, dut.part.row)
            if scene.sent[0] > 60:
                scene = Scene(np.random.default_rng(number), dut.part.row)
            while number == _EVEN and scene.weight < 2:
                scene = Scene(rng, dut.part.row)
            if _EVENTS[number % len(_EVENTS)] is _stall:    # many entries, and no grid
                scene.sent = scene.size = 25, 10
                scene.corner, scene.weight, scene.binning = (0, 0), 0, 0
            clocks.half = number % 3 % 2
            if number == _TALL:
                scene.sent = scene.size = 5, 264
                scene.corner, scene.weight, scene.binning, clocks.half = (0, 0), 0, 0, 1
            ctx.set(dut.limit, _LIMIT if _EVENTS[number % len(_EVENTS)] is _stop else 1 << 31)
            await clocks.settle(ctx, scene)
            clocks.wait = float(rng.choice([0, .3, .9]))
            clocks.send(2, _short if number % 7 == 6 else lambda y, row: row)
            await _EVENTS[number % len(_EVENTS)](ctx, clocks)
            while clocks.pins:
                await clocks.clock(ctx)
        await clocks.settle(ctx, clocks.scene)

    run_bench(dut, bench)
    assert clocks.good > scenes // 2 and clocks.bad > 2, (clocks.good, clocks.bad)


def _short(y, row):
    """A change of a frame: its fourth row lacks a sample."""
    return row[:-1] if y == 3 else row


async def _nothing(ctx, clocks):
    """Only frames."""


async def _reset(ctx, clocks):
    """Resets of the core, of the memory, or of both, at any time."""
    rng, dut = clocks.rng, clocks.dut
    clocks.wait = .9
    for k in range(8):
        for _ in range(int(rng.integers(40, 600))):
            await clocks.clock(ctx)
        for _ in range(500 * (k % 2)):      # the memory drops a burst that has begun
            if clocks.memory.left:
                break
            await clocks.clock(ctx)
        clocks.memory_rst = k % 2
        await clocks.falling(ctx)
        clocks.running = k != 1         # the sensor's clock may stand still
        ctx.set(dut.reset, 1)
        for _ in range(int(rng.integers(1, 4))):
            clocks.left += 1            # its edge is no clock of the reset's
            await clocks.clock(ctx)
        ctx.set(dut.reset, 0)
        # A frame is ignored whose FRAME_VALID was low for the last time within the reset.
        clocks.resets += 1
        clocks.pins = [(1, 0, 7)] * (clocks.resets % 4) + [(0, 0, 7)]
        clocks.send(1)
        for _ in range(3):
            clocks.left += 1
            await clocks.clock(ctx)
        clocks.running, clocks.memory_rst = True, 0
        clocks.memory.bytes = {}
    clocks.send(2)


async def _stop(ctx, clocks):
    """The sensor's clock stops in a frame, longer than the limit."""
    for _ in range(int(clocks.rng.integers(200, 500))):
        await clocks.clock(ctx)
    clocks.running = False
    for _ in range(_LIMIT + 300):
        await clocks.clock(ctx)
    clocks.running = True


async def _stall(ctx, clocks):
    """The memory takes nothing until the queue is full."""
    clocks.half = 1
    clocks.send(1 + _STALL // (2 * (clocks.scene.sent[0] + 2) * clocks.scene.sent[1]))
    clocks.wait = 1.0
    for _ in range(_STALL):
        await clocks.clock(ctx)
    clocks.wait = 0.0


async def _change(ctx, clocks):
    """The gains change while frames come; the capture is disabled, and enabled again."""
    rng, dut = clocks.rng, clocks.dut
    for _ in range(2):
        for _ in range(int(rng.integers(20, 300))):
            await clocks.clock(ctx)
        await clocks.falling(ctx)
        ctx.set(dut.enable, 0)
        for _ in range(int(rng.integers(1, 90))):
            await clocks.clock(ctx)
        await clocks.falling(ctx)
        ctx.set(dut.enable, 1)
    # A frame has the gains before or those after, never some of both.
    clocks.scene.gains = [int(gain) * 2 for gain in rng.integers(0, 512, 3)]
    clocks.sent += [clocks.scene.golden(frame) for frame in clocks.frames]
    ctx.set(dut.balance, {"gains": clocks.scene.gains, "phase": clocks.scene.phase})
    clocks.send(2)


_EVENTS = _nothing, _reset, _stop, _change, _reset, _nothing, _stall, _change, _reset
