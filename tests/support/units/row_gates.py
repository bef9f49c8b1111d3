"""The gate that waits for the camera's rows: frames of any height, rows that come just in time."""

import numpy as np

from ncdc_model.planner.follow import rows_needed
from pipelines import get, put, run_bench

__all__ = ["check_row_gate"]

_LEAD = 3       # clocks from the start of a frame to its first group
_SETTLED = 200  # clocks after which no window passes any more whose rows do not come


def _requests(rng, count, height):
    """Windows from the top of the frame to its bottom, somewhat up and down."""
    for k in range(count):
        down = int(np.clip(k * height // count + rng.integers(-3, 4), 0, height - 3))
        yield {"x0": int(rng.integers(4096)), "y0": down, "fx": int(rng.integers(1 << 10)),
               "fy": int(rng.integers(1 << 10)), "blank": int(rng.random() < .2),
               "edge_x": {"missing": int(rng.integers(4)), "after": int(rng.integers(2))},
               "edge_y": {"missing": int(rng.integers(4)), "after": int(rng.integers(2))},
               "first": k == 0, "last": k == count - 1}


def _rows(needed, rng):
    """Camera's rows by clock: for a while one too few for each window, then just enough."""
    yield from [0] * _LEAD
    most = 0
    for rows in needed:
        for value, clocks in ((max(most, rows - 1), 6), (max(most, rows), rng.integers(1, 5))):
            yield from [value] * int(clocks)
            most = value


def check_row_gate(dut, heights, count=120):
    """Each group passes unchanged, and not before its rows are there.

    Parameters
    ----------
    dut : ncdc_hdl.backend.row_gate.RowGate
        Of one lane and windows with a margin.
    heights : sequence of int
        Rows of the frames, one after the other; some begin with the counter of the one before.
        Every fourth one does not wait. The camera stops half-way in the one before that, which is
        aborted: windows whose rows are missing pass as blank ones.
    count : int
        Groups of a frame.
    """
    rng = np.random.default_rng(6)
    seen, got, clocks = [], [], []
    frames = [list(_requests(rng, count, height)) for height in heights]
    needed = [[int(rows_needed(one["y0"], not one["blank"], height, dut.interpolation))
               for one in frame] for frame, height in zip(frames, heights)]

    async def world(ctx):
        for k, height in enumerate(heights):
            ctx.set(dut.height, height)
            ctx.set(dut.follow, k % 4 != 3)
            rows = [0, *_rows(needed[k][:count // 2] if k % 4 == 2 else needed[k], rng)]
            shown = []
            for clock in range(100 * count):
                ctx.set(dut.start, clock == 0)
                ctx.set(dut.abort, k % 4 == 2 and clock > len(rows) + _SETTLED)
                ctx.set(dut.camera_rows, rows[min(clock, len(rows) - 1)])
                shown.append(rows[min(clock, len(rows) - 1)])
                if clock == _LEAD:
                    seen.append(shown)
                    clocks.append([])
                _, _, valid, ready = await ctx.tick().sample(dut.o.valid, dut.o.ready)
                if valid and ready:
                    clocks[k].append(clock)
                    if len(clocks[k]) == count:
                        break
            # The counter begins again once the frame is complete.
            ctx.set(dut.camera_rows, int(rng.integers(height)))
            await ctx.tick().repeat(2)

    async def source(ctx):
        for k, frame in enumerate(frames):
            while len(seen) <= k:
                await ctx.tick()
            gap = rng.choice([0, .3])
            await put(ctx, dut.i, frame, lambda gap=gap: rng.random() < gap)

    async def sink(ctx):
        for _ in frames:
            stall = rng.choice([0, .4])
            got.append(await get(ctx, dut.o, count, lambda stall=stall: rng.random() < stall))

    run_bench(dut, world, source, sink)
    for k, frame in enumerate(frames):
        for item, out, rows, clock in zip(frame, got[k], needed[k], clocks[k]):
            found = {name: getattr(out, name) for name in ("x0", "y0", "fx", "fy", "blank",
                                                           "first", "last")}
            there = k % 4 == 3 or seen[k][clock] >= rows
            assert there or k % 4 == 2, "passed before its rows were there"
            assert found == {name: item[name] for name in found} | {
                "blank": item["blank"] or not there}
            assert all(getattr(out, axis)[name] == value for axis in ("edge_x", "edge_y")
                       for name, value in item[axis].items())
