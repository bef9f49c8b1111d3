"""A fetcher in the Amaranth simulator: checks its windows by the raw frame, counts its reads."""

from dataclasses import dataclass

import numpy as np

from memory import read_agent
from ncdc_spec.interpolation import FAST
from pipelines import put, receive, run_bench

__all__ = ["BASE", "Pauses", "check_windows", "flipped", "turned"]

BASE = 64       # byte address of the raw frame


@dataclass(frozen=True)
class Pauses:
    """Probabilities of a pause of source, sink and memory; range of clocks of the memory's answer.

    ``wait`` and ``latency`` are as :func:`memory.read_agent` has them.
    """
    gap: float
    stall: float
    wait: float
    latency: tuple[int, int]


def flipped(x0, y0, phase):
    """How the window at (x0, y0) comes: its even columns are even ones, and green in even rows."""
    return {"x": x0 % 2, "y": 1 - (y0 + phase[0] + phase[1]) % 2}


def turned(window, flip):
    """The window, reflected as ``flip`` says."""
    return window[..., ::-1 if flip["y"] else 1, ::-1 if flip["x"] else 1]


def _edge(first, size, needs):
    """How much of a window is outside of a frame of ``size`` columns, or rows."""
    before, beyond = needs.margin - first, first + needs.after - (size - 1)
    return {"missing": max(before, beyond, 0), "after": int(beyond > 0)}


def check_windows(dut, raw, positions, rng, pauses, *, margin=64, needs=FAST, width=None,
                  phase=(0, 0), held=None, **controls):
    """Fetch windows of ``raw`` (height, pitch) with ``dut`` and compare every field of each.

    ``positions``: x0, y0, blank of the windows, in order. ``margin``: bytes of memory after the
    frame. ``needs``: the interpolation; of one whose windows may leave the frame, ``width`` are its
    columns that count, and ``phase`` is the parity of the red samples. ``held``: the samples that
    the fetcher makes of ``raw``, by default the same. ``controls``: further inputs of the fetcher,
    by name. Returns the number of reads that it counts and the commands (address, words) of each of
    its ports.
    """
    x0, y0, blank = positions
    count, pitch = len(x0), raw.shape[1]
    content = np.concatenate([np.zeros(BASE, np.uint8), raw.ravel(), np.zeros(margin, np.uint8)])
    items = [{"x0": int(x0[k]), "y0": int(y0[k]), "fx": k, "fy": 1023 - k, "blank": int(blank[k]),
              "first": k == 0, "last": k == count - 1} for k in range(count)]
    framed = raw if held is None else held
    if needs.margin:
        framed = np.pad(framed[:, :width], needs.margin, mode="reflect")
        controls["phase"] = phase[0] | phase[1] << 1
        for item in items:
            item["edge_x"] = _edge(item["x0"], width, needs)
            item["edge_y"] = _edge(item["y0"], raw.shape[0], needs)
    got, fetched, logs = [], [], [[] for _ in range(dut.ports)]

    async def source(ctx):
        for name, value in {"base": BASE, "limit": len(content), "height": len(raw),
                            "pitch": pitch, **controls}.items():
            ctx.set(getattr(dut, name), value)
        await put(ctx, dut.i, items, lambda: rng.random() < pauses.gap)

    async def sink(ctx):
        got.extend(await receive(ctx, dut.o, count, lambda: rng.random() < pauses.stall,
                                 dut.window_latency))

    async def count_fetches(ctx):
        while True:
            fetched.append((await ctx.tick().sample(dut.fetched))[2])

    agents = [read_agent(getattr(dut, f"bus{r}"), content, dut.data_width // 8, rng,
                         wait=pauses.wait, latency=pauses.latency, log=log)
              for r, log in enumerate(logs)]
    run_bench(dut, source, sink, background=(count_fetches, *agents))

    for k, window in enumerate(got):
        assert (window.fx, window.fy, window.blank) == (k, 1023 - k, blank[k])
        assert (window.first, window.last) == (k == 0, k == count - 1)
        if not blank[k]:
            window_samples = framed[y0[k]:y0[k] + needs.window, x0[k]:x0[k] + needs.window]
            if needs.margin:
                flip = flipped(x0[k], y0[k], phase)
                assert (window.flipped.x, window.flipped.y) == (flip["x"], flip["y"]), f"window {k}"
                window_samples = turned(window_samples, flip)
            else:
                assert (window.odd_column, window.odd_row) == (x0[k] & 1, y0[k] & 1)
            expected = [window_samples[j, i] for j, i in needs.samples]
            assert list(window.samples) == expected, f"window {k}"
    return sum(fetched), logs
