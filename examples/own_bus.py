"""A memory bus of your own: an adapter on the core's read port, and a frame through it.

    python examples/own_lens.py tiny.toml 48x32 && python examples/own_bus.py tiny.toml

The core asks for bursts on Avalon-MM. Here the memory has a plain bus: one word per access, with an
acknowledgement. A frame in Amaranth's simulator is compared with the golden model."""
import sys

import numpy as np
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from ncdc_hdl.corrector import Corrector
from ncdc_model.correction import correct
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import CTRL_START

WORD, CTRL = 4, 3       # bytes of a memory word; word address of a register


class MyCorrector(wiring.Component):
    """The core with a plain bus to memory; pixels leave as its stream."""
    address: Out(32)        # byte address of a word
    request: Out(1)         # stays with its address until acknowledged
    acknowledge: In(1)      # of a request
    data: In(8 * WORD)      # valid with acknowledge

    def __init__(self, descriptor):
        self.core = Corrector(descriptor, Hardware(data_width=8 * WORD, output="stream"))
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        m.submodules.core = core = self.core
        left = Signal.like(core.read0_burstcount)       # words of the burst still to come
        m.d.comb += [core.read0_waitrequest.eq(left != 0), self.request.eq(left != 0)]
        m.d.comb += [core.read0_readdata.eq(self.data),
                     core.read0_readdatavalid.eq(self.acknowledge)]
        with m.If(core.read0_read & ~core.read0_waitrequest):
            m.d.sync += [left.eq(core.read0_burstcount), self.address.eq(core.read0_address)]
        with m.If(self.acknowledge):
            m.d.sync += [left.eq(left - 1), self.address.eq(self.address + WORD)]
        return m


def main(network):
    """Correct a frame of noise; the exit status is 1 if a pixel differs."""
    descriptor, pixels = Descriptor.load(network), []
    raw = np.random.default_rng(1).integers(0, 256, descriptor.geometry.distorted[::-1], np.uint8)
    memory = np.pad(raw, ((0, 1), (0, -raw.shape[1] % WORD))).tobytes()
    dut, golden = MyCorrector(descriptor), correct(descriptor, raw).picture

    async def serve(ctx):
        async for _, _, request, at in ctx.tick().sample(dut.request, dut.address):
            ctx.set(dut.data, int.from_bytes(memory[at:at + WORD], "little"))
            ctx.set(dut.acknowledge, request and not ctx.get(dut.acknowledge))
    async def host(ctx, core=dut.core):
        ctx.set(Cat(core.stream_ready, core.csr_write), 0b11)
        ctx.set(Cat(core.csr_writedata, core.csr_address), CTRL_START | CTRL << 32)
        await ctx.tick().until(~core.csr_waitrequest)
        ctx.set(core.csr_write, 0)
        for _ in range(golden.size // 3):
            (pixel,) = await ctx.tick().sample(core.stream_data).until(core.stream_valid)
            pixels.append((pixel >> 16, pixel >> 8 & 255, pixel & 255))

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(serve, background=True)
    simulator.add_testbench(host)
    simulator.run()
    differ = (np.reshape(pixels, golden.shape) != golden).any(axis=2)
    print(f"{differ.size} pixels compared, {differ.sum()} differ")
    return int(differ.any())


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:2]))
