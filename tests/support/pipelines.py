"""Driving components in the Amaranth simulator: free-running pipelines and streams."""

from collections import deque
from contextlib import contextmanager

from amaranth.sim import Simulator

__all__ = ["get", "put", "receive", "run_bench", "run_pipeline", "run_stream", "send", "watched"]


_PERIOD = 1e-8          # seconds of a clock
_CLOCKS = 5_000_000     # no bench needs more
_WATCHERS = []          # further test benches of every simulation


@contextmanager
def watched(bench):
    """In this context every :func:`run_bench` has the test bench ``bench`` in the background."""
    _WATCHERS.append(bench)
    try:
        yield
    finally:
        _WATCHERS.remove(bench)


def run_bench(dut, *benches, background=(), clocks=_CLOCKS):
    """Simulate ``dut`` with the given async test benches until all have ended.

    Parameters
    ----------
    dut : Elaboratable
    benches : async functions of the simulator's context
    background : sequence of these
        Not waited for.
    clocks : int
        After so many the simulation fails: a component that hangs does not hold up the tests.
    """
    async def limit(ctx):
        await ctx.delay(clocks * _PERIOD)
        raise AssertionError(f"the benches have not ended after {clocks} clocks")

    simulator = Simulator(dut)
    simulator.add_clock(_PERIOD)
    for bench in benches:
        simulator.add_testbench(bench)
    for bench in (*background, *_WATCHERS, limit):
        simulator.add_testbench(bench, background=True)
    simulator.run()


def run_pipeline(dut, inputs, drive, sample, prepare=None):
    """Feed one of ``inputs`` per clock to a free-running pipeline; results in order.

    ``drive(ctx, item)`` sets the inputs, ``sample()`` gives the output signals,
    ``prepare(ctx)``, if any, runs before. Exactly
    ``dut.latency`` clocks later the result must be there: the list would be shifted otherwise.
    """
    results = []

    async def bench(ctx):
        if prepare:
            await prepare(ctx)
        for k in range(len(inputs) + dut.latency):
            if k < len(inputs):
                drive(ctx, inputs[k])
            await ctx.tick()
            if k >= dut.latency - 1 and len(results) < len(inputs):
                results.append(tuple(ctx.get(signal) for signal in sample()))

    run_bench(dut, bench)
    return results


async def put(ctx, stream, items, pause):
    """Offer ``items`` in order, idling while ``pause()`` says so."""
    for item in items:
        while pause():
            await ctx.tick()
        ctx.set(stream.payload, item)
        ctx.set(stream.valid, 1)
        taken = False
        while not taken:
            _, _, taken = await ctx.tick().sample(stream.ready)
        ctx.set(stream.valid, 0)


async def get(ctx, stream, count, pause):
    """Take ``count`` payloads; one that is stalled must stay valid and unchanged."""
    got, held = [], None
    while len(got) < count:
        ready = not pause()
        ctx.set(stream.ready, ready)
        _, _, valid, payload = await ctx.tick().sample(stream.valid, stream.payload)
        assert held is None or (valid and payload == held), f"payload {len(got)} changed in a stall"
        held = payload if valid and not ready else None
        if valid and ready:
            got.append(payload)
    ctx.set(stream.ready, 0)
    return got


async def send(ctx, items_in, items, pause, latency=0):
    """Announce and send ``items`` to a ``Credited`` input, each ``latency`` clocks after its issue.

    Idles while ``pause()`` says so, and then until all have left.
    """
    waiting, on_the_way, space = deque(items), deque([None] * latency), True
    while waiting or any(item is not None for item in on_the_way):
        issue = bool(waiting) and space and not pause()
        on_the_way.append(waiting.popleft() if issue else None)
        item = on_the_way.popleft()
        ctx.set(items_in.issue, issue)
        ctx.set(items_in.valid, item is not None)
        if item is not None:
            ctx.set(items_in.payload, item)
        _, _, space = await ctx.tick().sample(items_in.space)
    ctx.set(items_in.issue, 0)
    ctx.set(items_in.valid, 0)


async def receive(ctx, items_out, count, pause, latency):
    """Take ``count`` items of a ``Credited`` output; there is no space while ``pause()``.

    None may be announced without space a clock before, and each comes ``latency`` clocks later.
    """
    got, on_the_way, allowed = [], deque([False] * latency), True
    while len(got) < count:
        space = not pause()
        ctx.set(items_out.space, space)
        _, _, issue, valid, payload = await ctx.tick().sample(
            items_out.issue, items_out.valid, items_out.payload)
        assert allowed or not issue, f"item {len(got)} is announced, there is no space"
        on_the_way.append(bool(issue))
        assert on_the_way.popleft() == valid, f"item {len(got)} is not {latency} clocks late"
        allowed = space
        if valid:
            got.append(payload)
    ctx.set(items_out.space, 0)
    return got


def run_stream(dut, items, count, gap, stall):
    """Send ``items`` into ``dut.i`` and take ``count`` from ``dut.o``, with the given pauses."""
    results = []

    async def source(ctx):
        await put(ctx, dut.i, items, gap)

    async def sink(ctx):
        results.extend(await get(ctx, dut.o, count, stall))

    run_bench(dut, source, sink)
    return results
