"""Blocks of the tile cache: boxes of groups, and windows cut from the tile memory."""

import numpy as np
import pytest

from fetchers import turned
from ncdc_hdl.backend.cache.align import align_for
from ncdc_hdl.backend.cache.boxes import Boxes
from ncdc_hdl.backend.cache.layouts import Banks, banks_for
from ncdc_hdl.backend.cache.tiles import Tiles
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.interpolation import FAST, GRADIENT
from pipelines import get, put, run_bench

OPTIONS = {each: CacheOptions(tiles=64, pending=8, interpolation=each)
           for each in (FAST, GRADIENT)}
# Of each interpolation, the kind and the banks of its tile memory, and all splits.
MEMORIES = [(each, memory, banks, split) for each, options in OPTIONS.items()
            for memory, banks in (*(("blocks", Banks(*banks)) for banks in (
                ((2, 4), (2, 8)) if each == FAST else ((2, 8), (4, 4)))),
                ("shared", banks_for(32, 1, each, shared=True)))
            for split in range(options.max_split + 1)]
F = 10


def edge(first, size, needs):
    """What the window address says of a window in a frame of ``size`` columns, or rows."""
    before = max(needs.margin - first, 0)
    beyond = max(first + needs.after - (size - 1), 0)
    return {"missing": max(before, beyond), "after": int(beyond > 0)}


def parts(x0, y0, blank, lanes, needs, size, word):
    """(lanes, box or None) of each look-up of a group, by the rule of ``CacheOptions``."""
    used = [k for k in lanes if not blank[k]]
    if not used:
        return [(lanes, None)]
    box = (min(max(x0[k] - needs.margin, 0) for k in used),
           min(max(y0[k] - needs.margin, 0) for k in used),
           max(min(x0[k] + needs.after, size - 1) for k in used),
           max(min(y0[k] + needs.after, size - 1) for k in used))
    rows, tile_rows = (4, 2) if needs == FAST else (8, 4)
    height = 4 if needs == FAST else 2
    if len(lanes) == 1 or (box[2] // word - box[0] // word < 16 // word and box[3] - box[1] < rows
                           and box[3] // height - box[1] // height < tile_rows):
        return [(lanes, box)]
    half = len(lanes) // 2
    return (parts(x0, y0, blank, lanes[:half], needs, size, word)
            + parts(x0, y0, blank, lanes[half:], needs, size, word))


@pytest.mark.parametrize("needs,lanes", [(FAST, 2), (FAST, 4), (GRADIENT, 1), (GRADIENT, 2),
                                         (GRADIENT, 4)])
@pytest.mark.parametrize("gap,stall", [
    (.3, .5), pytest.param(0, 0, marks=pytest.mark.regress)])
def test_groups_become_boxes(needs, lanes, gap, stall):
    rng, count, size = np.random.default_rng(lanes), 400, 61
    word = 4 if (needs, lanes) == (GRADIENT, 4) else 8
    first = rng.integers(0, 60, (count, 1, 2))
    apart = rng.integers(-4, 32 // word + 4, (count, lanes, 2)) // [1, 3]
    positions = np.clip(first + apart, 0, size - needs.core)
    blank = rng.random((count, lanes)) < .2
    blank[:3] = True
    items, expected = [], []
    for k, (position, no) in enumerate(zip(positions.tolist(), blank.tolist())):
        x0, y0 = zip(*position)
        group = [{"x0": x, "y0": y, "fx": 0, "fy": k, "blank": int(b)}
                 | ({"edge_x": edge(x, size, needs), "edge_y": edge(y, size, needs)}
                    if needs.margin else {}) for x, y, b in zip(x0, y0, no)]
        items.append((group[0] if lanes == 1 else {"lane": group})
                     | {"first": k == 0, "last": k == count - 1})
        found = parts(x0, y0, no, list(range(lanes)), needs, size, word)
        expected += [(k, sum(1 << n for n in chosen), box, part is found[-1])
                     for part in found for chosen, box in [part]]
    dut, got, sizes = Boxes(F, lanes, needs), [], set()

    async def source(ctx):
        await put(ctx, dut.i, items, lambda: rng.random() < gap)

    async def sink(ctx):
        while not (got and got[-1].group.last and got[-1].end):
            got.extend(await get(ctx, dut.o, 1, lambda: rng.random() < stall))

    run_bench(dut, source, sink)
    assert len(got) == len(expected)
    for out, (k, mask, box, end) in zip(got, expected):
        assert (out.mask, out.end) == (mask, end)
        assert (out.group.first, out.group.last) == (k == 0, k == count - 1)
        assert lanes > 1 or out.group.fy == k
        assert out.used == (box is not None)
        if box:
            assert (out.x0, out.y0, out.x1, out.y1) == box
        sizes.add(mask.bit_count())
    assert sizes == {1 << k for k in range(lanes.bit_length())}


@pytest.mark.parametrize("needs,memory,banks,split", MEMORIES)
def test_any_window_in_one_clock(needs, memory, banks, split):
    """A frame that fits the cache as a whole; every position of a window in a block of tiles."""
    rng = np.random.default_rng(split)
    odd = split % 2 if needs.margin else 0      # whether rows are exchanged
    options, height, kinds = OPTIONS[needs], needs.tile_height, needs.tile_rows
    size, rows = needs.window, needs.box_rows
    across, down = 2 << split, kinds * (options.sets >> split)
    frame = rng.integers(0, 256, (height * down, 16 * across), np.uint8)
    tiles = Tiles(options, banks, memory)

    def set_of(tx, ty):
        return (ty // kinds) % (options.sets >> split) << split | (tx >> 1) % (1 << split)

    async def bench(ctx):
        ctx.set(tiles.split, split)
        ctx.set(tiles.load, 1)
        if needs.margin:
            ctx.set(tiles.odd_rows, odd)
        for ty in range(down):
            for tx in range(across):
                slot = ((tx & 1) | ty % kinds << 1) * options.sets + set_of(tx, ty)
                for row in range(height):
                    samples = frame[height * ty + row, 16 * tx:][:16].reshape(
                        -1, banks.across, banks.word_bytes)
                    for word, written in enumerate(samples):
                        ctx.set(tiles.fill, {
                            "enable": (1 << banks.across) - 1, "slot": slot, "row": row,
                            "word": word,
                            "data": [int.from_bytes(each.tobytes(), "little") for each in written]})
                        await ctx.tick()
        ctx.set(tiles.fill.enable, 0)
        for _ in range(300):
            x = int(rng.integers(0, 16 * across - size + 1))
            y = int(rng.integers(0, height * down - size + 1))
            tx, ty = x // 16, y // height
            ctx.set(tiles.box, {"set": set_of(tx, ty),
                                "next_set": set_of(tx + 1, ty + kinds - 1),
                                "odd_tile": {"x": tx & 1, "y": ty % kinds},
                                "row": y % height, "word": (x & 15) // banks.word_bytes})
            await ctx.tick().repeat(tiles.latency)
            window = [[ctx.get(tiles.samples[(y + j) % rows ^ odd][(x + i) % banks.columns])
                       for i in range(size)] for j in range(size)]
            assert window == frame[y:y + size, x:x + size].tolist(), (x, y)

    run_bench(tiles, bench)


@pytest.mark.parametrize("needs,columns", [(FAST, 4), (FAST, 8), (FAST, 16), (GRADIENT, 8),
                                           (GRADIENT, 16)])
def test_windows_are_cut_from_the_samples(needs, columns):
    """Every position modulo the samples; of windows with a margin, with every edge now and then."""
    rng = np.random.default_rng(columns)
    align, rows = align_for(columns, needs), needs.box_rows
    block = rng.integers(0, 256, (rows, columns))

    def inside(k, edge):
        """Row or column k of the window, or that which stands for it."""
        first, last = ((edge["missing"], 99) if not edge["after"] else
                       (0, needs.window - 1 - edge["missing"]))
        return 2 * first - k if k < first else 2 * last - k if k > last else k

    async def cut(ctx):
        ctx.set(align.take, 3)
        ctx.set(align.samples, block.tolist())
        for x, y in np.ndindex(max(16, columns), rows):
            ctx.set(align.x, x)
            ctx.set(align.y, y)
            edges = {name: {"missing": int(rng.integers(0, needs.margin + 1)),
                            "after": int(rng.integers(0, 2))} for name in "xy"}
            for name, edge in edges.items() if needs.margin else ():
                ctx.set(getattr(align, f"edge_{name}"), edge)
            odd = int(rng.integers(0, 2)) if needs.margin else 0
            if needs.margin:
                ctx.set(align.odd_rows, odd)
            await ctx.tick().repeat(1 + align.latency)
            window = np.array([[block[(y - needs.margin + inside(j, edges["y"])) % rows ^ odd,
                                      (x - needs.margin + inside(i, edges["x"])) % columns]
                                for i in range(needs.window)] for j in range(needs.window)])
            if needs.margin:
                window = turned(window, {"x": x % 2, "y": (y + odd) % 2})
            assert [ctx.get(sample) for sample in align.o] == [
                window[j, i] for j, i in needs.samples], (x, y, edges, odd)

    run_bench(align, cut)
