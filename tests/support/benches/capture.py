"""Capture from a sensor's pins into memory: two clocks of any ratio, every fault a sensor has.

With a grid stage the sensor sends as much more as that takes off: the window counts after it.
"""

import random

import cocotb
import numpy as np
from cocotb.triggers import FallingEdge, ReadOnly, Timer

from benches.avalon import write_memory
from benches.common import PERIOD, clocks, pack, settings, start, unpack
from ncdc_hdl.camera.frame_writer import AREA, COUNTS
from ncdc_hdl.camera.layouts import GRID, SETTINGS
from ncdc_hdl.lib.gains import BALANCE, NO_BALANCE
from ncdc_spec.raw_gains import sample_gains
from ncdc_spec.sensors.grid import gridded
from ncdc_spec.sensors.level import LINEAR, levelled

__all__ = ["balanced", "faults", "frames", "half_full", "restarts", "switched_off", "too_small"]

FRAME, WINDOW, CORNER = (26, 14), (18, 9), (5, 3)       # width and height; left and top
PITCH, BUFFER_BYTES, FIRST = 32, 512, 1024
CURVE = (0, 40, *range(56, 257, 16), 254, 250)
IDLE = 200              # clocks of the sensor without an entry after which its clock has stopped
GRID_IDLE = 1000        # the same with a grid stage, where twelve rows may come before the first


def grid():
    """Weight and binning of the grid stage, or None without one."""
    return settings().get("grid")


def sent():
    """Width and height of what the sensor sends, so that :data:`FRAME` is left."""
    weight, binning = grid() or (0, 0)
    return tuple((length + 2 * (weight > 0)) << binning for length in FRAME)


class Sensor:
    """Drives clock and pins; a frame's samples are random, and its faults are asked for."""
    def __init__(self, dut, period_ps, seed):
        self.dut, self.half = dut, period_ps // 2
        self.rng = random.Random(seed)
        dut.clock.value = 0

    async def tick(self, frame=0, line=0, sample=None):
        """One clock with these signals; without a sample the data are random."""
        dut = self.dut
        dut.camera__pins__frame_valid.value = frame
        dut.camera__pins__line_valid.value = line
        dut.camera__pins__data.value = self.rng.getrandbits(12) if sample is None else int(sample)
        await Timer(self.half, "ps")
        dut.clock.value = 1
        await Timer(self.half, "ps")
        dut.clock.value = 0

    async def rest(self, count):
        """Clocks between two frames."""
        for _ in range(count):
            await self.tick(line=self.rng.getrandbits(1))

    async def frame(self, change=lambda y, line: line, more=0, rows=None, at_row=None):
        """Send a frame of ``rows``, or ``more`` than it should have; returns its samples.

        ``change(y, line)`` makes another list of (LINE_VALID, sample) of a row, ``at_row(y)`` is
        awaited before it."""
        width, height = sent()
        samples = np.array([[self.rng.getrandbits(12) for _ in range(width)]
                            for _ in range(rows or height + more)])
        # FRAME_VALID may rise with the first sample.
        for _ in range(self.rng.choice((0, 0, 1, 4))):
            await self.tick(1)
        for y, row in enumerate(samples):
            if at_row is not None:
                await at_row(y)
            for line, sample in change(y, [(1, sample) for sample in row]):
                await self.tick(1, line, sample)
            for _ in range(self.rng.randrange(1, 6)):
                await self.tick(1)
        await self.rest(self.rng.randrange(2, 12))
        return samples


class Wait:
    """Probability of a wait in a clock, which may change while the memory runs."""
    def __init__(self, probability):
        self.probability = probability

    def __gt__(self, other):
        return self.probability > other


class Writer:
    """Gives each frame a buffer of its own, and records how each ended."""
    def __init__(self, dut, wait):
        self.dut, self.ended, self.begun, self.content = dut, [], 0, bytearray(b"\xee" * 16384)
        self.good = []          # numbers of the frames that ended as good
        self.wait, self.bytes, self.pitch = wait, PITCH * WINDOW[1], PITCH
        cocotb.start_soon(write_memory(dut, "bus", self.content, wait=wait))
        cocotb.start_soon(self._watch())

    @staticmethod
    def address(number):
        """Byte address of a frame."""
        return FIRST + BUFFER_BYTES * number

    async def _watch(self):
        dut = self.dut
        while True:
            await ReadOnly()
            begins, ends, good = (bool(signal.value) for signal in (dut.begins, dut.ends, dut.good))
            await FallingEdge(dut.clk)
            if begins:
                base = self.address(self.begun)
                dut.area.value = pack(AREA, {
                    "base": base, "limit": base + self.bytes,
                    "pitch": self.pitch, "width": WINDOW[0], "height": WINDOW[1]})
                self.begun += 1
            if ends:
                self.ended.append(good)
                self.good += [self.begun - 1] * good

    async def end_of(self, count):
        """Wait until so many frames have ended."""
        for _ in range(20_000):
            if len(self.ended) >= count:
                return
            await clocks(self.dut, 1)
        raise AssertionError(f"{len(self.ended)} of {count} frames have ended")

    def frame(self, number):
        """Bytes of the window, and whether all bytes around it are unchanged."""
        at = self.address(number)
        rows = np.frombuffer(self.content[at:at + BUFFER_BYTES], np.uint8)
        rows = rows[:PITCH * WINDOW[1]].reshape(WINDOW[1], PITCH)
        return rows[:, :WINDOW[0]]

    def check_outside(self):
        """Nothing is written outside the buffers of frames that were begun."""
        ends = [FIRST, *(self.address(k) + PITCH * WINDOW[1] for k in range(self.begun))]
        begins = [*(self.address(k) for k in range(self.begun)), len(self.content)]
        for end, begin in zip(ends, begins):
            assert set(self.content[end:begin]) <= {0xEE}


def expected(samples, black=0, curve=LINEAR, balance=NO_BALANCE):
    """The window of a frame, as bytes."""
    (x, y), (width, height) = CORNER, WINDOW
    if grid():
        samples = gridded(samples, *grid())
    phase = balance["phase"] & 1, balance["phase"] >> 1
    return levelled(samples[y:y + height, x:x + width], black, curve,
                    sample_gains(WINDOW, phase, balance["gains"]))


def limit():
    """Clocks of the core for which none of the sensor comes."""
    idle = GRID_IDLE if grid() else IDLE
    return max(idle, idle * settings()["camera_period_ps"] // (1000 * PERIOD))


async def begin(dut, black=0, curve=LINEAR, enable=1):
    """A sensor whose clock runs, and what has become of its frames."""
    s, (width, height) = settings(), sent()
    stage = {} if not grid() else {
        "grid": pack(GRID, dict(zip(("weight", "binning"), grid())))}
    await start(dut, memory_rst=0, limit=limit(), enable=0, camera__pins__frame_valid=0,
                camera__pins__line_valid=0, **stage, balance=pack(BALANCE, NO_BALANCE),
                settings=pack(SETTINGS, {
                    "sent_width": width, "sent_height": height, "left": CORNER[0],
                    "top": CORNER[1], "width": WINDOW[0], "height": WINDOW[1],
                    "level": {"black": black, "curve": list(curve)}}))
    sensor = Sensor(dut, s["camera_period_ps"], s["seed"])
    writer = Writer(dut, Wait(s["wait"]))
    await Timer(s["phase_ps"], "ps")
    await sensor.rest(12)
    dut.enable.value = enable
    await sensor.rest(12)
    return sensor, writer


def counts(dut):
    """Counters by name."""
    value = unpack(COUNTS, dut.counts.value)
    return {name: getattr(value, name) for name in ("lines", "cut", "overflows", "missed",
                                                    "stopped")}


@cocotb.test()
@cocotb.parametrize((("black", "curve"), [(0, LINEAR), (168, CURVE)]))
async def frames(dut, black, curve):
    """Every sample of the window is where it belongs, as the byte that the curve makes of it."""
    sensor, writer = await begin(dut, black, curve)
    for number in range(3):
        samples = await sensor.frame()
        # The sensor's clock goes on; the memory may take its time.
        while len(writer.ended) <= number:
            await sensor.tick()
        assert writer.ended[number], (number, counts(dut))
        assert np.array_equal(writer.frame(number), expected(samples, black, curve))
        assert int(dut.rows.value) == WINDOW[1]
    assert not any(counts(dut).values())
    writer.check_outside()


@cocotb.test()
async def balanced(dut):
    """Gains that change in a frame are those of the next one, as a whole."""
    sensor, writer = await begin(dut)
    balance = NO_BALANCE
    for number in range(4):
        following = {"gains": [sensor.rng.getrandbits(10) for _ in range(3)],
                     "phase": sensor.rng.getrandbits(2)}
        # When the frame has begun after the grid stage too.
        change_at = sensor.rng.randrange(2, WINDOW[1])

        async def change(y, row=change_at, following=following):
            if y == row:
                dut.balance.value = pack(BALANCE, following)

        samples = await sensor.frame(at_row=change)
        # Until the gains have crossed, and the frame is in memory.
        await sensor.rest(max(12, 40_000 * PERIOD // settings()["camera_period_ps"]))
        while len(writer.ended) <= number:
            await sensor.tick()
        assert writer.ended[number], (number, counts(dut))
        assert np.array_equal(writer.frame(number), expected(samples, balance=balance)), number
        balance = following
    writer.check_outside()


@cocotb.test()
async def half_full(dut):
    """The queue says that it is half full when the memory waits, and not when it keeps up with the
    sensor."""
    sensor, writer = await begin(dut)
    writer.wait.probability = 0
    seen = []

    async def watch():
        while True:
            await FallingEdge(dut.clk)
            seen.append(int(dut.half_full.value))

    cocotb.start_soon(watch())
    for _ in range(2):
        await sensor.frame()
    await sensor.rest(40)
    slower = settings()["camera_period_ps"] > 900 * PERIOD      # the sensor than the core
    assert len(seen) > 50 and not (slower and any(seen)), sum(seen)

    async def stall(y):
        writer.wait.probability = 1

    for _ in range(3):
        await sensor.frame(at_row=stall)
    assert seen[-1]
    writer.wait.probability = 0
    await sensor.rest(max(400, 4_000_000 // settings()["camera_period_ps"]))
    assert len(writer.ended) == writer.begun and not seen[-1]


def short(y, line):
    """A row without its last sample."""
    return line[:-1] if y == 6 else line


def long(y, line):
    """A row with one sample more."""
    return [*line, (1, 77)] if y == 1 else line


def glitch(y, line):
    """A row with LINE_VALID low for a clock."""
    return [*line[:9], (0, 5), *line[10:]] if y == 7 else line


@cocotb.test()
async def faults(dut):
    """Each fault is counted, its frame is bad, and the next one is right."""
    sensor, writer = await begin(dut)

    async def stop(y):
        if y == 8:
            await Timer(3 * limit() * PERIOD, "ns")

    def stall(row):
        async def at_row(y):
            if y == row:
                writer.wait.probability = 1
        return {"at_row": at_row}

    cases = [("lines", {"change": short}), ("lines", {"change": long}),
             ("lines", {"change": glitch}),
             ("cut", {"more": -1}), ("cut", {"more": 2}),
             # Rows below the window for longer than the limit: the clock has not stopped.
             ("cut", {"more": IDLE // sent()[0] + 8}), ("cut", {"rows": 2}),
             ("stopped", {"at_row": stop}),
             # The queue may happen to be full at the very end of a frame: not in both.
             ("overflows", stall(9)), ("overflows", {"more": 5} | stall(9))]
    for name, fault in cases:
        before, number = counts(dut), len(writer.ended)
        await sensor.frame(**fault)
        if name == "overflows":
            # Until the queue is full; then a frame is missed.
            for _ in range(4):
                await sensor.frame()
            writer.wait.probability = settings()["wait"]
        for _ in range(20_000):
            if len(writer.ended) > number:
                break
            await sensor.tick()
        await sensor.rest(max(40, 400_000 * PERIOD // settings()["camera_period_ps"]))
        after = counts(dut)
        # Before the queue is full, frames in it may be whole.
        clean = all(after[one] == before[one] for one in after if one != "missed")
        assert all(writer.ended[number:]) == clean, (name, fault)
        assert name == "overflows" or len(writer.ended) == number + 1, (name, fault)
        assert name == "overflows" or after[name] > before[name], (name, fault)
        assert name == "stopped" or after["stopped"] == before["stopped"], (name, fault)
        number = len(writer.ended)
        samples = await sensor.frame()
        while len(writer.ended) == number:
            await sensor.tick()
        assert writer.ended[number:] == [True], (name, fault)
        assert np.array_equal(writer.frame(writer.begun - 1), expected(samples)), (name, fault)
    assert counts(dut)["missed"] > 0 and counts(dut)["overflows"] > 0
    writer.check_outside()


@cocotb.test()
async def switched_off(dut):
    """Enabled in mid-frame, capture begins with the next one; disabled in mid-frame, it completes
    that one; then its settings are free."""
    sensor, writer = await begin(dut, enable=0)

    async def enable(y):
        if y == 4:
            dut.enable.value = 1

    async def disable(y):
        if y == 4:
            dut.enable.value = 0

    await sensor.frame(at_row=enable)
    assert writer.begun == 0
    samples = await sensor.frame(at_row=disable)
    await sensor.frame()
    await writer.end_of(1)
    assert writer.begun == 1 and writer.ended == [True]
    assert np.array_equal(writer.frame(0), expected(samples))
    assert dut.active.value == 0


@cocotb.test()
async def too_small(dut):
    """A buffer without space for the last row, and rows longer than the pitch: the frame is bad,
    and nothing is written beyond the buffer."""
    sensor, writer = await begin(dut)
    for pitch, size in ((PITCH, PITCH * WINDOW[1] - 16), (16, PITCH * WINDOW[1])):
        writer.pitch, writer.bytes = pitch, size
        number = len(writer.ended)
        await sensor.frame()
        while len(writer.ended) == number:
            await sensor.tick()
        assert writer.ended[number:] == [False], pitch
    first, second = (writer.content[writer.address(k):writer.address(k + 1)] for k in range(2))
    assert set(first[:PITCH * (WINDOW[1] - 1)]) != {0xEE}
    assert set(first[PITCH * (WINDOW[1] - 1):]) == {0xEE} == set(second)
    assert not any(counts(dut).values())


@cocotb.test()
async def restarts(dut):
    """Enabled, disabled and reset at any time: what ends as good is a whole frame, in order, and
    the last one is captured."""
    sensor, writer = await begin(dut, enable=0)
    period, frames = settings()["camera_period_ps"], []

    async def change(wait_ps, name):
        await Timer(max(1, wait_ps), "ps")
        if name == "rst":
            dut.rst.value = 1
            await Timer(3 * PERIOD, "ns")
            dut.rst.value = 0
        else:
            dut.enable.value = 1 - int(dut.enable.value)

    for number in range(16):
        clocks_of_frame = sent()[0] * sent()[1] * period
        cocotb.start_soon(change(sensor.rng.randrange(clocks_of_frame),
                                 "rst" if number % 4 == 3 else "enable"))
        frames.append(await sensor.frame())
        await sensor.rest(40)
    dut.enable.value = 1
    await Timer(40 * max(period, 1000 * PERIOD), "ps")
    await sensor.rest(max(40, 2000 * PERIOD // period))
    frames.append(await sensor.frame())
    while writer.begun - 1 not in writer.good:
        await sensor.tick()
    wanted = iter([expected(samples).tobytes() for samples in frames])
    for number in writer.good:
        assert writer.frame(number).tobytes() in wanted, number
    assert next(wanted, None) is None and len(writer.good) >= 3
    writer.check_outside()
