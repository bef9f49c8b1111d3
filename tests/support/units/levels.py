"""The byte of a sample, and a sample moved along its line: compared with the golden model."""

import numpy as np

from ncdc_spec.sensors.grid import evened
from ncdc_spec.sensors.level import LINEAR, PIECES, levelled
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY
from pipelines import run_bench

__all__ = ["check_level", "check_moved", "random_curve"]

_GAINS = 0, 1, 127, 128, UNITY - 1, UNITY, UNITY + 1, 511, LARGEST_GAIN


def random_curve(rng):
    """Nodes of a curve: any, at both ends of their range, rising, or the straight line."""
    kind = int(rng.integers(4))
    if kind == 0:
        return LINEAR
    if kind == 1:
        return tuple(int(node) for node in rng.choice([0, 1, 255, 256], PIECES + 1))
    nodes = rng.integers(0, 257, PIECES + 1)
    return tuple(int(node) for node in (np.sort(nodes) if kind == 2 else nodes))


def _run(dut, clocks, drive):
    """[(reset, output)] of each clock, as the clock's edge finds them.

    ``drive(ctx, clock)`` sets the inputs of a clock and returns whether there is a reset.
    """
    seen = []

    async def bench(ctx):
        for clock in range(clocks):
            reset = int(drive(ctx, clock))
            ctx.set(dut.reset, reset)
            *_, out = await ctx.tick().sample(dut.o)
            seen.append((reset, out))

    run_bench(dut, bench)
    return seen


def _compare(dut, wanted, seen):
    """Each output is that of the inputs ``latency`` clocks ago, or 0 after a reset."""
    for clock, ((reset, _), (_, found)) in enumerate(zip(seen, seen[1:]), 1):
        source = clock - dut.latency
        expected = 0 if reset else wanted[source] if source >= 0 else None
        assert expected is None or found == expected, (clock, found, expected)


def check_level(dut, settings=60, count=120, seed=5):
    """Samples and gains of any size, in every clock, with so many black levels and curves.

    ``dut``: :class:`simulations.traces.Alone` with a level. A reset lasts from one setting to the
    next, until no sample before it is under way.
    """
    rng, inputs, levels = np.random.default_rng(seed), [], []
    clocks = settings * (count + dut.latency)
    for k in range(settings):
        black = int(rng.choice([0, 1, 168, 4095, int(rng.integers(4096))]))
        levels.append({"black": black, "curve": random_curve(rng)})

    def drive(ctx, clock):
        number, at = divmod(clock, count + dut.latency)
        if at == 0:
            ctx.set(dut.level, levels[number])
        sample = int(rng.choice([int(rng.integers(4096)), 0, 4095, levels[number]["black"]]))
        gain = int(rng.choice([int(rng.integers(LARGEST_GAIN + 1)), int(rng.choice(_GAINS))]))
        ctx.set(dut.i, sample)
        ctx.set(dut.gain, gain)
        inputs.append((number, sample, gain))
        return at < dut.latency or rng.random() < .02

    seen = _run(dut, clocks, drive)
    wanted = [int(levelled(sample, gains=gain, **levels[number]))
              for number, sample, gain in inputs]
    _compare(dut, wanted, seen)


def check_moved(dut, count=4000, seed=6):
    """Samples of any line, or of one with the smallest and largest values, in every clock.

    ``dut``: :class:`simulations.traces.Alone` with a :class:`ncdc_hdl.camera.moved.Moved`.
    """
    rng, wanted = np.random.default_rng(seed), []

    def drive(ctx, clock):
        line = rng.integers(0, 4096, 9) if clock % 2 else rng.choice([0, 1, 4094, 4095], 9)
        odd, weight = int(rng.integers(2)), int(rng.integers(4))
        ctx.set(dut.taps, [int(value) for value in line[2 + odd:7 + odd][::-1]])
        ctx.set(dut.odd, odd)
        ctx.set(dut.weight, weight)
        # Equal rows do not move along columns.
        wanted.append(int(evened(np.tile(line, (5, 1)), weight)[2][4 + odd]))
        return rng.random() < .02

    _compare(dut, wanted, _run(dut, count, drive))
