"""A bus through an FFSynchronizer: what is seen was sent, if one bit changes at a time."""

import random

import cocotb
from cocotb.triggers import FallingEdge, ReadOnly, Timer

from benches.common import PERIOD, clocks, settings, start

__all__ = ["what_is_seen_was_sent"]

SEEN = 3        # clocks after which a value that is no longer sent must not be seen


@cocotb.test()
async def what_is_seen_was_sent(dut):
    """Values in the order of a counter, in Gray code or binary, each a while at the input.

    They are seen in order, and none is seen that was not at the input shortly before.
    """
    s, rng, sent = settings(), random.Random(settings()["seed"]), []

    async def send():
        for k in range(s["count"]):
            number = k % (1 << len(dut.i))
            dut.i.value = number ^ number >> 1 if s["gray"] else number
            sent.append((cocotb.simtime.get_sim_time("ps"), int(number)))
            await Timer(s["period_ps"] + rng.randrange(-5, 6), "ps")

    await start(dut, i=0)
    await clocks(dut, 4)
    sending, last = cocotb.start_soon(send()), -1
    while not sending.done():
        await ReadOnly()
        seen, now = int(dut.o.value), cocotb.simtime.get_sim_time("ps")
        if s["gray"]:
            for shift in (8, 4, 2, 1):
                seen ^= seen >> shift
        recent = [k for k, (at, number) in enumerate(sent)
                  if number == seen and (k + 1 == len(sent) or sent[k + 1][0]
                                         > now - 1000 * SEEN * PERIOD) and k >= last]
        assert recent or now < 1000 * (SEEN + 8) * PERIOD, f"{seen:b} is seen, it was not sent"
        last = recent[0] if recent else last
        await FallingEdge(dut.clk)
    assert last > s["count"] - 2 - SEEN * (1 + 1000 * PERIOD // s["period_ps"])
