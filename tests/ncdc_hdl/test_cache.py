"""The tile cache: windows, order and misses, whatever the memory and the consumer do."""

import numpy as np
import pytest

from fetchers import BASE, Pauses, check_windows
from ncdc_hdl.backend.cache.cache import Cache
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.interpolation import FAST, GRADIENT

F = 10
WIDTH, HEIGHT = 93, 70
SMALL = CacheOptions(tiles=16, pending=8, outstanding=3, sequence_bits=5)
LARGE_WINDOWS = CacheOptions(tiles=32, pending=8, outstanding=3, sequence_bits=5,
                             interpolation=GRADIENT)


def positions(rng, count, near, core=3):
    """First pixels that wander and jump, ``near`` of them next to the one before; corners first."""
    last_x, last_y = WIDTH - core, HEIGHT - core
    x0, y0 = rng.integers(0, last_x + 1, count), rng.integers(0, last_y + 1, count)
    for k in range(4, count):
        if rng.random() < near:
            x0[k] = np.clip(x0[k - 1] + rng.integers(-1, 3), 0, last_x)
            y0[k] = np.clip(y0[k - 1] + rng.integers(-1, 2), 0, last_y)
    x0[:4], y0[:4] = (0, last_x, 0, last_x), (0, 0, last_y, last_y)
    return x0, y0, rng.random(count) < .15


def misses(x0, y0, blank, options, split):
    """Tiles (tx, ty) that an empty cache asks for, in order."""
    held, asked, needs = {}, [], options.interpolation
    height, kinds = (4, 2) if needs == FAST else (2, 4)
    for x, y, no in zip(x0.tolist(), y0.tolist(), blank.tolist()):
        if no:
            continue
        columns = range(max(x - needs.margin, 0), min(x + needs.after, WIDTH - 1) + 1)
        rows = range(max(y - needs.margin, 0), min(y + needs.after, HEIGHT - 1) + 1)
        touched = {(tx % 2) + ty % kinds * 2: (tx, ty) for tx in {k // 16 for k in columns}
                   for ty in {k // height for k in rows}}
        for bank in sorted(touched):
            tx, ty = touched[bank]
            slot = bank, ty // kinds % (options.sets >> split), tx // 2 % (1 << split)
            if held.get(slot) != (tx, ty):
                held[slot] = tx, ty
                asked.append((tx, ty))
    return asked


CACHES = [(32, SMALL, 1), (64, SMALL, 0), (128, CacheOptions(tiles=64), 2),
          (32, LARGE_WINDOWS, 1), (128, LARGE_WINDOWS, 2)]
SHARED = [(32, SMALL, 1), (32, LARGE_WINDOWS, 2)]
PAUSES = [(Pauses(0, 0, 0, (1, 1)), .9), (Pauses(.3, 0, .5, (1, 20)), .7),
          (Pauses(0, .5, .3, (8, 8)), .5), (Pauses(.1, .1, .7, (1, 60)), 0)]


# Every fourth pair: each cache with one kind of pauses, each kind with one or two caches. Short
# ones are the smallest cache, and one with large windows.
@pytest.mark.parametrize("data_width,options,split,pauses,near", [
    pytest.param(*cache, *pauses, marks=[pytest.mark.regress] * ((i + j) % 4 > 0)
                 + [pytest.mark.longer] * (i not in (0, 2)))
    for i, cache in enumerate(CACHES) for j, pauses in enumerate(PAUSES)])
def test_windows_and_misses(data_width, options, split, pauses, near, memory="blocks"):
    # Of windows that are never near each other fewer ask for as many tiles.
    rng = np.random.default_rng(data_width + split)
    count = 250 if near else max(100, 3 * options.tiles)
    word = data_width // 8
    pitch = -(-WIDTH // word) * word
    raw = rng.integers(0, 256, (HEIGHT, pitch), np.uint8)
    needs = options.interpolation
    found = positions(rng, count, near, needs.core)
    cache = Cache(F, data_width, options, tile_memory=memory)
    fetched, (log,) = check_windows(cache, raw, found, rng, pauses, margin=4 * pitch, needs=needs,
                                    width=WIDTH, phase=(split & 1, 0), split=split)
    expected = misses(*found, options, split)
    assert near or len(expected) > 2 * options.tiles
    assert fetched == len(expected)
    height = needs.tile_height
    assert log == [(BASE + (height * ty + row) * pitch + 16 * tx, 16 // word)
                   for tx, ty in expected for row in range(height)]


@pytest.mark.parametrize("data_width,options,split", SHARED)
@pytest.mark.parametrize("pauses,near", [
    pytest.param(*each, marks=[pytest.mark.longer] * (i != 1)) for i, each in enumerate(PAUSES)])
def test_shared_banks(data_width, options, split, pauses, near):
    """The same windows and tiles, from half the block RAMs."""
    test_windows_and_misses(data_width, options, split, pauses, near, "shared")
