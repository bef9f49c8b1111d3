"""The burst writer: what lands in memory, and in which bursts, two frames in a row."""

import cocotb
import numpy as np
from cocotb.triggers import FallingEdge, ReadOnly

from ncdc_hdl.avalon.burst_writer import word_layout
from ncdc_sim.benches.avalon import write_memory
from ncdc_sim.benches.common import clocks, pack, put, settings, start

__all__ = ["two_frames"]


@cocotb.test()
async def two_frames(dut):
    """Full bursts and a short last one; the last word's missing bytes stay as they were."""
    s, width = settings(), settings()["data_width"]
    rng, word = np.random.default_rng(7), width // 8
    content, expected = bytearray(b"\xee" * 8192), bytearray(b"\xee" * 8192)
    log, bursts, done = [], [], []

    async def watch():
        while True:
            await ReadOnly()
            done.extend([1] * bool(dut.done.value))
            await FallingEdge(dut.clk)

    await start(dut, start=0, base=0, i__valid=0)
    cocotb.start_soon(write_memory(dut, "bus", content, wait=s["wait"], log=log))
    cocotb.start_soon(watch())
    for frame, (base, count) in enumerate(((256, s["count"]), (4096, s["count"] + s["burst"]))):
        dut.start.value, dut.base.value = 1, base
        await clocks(dut, 1)
        dut.start.value = 0
        data = rng.integers(0, 256, (count, word), np.uint8)
        enable = [(1 << word) - 1] * (count - 1) + [(1 << word // 2) - 1]
        for k in range(count):
            kept = word // 2 if k == count - 1 else word
            expected[base + k * word:base + k * word + kept] = data[k, :kept].tobytes()
        await put(dut, "i", [pack(word_layout(width), {
            "data": int.from_bytes(data[k].tobytes(), "little"), "enable": enable[k],
            "last": k == count - 1}) for k in range(count)], s["gap"])
        for _ in range(2000):
            if len(done) > frame:
                break
            await clocks(dut, 1)
        assert len(done) == frame + 1, "a frame without an end"
        full, rest = divmod(count, s["burst"])
        sizes = [s["burst"]] * full + [rest] * (rest > 0)
        bursts += [(base + k * s["burst"] * word, n) for k, n in enumerate(sizes)]
    assert content == expected
    assert log == bursts
