"""Registers through JTAG scans: the JTAG clock stops, has any phase, and hosts go."""

import numpy as np
import pytest
from amaranth import *
from amaranth.sim import Simulator

from ncdc_hdl.registers.jtag_bridge import DOMAIN, JtagBridge
from ncdc_spec.protocols.jtag_link import BITS, NOTHING, READ, WRITE, jtag_message

ADDRESS_BITS = 14


class Chain:
    """A bridge, its registers, and a host that scans."""

    def __init__(self, core_ns, chain_ns, longest=20, seed=1):
        self.bridge, self.tck = JtagBridge(ADDRESS_BITS), Signal()
        self.core_ns, self.chain_ns, self.longest = core_ns, chain_ns, longest
        self.rng, self.accesses = np.random.default_rng(seed), []
        self.words = {}

    async def registers(self, ctx):
        """Serve accesses after some clocks; what is asked must stay until then."""
        access = self.bridge.access
        while True:
            while not ctx.get(access.valid):
                await ctx.tick()
            asked = None
            for _ in range(int(self.rng.integers(1, self.longest))):
                now = (ctx.get(access.valid), ctx.get(access.write), ctx.get(access.address),
                       ctx.get(access.word))
                assert asked in (None, now), "a request changed under way"
                asked = now
                await ctx.tick()
            _, writes, address, word = asked
            self.accesses.append((WRITE if writes else READ, address, word))
            if writes:
                self.words[address] = word
            ctx.set(access.answer, self.words.get(address, 0))
            ctx.set(access.done, 1)
            await ctx.tick()
            ctx.set(access.done, 0)
            ctx.set(access.answer, 0xDEAD)
            await ctx.tick()

    async def edge(self, ctx, **scan):
        """A clock of the chain with the virtual TAP in a state."""
        for name in ("tdi", "capture", "shift", "update"):
            ctx.set(getattr(self.bridge.scan, name), scan.get(name, 0))
        await ctx.delay(self.chain_ns / 2 * 1e-9)
        tdo = ctx.get(self.bridge.scan.tdo)
        ctx.set(self.tck, 1)
        await ctx.delay(self.chain_ns / 2 * 1e-9)
        ctx.set(self.tck, 0)
        return tdo

    async def scan(self, ctx, value, bits=BITS):
        """The bits that come out as ``value`` goes in."""
        await self.edge(ctx)
        await self.edge(ctx, capture=1)
        out = 0
        for k in range(bits):
            out |= await self.edge(ctx, shift=1, tdi=value >> k & 1) << k
        await self.edge(ctx)
        await self.edge(ctx, update=1)
        return out

    async def ask(self, ctx, kind, tag, address, word=0):
        """The answer of the tag, as (kind, address, word); None if ten scans bring none."""
        await self.scan(ctx, jtag_message(kind, tag, address, word))
        for _ in range(10):
            out = await self.scan(ctx, 0)
            if out >> 56 != NOTHING and out >> 48 & 0xFF == tag:
                return out >> 56, out >> 32 & 0xFFFF, out & 0xFFFFFFFF
            await ctx.delay(int(self.rng.integers(0, 100)) * self.core_ns * 1e-9)
        return None

    def run(self, host):
        m = Module()
        m.domains += ClockDomain(DOMAIN, reset_less=True)
        m.d.comb += ClockSignal(DOMAIN).eq(self.tck)
        m.submodules.bridge = self.bridge
        simulator = Simulator(m)
        simulator.add_clock(self.core_ns * 1e-9)
        simulator.add_testbench(self.registers, background=True)
        simulator.add_testbench(host)
        simulator.run()


@pytest.mark.parametrize("core_ns,chain_ns", [
    pytest.param(13.3, 41.7, marks=pytest.mark.longer),
    pytest.param(16, 200.3, marks=pytest.mark.longer), (13.3, 9.1)])
def test_reads_and_writes(core_ns, chain_ns):
    """Also with a chain that is faster than the core, which no cable has."""
    chain, wanted, got = Chain(core_ns, chain_ns), {}, []

    async def host(ctx):
        for k in range(40):
            address, word = int(chain.rng.integers(4)), int(chain.rng.integers(1 << 32))
            if chain.rng.integers(2):
                wanted[address] = word
                got.append((await chain.ask(ctx, WRITE, k, address, word), (WRITE, address, word)))
            else:
                got.append((await chain.ask(ctx, READ, k, address),
                            (READ, address, wanted.get(address, 0))))

    chain.run(host)
    assert [answer for answer, _ in got] == [right for _, right in got]
    assert len(chain.accesses) == 40


def test_one_at_a_time():
    """A request while another is under way is dropped; an answer that no host has seen is not that
    of the next request; short scans ask nothing."""
    chain, seen = Chain(13.3, 5, longest=400), []

    async def host(ctx):
        await chain.scan(ctx, jtag_message(WRITE, 1, 3, 33))
        for tag in (2, 3, 4):       # at once: the first request is under way
            await chain.scan(ctx, jtag_message(WRITE, tag, 5, 55))
        await ctx.delay(1e-5)
        seen.append(await chain.ask(ctx, READ, 9, 3))
        seen.append(await chain.scan(ctx, jtag_message(READ, 7, 3), bits=20))
        for _ in range(3):
            seen.append(await chain.scan(ctx, 0))

    chain.run(host)
    assert seen == [(READ, 3, 33), 0, 0, 0, 0]
    assert chain.accesses[0] == (WRITE, 3, 33)
    assert len(chain.accesses) < 5 and chain.accesses[-1][:2] == (READ, 3)
