"""Stages between others, and what leads from one clock to another: queues that run full, words."""

import numpy as np
from amaranth import Value
from amaranth.lib import wiring
from amaranth.lib.fifo import AsyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from pipelines import run_bench

__all__ = ["check_queue", "check_relay", "check_word_crossing", "queue_of"]


def queue_of(width, depth, r_domain, w_domain):
    """A queue between two clocks with the signature of a component."""
    queue = AsyncFIFOBuffered(width=width, depth=depth, r_domain=r_domain, w_domain=w_domain)
    queue.signature = wiring.Signature({
        "w_data": In(width), "w_en": In(1), "w_rdy": Out(1), "r_data": Out(width), "r_en": In(1),
        "r_rdy": Out(1), "r_level": Out(queue.r_level.shape())})
    return queue


def _bits(rng, width):
    """A random number of so many bits."""
    return int.from_bytes(rng.bytes(-(-width // 8)), "little") & (1 << width) - 1


def check_relay(dut, clocks=1500, seed=22):
    """Random items, which come and are taken at any rates, with resets: each comes out once.

    ``dut``: :class:`simulations.traces.Alone` with a relay.
    """
    rng, waiting = np.random.default_rng(seed), []
    width = len(Value.cast(dut.i.payload))

    async def bench(ctx):
        offered, rates = False, (.5, .5)
        for clock in range(clocks):
            if clock % 100 == 0:
                rates = rng.choice([.2, .6, 1]), rng.choice([.2, .6, 1])
            if not offered and rng.random() < rates[0]:
                item, offered = _bits(rng, width), True
                ctx.set(Value.cast(dut.i.payload), item)
            reset = rng.random() < .005
            ctx.set(dut.i.valid, int(offered))
            ctx.set(dut.o.ready, int(rng.random() < rates[1]))
            ctx.set(dut.reset, int(reset))
            _, _, takes, valid, ready, found = await ctx.tick().sample(
                dut.i.ready, dut.o.valid, dut.o.ready, Value.cast(dut.o.payload))
            assert valid == bool(waiting) and takes == (len(waiting) < 2)
            assert not valid or found == waiting[0]
            waiting[:] = waiting[bool(valid and ready):] + [item] * bool(offered and takes)
            offered = offered and not takes
            if reset:
                waiting.clear()

    run_bench(dut, bench)


class _Clock:
    """The other clock, which moves between clocks of the core, at most in each of them."""

    def __init__(self, dut, rng):
        self.dut, self.rng = dut, rng
        self.level, self.left, self.longest = 0, 1, 1

    def falls(self):
        """Whether it falls before the next clock of the core: then its inputs may change."""
        return self.level and self.left == 1

    def rises(self):
        """Whether it rises before the next clock of the core."""
        return not self.level and self.left == 1

    def move(self, ctx):
        """Let it go on by a clock of the core."""
        self.left -= 1
        if self.left == 0:
            self.left = int(self.rng.integers(1, self.longest + 1))
            self.level ^= 1
            ctx.set(self.dut.clock, self.level)


# Clocks of the core, rates of writing and reading: (nearly) full, empty, and full again.
_PHASES = (1200, 1, 0), (5200, 1, .3), (400, .5, 1), (1600, .3, 1), (1600, 1, .6), (600, .05, 1)


def check_queue(dut, seed=23):
    """A queue that runs full and empty at all its positions: entries in order, none is lost.

    ``dut``: :class:`simulations.traces.Alone` with a queue of :func:`queue_of`.
    """
    rng, width = np.random.default_rng(seed), len(dut.w_data)
    depth, stored, clock = dut.part.depth, [], _Clock(dut, rng)
    full = 0

    async def bench(ctx):
        nonlocal full
        for number, (clocks, writes, reads) in enumerate(_PHASES):
            clock.longest = 1 + (number > 2)
            for _ in range(clocks):
                if clock.falls():
                    ctx.set(dut.w_en, int(rng.random() < writes))
                    ctx.set(dut.w_data, _bits(rng, width))
                if clock.rises():
                    ready = ctx.get(dut.w_rdy)
                    full += not ready
                    if ready and ctx.get(dut.w_en):
                        stored.append(ctx.get(dut.w_data))
                clock.move(ctx)
                ctx.set(dut.r_en, int(rng.random() < reads))
                *_, there, takes, found = await ctx.tick().sample(dut.r_rdy, dut.r_en,
                                                                  dut.r_data)
                assert len(stored) <= depth + 1
                assert not there or found == stored[0]
                if there and takes:
                    stored.pop(0)

    run_bench(dut, bench)
    assert full > depth


def check_word_crossing(dut, clocks=8000, seed=24):
    """Words that change by any bits, one at a time too, and clocks of any rates, which stop.

    What comes is one of the words given, and the last one if it stays. ``dut``:
    :class:`simulations.traces.Alone` with a crossing of words.
    """
    rng, clock = np.random.default_rng(seed), _Clock(dut, np.random.default_rng(seed + 1))
    word, there = dut.i.as_value(), dut.o.as_value()
    width, wait = len(word), 24     # clocks of the core until a word is there

    async def bench(ctx):
        value, stays, long = ctx.get(word), 0, False
        given = {value}
        for number in range(clocks):
            if number % 500 == 0:
                clock.longest = int(rng.integers(1, 4))
            resets = number % 1500 > 1490
            if stays == 0 or resets:
                stays = int(rng.choice([1, 5, wait * clock.longest]))
                long = stays > 5 and not resets
                value = (_bits(rng, width) if rng.random() < .2 else
                         value ^ 1 << int(rng.integers(width)))
                given.add(value)
                ctx.set(word, value)
            stays -= 1
            ctx.set(dut.reset, int(resets))
            if not clock.rises():
                ctx.set(dut.other_reset, int(resets))
            clock.move(ctx)
            await ctx.tick()
            found = ctx.get(there)
            assert found in given
            assert stays or not long or found == value

    run_bench(dut, bench)
