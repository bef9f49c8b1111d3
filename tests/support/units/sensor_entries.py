"""The camera's side of capture: bytes in entries, rows on an even grid, frames in a window."""

import numpy as np

from ncdc_hdl.camera.layouts import REPORT, SIZE_BITS, Kind
from ncdc_spec.raw_gains import sample_gains
from ncdc_spec.sensors.grid import grid_size, gridded
from ncdc_spec.sensors.level import levelled
from pipelines import run_bench
from sensor_ports import samples_of
from units.levels import random_curve

__all__ = ["Scene", "check_entry_packer", "check_grid", "check_sensor_port"]

_MISSED = 1100      # frames that meet a full queue


def check_entry_packer(dut, clocks=6000, seed=7):
    """Rows of any length, with gaps; frames that begin in the midst of a row, and resets.

    ``dut``: :class:`simulations.traces.Alone` with an entry packer of one byte per clock.
    """
    rng, found, wanted = np.random.default_rng(seed), [], []

    async def bench(ctx):
        gathered, left = [], 0
        for _ in range(clocks):
            inside, clear, reset = rng.random() < .7, rng.random() < .03, rng.random() < .01
            closes = left == 0 and rng.random() < .5 and not clear
            byte = int(rng.integers(256))
            for name, value in (("inside", inside), ("clear", clear), ("closes", closes),
                                ("taken", rng.random() < .8), ("reset", reset)):
                ctx.set(getattr(dut, name), int(value))
            ctx.set(dut.data, [byte])
            *_, valid, row_end, entry = await ctx.tick().sample(dut.valid, dut.row_end, dut.o)
            found.append((valid, row_end, entry) if valid else None)
            gathered = ([] if clear else gathered) + [byte] * inside
            complete = closes or len(gathered) == 4
            wanted.append((1, int(closes), int.from_bytes(bytes(gathered), "little"))
                          if complete else None)
            left = int(rng.integers(13)) if closes else max(0, left - inside)
            gathered = [] if complete or reset else gathered

    run_bench(dut, bench)
    assert found == wanted and sum(one is not None for one in found) > clocks // 8


def _rows(frame, rng):
    """(frame, valid, row end, sample) of each clock of a frame, with pauses."""
    clocks, slow = [(1, 0, 0, 777)] * int(rng.integers(3)), rng.random() < .5
    for row in frame:
        for sample in row:
            clocks += [(1, 0, 0, 4095)] * int(slow and rng.integers(2))
            clocks.append((1, 1, 0, int(sample)))
        clocks[-1] = (1, 1, 1, int(sample))
        clocks += [(1, 0, 0, 55)] * int(rng.integers(3) * slow)
    return clocks + [(0, 0, 0, 1234)] * int(rng.integers(1, 4))


def check_grid(dut, frames=60, seed=8):
    """Frames of any size in each mode: the result of the golden model.

    ``dut``: :class:`simulations.traces.Alone` with a grid stage.
    """
    rng, width = np.random.default_rng(seed), dut.part.width

    async def bench(ctx):
        for number in range(frames):
            weight, binning = number % 4, number // 4 % 2
            longest = width if number % 5 == 4 else 24
            size = (int(rng.integers(max(8, longest - 12), longest + 1)),
                    int(rng.integers(2, 6 if longest == width else 17)))
            values = [0, 4095] if number % 3 == 2 else range(4096)
            frame = rng.choice(values, size[::-1])
            ctx.set(dut.settings, {"weight": weight, "binning": binning})
            before = _rows(frame[:int(rng.integers(1, size[1] + 1))], rng)
            if number % 6 == 5:         # a frame that a reset ends
                await _give(ctx, dut, before[:int(rng.integers(1, len(before)))])
                await _rest(ctx, dut, 1)
            else:
                await _rest(ctx, dut, 0)
            rows = await _give(ctx, dut, [*_rows(frame, rng), *[(0, 0, 0, 0)] * dut.latency])
            first = 2 if weight else 0
            rows = [row[first:] for row in rows[first:]]
            wanted = gridded(frame, weight, binning).tolist()
            assert [row[:len(one)] for row, one in zip(rows, wanted)] == wanted, number
            assert len(rows) == len(wanted) and grid_size(size, weight, binning)[1] == len(rows)

    run_bench(dut, bench)


async def _rest(ctx, dut, reset):
    """Clocks without a frame, with a reset at their end."""
    for signal in (dut.i.frame, dut.i.valid, dut.i.row_end):
        ctx.set(signal, 0)
    await ctx.tick().repeat(1 if reset else dut.latency)
    ctx.set(dut.reset, reset)
    await ctx.tick()
    ctx.set(dut.reset, 0)


async def _give(ctx, dut, clocks):
    """Give the inputs what ``clocks`` say; rows of samples that come meanwhile."""
    rows = [[]]
    for clock in clocks:
        for name, value in zip(("frame", "valid", "row_end", "sample"), clock):
            ctx.set(getattr(dut.i, name), value)
        *_, row_end, valid, sample = await ctx.tick().sample(dut.o.row_end, dut.o.valid,
                                                             dut.o.sample)
        if valid:
            rows[-1].append(sample)
        if row_end:
            rows.append([])
    return [row for row in rows if row]


class Scene:
    """Settings of a sensor port, and the frames that come with them.

    Parameters
    ----------
    rng : numpy.random.Generator
    row : int
        Samples of the longest row of the grid stage.
    """
    def __init__(self, rng, row):
        self.sent = int(rng.integers(5, 26)), int(rng.integers(4, 11))
        self.weight, self.binning = int(rng.choice([0, 0, 1, 2, 3])), int(rng.integers(2))
        if rng.random() < .15:
            self.sent = row + int(rng.integers(-2, 1)), 4
        if min(self.sent) < 8:
            self.binning = 0
        if rng.random() < .2:       # the stage is off, and rows may be longer than it holds
            self.weight = self.binning = 0
            self.sent = self.sent if rng.random() < .5 else (row + 9, 4)
        whole = grid_size(self.sent, self.weight, self.binning)
        self.corner = tuple(int(rng.integers(0, max(1, min(6, side - 2)))) for side in whole)
        self.size = tuple(int(rng.integers(1, side - at + 1)) if rng.random() < .6 else side - at
                          for side, at in zip(whole, self.corner))
        self.black, self.curve = int(rng.choice([0, 168, int(rng.integers(4096))])), \
            random_curve(rng)
        self.gains = [int(gain) for gain in rng.integers(0, 1024, 3)]
        self.phase = int(rng.integers(8))

    @property
    def settings(self):
        """As of the layout ``SETTINGS``."""
        return {"sent_width": self.sent[0], "sent_height": self.sent[1], "left": self.corner[0],
                "top": self.corner[1], "width": self.size[0], "height": self.size[1],
                "level": {"black": self.black, "curve": self.curve}}

    def golden(self, frame):
        """Rows of bytes of a whole frame's window."""
        (left, top), (width, height) = self.corner, self.size
        window = gridded(frame, self.weight, self.binning)[top:top + height, left:left + width]
        phase = None if self.phase & 4 else (self.phase & 1, self.phase >> 1 & 1)
        gains = sample_gains(self.size, phase, self.gains)
        return levelled(window, self.black, self.curve, gains).tolist()


def _fault(rng, sent):
    """(change of rows, rows, what the end says) of a frame, mostly of a right one."""
    width, height = sent
    kind, at = int(rng.integers(18)), int(rng.integers(height))

    def change(y, row):
        if y != at or kind > 3:
            return row
        return {0: row[:int(rng.integers(1, width))], 1: [*row, 77, 4095][:width + 1 + at % 2],
                2: [*row, *row[:9]], 3: [*row, None]}[kind]
    rows = {4: 1, 5: height + 1, 6: max(1, height - 1)}.get(kind, height)
    return change, rows, {7: (1, 1), 8: (0, 0)}.get(kind, (1, 0))


class _Watch:
    """Frames that a port has pushed, as rows of bytes with their report."""

    def __init__(self):
        self.frames, self.rows = [], None

    def look(self, entry, width):
        """Take an entry."""
        if entry.kind == Kind.BEGIN:
            self.rows = [[]]
        elif entry.kind == Kind.END:
            report = REPORT.from_bits(entry.data)
            self.frames.append(([row[:width] for row in self.rows[:-1]],
                                {name: getattr(report, name) for name, _ in REPORT}))
        elif entry.kind in (Kind.WORD, Kind.ROW_END) and self.rows is not None:
            self.rows[-1] += list(entry.data.to_bytes(4, "little"))
            if entry.kind == Kind.ROW_END:
                self.rows.append([])


class _Port:
    """A sensor port with its inputs driven clock by clock."""

    def __init__(self, dut, rng):
        self.dut, self.rng, self.watch = dut, rng, _Watch()
        self.width, self.space = 0, 1.0

    async def clock(self, ctx, samples=(), first=0, last=0, end=0, bad=0):
        """A clock with these samples."""
        i, dut = self.dut.i, self.dut
        ctx.set(i.valid, len(samples))
        if samples:
            ctx.set(i.sample[0], samples[0])
        for signal, value in ((i.first, first), (i.last, last), (i.end, end), (i.bad, bad)):
            ctx.set(signal, int(value))
        ctx.set(dut.space, int(self.space >= 1 or self.rng.random() < self.space))
        *_, push, space, entry, active = await ctx.tick().sample(dut.push, dut.space, dut.entry,
                                                                 dut.active)
        if push and space:
            self.watch.look(entry, self.width)
        return active

    async def settle(self, ctx, scene):
        """Disable the port, and enable it with the settings of a scene."""
        dut = self.dut
        ctx.set(dut.enable, 0)
        self.space = 1.0
        for _ in range(60):
            await self.clock(ctx)
        ctx.set(dut.settings, scene.settings)
        ctx.set(dut.grid, {"weight": scene.weight, "binning": scene.binning})
        ctx.set(dut.balance, {"gains": scene.gains, "phase": scene.phase})
        self.width = scene.size[0]
        for _ in range(4):
            await self.clock(ctx)
        ctx.set(dut.enable, 1)
        for _ in range(60):
            await self.clock(ctx)


def check_sensor_port(dut, scenes=30, seed=9):
    """Frames in any window, with faults, a queue that is full, resets, and balances that change.

    Each frame with a clean report must be the golden model's of a frame that was sent. ``dut``:
    :class:`simulations.traces.Alone` with a sensor port of one sample per clock and a grid stage.
    """
    rng = np.random.default_rng(seed)
    port, counts = _Port(dut, rng), {"clean": 0, "bad": 0}

    async def bench(ctx):
        for number in range(scenes):
            scene = Scene(rng, dut.part.row)
            await port.settle(ctx, scene)
            await _scene(ctx, port, scene, number, counts)
        await _long(ctx, port)

    run_bench(dut, bench)
    assert counts["clean"] > scenes and counts["bad"] > scenes // 4, counts


async def _scene(ctx, port, scene, number, counts):
    """Frames of a scene, compared with those that were sent."""
    rng, dut, sent, whole = port.rng, port.dut, [], []
    port.space = 1.0 if number % 4 else float(rng.choice([.3, .6, .9]))
    port.watch.frames = []
    for k in range(4):
        change, rows, end = _fault(rng, scene.sent)
        frame = rng.integers(0, 4096, (rows, scene.sent[0]))
        if rows == scene.sent[1]:
            whole.append(frame)
            sent.append(scene.golden(frame))
        clocks = samples_of(frame, 1, rng, change, end)
        late = int(rng.integers(25)) if number % 5 == 2 and k == 2 else None
        ctx.set(dut.enable, int(late is None))
        stop = int(rng.integers(len(clocks))) if number % 5 == 1 and k == 1 else None
        for at, clock in enumerate(clocks):
            if at == late:          # the frame began before, or some clocks earlier
                ctx.set(dut.enable, 1)
            if at == len(clocks) // 2 and number % 5 == 3 and k == 1:
                # A frame has the gains of its beginning.
                scene.gains = [int(gain) for gain in rng.integers(0, 1024, 3)]
                ctx.set(dut.balance, {"gains": scene.gains, "phase": scene.phase})
                sent += [scene.golden(one) for one in whole]
            if at == stop:
                ctx.set(dut.enable if number % 2 else dut.reset, number % 2 ^ 1)
                if not number % 2:
                    port.watch.rows = None
            await port.clock(ctx, *clock)
            ctx.set(dut.reset, 0)
        for _ in range(int(rng.integers(8))):
            await port.clock(ctx)
        ctx.set(dut.enable, 1)
    port.space = 1.0
    for _ in range(60):
        await port.clock(ctx)
    for rows, report in port.watch.frames:
        clean = not any(report[name] for name in ("rows", "overflow", "bad", "lines"))
        counts["clean" if clean else "bad"] += 1
        assert not clean or rows in sent, (number, report)


async def _frame(ctx, port, rows):
    """A frame of these rows without pauses; its report, or None."""
    port.watch.frames = []
    for y, row in enumerate(rows):
        for x, sample in enumerate(row):
            await port.clock(ctx, [int(sample)], first=x == y == 0, last=x == len(row) - 1)
    await port.clock(ctx, end=1)
    for _ in range(60 if port.space else 2):
        await port.clock(ctx)
    return port.watch.frames[-1] if port.watch.frames else None


async def _long(ctx, port):
    """A row and a frame beyond what counters hold; many wrong rows, and frames that are missed."""
    rng, most = port.rng, (1 << SIZE_BITS) - 1
    scene = Scene(rng, port.dut.part.row)
    scene.weight = scene.binning = 0
    scene.sent, scene.corner, scene.size = (most, 2), (most - 11, 0), (9, 2)
    await port.settle(ctx, scene)
    frame = rng.integers(0, 4096, (2, most))
    rows, report = await _frame(ctx, port, [frame[0], frame[1][:20]])
    assert report["lines"] == 1 and not report["rows"] and rows[0] == scene.golden(frame)[0]
    scene.sent, scene.corner, scene.size = (1, most), (0, most - 9), (1, 9)
    await port.settle(ctx, scene)
    frame = rng.integers(0, 4096, (most, 1))
    rows, report = await _frame(ctx, port, frame)
    assert not any(report[name] for name in ("lines", "rows", "overflow", "bad"))
    assert rows == scene.golden(frame)
    _, report = await _frame(ctx, port, np.zeros((most + 5, 2)))
    assert report["lines"] == most
    before = report["missed"]
    port.space = 0.0
    for _ in range(_MISSED):
        await _frame(ctx, port, [[5]])
    for _ in range(60):
        await port.clock(ctx)
    port.space = 1.0
    _, report = await _frame(ctx, port, frame[:5])
    assert report["missed"] == before + _MISSED and report["rows"]
