"""The burst writer: what lands in memory, and in which bursts, two frames in a row."""

import cocotb
import numpy as np
from cocotb.triggers import FallingEdge, ReadOnly

from benches.avalon import write_memory
from benches.common import clocks, pack, put, settings, start
from ncdc_hdl.avalon.burst_writer import word_layout

__all__ = ["two_frames"]


@cocotb.test()
async def two_frames(dut):
    """Full bursts, a short one before a jump in the middle, and a short last one.

    Bytes of the last word that are not written keep their values.
    """
    s, width = settings(), settings()["data_width"]
    rng, word = np.random.default_rng(7), width // 8
    content, expected = bytearray(b"\xee" * 8192), bytearray(b"\xee" * 8192)
    log, bursts, done = [], [], []

    async def watch():
        while True:
            await ReadOnly()
            done.extend([1] * bool(dut.done.value))
            await FallingEdge(dut.clk)

    await start(dut, i__valid=0, memory_rst=0)
    cocotb.start_soon(write_memory(dut, "bus", content, wait=s["wait"], log=log))
    cocotb.start_soon(watch())
    for frame, (base, count) in enumerate(((256, s["count"]), (4096, s["count"] + s["burst"]))):
        jump = count // 2                    # the words after it lie a word further on
        addresses = [base + (k + (k >= jump)) * word for k in range(count)]
        data = rng.integers(0, 256, (count, word), np.uint8)
        enable = [(1 << word) - 1] * (count - 1) + [(1 << word // 2) - 1]
        for k in range(count):
            valid = word // 2 if k == count - 1 else word
            expected[addresses[k]:addresses[k] + valid] = data[k, :valid].tobytes()
        words = [{"data": int.from_bytes(data[k].tobytes(), "little"), "enable": enable[k],
                  "address": addresses[k], "end": k in (jump - 1, count - 1),
                  "last": k == count - 1, "void": 0} for k in range(count)]
        await put(dut, "i", [pack(word_layout(width), fields) for fields in words], s["gap"])
        for _ in range(2000):
            if len(done) > frame:
                break
            await clocks(dut, 1)
        assert len(done) == frame + 1, "a frame without an end"
        bursts += [(addresses[k], min(s["burst"], end - k)) for begin, end in
                   ((0, jump), (jump, count)) for k in range(begin, end, s["burst"])]
    assert content == expected
    assert log == bursts
