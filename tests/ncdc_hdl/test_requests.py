"""Read commands of tiles: addresses, rows below the frame, and one per clock while tiles wait."""

import numpy as np
import pytest

from ncdc_hdl.backend.cache.requests import TileRequests
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.interpolation import FAST, GRADIENT
from pipelines import put, run_bench

BASE, PITCH, HEIGHT = 0x1234_5670, 656, 63      # an odd height: rows of the lowest tiles are below


def requests_of(interpolation, tiles, gap, stall):
    """(clock, address, beyond) of each command for ``tiles``, (clock, tile) of each one taken."""
    options = CacheOptions(tiles=64, pending=8, interpolation=interpolation)
    dut, commands, taken = TileRequests(options), [], []

    async def source(ctx):
        ctx.set(dut.base, BASE)
        ctx.set(dut.pitch, PITCH)
        ctx.set(dut.height, HEIGHT)
        await ctx.tick().repeat(4)
        await put(ctx, dut.i, [{"x": x, "y": y, "slot": 0} for x, y in tiles], gap)

    async def watch(ctx):
        clock = 0
        while len(commands) < len(tiles) * options.tile_height:
            ctx.set(dut.o.ready, not stall())
            _, _, given, accepted, valid, ready, address, beyond = await ctx.tick().sample(
                dut.i.valid, dut.i.ready, dut.o.valid, dut.o.ready, dut.o.payload, dut.beyond)
            if given and accepted:
                taken.append(clock)
            if valid and ready:
                commands.append((clock, address, beyond))
            clock += 1

    run_bench(dut, source, watch)
    return commands, taken, options.tile_height


def random_tiles(rng, count, tile_height):
    return [(int(x), int(y)) for x, y in zip(rng.integers(0, PITCH // 16, count), rng.integers(
        0, -(-HEIGHT // tile_height), count))]


@pytest.mark.parametrize("interpolation", [FAST, GRADIENT])
@pytest.mark.parametrize("gap,stall", [(0, 0), (.5, 0), (.9, 0), (0, .5), (.7, .7)])
def test_a_command_for_each_row_of_each_tile(interpolation, gap, stall):
    rng = np.random.default_rng(3)
    tile_height = CacheOptions(interpolation=interpolation).tile_height
    tiles = [*random_tiles(rng, 150, tile_height), (0, (HEIGHT - 1) // tile_height), (0, 0)]
    commands, _, _ = requests_of(interpolation, tiles, lambda: rng.random() < gap,
                                 lambda: rng.random() < stall)
    rows = [(x, y * tile_height + row) for x, y in tiles for row in range(tile_height)]
    assert [command[1:] for command in commands] == [
        (BASE + row * PITCH + 16 * x, row >= HEIGHT) for x, row in rows]
    assert commands[-tile_height - 1][2]


@pytest.mark.parametrize("interpolation", [FAST, GRADIENT])
def test_tiles_that_wait_follow_each_other_without_a_gap(interpolation):
    """A word of 128 bits is a row: a tile of two rows takes two clocks of the bus, one of four
    rows four."""
    commands, taken, tile_height = requests_of(
        interpolation, random_tiles(np.random.default_rng(4), 50, 4), lambda: False,
        lambda: False)
    clocks = [command[0] for command in commands]
    assert clocks[0] == taken[0] + TileRequests.latency
    assert np.all(np.diff(clocks) == 1) and len(clocks) == 50 * tile_height


@pytest.mark.parametrize("interpolation", [FAST, GRADIENT])
@pytest.mark.parametrize("distance", [1, 2, 3, 4, 5, 8])
def test_every_tile_leaves_at_its_latency_or_when_the_one_before_has_left(interpolation, distance):
    """The rule of the planner: tiles come ``distance`` clocks apart."""
    steps = iter(range(1 << 20))
    commands, taken, tile_height = requests_of(
        interpolation, random_tiles(np.random.default_rng(5), 30, 4),
        lambda: next(steps) % distance != 0, lambda: False)
    firsts = [command[0] for command in commands[::tile_height]]
    free = 0
    for clock, first in zip(taken, firsts):
        if distance >= tile_height:
            assert first == max(free, clock + TileRequests.latency)
        free = first + tile_height
    assert np.all(np.diff(firsts) == max(distance, tile_height))
