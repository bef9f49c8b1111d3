"""An Avalon-MM memory for the Amaranth simulator, with random waits and latency."""

__all__ = ["read_agent", "write_agent"]


def read_agent(bus, content, word_bytes, rng, *, wait=0.0, latency=(1, 1), log=None):
    """Background process: serves pipelined bursts of ``bus`` from the bytes ``content``.

    ``latency``: smallest and largest clocks from an accepted command to its first word; words
    stay in order. ``log`` collects (address, words) of the commands.
    """
    async def agent(ctx):
        pending, clock, held = [], 0, None
        while True:
            waiting = rng.random() < wait
            ctx.set(bus.waitrequest, waiting)
            if pending and pending[0][0] <= clock:
                ctx.set(bus.readdata, pending.pop(0)[1])
                ctx.set(bus.readdatavalid, 1)
            else:
                ctx.set(bus.readdatavalid, 0)
            _, _, read, address, words = await ctx.tick().sample(bus.read, bus.address,
                                                                 bus.burstcount)
            clock += 1
            command = (address, words)
            assert held is None or (read and command == held), "a command changed while waiting"
            held = command if read and waiting else None
            if read and not waiting:
                assert words >= 1 and address % word_bytes == 0
                if log is not None:
                    log.append(command)
                due = clock + int(rng.integers(*latency, endpoint=True)) - 1
                for k in range(words):
                    start = address + k * word_bytes
                    word = int.from_bytes(content[start:start + word_bytes].tobytes(), "little")
                    pending.append((due, word))

    return agent


def write_agent(bus, content, word_bytes, rng, *, wait=0.0, log=None):
    """Background process: takes write bursts of ``bus`` into the bytes ``content``."""
    async def agent(ctx):
        left, address, held = 0, 0, None
        while True:
            waiting = rng.random() < wait
            ctx.set(bus.waitrequest, waiting)
            _, _, write, start, words, value, enable = await ctx.tick().sample(
                bus.write, bus.address, bus.burstcount, bus.writedata, bus.byteenable)
            beat = (start, words, value, enable)
            assert held is None or (write and beat == held), "a beat changed while waiting"
            held = beat if write and waiting else None
            if write and not waiting:
                if left == 0:
                    assert words >= 1 and start % word_bytes == 0
                    left, address = words, start
                    if log is not None:
                        log.append((start, words))
                for k in range(word_bytes):
                    if enable >> k & 1:
                        content[address + k] = value >> (8 * k) & 0xFF
                left, address = left - 1, address + word_bytes

    return agent
