"""The memory model with rows and banks: the clock of every word of a list of commands.

Settings: ``memory`` (its settings), ``word`` (bytes), ``clocks`` (to run), ``reads`` and ``writes``
(lists of [port, clock, address, words]). A command is offered from that clock on, after the one
before it on its port. The beats are logged as one line ``BEATS`` with the clock of every beat
of each port, counted from reset.
"""

import json

import cocotb
from cocotb.triggers import FallingEdge, ReadOnly

from benches.avalon_memory import BURST_WIDTH, prepare
from benches.common import settings

__all__ = ["commands_in_time"]


@cocotb.test()
async def commands_in_time(dut):
    """Play the commands, log the clocks of the beats and of the acceptances."""
    await prepare(dut)
    ports = len(dut.read_read)
    reads = [[c[1:] for c in settings()["reads"] if c[0] == p] for p in range(ports)]
    writes = [c[1:] for c in settings()["writes"]]
    beats, accepted = [[] for _ in range(ports)], [[] for _ in range(ports)]
    for clock in range(settings()["clocks"]):
        asking = [bool(q) and q[0][0] <= clock for q in reads]
        for name, width, column in (("address", 32, 1), ("burstcount", BURST_WIDTH, 2)):
            getattr(dut, f"read_{name}").value = sum(
                reads[p][0][column] << width * p for p in range(ports) if asking[p])
        dut.read_read.value = sum(asking[p] << p for p in range(ports))
        writing = bool(writes) and writes[0][0] <= clock
        dut.write_write.value = writing
        if writing:
            dut.write_address.value, dut.write_burstcount.value = writes[0][1:3]
            dut.write_byteenable.value = 0
        await ReadOnly()
        waiting, valid = int(dut.read_waitrequest.value), int(dut.read_readdatavalid.value)
        for p in range(ports):
            if valid >> p & 1:
                beats[p].append(clock)
            if asking[p] and not waiting >> p & 1:
                accepted[p].append(clock)
                reads[p].pop(0)
        if writing and not bool(dut.write_waitrequest.value):
            left = writes[0][3] if len(writes[0]) > 3 else writes[0][2]
            writes[0][3:] = [left - 1]
            if left == 1:
                writes.pop(0)
        await FallingEdge(dut.clk)
    dut._log.warning("BEATS " + json.dumps(
        {"beats": beats, "accepted": accepted, "refreshes": int(dut.dram_timing.refreshes.value)}))
    assert not any(reads) and not writes, "commands are left"
    assert int(dut.errors.value) == 0, "a rule of the memory was broken"
