"""Bridges of the system on a chip: random gaps and stalls on both sides, resets amid the traffic.

The controller's side behaves as LiteDRAM's native port. It takes commands at any time, asks for
the words of accepted writes, and answers reads in order. It waits for neither words nor readers.
The bridges' ``reset`` resets the hosts on their near side and the controller as well. All have one
reset in the system: accesses under way are dropped.
"""

import random

import cocotb
from cocotb.triggers import FallingEdge, ReadOnly

from benches.common import clocks, settings, start

__all__ = ["bursts_store_their_words", "registers_store_their_words"]

_WORDS = 256            # of the memory and of the registers
_TIMEOUT = 4000        # clocks for one burst


class _Controller:
    """Memory at a native port, ``wait``: probability that it does nothing in a clock."""

    def __init__(self, dut, wait, rng):
        self.dut, self.wait, self.rng = dut, wait, rng
        self.words = [rng.getrandbits(32) for _ in range(_WORDS)]
        self.forget()

    def forget(self):
        """Reset: commands under way are lost, the words stay."""
        self.reads, self.writes = [], []

    async def run(self):
        dut, rng = self.dut, self.rng
        while True:
            dut.port__cmd_ready.value = int(rng.random() >= self.wait)
            answers = bool(self.reads) and rng.random() >= self.wait
            dut.port__rdata_valid.value = int(answers)
            dut.port__rdata_data.value = (self.words[self.reads[0]] if answers
                                          else rng.getrandbits(32))
            asks = bool(self.writes) and rng.random() >= self.wait
            dut.port__wdata_ready.value = int(asks)
            await ReadOnly()
            if not int(dut.rst.value):
                self._clock(answers, asks)
            await FallingEdge(dut.clk)

    def _clock(self, answers, asks):
        dut = self.dut
        if answers:
            self.reads.pop(0)
        if asks:
            assert int(dut.port__wdata_valid.value), "no word is there for a command"
            mask, data = int(dut.port__wdata_we.value), int(dut.port__wdata_data.value)
            address = self.writes.pop(0)
            for lane in range(4):
                if mask >> lane & 1:
                    clear = ~(0xFF << 8 * lane)
                    self.words[address] = self.words[address] & clear | data & 0xFF << 8 * lane
        if int(dut.port__cmd_valid.value) and int(dut.port__cmd_ready.value):
            address = int(dut.port__cmd_addr.value)
            (self.writes if int(dut.port__cmd_we.value) else self.reads).append(address)


async def _reset(dut, controller=None):
    dut.rst.value = 1
    if controller:
        controller.forget()
    await clocks(dut, 2)
    dut.rst.value = 0
    await clocks(dut, 1)


async def _accepted(dut, limit=_TIMEOUT):
    """Until what the host shows is accepted."""
    for _ in range(limit):
        await ReadOnly()
        waits = int(dut.bus__waitrequest.value)
        await FallingEdge(dut.clk)
        if not waits:
            return
    raise AssertionError(f"not accepted in {limit} clocks")


# A design is one bridge: the test of the others has nothing to drive.
@cocotb.test(skip=settings()["bridge"] == "wishbone")
async def bursts_store_their_words(dut):
    """Random bursts; after each one, the words are those that were written, or unchanged."""
    s = settings()
    rng, reads = random.Random(s["seed"]), s["bridge"] == "reader"
    inputs = {"bus__read": 0} if reads else {"bus__write": 0}
    await start(dut, port__cmd_ready=0, port__rdata_valid=0, port__wdata_ready=0, **inputs)
    controller = _Controller(dut, s["wait"], rng)
    cocotb.start_soon(controller.run())
    resets = 0
    for _ in range(s["bursts"]):
        cut = rng.random() < s["reset"]
        resets += cut
        counts = [rng.randint(1, s["burst"]) for _ in range(rng.randint(1, 4))]
        bursts = [(rng.randrange(_WORDS - count), count) for count in counts]
        if reads:
            await _read(dut, controller, rng, bursts, s["gap"], cut)
        else:
            await _write(dut, controller, rng, *bursts[0], s["gap"], cut)
    assert bool(resets) == (s["reset"] > 0)


async def _read(dut, controller, rng, bursts, gap, cut):
    """Bursts, (address, count), one after the other; the next is requested while words come."""
    got, expected = [], []
    for address, count in bursts:
        expected += controller.words[address:address + count]

    async def collect():
        while len(got) < len(expected):
            await ReadOnly()
            if int(dut.bus__readdatavalid.value):
                got.append(int(dut.bus__readdata.value))
            await FallingEdge(dut.clk)
    taking = cocotb.start_soon(collect())
    for address, count in bursts:
        while rng.random() < gap:
            await FallingEdge(dut.clk)
        dut.bus__address.value, dut.bus__burstcount.value = 4 * address, count
        dut.bus__read.value = 1
        await _accepted(dut)
        dut.bus__read.value = 0
        dut.bus__address.value = rng.getrandbits(32)
    if cut:
        await clocks(dut, rng.randint(0, bursts[-1][1]))
        taking.cancel()
        await _reset(dut, controller)
        return
    for _ in range(_TIMEOUT):
        if len(got) == len(expected):
            break
        await FallingEdge(dut.clk)
    assert got == expected


async def _write(dut, controller, rng, address, count, gap, cut):
    before, answers = list(controller.words), []
    sent = []

    async def watch():
        while True:
            await ReadOnly()
            if int(dut.bus__writeresponsevalid.value):
                answers.append(list(controller.words))
            await FallingEdge(dut.clk)
    watching = cocotb.start_soon(watch())
    stop = rng.randrange(count) if cut else count
    for k in range(stop):
        while rng.random() < gap:
            dut.bus__write.value = 0
            await FallingEdge(dut.clk)
        word, mask = rng.getrandbits(32), rng.randrange(16)
        sent.append((word, mask))
        dut.bus__write.value, dut.bus__writedata.value, dut.bus__byteenable.value = 1, word, mask
        dut.bus__address.value, dut.bus__burstcount.value = 4 * address, count
        await _accepted(dut)
    dut.bus__write.value = 0
    if not cut:
        for _ in range(_TIMEOUT):
            if answers:
                break
            await FallingEdge(dut.clk)
        bits = [sum(0xFF << 8 * lane for lane in range(4) if mask >> lane & 1) for _, mask in sent]
        expected = list(before)
        for k, ((word, _), mask) in enumerate(zip(sent, bits)):
            expected[address + k] = before[address + k] & ~mask | word & mask
        # All words of the burst are in the memory when it is answered, and it is answered once.
        await clocks(dut, 5)
        assert answers == [expected] == [controller.words]
    watching.cancel()
    if cut:
        await _reset(dut, controller)
        inside = range(address, address + count)
        assert all(controller.words[k] == before[k] for k in range(_WORDS) if k not in inside)


@cocotb.test(skip=settings()["bridge"] != "wishbone")
async def registers_store_their_words(dut):
    """Random accesses of a host that gives some of them up; registers that take their time."""
    s = settings()
    rng = random.Random(s["seed"])
    await start(dut, host__cyc=0, host__stb=0, agent__waitrequest=1, agent__readdatavalid=0)
    words = [rng.getrandbits(32) for _ in range(_WORDS)]
    cocotb.start_soon(_registers(dut, words, s["wait"], rng))
    model, given_up = list(words), 0
    for _ in range(s["bursts"]):
        while rng.random() < s["gap"]:
            await FallingEdge(dut.clk)
        address, write, partial = rng.randrange(_WORDS), rng.random() < .5, rng.random() < .1
        value = rng.getrandbits(32)
        dut.host__adr.value, dut.host__we.value = address, int(write)
        dut.host__dat_w.value, dut.host__sel.value = value, 7 if partial else 15
        dut.host__cyc.value = dut.host__stb.value = 1
        timeout = rng.randint(1, 6) if rng.random() < s["reset"] else _TIMEOUT
        ends = None
        for _ in range(timeout):
            await ReadOnly()
            ends = (int(dut.host__ack.value), int(dut.host__err.value), int(dut.host__dat_r.value))
            await FallingEdge(dut.clk)
            if ends[0] or ends[1]:
                break
        dut.host__cyc.value = dut.host__stb.value = 0
        if ends[0] or ends[1]:
            assert ends[1] == (write and partial) != ends[0]
            if write and not partial:
                model[address] = value
            assert write or ends[2] == model[address]
        else:
            assert timeout < _TIMEOUT, "no answer"
            given_up += 1
        await clocks(dut, 1)
        assert words == model       # a write that was given up has not happened
    assert bool(given_up) == (s["reset"] > 0)


async def _registers(dut, words, wait, rng):
    """Registers at an Avalon-MM agent; a read is answered later, also one given up."""
    owed = []
    while True:
        waits = rng.random() < wait
        answers = bool(owed) and rng.random() >= wait
        dut.agent__waitrequest.value, dut.agent__readdatavalid.value = int(waits), int(answers)
        dut.agent__readdata.value = owed[0] if answers else rng.getrandbits(32)
        await ReadOnly()
        if answers:
            owed.pop(0)
        address = int(dut.agent__address.value) if not waits else 0
        if not waits and int(dut.agent__write.value):
            words[address] = int(dut.agent__writedata.value)
        if not waits and int(dut.agent__read.value):
            assert not owed, "two reads are under way"
            owed.append(words[address])
        await FallingEdge(dut.clk)
