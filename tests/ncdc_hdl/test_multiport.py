"""The three-port fetcher: windows, order and number of reads compared with the golden model."""

import numpy as np
import pytest
from amaranth import ResetInserter, Signal
from amaranth.sim import Simulator

from fetchers import Pauses, check_windows
from memory import read_agent
from ncdc_hdl.backend.multiport import Multiport
from ncdc_model.golden.picture import fetches
from pipelines import put, receive, run_bench

F = 10
WIDTH, HEIGHT = 37, 20


def requests(rng, count):
    """Origins that wander, jump, stay, with blanks between; the image's corners first."""
    x0, y0 = rng.integers(0, WIDTH - 2, count), rng.integers(0, HEIGHT - 2, count)
    for k in range(8, count):
        if rng.random() < .6:
            x0[k] = min(max(x0[k - 1] + rng.integers(0, 2), 0), WIDTH - 3)
            y0[k] = y0[k - 1]
    x0[:4], y0[:4] = (0, WIDTH - 3, 0, WIDTH - 3), (0, 0, HEIGHT - 3, HEIGHT - 3)
    return x0, y0, rng.random(count) < .15


@pytest.mark.parametrize("data_width", [32, 64, 128])
@pytest.mark.parametrize("pauses", [
    Pauses(0, 0, 0, (1, 1)), Pauses(.3, 0, .5, (1, 20)), Pauses(0, .5, .3, (8, 8)),
    Pauses(.5, .5, .7, (1, 60))])
def test_windows_equal_model(data_width, pauses):
    rng, count = np.random.default_rng(data_width), 150
    word = data_width // 8
    pitch = -(-WIDTH // word) * word
    raw = rng.integers(0, 256, (HEIGHT, pitch), np.uint8)
    x0, y0, blank = requests(rng, count)
    fetched, logs = check_windows(Multiport(F, data_width), raw, (x0, y0, blank), rng, pauses)
    expected = fetches(x0, y0, ~blank)
    assert fetched == expected < count
    assert [len(log) for log in logs] == [expected] * 3


def test_a_new_frame_is_read_again():
    """The same quad in the next frame is another frame's: it must not be reused."""
    rng = np.random.default_rng(1)
    raw = rng.integers(0, 256, (8, 8), np.uint8)
    item = {"x0": 2, "y0": 3, "fx": 0, "fy": 0, "blank": 0, "first": 1, "last": 1}
    blank_first = {**item, "blank": 1, "last": 0}
    items = [item, item, blank_first, {**item, "first": 0}]
    dut, logs = Multiport(F, 32), [[], [], []]

    async def bench(ctx):
        ctx.set(dut.pitch, 8)
        ctx.set(dut.limit, raw.size)
        await put(ctx, dut.i, items, lambda: False)

    async def sink(ctx):
        await receive(ctx, dut.o, len(items), lambda: False, 0)

    run_bench(dut, bench, sink, background=[
        read_agent(getattr(dut, f"bus{r}"), raw.ravel(), 4, rng, log=logs[r]) for r in range(3)])
    assert [len(log) for log in logs] == [3, 3, 3]


@pytest.mark.longer
def test_a_reset_does_not_forget_reads():
    """Words asked for before a reset come after it, and must not be taken for those of later."""
    rng = np.random.default_rng(2)
    raw = rng.integers(0, 256, (64, 64), np.uint8)
    origins = [(int(x), int(y)) for x, y in rng.integers(0, 61, (12, 2))]
    items = [{"x0": x, "y0": y, "fx": 0, "fy": 0, "blank": 0, "first": k == 0, "last": 0}
             for k, (x, y) in enumerate(origins)]
    for clocks in (8, 15, 31):
        dut, got = Multiport(F, 32), []
        reset = ResetInserter(Signal(name="rst"))
        held = reset.controls["sync"]
        simulator = Simulator(reset(dut))
        simulator.add_clock(1e-8)

        async def bench(ctx):
            ctx.set(dut.pitch, 64)
            ctx.set(dut.limit, raw.size)
            ctx.set(dut.i.valid, 1)
            for k in range(clocks):
                ctx.set(dut.i.payload, items[-1 - k % 3])
                await ctx.tick()
            ctx.set(dut.i.valid, 0)
            ctx.set(held, 1)
            await ctx.tick().repeat(2)
            ctx.set(held, 0)
            await put(ctx, dut.i, items, lambda: False)

        async def sink(ctx):
            await ctx.tick().repeat(clocks + 2)
            got.extend(await receive(ctx, dut.o, len(items), lambda: False, 0))

        simulator.add_testbench(bench)
        simulator.add_testbench(sink)
        for r in range(3):
            simulator.add_testbench(read_agent(getattr(dut, f"bus{r}"), raw.ravel(), 4, rng,
                                               latency=(40, 40)), background=True)
        simulator.run_until(3000e-8)
        assert len(got) == len(items), "windows are missing"
        for (x, y), window in zip(origins, got):
            assert list(window.samples) == raw[y:y + 3, x:x + 3].ravel().tolist()
