"""AXI4-Stream video from the source of ``cocotbext-axi`` as a stream of samples."""

import logging
import random

import cocotb
from cocotb.triggers import FallingEdge, ReadOnly
from cocotbext.axi import AxiStreamBus, AxiStreamFrame, AxiStreamSource

from benches.axi import pauses
from benches.common import clocks, settings, start

__all__ = ["frames"]

_WIDTH, _HEIGHT, _COUNT = 8, 5, 6       # of a frame; frames


@cocotb.test()
async def frames(dut):
    """Every sample of every frame, in the upper bits, with ``first``, ``last`` and ``end``."""
    count, bits, gap = (settings()[name] for name in ("count", "bits", "gap"))
    rng = random.Random(1)
    await start(dut, height=_HEIGHT)
    source = AxiStreamSource(AxiStreamBus.from_entity(dut), dut.clk, dut.rst,
                             byte_lanes=1)
    source.log.setLevel(logging.WARNING)
    source.set_pause_generator(pauses(gap, 2))
    expected, got = [], []
    for _ in range(_COUNT):
        for y in range(_HEIGHT):
            row = [rng.getrandbits(bits) for _ in range(_WIDTH)]
            beats = [row[x:x + count] for x in range(0, _WIDTH, count)]
            source.send_nowait(AxiStreamFrame(
                [sum(sample << bits * k for k, sample in enumerate(beat)) for beat in beats],
                tuser=[int(y == x == 0) for x in range(len(beats))]))
            expected += [([sample << 12 >> bits for sample in beat], y == x == 0,
                          x == len(beats) - 1, x == len(beats) - 1 and y == _HEIGHT - 1)
                         for x, beat in enumerate(beats)]

    async def watch():
        while True:
            await ReadOnly()
            valid = int(dut.o__valid.value)
            assert valid in (0, (1 << count) - 1)
            if valid:
                sample = int(dut.o__sample.value)
                got.append(([sample >> 12 * k & 0xFFF for k in range(count)],
                            *(bool(signal.value) for signal in (dut.o__first, dut.o__last,
                                                                dut.o__end))))
            await FallingEdge(dut.clk)

    cocotb.start_soon(watch())
    await source.wait()
    await clocks(dut, 5)
    assert got == expected and not source.active
