"""Parts of a CSI-2 PHY in Amaranth's simulator: settling, sync bytes, search of the eye."""

import numpy as np
import pytest

from ncdc_hdl.camera.csi2.burst_start import BurstCheck, Settling
from ncdc_hdl.camera.csi2.eye_search import EyeSearch
from ncdc_spec.sensors.csi2 import SYNC_BYTE
from pipelines import run_bench

SYNC = np.unpackbits(np.array([SYNC_BYTE], np.uint8), bitorder="little")


def verdict(bits):
    """Whether BurstCheck takes a burst of bits for a good one; after one that it does."""
    dut, found = BurstCheck(), []
    right = np.concatenate([np.zeros(8, np.uint8), SYNC, np.ones(16, np.uint8)])

    async def bench(ctx):
        await ctx.tick()
        for burst in (right, bits):
            for byte in np.packbits(burst, bitorder="little"):
                ctx.set(dut.i.data, int(byte))
                ctx.set(dut.i.active, 1)
                await ctx.tick()
            ctx.set(dut.i.active, 0)
            for _ in range(3):
                ctx.set(dut.i.data, 0x5A)
                await ctx.tick()
                if ctx.get(dut.ended):
                    found.append(ctx.get(dut.good))

    run_bench(dut, bench)
    assert len(found) == 2 and found[0]
    return found[1]


@pytest.mark.parametrize("zeros", range(8, 24))
def test_a_sync_byte_at_each_position(zeros):
    """It is right, but with any of its bits wrong, or with a bit among the zeros, it is not."""
    rest = np.random.default_rng(zeros).integers(0, 2, 40, np.uint8)
    bits = np.concatenate([np.zeros(zeros, np.uint8), SYNC, rest])
    assert verdict(bits)
    for wrong in (3, zeros, *range(zeros + 3, zeros + 8)):
        changed = bits.copy()
        changed[wrong] ^= 1
        assert not verdict(changed), wrong - zeros


def test_a_burst_without_a_bit_is_bad():
    assert not verdict(np.zeros(64, np.uint8))


@pytest.mark.parametrize("settle", [1, 5, 40])
def test_settling_counts_clocks(settle):
    """Two clocks of the synchroniser, and one of the output, are more. Low for less: no burst."""
    dut, active = Settling(), []

    async def bench(ctx):
        ctx.set(dut.settle, settle)
        ctx.set(dut.low_power, 1)
        await ctx.tick().repeat(4)
        for low_power, clocks in ((0, 60), (1, 6), (0, settle), (1, 6)):
            ctx.set(dut.low_power, low_power)
            for _ in range(clocks):
                await ctx.tick()
                active.append(ctx.get(dut.active))

    run_bench(dut, bench)
    begins = settle + 2
    assert active == [0] * begins + [1] * (62 - begins) + [0] * (len(active) - 62)


def searched(eyes, bursts, *, steps=16, fails=None):
    """An EyeSearch after so many bursts, on lanes that are right from the first to the last of
    ``eyes``: (ready, delays, widths, failures). ``fails``: the burst from which on all are bad."""
    dut = EyeSearch(len(eyes), steps=steps, bursts=2, stride=2, timeout=2000, domain="sync")
    delays, result = [0] * len(eyes), []

    async def clock(ctx, before):
        await ctx.tick()
        moves = ctx.get(dut.move)
        for lane in range(len(eyes)):
            if before >> lane & ~moves >> lane & 1:
                delays[lane] += 1
        if not ctx.get(dut.load_n):
            delays[:] = [0] * len(eyes)
        return moves

    async def bench(ctx):
        moves = 0
        for number in range(bursts):
            for phase in range(60):
                if phase == 0:
                    good = sum((low <= delay <= high) << lane for lane, (delay, (low, high))
                               in enumerate(zip(delays, eyes)))
                    ctx.set(dut.good, 0 if fails is not None and number >= fails else good)
                ctx.set(dut.ended, (1 << len(eyes)) - 1 if phase == 0 else 0)
                moves = await clock(ctx, moves)
        result.extend([ctx.get(dut.ready), list(delays), [ctx.get(eye.width) for eye in dut.eyes],
                       ctx.get(dut.failures)])

    run_bench(dut, bench)
    return result


def test_each_lane_gets_the_middle_of_its_eye():
    """Steps of two: 8 to 21 are the steps 4 to 10, whose middle is 7; 0 to 9 are 0 to 4."""
    assert searched([(8, 21), (0, 9)], 120) == [1, [14, 4], [7, 5], 0]


def test_the_longer_of_two_runs_is_chosen_and_a_short_one_is_none():
    ready, _, widths, failures = searched([(8, 21), (4, 6)], 200)
    assert not ready and failures >= 2 and widths[1] <= 2


def test_bursts_that_turn_bad_start_the_search_again():
    ready, *_, failures = searched([(8, 21), (0, 9)], 300, fails=120)
    assert not ready and failures >= 1
