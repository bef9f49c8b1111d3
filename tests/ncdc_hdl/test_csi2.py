"""Parts of the CSI-2 receiver in Amaranth's simulator."""

from itertools import product

import numpy as np
import pytest
from amaranth import *
from amaranth.sim import Simulator

from ncdc_hdl.camera.csi2.checksum import Checksum
from ncdc_hdl.camera.csi2.header import HeaderDecoder
from ncdc_hdl.camera.csi2.lane_aligner import LaneAligner
from ncdc_hdl.camera.csi2.layouts import FAULTS
from ncdc_hdl.camera.csi2.receiver import Receiver
from ncdc_hdl.camera.csi2.word_aligner import WordAligner
from ncdc_hdl.camera.fault_counters import FaultCounters
from ncdc_sim.csi2.packets import checksum, frame_packets
from ncdc_spec.errors import InputError
from ncdc_spec.sensors.csi2 import MAX_SKEW, SYNC_BYTE, DataType
from pipelines import run_bench, run_pipeline


def test_word_aligner_at_each_bit_position():
    """The bytes after the sync byte, in each of the clocks from the first to the burst's end."""
    dut, rng = WordAligner(), np.random.default_rng(1)
    sent = [rng.bytes(9) for _ in range(24)]
    got = []

    async def bench(ctx):
        await ctx.tick()
        for number, content in enumerate(sent):
            zeros = np.zeros(8 * (number // 8) + number % 8, np.uint8)
            bits = np.unpackbits(np.frombuffer(bytes([SYNC_BYTE]) + content, np.uint8),
                                 bitorder="little")
            clocks = np.packbits(np.concatenate([zeros, bits]), bitorder="little")
            for at, byte in enumerate([*clocks, 255, 255, 255]):
                ctx.set(dut.i.data, int(byte))
                ctx.set(dut.i.active, at < len(clocks))
                await ctx.tick()
                if ctx.get(dut.o.valid):
                    got.append(ctx.get(dut.o.data))

    run_bench(dut, bench)
    assert bytes(got) == b"".join(sent)


@pytest.mark.parametrize("clocks,count", [
    ([0, 0, SYNC_BYTE, 1, 2], 2), ([0, 0, SYNC_BYTE ^ 1, 1, 2], 0),
    ([SYNC_BYTE << 4 & 255, 0, SYNC_BYTE >> 4, 1], 0)])
def test_word_aligner_without_a_sync_byte(clocks, count):
    dut = WordAligner()
    valid = []

    async def bench(ctx):
        await ctx.tick()
        ctx.set(dut.i.active, 1)
        for byte in clocks:
            ctx.set(dut.i.data, byte)
            await ctx.tick()
            valid.append(ctx.get(dut.o.valid))

    run_bench(dut, bench)
    assert sum(valid) == count


def test_word_aligner_ignores_what_was_before_a_burst():
    """The last bits of the burst before look like half a sync byte."""
    dut = WordAligner()

    async def bench(ctx):
        for active, byte in [(1, SYNC_BYTE << 4 & 255), (0, 0), (1, SYNC_BYTE >> 4), (1, 5),
                             (1, 5)]:
            ctx.set(dut.i.active, active)
            ctx.set(dut.i.data, byte)
            await ctx.tick()
            assert not ctx.get(dut.o.valid)

    run_bench(dut, bench)


async def lanes_of(ctx, lanes, starts, contents, gap):
    """Bytes of a burst on each lane, from the clock at which it starts; ``active`` for all."""
    clocks = max(starts) + max(map(len, contents))
    for clock in range(clocks + gap):
        for lane, start, content in zip(lanes, starts, contents):
            inside = start <= clock < start + len(content)
            ctx.set(lane.active, clock < clocks)
            ctx.set(lane.valid, inside)
            ctx.set(lane.data, content[clock - start] if inside else 0xEE)
        yield await ctx.tick()


@pytest.mark.parametrize("lanes", [2, pytest.param(4, marks=pytest.mark.longer)])
def test_lane_aligner_with_each_skew(lanes):
    """Words are whole up to ``MAX_SKEW`` clocks; beyond that the burst is reported, once."""
    dut, rng = LaneAligner(lanes), np.random.default_rng(2)
    cases = list(product(range(MAX_SKEW + 3), repeat=lanes))
    cases = [cases[k] for k in rng.permutation(len(cases))[:200]]
    results = []

    async def bench(ctx):
        await ctx.tick()
        for skews in cases:
            contents = [rng.bytes(7) for _ in range(lanes)]
            words, reports, valid = [], 0, []
            async for _ in lanes_of(ctx, dut.i, skews, contents, dut.min_gap):
                reports += ctx.get(dut.unaligned)
                valid.append(ctx.get(dut.o.valid))
                if valid[-1]:
                    words.append(ctx.get(dut.o.data))
            results.append((skews, contents, words, valid, reports))

    run_bench(dut, bench)
    for skews, contents, words, valid, reports in results:
        if max(skews) - min(skews) > MAX_SKEW:
            assert (words, reports) == ([], 1), skews
        else:
            assert words == [int.from_bytes(word, "little") for word in zip(*contents)], skews
            assert not valid[-1] and not reports


def test_lane_aligner_ignores_a_burst_that_began_before():
    """At the end of a reset: no word and no report, and the next burst is right."""
    dut, words = LaneAligner(2), []

    async def bench(ctx):
        for content in (b"abc", b"def"):
            async for _ in lanes_of(ctx, dut.i, [0, 1], [content] * 2, dut.min_gap):
                assert not ctx.get(dut.unaligned)
                if ctx.get(dut.o.valid):
                    words.append(ctx.get(dut.o.data).to_bytes(2, "little"))

    run_bench(dut, bench)
    assert words == [b"dd", b"ee", b"ff"]


@pytest.mark.parametrize("errors", [(), (4,), (30,), (3, 31), (0, 9), (24, 25)])
def test_header_of_a_sensor(errors):
    dut = HeaderDecoder()
    value = int.from_bytes(bytes.fromhex("2B 60 09 1D"), "little")
    for bit in errors:
        value ^= 1 << bit
    (found, corrected, wrong), = run_pipeline(
        dut, [value], lambda ctx, item: ctx.set(dut.i, item),
        lambda: [dut.o.as_value(), dut.corrected, dut.wrong])
    assert (corrected, wrong) == (len(errors) == 1, len(errors) == 2)
    assert wrong or found == 0x09602B


@pytest.mark.parametrize("lanes", [1, 2, 4])
def test_checksum_of_each_length(lanes):
    """The checksum is right, and no longer if a bit of the payload or of itself changes."""
    dut, rng = Checksum(lanes), np.random.default_rng(3)

    async def good(ctx, sent):
        ctx.set(dut.start, 1)
        await ctx.tick()
        ctx.set(dut.start, 0)
        ctx.set(dut.valid, 1)
        for begin in range(0, len(sent), lanes):
            word = sent[begin:begin + lanes]
            ctx.set(dut.rest, len(word) % lanes)
            ctx.set(dut.data, int.from_bytes(word + rng.bytes(lanes - len(word)), "little"))
            await ctx.tick()
        ctx.set(dut.valid, 0)
        await ctx.tick().repeat(dut.latency - 1)
        return ctx.get(dut.good)

    async def bench(ctx):
        for length in range(1, 14):
            payload = rng.bytes(length)
            sent = payload + checksum(payload)
            assert await good(ctx, sent)
            wrong = int.from_bytes(sent, "little") ^ 1 << int(rng.integers(8 * len(sent)))
            assert not await good(ctx, wrong.to_bytes(len(sent), "little"))

    run_bench(dut, bench)


@pytest.mark.parametrize("lanes", [1, 2, pytest.param(4, marks=pytest.mark.longer)])
@pytest.mark.parametrize("wrong", [0, 1])
def test_receiver_of_a_phy_that_aligns_words(lanes, wrong):
    """Its lanes may end with the last byte; a frame's end leaves ``latency`` clocks after it.
    ``wrong``: a bit of the last row's checksum, just before the end."""
    dut, rng = Receiver(lanes, aligned=True), np.random.default_rng(4)
    frame = rng.integers(0, 1 << 10, (3, 12))
    rows, last_byte, ends, faults = [[]], [], [], []

    async def bench(ctx):
        ctx.set(dut.settings.type, DataType.RAW10)
        await ctx.tick()
        clock = 0
        packets = frame_packets(frame)
        packets[-2] = packets[-2][:-1] + bytes([packets[-2][-1] ^ wrong])
        for packet in packets:
            gap = LaneAligner.min_gap if packet is not packets[-1] else dut.latency
            contents = [packet[lane::lanes] for lane in range(lanes)]
            last_byte.append(clock + len(contents[0]) - 1)
            async for _ in lanes_of(ctx, dut.i, [0] * lanes, contents, gap):
                clock += 1
                valid = ctx.get(dut.o.valid)
                rows[-1] += [ctx.get(dut.o.sample[k]) for k in range(lanes) if valid >> k & 1]
                if ctx.get(dut.o.last):
                    rows.append([])
                if ctx.get(dut.o.end):
                    ends.append((clock - 1, ctx.get(dut.o.bad)))
                faults.extend(name for name, _ in FAULTS if ctx.get(dut.faults[name]))

    run_bench(dut, bench)
    assert np.array_equal(np.array(rows[:-1]) >> 2, frame) and not rows[-1]
    assert ends == [(last_byte[-1] + dut.latency - 1, wrong)]
    assert faults == ["checksum"] * wrong


@pytest.mark.parametrize("lanes", [0, 3, 8])
def test_lanes_that_are_not_supported(lanes):
    with pytest.raises(InputError, match=f"has 1, 2 or 4 lanes, not {lanes}"):
        Receiver(lanes)


@pytest.mark.parametrize("period", [1.7e-9, 1e-8, 9.3e-8])
def test_faults_are_counted_in_the_core_clock(period):
    """Faults two core clocks apart and more; a reset of both sides counts nothing."""
    dut, rng = FaultCounters(FAULTS), np.random.default_rng(5)
    reset, expected = Signal(), dict.fromkeys((name for name, _ in FAULTS), 0)
    simulator = Simulator(ResetInserter({"sync": reset, "camera": reset})(dut))
    simulator.add_clock(1e-8)
    simulator.add_clock(period, domain="camera")

    async def bench(ctx):
        for number in range(60):
            chosen = {name: int(rng.integers(2)) for name in expected}
            ctx.set(dut.faults, chosen)
            await ctx.tick("camera")
            ctx.set(dut.faults, dict.fromkeys(chosen, 0))
            await ctx.tick("camera").repeat(11)
            if number == 30:
                await ctx.tick().repeat(5)
                ctx.set(reset, 1)
                await ctx.tick()
                await ctx.tick("camera")
                ctx.set(reset, 0)
                expected.update(dict.fromkeys(expected, 0))
            else:
                for name, value in chosen.items():
                    expected[name] += value
        await ctx.tick().repeat(5)
        assert {name: ctx.get(dut.counts[name]) for name, _ in FAULTS} == expected

    simulator.add_testbench(bench)
    simulator.run()
