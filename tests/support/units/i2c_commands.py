"""Commands of the I2C controller, with a target that answers anything, or holds the lines."""

import numpy as np

from pipelines import run_bench

__all__ = ["check_i2c"]

_LONG = (1 << 15) + 1       # clocks of a quarter in which each bit of its counter changes


class _Lines:
    """Both lines; a target that pulls SDA low for random bits, and SCL for some clocks."""

    def __init__(self, dut, rng):
        self.dut, self.rng = dut, rng
        self.scl = self.sda = 1
        self.bits, self.stretch, self.pulls, self.spikes = [], 0, False, 0
        self.target = []        # bits that it sends from the next falling edge of SCL on
        self.limit, self.clashes = 0, False

    async def clock(self, ctx):
        """A clock; whether a command is over with it."""
        dut, rng = self.dut, self.rng
        scl_low, sda_low = ctx.get(dut.scl_low), ctx.get(dut.sda_low)
        scl = int(not scl_low and self.stretch <= 0)
        if not scl_low and self.stretch > 0:
            self.stretch -= 1
        if self.scl and not scl:
            self.pulls = not (self.target.pop(0) if self.target else 1)
            self.stretch = int(rng.choice([0, 0, 0, 3, 20])) if self.stretch <= 0 else self.stretch
        sda = int(not sda_low and not self.pulls)
        if scl and not self.scl:
            self.bits.append(sda)
        if scl and self.scl and self.sda and not sda and sda_low:
            self.bits = []
        self.scl, self.sda = scl, sda
        spike = self.spikes and rng.random() < .1
        self.spikes = 0 if spike else 1
        ctx.set(dut.scl, scl ^ int(spike and rng.integers(2)))
        ctx.set(dut.sda, sda ^ int(spike and rng.integers(2)))
        *_, done = await ctx.tick().sample(dut.done)
        return done


def _command(rng, number):
    """A command and the bits that the target sends: a byte or none, START, STOP."""
    kind = number % 4
    command = {"data": int(rng.integers(256)), "start": int(rng.random() < .5),
               "write": int(kind in (0, 1)), "read": int(kind == 2),
               "nack": int(rng.integers(2)), "stop": int(rng.random() < .5)}
    if kind == 3 and not command["start"]:
        command["stop"] = 1
    bits = [int(bit) for bit in rng.integers(0, 2, 8)] + [1] if command["read"] else (
        [1] * 8 + [int(rng.integers(2))])
    return command, bits


def check_i2c(dut, commands=70, seed=18):
    """Commands of all kinds: their bits on the bus, and what the target answers.

    ``dut``: :class:`simulations.traces.Alone` with an I2C controller.
    """
    rng = np.random.default_rng(seed)
    lines, outcome = _Lines(dut, rng), {"lost": 0, "timeout": 0, "right": 0}

    async def bench(ctx):
        ctx.set(dut.scl, 1)
        ctx.set(dut.sda, 1)
        for number in range(commands):
            await _run(ctx, dut, lines, number, outcome)
        await _long(ctx, dut)

    run_bench(dut, bench)
    assert outcome["right"] > commands // 2 and outcome["lost"] and outcome["timeout"], outcome


async def _run(ctx, dut, lines, number, outcome):
    """A command, and what comes of it."""
    rng = lines.rng
    command, bits = _command(rng, number)
    byte = command["write"] or command["read"]
    # On an idle bus a byte without START is sent to free it: its first bit has no edge.
    checked = byte and not (lines.scl and not command["start"])
    clash = number % 11 == 10
    slow = number % 17 == 16
    if clash:
        bits = [int(bit) for bit in rng.integers(0, 2, 9)]
    # The target's bit changes as SCL falls; it falls at the end of START, or before the first bit.
    lines.target = bits if byte else []
    if not lines.scl and byte and not command["start"]:
        lines.pulls = not lines.target.pop(0)
    elif not lines.scl:
        lines.pulls = False
        if byte:
            lines.target = [1, *bits]
    lines.bits = []
    longer = number % 17 == 8
    limit = 650 if longer else int(rng.integers(8, 40)) if slow else 1 << int(rng.integers(9, 32))
    ctx.set(dut.limit, limit)
    lines.stretch = 900 if longer else 400 if slow else 0
    ctx.set(dut.quarter, int(rng.integers(8, 14) if byte else rng.integers(8, 1000)))
    ctx.set(dut.i.payload, command)
    ctx.set(dut.i.valid, 1)
    assert ctx.get(dut.i.ready)
    await lines.clock(ctx)
    ctx.set(dut.i.valid, int(rng.integers(2)))      # one that comes too early is not taken
    reset = int(rng.integers(1, 300)) if number % 13 == 12 else None
    for clock in range(20_000):
        if clock == 5:
            ctx.set(dut.i.valid, 0)
        if clock == reset:
            ctx.set(dut.reset, 1)
        done = await lines.clock(ctx)
        ctx.set(dut.reset, 0)
        if done or clock == reset:
            break
    else:
        raise AssertionError("the command does not end")
    if clock != reset:
        _compare(ctx.get(dut.result), command, lines, checked, outcome)
    lines.stretch, lines.pulls, lines.target = 0, False, []
    for _ in range(12):
        await lines.clock(ctx)


def _compare(result, command, lines, checked, outcome):
    """Compare a command's result with the bits on the bus."""
    for name in ("lost", "timeout"):
        if getattr(result, name):
            outcome[name] += 1
            return
    outcome["right"] += 1
    if checked:
        seen = lines.bits[:9]
        value = int("".join(map(str, seen[:8])), 2)
        assert result.data == value, (command, seen)
        assert result.nack == (command["write"] and seen[8])
        if command["write"]:
            assert value == command["data"]
        else:
            assert seen[8] == command["nack"]


async def _long(ctx, dut):
    """A quarter of many clocks: SDA falls after the first one of START."""
    ctx.set(dut.reset, 1)
    ctx.set(dut.scl, 1)
    ctx.set(dut.sda, 1)
    await ctx.tick()
    ctx.set(dut.reset, 0)
    ctx.set(dut.quarter, _LONG)
    ctx.set(dut.limit, 1 << 31)
    ctx.set(dut.i.payload, {"data": 0, "start": 0, "write": 1, "read": 0, "nack": 0, "stop": 1})
    ctx.set(dut.i.valid, 1)
    await ctx.tick()
    ctx.set(dut.i.valid, 0)
    for clock in range(_LONG + 20):
        assert ctx.get(dut.sda_low) == (clock >= _LONG), clock
        await ctx.tick()
