"""A fetcher in the Amaranth simulator: its windows against the raw frame, its reads counted."""

import numpy as np
from amaranth.sim import Simulator

from memory import read_agent
from pipelines import get, put

__all__ = ["BASE", "check_windows"]

BASE = 64       # byte address of the raw frame


def check_windows(dut, raw, places, rng, *, gap, stall, wait, latency, margin=64, **controls):
    """Fetch windows of ``raw`` (height, pitch) with ``dut`` and compare every field of each.

    ``places``: x0, y0, blank of the windows, in order. ``gap``, ``stall``, ``wait``, ``latency``:
    of the source, the sink and the memory, as :func:`memory.read_agent` has them. ``margin``: bytes
    of memory behind the frame. ``controls``: further inputs of the fetcher, by name. Returns the
    number of reads that it counts and the commands (address, words) of each of its ports.
    """
    x0, y0, blank = places
    count, pitch = len(x0), raw.shape[1]
    content = np.concatenate([np.zeros(BASE, np.uint8), raw.ravel(), np.zeros(margin, np.uint8)])
    items = [{"x0": int(x0[k]), "y0": int(y0[k]), "fx": k, "fy": 1023 - k, "blank": int(blank[k]),
              "first": k == 0, "last": k == count - 1} for k in range(count)]
    got, fetched, logs = [], [], [[] for _ in range(dut.ports)]

    async def source(ctx):
        for name, value in {"base": BASE, "limit": len(content), "height": len(raw),
                            "pitch": pitch, **controls}.items():
            ctx.set(getattr(dut, name), value)
        await put(ctx, dut.i, items, lambda: rng.random() < gap)

    async def sink(ctx):
        got.extend(await get(ctx, dut.o, count, lambda: rng.random() < stall))

    async def count_fetches(ctx):
        while True:
            fetched.append((await ctx.tick().sample(dut.fetched))[2])

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(source)
    simulator.add_testbench(sink)
    simulator.add_testbench(count_fetches, background=True)
    for r, log in enumerate(logs):
        agent = read_agent(getattr(dut, f"bus{r}"), content, dut.data_width // 8, rng,
                           wait=wait, latency=latency, log=log)
        simulator.add_testbench(agent, background=True)
    simulator.run()

    for k, window in enumerate(got):
        assert (window.fx, window.fy, window.blank) == (k, 1023 - k, blank[k])
        assert (window.first, window.last) == (k == 0, k == count - 1)
        if not blank[k]:
            expected = raw[y0[k]:y0[k] + 3, x0[k]:x0[k] + 3]
            assert list(window.samples) == expected.ravel().tolist(), f"window {k}"
            assert (window.odd_column, window.odd_row) == (x0[k] & 1, y0[k] & 1)
    return sum(fetched), logs
