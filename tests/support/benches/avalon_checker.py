"""The Avalon-MM checker in Verilog: silent on good traffic, one violation for each planted one."""

import cocotb
from cocotb.types import Logic

from benches.common import clocks, settings, start

__all__ = ["violations", "good_traffic"]

IDLE = {"address": 0, "read": 0, "write": 0, "burstcount": 0, "writedata": 0, "byteenable": 0,
        "waitrequest": 0, "readdatavalid": 0, "host_rst": 0, "memory_rst": 0}
READ = {"read": 1, "address": 64, "burstcount": 2}
WRITE = {"write": 1, "address": 128, "burstcount": 2, "writedata": 7, "byteenable": 15}
WAIT = {"waitrequest": 1}
DATA = {"readdatavalid": 1}
HOST = {"host_rst": 1}
MEMORY = {"memory_rst": 1}

GOOD = [
    READ | WAIT, READ, {}, DATA, DATA,
    READ, READ | DATA, DATA, DATA, DATA,                        # pipelined
    WRITE | WAIT, WRITE, {}, WRITE | {"writedata": 9, "address": 1} | WAIT,
    WRITE | {"writedata": 9, "address": 2},                     # the address counts once
    READ | {"burstcount": 16}, *[DATA] * 16, WAIT, {},
    READ | WAIT | HOST, {}, READ, HOST, DATA, DATA,             # its host is reset
    READ | WAIT, READ | MEMORY | WAIT, {}, MEMORY | DATA, {},   # host and memory are
]

# Rule, then the clocks that break it once.
VIOLATIONS = [
    ("held", [READ | WAIT, READ | {"address": 68}, DATA, DATA]),
    ("held", [READ | WAIT, {}]),
    ("held", [READ | WAIT, READ | {"read": 0}]),
    ("held", [WRITE | WAIT, WRITE | {"write": 0}]),
    ("held", [READ | WAIT, READ | {"burstcount": 1}, DATA]),
    ("held", [WRITE | WAIT, WRITE | {"writedata": 8}, WRITE]),
    ("held", [WRITE | WAIT, WRITE | {"byteenable": 7}, WRITE]),
    ("held", [WRITE, WRITE | WAIT, {}, WRITE]),
    ("burst-range", [READ | {"burstcount": 0}]),
    ("burst-range", [READ | {"burstcount": 17}, *[DATA] * 17]),
    ("burst-constant", [WRITE, WRITE | {"burstcount": 3}]),
    ("read-in-write", [WRITE, READ, WRITE, DATA, DATA]),
    ("read-and-write", [READ | WRITE | {"burstcount": 1}, DATA]),
    ("aligned", [READ | {"address": 66}, DATA, DATA]),
    ("aligned", [WRITE | {"address": 129}, WRITE]),
    ("held", [HOST | READ | WAIT, READ | WAIT, {}]),
    ("burst-constant", [WRITE, HOST, WRITE | {"burstcount": 3}]),
    ("unrequested", [DATA]),
    ("unrequested", [READ, HOST | MEMORY, DATA]),
    ("burst-range", [WRITE, HOST | MEMORY, WRITE | {"burstcount": 0}]),
    ("unrequested", [READ, DATA, DATA, DATA]),
    ("unrequested", [READ | DATA | {"burstcount": 1}, DATA]),
]

X = Logic("X")
UNKNOWN = [("unknown", [{"read": X}]), ("unknown", [{"waitrequest": X}]),
           ("unknown", [READ | {"address": None}, DATA, DATA]),
           ("unknown", [WRITE | {"writedata": None}, WRITE])]


UNUSED = [WRITE | {"writedata": None, "byteenable": 0}, WRITE]


async def play(dut, steps):
    """Reset, play the ``steps``, and give the number of errors."""
    await start(dut, **IDLE)
    for step in steps:
        for name, value in (IDLE | step).items():
            handle = getattr(dut, name)
            handle.value = "X" * len(handle) if value is None else value
        await clocks(dut, 1)
    for name, value in IDLE.items():
        getattr(dut, name).value = value
    await clocks(dut, 2)
    return int(dut.errors.value)


@cocotb.test()
async def good_traffic(dut):
    """No violation; the counters count."""
    assert await play(dut, GOOD) == 0
    assert [int(getattr(dut, name).value) for name in ("commands", "beats", "bytes", "waits")] \
        == [6, 8 + 2 + 16, 8, 5]
    assert not settings()["four_states"] or await play(dut, UNUSED) == 0


@cocotb.test()
async def violations(dut):
    """Each planted violation counts once."""
    planted = VIOLATIONS + (UNKNOWN if settings()["four_states"] else [])
    for rule, steps in planted:
        errors = await play(dut, steps)
        assert errors == 1, f"{rule}: {errors} errors in {steps}"
