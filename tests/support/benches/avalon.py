"""Avalon-MM memory agents and a register host for the test benches, with protocol checks.

They work around the falling edge, as described in ``common``.
"""

import random

from cocotb.triggers import FallingEdge, ReadOnly

__all__ = ["Host", "read_memory", "write_memory"]


def _ports(dut, prefix, *names):
    """Ports of a block (prefix__name) or of the whole corrector (prefix_name)."""
    joint = "__" if hasattr(dut, f"{prefix}__{names[0]}") else "_"
    return [getattr(dut, f"{prefix}{joint}{name}") for name in names]


async def read_memory(dut, prefix, content, *, wait=0.0, latency=(1, 1), seed=3, log=None):
    """Serve pipelined burst reads of ``prefix`` from the bytes ``content``, forever.

    ``wait``: probability of waitrequest in a clock; ``latency``: minimum and maximum number of
    clocks from an accepted command to its first word. ``log`` collects (address, words).
    """
    address, read, burstcount, waitrequest, readdata, readdatavalid = _ports(
        dut, prefix, "address", "read", "burstcount", "waitrequest", "readdata", "readdatavalid")
    rng, word = random.Random(seed), len(readdata) // 8
    queue, clock, held = [], 0, None
    while True:
        waiting = rng.random() < wait
        waitrequest.value = int(waiting)
        if queue and queue[0][0] <= clock:
            readdata.value, readdatavalid.value = queue.pop(0)[1], 1
        else:
            readdata.value, readdatavalid.value = rng.getrandbits(8 * word), 0
        await ReadOnly()
        command = (int(address.value), int(burstcount.value)) if bool(read.value) else None
        assert held is None or command == held, f"{prefix}: command {held} changed in a wait"
        held = command if waiting else None
        if command and not waiting:
            start, words = command
            assert words >= 1 and start % word == 0, f"{prefix}: {words} words at {start:#x}"
            assert start + words * word <= len(content), f"{prefix}: read beyond the memory"
            if log is not None:
                log.append(command)
            due = clock + rng.randint(*latency)
            for k in range(words):
                data = bytes(content[start + k * word:start + (k + 1) * word])
                queue.append((due, int.from_bytes(data, "little")))
        clock += 1
        await FallingEdge(dut.clk)


async def write_memory(dut, prefix, content, *, wait=0.0, seed=4, log=None):
    """Take write bursts of ``prefix`` into the bytearray ``content``, forever."""
    address, write, burstcount, writedata, byteenable, waitrequest = _ports(
        dut, prefix, "address", "write", "burstcount", "writedata", "byteenable", "waitrequest")
    rng, word = random.Random(seed), len(writedata) // 8
    left, at, held = 0, 0, None
    while True:
        waiting = rng.random() < wait
        waitrequest.value = int(waiting)
        await ReadOnly()
        beat = None
        if bool(write.value):
            beat = tuple(int(p.value) for p in (address, burstcount, writedata, byteenable))
        assert held is None or beat == held, f"{prefix}: a beat changed in a wait"
        held = beat if waiting else None
        if beat and not waiting:
            start, words, data, enable = beat
            if left == 0:
                assert words >= 1 and start % word == 0, f"{prefix}: {words} words at {start:#x}"
                left, at = words, start
                if log is not None:
                    log.append((start, words))
            for lane, byte in enumerate(data.to_bytes(word, "little")):
                if enable >> lane & 1:
                    content[at + lane] = byte
            left, at = left - 1, at + word
        await FallingEdge(dut.clk)


class Host:
    """Register accesses through the Avalon-MM agent ``prefix``."""

    def __init__(self, dut, prefix):
        self.clk = dut.clk
        (self.address, self.read_, self.write_, self.writedata, self.readdata,
         self.readdatavalid, self.waitrequest) = _ports(
            dut, prefix, "address", "read", "write", "writedata", "readdata", "readdatavalid",
            "waitrequest")

    async def _accepted(self, strobe):
        strobe.value = 1
        waiting = True
        while waiting:
            await ReadOnly()
            waiting = bool(self.waitrequest.value)
            await FallingEdge(self.clk)
        strobe.value = 0

    async def write(self, address, value):
        """Write ``value`` to the word ``address``."""
        self.address.value, self.writedata.value = address, value & 0xFFFFFFFF
        await self._accepted(self.write_)

    async def read(self, address, limit=100):
        """The value at the word ``address``; fails after ``limit`` clocks without an answer."""
        self.address.value = address
        await self._accepted(self.read_)
        for _ in range(limit):
            await ReadOnly()
            if bool(self.readdatavalid.value):
                value = int(self.readdata.value)
                await FallingEdge(self.clk)
                return value
            await FallingEdge(self.clk)
        raise AssertionError(f"no answer from word {address} in {limit} clocks")
