"""CSI-2 lanes at their full rate through the receiver and capture into memory."""

import numpy as np
import pytest
from amaranth.sim import Simulator

from ncdc_hdl.camera.capture import Capture
from ncdc_hdl.camera.csi2.receiver import Receiver
from ncdc_sim.csi2.lanes import Lanes
from ncdc_sim.csi2.packets import frame_packets
from ncdc_spec.sensors.csi2 import DataType
from ncdc_spec.sensors.level import levelled

CORE_NS, WORD = 10, 8           # period of the core's clock, bytes of a word of the memory
WAITS = .3                      # of the memory, in how many clocks
GAP_NS = 200                    # between two packets; D-PHY has 295 at least
WIDTH, ROWS = 1920, 3
BASE, SIZE = 0x1000, 0x2000     # of the first frame's buffer


def memory_of(dut, rng, content):
    """A bench that takes the words of the bus into ``content``."""
    async def bench(ctx):
        bus, left = dut.bus, 0
        while True:
            wait = rng.random() < WAITS
            ctx.set(bus.waitrequest, wait)
            if ctx.get(bus.write) and not wait:
                if not left:
                    address, left = ctx.get(bus.address), ctx.get(bus.burstcount)
                word = ctx.get(bus.writedata).to_bytes(WORD, "little")
                for k in range(WORD):
                    if ctx.get(bus.byteenable) >> k & 1:
                        content[address + k] = word[k]
                address, left = address + WORD, left - 1
            await ctx.tick()
    return bench


def lanes_of(dut, frames, lanes, byte_ns, rng):
    """A bench that sends frames, each lane's bits from 8 bits of a byte clock."""
    sent = Lanes(lanes, rng)
    sent.rest(400)
    for frame in frames:
        for packet in frame_packets(frame, embedded=2):
            sent.burst(packet, gap=int(GAP_NS / byte_ns))
        sent.rest(200)

    async def bench(ctx):
        for data, active in zip(*sent.clocks):
            for lane in range(lanes):
                ctx.set(dut.camera.i[lane].data, int(data[lane]))
                ctx.set(dut.camera.i[lane].active, int(active[lane]))
            for level in (1, 0):
                ctx.set(dut.clock, level)
                await ctx.delay(byte_ns * 5e-10)
        await ctx.tick().repeat(400)
    return bench


@pytest.mark.longer
@pytest.mark.parametrize("lanes,rate", [
    (2, 912), pytest.param(4, 900, marks=pytest.mark.regress)])
def test_no_sample_is_dropped_at_full_rate(lanes, rate):
    """Rows of 1920 samples of RAW10; ``rate``: Mb/s of a lane."""
    dut = Capture(8 * WORD, burst=16, source=Receiver(lanes))
    rng = np.random.default_rng(lanes)
    frames = rng.integers(0, 1 << 10, (2, ROWS, WIDTH))
    content, ended = bytearray(BASE + 2 * SIZE), []

    async def configure(ctx):
        ctx.set(dut.camera.settings.type, DataType.RAW10)
        ctx.set(dut.settings, {"sent_width": WIDTH, "sent_height": ROWS, "left": 0, "top": 0,
                               "width": WIDTH, "height": ROWS})
        ctx.set(dut.settings.level.curve, [16 * k for k in range(17)])
        ctx.set(dut.enable, 1)
        async for *_, begins, ends, good in ctx.tick().sample(dut.begins, dut.ends, dut.good):
            if begins:
                base = BASE + SIZE * len(ended)
                ctx.set(dut.area, {"base": base, "limit": base + SIZE, "pitch": WIDTH,
                                   "width": WIDTH, "height": ROWS})
            if ends:
                ended.append(good)

    simulator = Simulator(dut)
    simulator.add_clock(CORE_NS * 1e-9)
    simulator.add_testbench(lanes_of(dut, frames, lanes, 8000 / rate, rng))
    for bench in (memory_of(dut, rng, content), configure):
        simulator.add_testbench(bench, background=True)
    simulator.run()
    assert ended == [1, 1]
    for number, frame in enumerate(frames):
        stored = content[BASE + SIZE * number:][:WIDTH * ROWS]
        assert stored == levelled(frame << 2).tobytes(), number
