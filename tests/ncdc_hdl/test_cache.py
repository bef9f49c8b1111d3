"""The tile cache: windows, order and misses, whatever the memory and the consumer do."""

import numpy as np
import pytest

from fetchers import BASE, check_windows
from ncdc_hdl.backend.cache.cache import Cache
from ncdc_model.fetch.cache_options import CacheOptions

F = 10
WIDTH, HEIGHT = 93, 70
SMALL = CacheOptions(tiles=16, pending=8, outstanding=3, sequence_bits=5)


def places(rng, count, near):
    """Origins that wander and jump, ``near`` of them next to the one before; corners first."""
    x0, y0 = rng.integers(0, WIDTH - 2, count), rng.integers(0, HEIGHT - 2, count)
    for k in range(4, count):
        if rng.random() < near:
            x0[k] = np.clip(x0[k - 1] + rng.integers(-1, 3), 0, WIDTH - 3)
            y0[k] = np.clip(y0[k - 1] + rng.integers(-1, 2), 0, HEIGHT - 3)
    x0[:4], y0[:4] = (0, WIDTH - 3, 0, WIDTH - 3), (0, 0, HEIGHT - 3, HEIGHT - 3)
    return x0, y0, rng.random(count) < .15


def misses(x0, y0, blank, options, split):
    """Tiles (tx, ty) that an empty cache asks for, in order."""
    held, asked = {}, []
    for x, y, no in zip(x0.tolist(), y0.tolist(), blank.tolist()):
        if no:
            continue
        touched = {((tx & 1) | (ty & 1) << 1): (tx, ty) for tx in (x >> 4, (x + 2) >> 4)
                   for ty in (y >> 2, (y + 2) >> 2)}
        for bank in sorted(touched):
            tx, ty = touched[bank]
            rows = options.sets >> split
            slot = bank, (ty >> 1) % rows, (tx >> 1) % (1 << split)
            if held.get(slot) != (tx, ty):
                held[slot] = tx, ty
                asked.append((tx, ty))
    return asked


CACHES = [(32, SMALL, 1), (64, SMALL, 0), (128, CacheOptions(tiles=64), 2)]
PAUSES = [(0, 0, 0, (1, 1), .9), (.3, 0, .5, (1, 20), .7), (0, .5, .3, (8, 8), .5),
          (.1, .1, .7, (1, 60), 0)]


# Every second pair: each cache with two kinds of pauses, each kind with one or two caches.
@pytest.mark.parametrize("data_width,options,split,gap,stall,wait,latency,near", [
    pytest.param(*cache, *pauses, marks=[pytest.mark.regress] * ((i + j) % 2))
    for i, cache in enumerate(CACHES) for j, pauses in enumerate(PAUSES)])
def test_windows_and_misses(data_width, options, split, gap, stall, wait, latency, near):
    rng, count = np.random.default_rng(data_width + split), 250
    word = data_width // 8
    pitch = -(-WIDTH // word) * word
    raw = rng.integers(0, 256, (HEIGHT, pitch), np.uint8)
    found = places(rng, count, near)
    fetched, (log,) = check_windows(Cache(F, data_width, options), raw, found, rng, gap=gap,
                                    stall=stall, wait=wait, latency=latency, margin=4 * pitch,
                                    split=split)
    expected = misses(*found, options, split)
    assert fetched == len(expected)
    assert log == [(BASE + (4 * ty + row) * pitch + 16 * tx, 16 // word)
                   for tx, ty in expected for row in range(4)]
