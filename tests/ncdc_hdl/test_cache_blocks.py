"""Blocks of the tile cache: boxes of groups, and windows cut from the tile memory."""

import numpy as np
import pytest

from ncdc_hdl.backend.cache.align import Align
from ncdc_hdl.backend.cache.boxes import Boxes
from ncdc_hdl.backend.cache.tiles import Tiles
from ncdc_model.fetch.cache_options import CacheOptions
from pipelines import get, put, run_bench

OPTIONS = CacheOptions(tiles=64, pending=8)
F = 10


def parts(x0, y0, blank, lanes):
    """(lanes, box or None) of each look-up of a group, by the rule of ``CacheOptions``."""
    used = [k for k in lanes if not blank[k]]
    if not used:
        return [(lanes, None)]
    box = (min(x0[k] for k in used), min(y0[k] for k in used), max(x0[k] for k in used) + 2,
           max(y0[k] for k in used) + 2)
    if len(lanes) == 1 or ((box[2] >> 3) - (box[0] >> 3) <= 1 and box[3] - box[1] <= 3):
        return [(lanes, box)]
    half = len(lanes) // 2
    return parts(x0, y0, blank, lanes[:half]) + parts(x0, y0, blank, lanes[half:])


@pytest.mark.parametrize("lanes", [2, 4])
@pytest.mark.parametrize("gap,stall", [(0, 0), (.3, .5)])
def test_groups_become_boxes(lanes, gap, stall):
    rng, count = np.random.default_rng(lanes), 400
    first = rng.integers(0, 60, (count, 1, 2))
    places = np.clip(first + rng.integers(-4, 8, (count, lanes, 2)) // [1, 3], 0, 4093)
    blank = rng.random((count, lanes)) < .2
    blank[:3] = True
    items, expected = [], []
    for k, (place, no) in enumerate(zip(places.tolist(), blank.tolist())):
        x0, y0 = zip(*place)
        items.append({"lane": [{"x0": x, "y0": y, "fx": 0, "fy": k, "blank": int(b)}
                               for x, y, b in zip(x0, y0, no)],
                      "first": k == 0, "last": k == count - 1})
        found = parts(x0, y0, no, list(range(lanes)))
        expected += [(k, sum(1 << n for n in chosen), box, place is found[-1])
                     for place in found for chosen, box in [place]]
    dut, got, sizes = Boxes(F, lanes), [], set()

    async def source(ctx):
        await put(ctx, dut.i, items, lambda: rng.random() < gap)

    async def sink(ctx):
        while not (got and got[-1].group.last and got[-1].end):
            got.extend(await get(ctx, dut.o, 1, lambda: rng.random() < stall))

    run_bench(dut, source, sink)
    assert len(got) == len(expected)
    for out, (k, mask, box, end) in zip(got, expected):
        assert (out.group.lane[0].fy, out.mask, out.end) == (k, mask, end)
        assert out.used == (box is not None)
        if box:
            assert (out.x0, out.y0, out.x1, out.y1) == box
        sizes.add(mask.bit_count())
    assert sizes == {1, 2, 4} if lanes == 4 else sizes == {1, 2}


@pytest.mark.parametrize("word_bytes", [4, 8])
@pytest.mark.parametrize("split", range(OPTIONS.max_split + 1))
def test_any_window_in_one_clock(word_bytes, split):
    """A frame that fits the cache as a whole; every place of a window in a block of tiles."""
    rng = np.random.default_rng(split)
    across, down = 2 << split, 2 * (OPTIONS.sets >> split)
    frame = rng.integers(0, 256, (4 * down, 16 * across), np.uint8)
    tiles, align = Tiles(OPTIONS, word_bytes), Align(word_bytes)

    def place(tx, ty):
        return (ty >> 1) % (OPTIONS.sets >> split) << split | (tx >> 1) % (1 << split)

    async def bench(ctx):
        ctx.set(tiles.split, split)
        ctx.set(tiles.shift, 1)
        for ty in range(down):
            for tx in range(across):
                slot = ((tx & 1) | (ty & 1) << 1) * OPTIONS.sets + place(tx, ty)
                for row in range(4):
                    for word in range(16 // (2 * word_bytes)):
                        start = 16 * tx + 2 * word_bytes * word
                        pair = [int.from_bytes(frame[4 * ty + row, start + word_bytes * k:][
                            :word_bytes].tobytes(), "little") for k in range(2)]
                        ctx.set(tiles.fill, {"enable": 3, "slot": slot, "row": row, "word": word,
                                             "data": pair})
                        await ctx.tick()
        ctx.set(tiles.fill.enable, 0)
        for _ in range(300):
            x, y = int(rng.integers(0, 16 * across - 2)), int(rng.integers(0, 4 * down - 2))
            ctx.set(tiles.box, {"set": place(x >> 4, y >> 2),
                                "next_set": place((x >> 4) + 1, (y >> 2) + 1),
                                "odd_tile": {"x": x >> 4 & 1, "y": y >> 2 & 1},
                                "row": y & 3, "word": (x & 15) // word_bytes})
            await ctx.tick().repeat(tiles.latency)
            window = [[ctx.get(tiles.samples[(y + j) % 4][(x + i) % (2 * word_bytes)])
                       for i in range(3)] for j in range(3)]
            assert window == frame[y:y + 3, x:x + 3].tolist(), (x, y)

    run_bench(tiles, bench)

    async def cut(ctx):
        ctx.set(align.shift, 1)
        ctx.set(align.take, 1)
        block = rng.integers(0, 256, (4, 2 * word_bytes))
        ctx.set(align.samples, block.tolist())
        for x in range(16):
            for y in range(4):
                ctx.set(align.x, x)
                ctx.set(align.y, y)
                await ctx.tick().repeat(align.latency)
                assert [ctx.get(sample) for sample in align.o] == [
                    block[(y + j) % 4, (x + i) % (2 * word_bytes)] for j in range(3)
                    for i in range(3)], (x, y)

    run_bench(align, cut)
