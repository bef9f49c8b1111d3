"""The Verilog memory model: content, order, latency, pending commands, bandwidth."""

import random

import cocotb
from cocotb.triggers import FallingEdge, ReadOnly
from cocotb.utils import get_sim_time

from benches.common import PERIOD, settings, start

__all__ = ["bandwidth_is_shared", "content_order_and_latency", "prepare"]

PORTS, WORD, BURST_WIDTH, BYTES = 2, 4, 5, 4096


async def prepare(dut, **changes):
    """Reset with the memory of the settings, and ``changes`` to it."""
    timing = settings()["memory"] | changes
    for name, value in timing.items():
        where = dut if hasattr(dut, name) else dut.dram_timing
        getattr(where, name).value = value
    await start(dut, seed=settings()["seed"], read_read=0, write_write=0)
    return timing


async def fill(dut, rng):
    """Write the whole memory in bursts of random length and enables; returns the content."""
    content, at = bytearray(BYTES), 0
    for everything in (True, False):
        at = 0
        while at < BYTES:
            words = min(rng.randint(1, 16), (BYTES - at) // WORD)
            for k in range(words):
                data = rng.randbytes(WORD)
                enable = 15 if everything else rng.getrandbits(WORD)
                # The address counts on the first beat only.
                dut.write_address.value = at if k == 0 else rng.getrandbits(32)
                dut.write_write.value, dut.write_burstcount.value = 1, words
                dut.write_writedata.value = int.from_bytes(data, "little")
                dut.write_byteenable.value = enable
                taken = False
                while not taken:
                    await ReadOnly()
                    taken = not bool(dut.write_waitrequest.value)
                    await FallingEdge(dut.clk)
                for lane in range(WORD):
                    if enable >> lane & 1:
                        content[at + WORD * k + lane] = data[lane]
            at += WORD * words
    dut.write_write.value = 0
    return content


class Reader:
    """One read port: offers random bursts, remembers what is due."""

    def __init__(self, port, rng, gap, bursts=(1, 16)):
        self.port, self.rng, self.gap, self.bursts = port, rng, gap, bursts
        self.command, self.due, self.commands, self.beats, self.first = None, [], 0, 0, []
        self.waits = 0

    def offer(self):
        """(read, address, burstcount) for this clock; held while it waits."""
        if self.command is None and self.rng.random() >= self.gap:
            words = self.rng.randint(*self.bursts)
            self.command = WORD * self.rng.randrange(BYTES // WORD - words), words
        return (1, *self.command) if self.command else (0, self.rng.getrandbits(32), 0)

    def step(self, clock, waiting, valid, data, content, timing):
        """Check what the port answers in this clock."""
        if valid:
            assert self.due, f"port {self.port}: data without a command"
            asked, address, words, k = self.due[0]
            at = address + WORD * k
            assert data == int.from_bytes(content[at:at + WORD], "little"), hex(at)
            if k == 0:
                self.first.append(clock - asked)
                assert timing["dram"] or clock - asked >= timing["latency_min"]
            self.due[0][3] += 1
            if k == words - 1:
                self.due.pop(0)
            self.beats += 1
        if self.command and waiting:
            self.waits += 1
        elif self.command:
            self.due.append([clock, *self.command, 0])
            self.command = None
            self.commands += 1
        assert len(self.due) <= timing["max_pending"]


def successors(readers, rng, **options):
    """Fresh readers that take over what the ``readers`` have under way."""
    result = [Reader(reader.port, rng, **options) for reader in readers]
    for reader, last in zip(result, readers):
        reader.command, reader.due = last.command, last.due
    return result


async def read(dut, readers, content, timing, count):
    """Let the readers work for ``count`` clocks."""
    now = round(get_sim_time("ns")) // PERIOD
    for clock in range(now, now + count):
        offers = [reader.offer() for reader in readers]
        for name, width, column in (("read", 1, 0), ("address", 32, 1),
                                    ("burstcount", BURST_WIDTH, 2)):
            value = sum(offer[column] << width * k for k, offer in enumerate(offers))
            getattr(dut, f"read_{name}").value = value
        await ReadOnly()
        waiting, valid = int(dut.read_waitrequest.value), int(dut.read_readdatavalid.value)
        data = int(dut.read_readdata.value) if valid == 3 else dut.read_readdata.value
        for k, reader in enumerate(readers):
            word = 0
            if valid >> k & 1:
                word = (data >> 32 * k & 0xFFFFFFFF if valid == 3
                        else int(data[32 * k + 31:32 * k]))
            reader.step(clock, waiting >> k & 1, valid >> k & 1, word, content, timing)
        await FallingEdge(dut.clk)


@cocotb.test()
async def content_order_and_latency(dut):
    """Random bursts on both ports at once; lone commands then show the latency itself."""
    rng = random.Random(settings()["seed"])
    timing = await prepare(dut)
    content = await fill(dut, rng)
    readers = [Reader(k, rng, gap=.3) for k in range(PORTS)]
    await read(dut, readers, content, timing, 1500)
    assert all(reader.commands > 10 for reader in readers)
    assert not timing.get("wait_probability") or readers[0].waits > 100
    rest = successors(readers, rng, gap=1)
    await read(dut, rest, content, timing, 2000)
    assert not any(reader.due for reader in rest)
    lone = successors(rest, rng, gap=.99, bursts=(1, 1))
    await read(dut, lone, content, timing, 3000)
    latencies = [n for reader in lone for n in reader.first]
    if not timing["dram"]:
        low, high = timing["latency_min"], timing["latency_max"]
        # One of some sixty draws is in the lowest tenth; which one is random.
        assert low <= min(latencies) <= low + (high - low) // 10
        assert max(latencies) <= high + 1
        assert high == low or len(set(latencies)) > 3
    assert int(dut.errors.value) == 0


@cocotb.test(skip=not settings().get("bandwidth"))
async def bandwidth_is_shared(dut):
    """Ports that ask without end get the whole rate together, and fair parts of it."""
    rng, clocks = random.Random(1), 2000
    timing = await prepare(dut, dram=0, rate=400, wait_probability=0, latency_min=3, latency_max=3,
                           max_pending=16, granule=1)
    content = await fill(dut, rng)
    readers = [Reader(k, rng, gap=0) for k in range(PORTS)]
    for rate in (400, 256, 100, 32):
        dut.rate.value = rate
        readers = successors(readers, rng, gap=0)
        await read(dut, readers, content, timing, clocks)
        beats, limit = [reader.beats for reader in readers], rate * clocks / 256
        assert .97 * limit - 4 <= sum(beats) <= limit + 4, (rate, beats)
        assert abs(beats[0] - beats[1]) <= .02 * limit + 4, (rate, beats)
    # Single words from a memory that moves four at a time.
    dut.rate.value, dut.granule.value = 256, 4
    for _ in range(2):      # the first time, longer bursts are still under way
        readers = successors(readers, rng, gap=0, bursts=(1, 1))
        await read(dut, readers, content, timing, clocks)
    assert abs(sum(reader.beats for reader in readers) - clocks / 4) <= 4
