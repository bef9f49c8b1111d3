"""The stream checker in Verilog: silent on good traffic, one violation for each planted one."""

import cocotb
from cocotb.types import Logic

from benches.common import clocks, settings, start

__all__ = ["violations", "good_traffic"]

IDLE = {"valid": 0, "ready": 0, "data": 0, "startofpacket": 0, "endofpacket": 0,
        "host_rst": 0}
TAKE = {"valid": 1, "ready": 1}
FIRST, LAST = TAKE | {"startofpacket": 1}, TAKE | {"endofpacket": 1}
STALL = {"ready": 0}
HOST = {"host_rst": 1}

GOOD = [FIRST | STALL, FIRST, TAKE | {"data": 3} | STALL, TAKE | {"data": 3}, {}, LAST,
        FIRST | LAST, FIRST, LAST,
        # The source is reset, at once and a clock later.
        FIRST, TAKE | STALL | HOST, {}, FIRST, LAST,
        FIRST, TAKE | STALL | HOST, TAKE | {"data": 3} | STALL, FIRST, LAST]

VIOLATIONS = [
    ("held", [FIRST | STALL, {}]),
    ("held", [FIRST | STALL, FIRST | {"valid": 0}]),
    ("held", [FIRST | STALL, FIRST | {"data": 1}]),
    ("held", [FIRST, TAKE | STALL, LAST]),
    ("packet-start", [TAKE]),
    ("packet-start", [FIRST, FIRST]),
    ("packet-start", [FIRST, LAST, LAST]),
    ("packet-start", [FIRST, TAKE | STALL | HOST, {}, TAKE]),
]
UNKNOWN = [("unknown", [{"valid": Logic("X")}]), ("unknown", [FIRST | {"data": None}])]


async def play(dut, steps):
    """Reset, play the ``steps``, and give the number of errors."""
    await start(dut, **IDLE)
    for step in [*steps, IDLE]:
        for name, value in (IDLE | step).items():
            handle = getattr(dut, name)
            handle.value = "X" * len(handle) if value is None else value
        await clocks(dut, 1)
    return int(dut.errors.value)


@cocotb.test()
async def good_traffic(dut):
    """No violation; the counters count."""
    assert await play(dut, GOOD) == 0
    assert [int(getattr(dut, name).value) for name in ("beats", "packets", "waits")] == [12, 5, 5]


@cocotb.test()
async def violations(dut):
    """Each planted violation counts once."""
    for rule, steps in VIOLATIONS + (UNKNOWN if settings()["four_states"] else []):
        errors = await play(dut, steps)
        assert errors == 1, f"{rule}: {errors} errors in {steps}"
