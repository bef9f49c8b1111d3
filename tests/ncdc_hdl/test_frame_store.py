"""Which buffer a reader has, for how long, and what becomes of one that holds it too long."""

import pytest
from amaranth.sim import Simulator

from ncdc_hdl.camera.frame_store import FrameStore

LIMIT = 20


def run(bench, readers=2):
    """``bench(ctx, store)`` with a store; two frames have been written, the second one is newer."""
    store = FrameStore(readers)
    simulator = Simulator(store)
    simulator.add_clock(1e-6)

    async def whole(ctx):
        for _ in range(2):
            await frame(ctx, store)
        await bench(ctx, store)

    simulator.add_testbench(whole)
    simulator.run()


async def pulse(ctx, *signals):
    for signal in signals:
        ctx.set(signal, 1)
    await ctx.tick()
    for signal in signals:
        ctx.set(signal, 0)


async def frame(ctx, store, good=1):
    """Write a frame; its buffer."""
    await pulse(ctx, store.begins)
    buffer = ctx.get(store.buffer)
    ctx.set(store.good, good)
    await pulse(ctx, store.ends)
    return buffer


async def clocks_held(ctx, reader, most=100):
    """Clocks for which a reader has its buffer from now on."""
    for clock in range(most):
        if not ctx.get(reader.held):
            return clock
        await ctx.tick()
    return None


@pytest.mark.parametrize("number", [0, 1])
def test_a_buffer_is_taken_away_after_the_limit(number):
    async def bench(ctx, store):
        reader = store.readers[number]
        ctx.set(store.limit, LIMIT)
        await pulse(ctx, reader.claim)
        assert await clocks_held(ctx, reader) == LIMIT
        assert (ctx.get(reader.lost), ctx.get(store.taken)) == (1, 1)
        # Until it says that it knows.
        await ctx.tick().repeat(3 * LIMIT)
        assert (ctx.get(reader.lost), ctx.get(store.taken)) == (1, 1)
        await pulse(ctx, reader.release)
        assert (ctx.get(reader.lost), ctx.get(reader.held)) == (0, 0)

    run(bench)


def test_a_claim_ends_what_was_lost_and_begins_the_time_anew():
    async def bench(ctx, store):
        reader = store.readers[1]
        ctx.set(store.limit, LIMIT)
        await pulse(ctx, reader.claim)
        assert await clocks_held(ctx, reader) == LIMIT and ctx.get(reader.lost)
        await pulse(ctx, reader.claim)
        assert (ctx.get(reader.lost), ctx.get(reader.held)) == (0, 1)
        await ctx.tick().repeat(LIMIT - 1)
        await pulse(ctx, reader.claim)          # in the last clock
        assert await clocks_held(ctx, reader) == LIMIT

    run(bench)


def test_a_reader_that_releases_in_time_loses_nothing():
    async def bench(ctx, store):
        reader = store.readers[1]
        ctx.set(store.limit, LIMIT)
        await pulse(ctx, reader.claim)
        await ctx.tick().repeat(LIMIT - 1)
        await pulse(ctx, reader.release)        # in the last clock
        await ctx.tick().repeat(2 * LIMIT)
        assert (ctx.get(reader.lost), ctx.get(reader.held), ctx.get(store.taken)) == (0, 0, 0)

    run(bench)


def test_without_a_limit_a_buffer_is_held_for_ever_and_released_it_is_free():
    async def bench(ctx, store):
        first, second = store.readers
        await pulse(ctx, first.claim)
        assert await clocks_held(ctx, first, 500) is None
        held = ctx.get(first.buffer)
        # Others get newer frames, and nothing writes into the one that is held.
        written = [await frame(ctx, store) for _ in range(8)]
        assert held not in written and len(set(written)) >= 2
        await pulse(ctx, second.claim)
        assert ctx.get(second.buffer) == written[-1] != held
        await pulse(ctx, first.release)
        assert held in [await frame(ctx, store) for _ in range(8)]

    run(bench)


def test_the_first_reader_follows_the_writer():
    async def bench(ctx, store):
        first, second = store.readers
        newest = ctx.get(store.newest)
        ctx.set(store.follow, 1)
        await pulse(ctx, first.claim)
        assert not ctx.get(first.held), "nothing is being written"
        await pulse(ctx, store.begins)
        written = ctx.get(store.buffer)
        await pulse(ctx, first.claim, second.claim)
        assert (ctx.get(first.held), ctx.get(first.buffer)) == (1, written)
        assert (ctx.get(second.held), ctx.get(second.buffer)) == (1, newest) != (1, written)
        # A bad frame is forgotten, but not by whoever follows it.
        ctx.set(store.good, 0)
        await pulse(ctx, store.ends)
        assert ctx.get(first.held) and await frame(ctx, store) != written
        ctx.set(store.follow, 0)
        await pulse(ctx, first.claim)
        assert ctx.get(first.buffer) == ctx.get(store.newest) != written

    run(bench)
