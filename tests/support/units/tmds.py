"""A TMDS encoder, compared with a decoder and an algorithm, both written from the specification."""

import numpy as np

from pipelines import run_bench

__all__ = ["check_tmds", "decoded", "encoded", "specified"]

# Digital Visual Interface 1.0, section 3.3.3, as strings of bits from 9 to 0.
TOKENS = {(0, 0): "1101010100", (1, 0): "0010101011", (0, 1): "0101010100", (1, 1): "1010101011"}


def decoded(word):
    """A byte of a word, by figure 3-6 of the specification; the word as bits, the lowest first."""
    bits = [1 - bit for bit in word[:8]] if word[9] else list(word[:8])
    byte = [bits[0]]
    for k in range(1, 8):
        byte.append(bits[k] ^ bits[k - 1] if word[8] else 1 - (bits[k] ^ bits[k - 1]))
    return sum(bit << k for k, bit in enumerate(byte))


def specified(data, count):
    """Word of a byte and the new count, by the flow chart of figure 3-5."""
    d = [data >> k & 1 for k in range(8)]
    q = [d[0]]
    xnor = sum(d) > 4 or (sum(d) == 4 and d[0] == 0)
    for k in range(1, 8):
        q.append(int(q[-1] == d[k]) if xnor else int(q[-1] != d[k]))
    q8 = 0 if xnor else 1
    ones, zeros = sum(q), 8 - sum(q)
    inverted = [1 - bit for bit in q]
    if count == 0 or ones == zeros:
        word = (q if q8 else inverted) + [q8, 1 - q8]
        return word, count + (ones - zeros if q8 else zeros - ones)
    if (count > 0 and ones > zeros) or (count < 0 and zeros > ones):
        return inverted + [q8, 1], count + 2 * q8 + zeros - ones
    return q + [q8, 0], count - 2 * (1 - q8) + ones - zeros


def encoded(dut, items):
    """Words, as bits, of (visible, byte or control)."""
    words = []

    async def bench(ctx):
        for visible, value in [*items, *[(0, 0)] * dut.latency]:
            ctx.set(dut.visible, visible)
            ctx.set(dut.colour if visible else dut.control, value)
            await ctx.tick()
            words.append(ctx.get(dut.word))

    run_bench(dut, bench)
    return [[word >> k & 1 for k in range(10)] for word in words[dut.latency - 1:-1]]


def sequence(seed):
    """Lines of random bytes, each byte in many states, between runs of control words."""
    rng = np.random.default_rng(seed)
    items = []
    for _ in range(30):
        items += [(0, int(rng.integers(4))) for _ in range(rng.integers(1, 5))]
        kind = rng.integers(3)
        line = rng.integers(0, 256, rng.integers(1, 200)) if kind else [
            int(rng.choice([0, 255, 0x55, 0x10]))] * 100
        items += [(1, int(byte)) for byte in line]
    return items + [(1, byte) for byte in range(256)]


def check_tmds(dut, seed=1):
    """Each word is the specification's."""
    count, items = 0, sequence(seed)
    words = encoded(dut, items)
    assert len(words) == len(items)
    for (visible, value), word in zip(items, words):
        if visible:
            wanted, count = specified(value, count)
            assert word == wanted
            assert decoded(word) == value
        else:
            count = 0
            assert "".join(map(str, reversed(word))) == TOKENS[value & 1, value >> 1]
