"""Registers of a page, and write hosts at one memory."""

import numpy as np

from pipelines import run_bench

__all__ = ["check_page", "check_write_arbiter"]

_BEAT = "address", "burstcount", "writedata", "byteenable"


def check_page(dut, accesses=1100, seed=16):
    """Reads and writes of all addresses, locked or not, compared with a model of the registers.

    ``dut``: :class:`simulations.traces.Alone` with a page of registers.
    """
    rng, page = np.random.default_rng(seed), dut.part
    by_address = {one.address: one for one in page.table}
    initial = {name: _bits(value, page.values[name])
               for name, value in page.signature.members["values"].init.items()}

    async def bench(ctx):
        values = dict(initial)
        for number in range(accesses):
            known = page.table[number % len(page.table)]
            address = known.address ^ (1 << int(rng.integers(len(dut.bus.address)))
                                       if rng.random() < .2 else 0)
            one, lock = by_address.get(address), int(rng.random() < .3)
            shown = {name: int(rng.integers(1 << 31)) * 2 + number % 2 & (1 << len(
                page.read[name])) - 1 for name in page.signature.members["read"].shape.members}
            ctx.set(dut.read, shown)
            ctx.set(dut.lock, lock)
            word, write = int(rng.integers(1 << 32)), int(rng.random() < .6)
            found = await _access(ctx, dut, address, write, word)
            locked = one is not None and one.name in page.locked and lock
            action = one is not None and one.access == "action"
            assert found["rejected"] == (write and one is not None and one.access == "rw"
                                         and locked)
            assert found["written"] == ([one.name] if write and action else [])
            if write and one is not None and one.access == "rw" and not locked:
                low = (1 << page.aligned.get(one.name, 0)) - 1
                values[one.name] = word & (1 << len(page.values[one.name])) - 1 & ~low
            if not write:
                expected = 0 if one is None else (
                    values[one.name] if one.access == "rw" else shown[one.name])
                assert found["data"] == expected, (one, hex(address))
            stored = ctx.get(dut.values)
            assert {name: getattr(stored, name) for name in values} == values
            if rng.random() < .02:
                ctx.set(dut.reset, 1)
                await ctx.tick()
                ctx.set(dut.reset, 0)
                values = dict(initial)

    run_bench(dut, bench)


def _bits(value, view):
    return int(value) & (1 << len(view)) - 1


async def _access(ctx, dut, address, write, word):
    """An access; data, registers written, and whether it was rejected."""
    bus, found = dut.bus, {"rejected": 0, "written": [], "data": None}
    ctx.set(bus.address, address)
    ctx.set(bus.writedata, word)
    ctx.set(bus.write if write else bus.read, 1)
    for clock in range(10):
        *_, wait, valid, data, rejected, written, given = await ctx.tick().sample(
            bus.waitrequest, bus.readdatavalid, bus.readdata, dut.rejected, dut.written, dut.word)
        if not wait:
            ctx.set(bus.write, 0)
            ctx.set(bus.read, 0)
        names = [name for name in dut.part.signature.members["written"].shape.members
                 if getattr(written, name)]
        assert not names or given == word
        found["written"] += names
        found["rejected"] |= rejected
        if valid:
            assert not write and clock == dut.latency
            found["data"] = data
    return found


class _Host:
    """A write host with bursts of random words."""

    def __init__(self, bus, rng, burst):
        self.bus, self.rng, self.most, self.words = bus, rng, burst, []

    def offer(self, ctx, rate):
        """Drive the outputs of a clock."""
        rng = self.rng
        if not self.words and rng.random() < rate:
            count, address = int(rng.integers(1, self.most + 1)), int(rng.integers(1 << 32))
            self.words = [(address, count, int(rng.integers(1 << 63)) * 2 + k % 2,
                           int(rng.integers(256))) for k in range(count)]
        ctx.set(self.bus.write, int(bool(self.words)))
        if self.words:
            for name, value in zip(_BEAT, self.words[0]):
                ctx.set(getattr(self.bus, name), value)


class _Port:
    """A reference model of who has the memory's port, and to whom its answers go."""

    def __init__(self, count, pending):
        self.count, self.pending = count, pending
        self.owner = self.left = 0
        self.held, self.owed = False, []

    def choose(self, wants, urgent):
        """(The host that has the port, whether a word may go to the bus)."""
        space = self.left != 0 or not self.pending or len(self.owed) < self.pending
        if self.held:
            return self.owner, space
        order = [(self.owner + step) % self.count for step in range(1, self.count + 1)]
        first = [k for k in range(self.count) if urgent >> k & 1]
        return next((k for k in first + order if wants[k]), self.owner), space

    def clock(self, owner, write, wait, count, answered):
        """After a clock in which ``owner`` had the port."""
        if answered:
            self.owed.pop(0)
        if write and not wait:
            if self.left == 0:
                self.owed.append(owner)
            self.left = (self.left or count) - 1
        self.owner, self.held = owner, bool(write and wait) or self.left != 0

    def reset(self):
        """The memory drops what has begun."""
        self.held, self.left, self.owed = False, 0, []


def check_write_arbiter(dut, clocks=7000, seed=17):
    """Hosts that want the port at any time: whole bursts, one after the other, and answers.

    ``dut``: :class:`simulations.traces.Alone` with an arbiter of words of 64 bits. A reset clears
    nothing; one of the memory drops the burst that has begun.
    """
    rng, part = np.random.default_rng(seed), dut.part
    hosts = [_Host(bus, rng, part.burst) for bus in dut.hosts]
    port = _Port(len(hosts), part.pending)

    async def bench(ctx):
        wait = rate = answers = resets = 0.0
        longest = part.burst
        for clock in range(clocks):
            if clock % 300 == 0:
                wait, rate = float(rng.choice([0, .3, .9])), float(rng.choice([.05, .5, 1]))
                answers = float(rng.choice([.005, .05, .4]))
                resets, longest = .005, part.burst
            if clock > 4000 and clock % 150 == 0:
                # Short bursts without an answer until no more may wait, then answers, few urgent.
                wait, rate, resets, longest = .1, .9, 0, 2
                answers = float(clock % 300 / 150 * rng.choice([.1, .6]))
            for host in hosts:
                host.most = longest
                host.offer(ctx, rate)
            urgent, memory_rst = int(rng.integers(1 << len(hosts))), int(rng.random() < resets)
            urgent &= int(rng.integers(1 << len(hosts))) if clock > 4000 else -1
            waits, answer = int(rng.random() < wait), bool(port.owed) and rng.random() < answers
            for name, value in (("urgent", urgent), ("memory_rst", memory_rst),
                                ("reset", int(rng.random() < .01))):
                ctx.set(getattr(dut, name), value)
            ctx.set(dut.bus.waitrequest, waits)
            if part.pending:
                ctx.set(dut.bus.writeresponsevalid, int(answer))
                ctx.set(dut.bus.response, int(rng.integers(4)))
            owner, space = port.choose([bool(host.words) for host in hosts], urgent)
            write = bool(hosts[owner].words) and space
            _compare_port(ctx, dut, hosts, (owner, space, write, waits, answer, port))
            count = hosts[owner].words[0][1] if write else 0
            await ctx.tick()
            port.clock(owner, write, waits, count, part.pending and answer)
            if write and not waits:
                hosts[owner].words.pop(0)
            if not part.pending:
                port.owed = []
            if memory_rst:
                port.reset()
                for host in hosts:
                    host.words = []

    run_bench(dut, bench)


def _compare_port(ctx, dut, hosts, seen):
    """Compare the bus, the waits and the answers of a clock with the model."""
    owner, space, write, waits, answer, port = seen
    assert ctx.get(dut.bus.write) == write
    if write:
        beat = tuple(ctx.get(getattr(dut.bus, name)) for name in _BEAT)
        assert beat == hosts[owner].words[0]
    for k, host in enumerate(hosts):
        assert ctx.get(host.bus.waitrequest) == (waits or k != owner or not space)
        if port.pending:
            wanted = bool(answer and port.owed[0] == k)
            assert ctx.get(host.bus.writeresponsevalid) == wanted
            assert not wanted or ctx.get(host.bus.response) == ctx.get(dut.bus.response)
