"""The gate that waits for the camera's rows, alone."""

import numpy as np
import pytest

from formal import sby
from formal.rows import Rows
from ncdc_hdl.backend.row_gate import RowGate
from ncdc_model.planner.follow import rows_needed
from ncdc_spec.interpolation import FAST, GRADIENT
from pipelines import get, put, run_bench

F_BITS, HEIGHT = 10, 30


def requests(rng, count, lanes):
    """Groups with windows from the top of the frame to its bottom, somewhat up and down."""
    groups = []
    for k in range(count):
        down = np.clip(k * HEIGHT // count + rng.integers(-3, 4, lanes), 0, HEIGHT - 3).tolist()
        pixels = [{"x0": int(rng.integers(4000)), "y0": down[lane],
                   "fx": k % 1024, "fy": lane, "blank": int(rng.random() < .2)}
                  for lane in range(lanes)]
        fields = pixels[0] if lanes == 1 else {"lane": pixels}
        groups.append({**fields, "first": k == 0, "last": k == count - 1})
    return groups


def fields(payload, lanes):
    """What a taken payload holds, as of :func:`requests`."""
    names = "x0", "y0", "fx", "fy", "blank"
    pixels = [{name: getattr(lane, name) for name in names}
              for lane in ([payload] if lanes == 1 else payload.lane)]
    whole = pixels[0] if lanes == 1 else {"lane": pixels}
    return {**whole, "first": bool(payload.first), "last": bool(payload.last)}


def needed(group):
    """Rows that must be in memory for a group."""
    return max(int(rows_needed(pixel["y0"], not pixel["blank"], HEIGHT))
               for pixel in group.get("lane", [group]))


def run(groups, lanes, *, follow=1, rows=lambda clock: HEIGHT, gap=0, stall=0, abort_at=None):
    """[(group taken, clock)] and the camera's rows by clock; the frame starts in clock 0."""
    rng = np.random.default_rng(1)
    dut = RowGate(F_BITS, lanes)
    got, clocks, seen = [], [], []

    async def world(ctx):
        ctx.set(dut.height, HEIGHT)
        ctx.set(dut.follow, follow)
        for clock in range(20 + 12 * len(groups)):
            ctx.set(dut.start, clock == 0)
            ctx.set(dut.camera_rows, rows(clock))
            ctx.set(dut.abort, abort_at is not None and clock >= abort_at)
            seen.append(rows(clock))
            _, _, valid, ready = await ctx.tick().sample(dut.o.valid, dut.o.ready)
            if valid and ready:
                clocks.append(clock)

    async def source(ctx):
        await ctx.tick().repeat(3)
        await put(ctx, dut.i, groups, lambda: rng.random() < gap)

    async def sink(ctx):
        got.extend(await get(ctx, dut.o, len(groups), lambda: rng.random() < stall))

    run_bench(dut, world, source, sink)
    return [fields(payload, lanes) for payload in got], clocks, seen


@pytest.mark.parametrize("lanes", [1, 2, 4])
@pytest.mark.parametrize("gap,stall", [(0, 0), (.3, .5)])
def test_a_group_passes_when_its_rows_are_there_and_not_later(lanes, gap, stall):
    groups = requests(np.random.default_rng(3), 60, lanes)
    got, clocks, seen = run(groups, lanes, rows=lambda clock: min(HEIGHT, clock // 9), gap=gap,
                            stall=stall)
    assert got == groups
    waited = 0
    for k, (group, clock) in enumerate(zip(groups, clocks)):
        assert seen[clock] >= needed(group), "passed before its rows were there"
        there = next(c for c, rows in enumerate(seen) if rows >= needed(group))
        if not (gap or stall):
            # A group follows the one before; the first one comes in clock 3.
            passes = there + RowGate.rows_latency + RowGate.latency
            assert clock == max(passes, clocks[k - 1] + 1 if k else 3 + RowGate.latency)
        waited += clock > (clocks[k - 1] if k else 4) + 3
    assert waited >= 4


def test_without_follow_nothing_waits():
    groups = requests(np.random.default_rng(3), 40, 1)
    got, clocks, _ = run(groups, 1, follow=0, rows=lambda clock: 0)
    assert got == groups and clocks == list(
        range(3 + RowGate.latency, 43 + RowGate.latency))


def test_the_counter_may_begin_again_once_the_frame_is_complete():
    groups = requests(np.random.default_rng(3), 40, 1)
    got, clocks, _ = run(groups, 1, rows=lambda clock: HEIGHT if clock == 1 else 0)
    first = 1 + RowGate.rows_latency + RowGate.latency
    assert got == groups and clocks == list(range(first, first + 40))


def test_rows_of_the_frame_before_do_not_count():
    """The counter of the frame before stands at its end until the clock before the start."""
    groups = requests(np.random.default_rng(3), 5, 1)
    groups[0] |= {"y0": 0, "blank": 0}
    dut, taken = RowGate(F_BITS), []

    async def world(ctx):
        ctx.set(dut.height, HEIGHT)
        ctx.set(dut.follow, 1)
        ctx.set(dut.o.ready, 1)
        for frame, rows in enumerate((HEIGHT, 0)):
            ctx.set(dut.camera_rows, rows)
            ctx.set(dut.start, 1)
            await ctx.tick()
            ctx.set(dut.start, 0)
            await ctx.tick().repeat(3)
            ctx.set(dut.i.payload, groups[0])
            ctx.set(dut.i.valid, 1)
            for _ in range(10):
                _, _, valid, ready = await ctx.tick().sample(dut.o.valid, dut.i.ready)
                taken.append((frame, valid))
                if ready:
                    ctx.set(dut.i.valid, 0)

    run_bench(dut, world)
    assert (0, 1) in taken and (1, 1) not in taken


@pytest.mark.parametrize("lanes", [1, 2])
def test_an_abort_blanks_what_would_wait(lanes):
    """The camera stops after eight rows: until the abort the groups wait, then all of them pass."""
    groups = requests(np.random.default_rng(3), 40, lanes)
    got, clocks, _ = run(groups, lanes, rows=lambda clock: 8, abort_at=60)
    assert len(got) == len(groups) and max(clocks) >= 60
    for group, out in zip(groups, got):
        for pixel, result in zip(group.get("lane", [group]), out.get("lane", [out])):
            there = int(rows_needed(pixel["y0"], not pixel["blank"], HEIGHT)) <= 8
            assert result["blank"] == (pixel["blank"] or not there)


@pytest.mark.longer
@pytest.mark.parametrize("needs,lanes", [
    (GRADIENT, 1), *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        (GRADIENT, 2), (FAST, 1), (FAST, 2)))],
    ids=lambda each: getattr(each, "name", each))
def test_no_group_passes_before_its_rows_are_there(lanes, needs, tmp_path):
    """Proved for all time, all requests and all ways that the counter may go."""
    assert sby.run(Rows(lanes, needs=needs), tmp_path, mode="prove", depth=3) == (sby.PASS, set())


@pytest.mark.longer
def test_a_proof_of_a_gate_that_opens_a_row_early_fails(tmp_path, monkeypatch):
    monkeypatch.setattr(RowGate, "_after", staticmethod(lambda each: each.after - 1))
    gate = Rows(state=False)
    assert sby.run(gate, tmp_path, mode="bmc", depth=10) == (sby.FAIL, {"row_is_there0"})


@pytest.mark.longer
def test_what_is_proved_about_happens(tmp_path):
    status, names = sby.run(Rows(), tmp_path, mode="cover", depth=10)
    assert (status, names) == (sby.PASS, {"waits", "passes_below_the_end"})
