"""The burst writer alone: words of any rows, and a memory that waits."""

import numpy as np

from pipelines import put, run_bench

__all__ = ["check_burst_writer"]

# Words of a row, and how often the memory waits and the source pauses, in each phase.
_PHASES = ((1, 2), .9, 0), ((1, 40), .3, .1), ((1, 9), 0, 0), ((1, 3), .5, .5), ((30, 60), .8, 0)


def _rows(rng, dut, lengths, count):
    """[(address, [(data, enable)])] of rows, some of them without a word; the last has one."""
    word = dut.data_width // 8
    for k in range(count):
        words = int(rng.integers(*lengths, endpoint=True)) if k % 7 or k == count - 1 else 0
        address = int(rng.integers((1 << 32) // word - words)) * word
        yield address, [(int.from_bytes(rng.bytes(word), "little"), int(rng.integers(1 << word)))
                        for _ in range(words)]


def _items(dut, rows):
    """Words at the input; a row without one is a void word, and some rows end with a void one."""
    for k, (address, words) in enumerate(rows):
        last, word = k == len(rows) - 1, dut.data_width // 8
        void = not words or (k % 5 == 3 and len(words) % dut.burst)
        for n, (data, enable) in enumerate(words):
            ends = n == len(words) - 1 and not void
            yield {"address": address + word * n, "data": data, "enable": enable, "void": 0,
                   "end": int(ends), "last": int(ends and last)}
        if void:
            yield {"address": address + word * len(words), "data": 0, "enable": 0, "void": 1,
                   "end": 1, "last": int(last)}


def _beats(dut, rows):
    """(address, burstcount, data, enable) of each word on the bus."""
    for address, words in rows:
        for first in range(0, len(words), dut.burst):
            burst = words[first:first + dut.burst]
            for data, enable in burst:
                yield address + dut.data_width // 8 * first, len(burst), data, enable


def check_burst_writer(dut, rows=60, seed=5):
    """Each word in its burst, in order, and ``done`` once for each frame.

    ``dut``: a :class:`ncdc_hdl.avalon.burst_writer.BurstWriter` without pending writes.
    """
    rng, bus = np.random.default_rng(seed), dut.bus
    frames = [list(_rows(rng, dut, lengths, rows)) for lengths, _, _ in _PHASES]
    found, done = [], []

    async def source(ctx):
        for k, ((_, _, pause), frame) in enumerate(zip(_PHASES, frames)):
            await put(ctx, dut.i, list(_items(dut, frame)),
                      lambda pause=pause: rng.random() < pause)
            while len(done) == k:
                await ctx.tick()

    async def memory(ctx):
        while True:
            waits = rng.random() < _PHASES[min(len(done), len(_PHASES) - 1)][1]
            ctx.set(bus.waitrequest, waits)
            _, _, write, ended, *beat = await ctx.tick().sample(
                bus.write, dut.done, bus.address, bus.burstcount, bus.writedata, bus.byteenable)
            if write and not waits:
                found.append(tuple(map(int, beat)))
            if ended:
                done.append(len(found))

    run_bench(dut, source, background=(memory,))
    expected = [list(_beats(dut, frame)) for frame in frames]
    assert found == sum(expected, [])
    assert done == np.cumsum([len(one) for one in expected]).tolist()
