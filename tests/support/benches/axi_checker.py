"""The AXI checker in Verilog: silent on good traffic, one violation for each planted one."""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, FallingEdge
from cocotb.types import Logic

from benches.common import PERIOD, settings

__all__ = ["violations", "good_traffic"]

_BURST = {"len": 1, "size": 2, "burst": 1, "lock": 0, "id": 0, "addr": 64}
IDLE = ({f"a{c}{name}": value if name in ("size", "burst") else 0
         for c in "rw" for name, value in _BURST.items()}
        | dict.fromkeys(("arvalid", "awvalid", "wvalid", "rvalid", "bvalid", "wlast", "rlast",
                         "rid", "bid", "rresp", "bresp", "rdata", "wdata"), 0)
        | dict.fromkeys(("arready", "awready", "wready", "rready", "bready", "resetn"), 1)
        | {"wstrb": 15})
AR = {f"ar{name}": value for name, value in _BURST.items()} | {"arvalid": 1}
AW = {f"aw{name}": value for name, value in _BURST.items()} | {"awvalid": 1}
W, LAST = {"wvalid": 1, "wdata": 7}, {"wlast": 1}
R, RLAST, B = {"rvalid": 1, "rdata": 3}, {"rlast": 1}, {"bvalid": 1}
AR_WAIT, AW_WAIT, W_WAIT = {"arready": 0}, {"awready": 0}, {"wready": 0}
RESET = {"resetn": 0}

GOOD = [
    AR | AR_WAIT, AR, R, R | RLAST,
    AR, AR | R, R | RLAST, R, R | RLAST,                        # pipelined
    AW | W | AW_WAIT | W_WAIT, AW | W, W | LAST, B,
    AW | W | AW_WAIT, AW | W | LAST | AW_WAIT, AW | AW_WAIT, AW, B,     # words before the address
    AW, W, W | LAST, {}, B | {"bready": 0}, B,
    AW | {"awaddr": 4088}, W, W | LAST, B,                      # to the end of a page
    AR | AR_WAIT, AR | AR_WAIT | RESET, RESET, {}, AR, R, R | RLAST,
    AW | W, RESET, {}, AW | W, W | LAST, B,
]

# Rule, then the clocks that break it once.
VIOLATIONS = [
    ("held", [AR | AR_WAIT, AR | {"araddr": 68}, R, R | RLAST]),
    ("held", [AR | AR_WAIT, {}]),
    ("held", [AW | AW_WAIT, AW | {"awlen": 0}, W, W | LAST, B]),
    ("held", [AW | W | W_WAIT, W | {"wdata": 8}, W | LAST, B]),
    ("held", [AW | W | W_WAIT, {}, W, W | LAST, B]),
    ("held", [AR, R | {"rready": 0}, {}, R, R | RLAST]),
    ("held", [AW | W, W | LAST, B | {"bready": 0}, B | {"bresp": 2}]),
    ("burst", [AR | {"arburst": 0}, R, R | RLAST]),
    ("burst", [AR | {"arsize": 1}, R, R | RLAST]),
    ("burst", [AR | {"araddr": 66}, R, R | RLAST]),
    ("burst", [AR | {"arlock": 1}, R, R | RLAST]),
    ("burst", [AW | {"awid": 1}, W, W | LAST, B]),
    ("burst", [AR | {"arlen": 16}, *[R] * 16, R | RLAST]),
    ("page", [AR | {"araddr": 4092}, R, R | RLAST]),
    ("page", [AW | {"awaddr": 8188}, W, W | LAST, B]),
    ("last", [AW, W | LAST, W | LAST, B]),
    ("last", [AW, W, W, B]),
    ("no-address", [W | W_WAIT, AW | W, W | LAST, B]),
    ("outstanding", [*[AR] * 5, *[R, R | RLAST] * 5]),
    ("outstanding", [*[AW | {"awlen": 0} | W | LAST] * 5, *[B] * 5]),
    ("unrequested", [R | RLAST]),
    ("unrequested", [B]),
    ("answer-early", [AW, W, B, W | LAST, B]),
    ("read-last", [AR, R, R]),
    ("read-last", [AR, R | RLAST, R | RLAST]),
    ("read-last", [AR, R | {"rid": 1}, R | RLAST]),
    ("in-reset", [RESET, RESET, RESET, RESET | AR | AR_WAIT, RESET]),
]

X = Logic("X")
UNKNOWN = [("unknown", [{"arready": X}]), ("unknown", [AR | {"araddr": None, "arready": 1}, R,
                                                       R | RLAST])]


async def play(dut, steps):
    """Reset, play the ``steps``, and give the number of errors since."""
    for name, value in (IDLE | RESET).items():
        getattr(dut, name).value = value
    await ClockCycles(dut.clk, 2)
    await FallingEdge(dut.clk)
    dut.resetn.value = 1
    await FallingEdge(dut.clk)
    before = int(dut.errors.value)
    for step in steps:
        for name, value in (IDLE | step).items():
            handle = getattr(dut, name)
            handle.value = "X" * len(handle) if value is None else value
        await FallingEdge(dut.clk)
    for name, value in IDLE.items():
        getattr(dut, name).value = value
    await FallingEdge(dut.clk)
    return int(dut.errors.value) - before


@cocotb.test()
async def good_traffic(dut):
    """No violation; the counters count."""
    cocotb.start_soon(Clock(dut.clk, PERIOD, unit="ns").start())
    assert await play(dut, GOOD) == 0
    assert [int(getattr(dut, name).value) for name in ("reads", "writes", "words_read",
                                                       "words_written")] == [4, 6, 8, 11]


@cocotb.test()
async def violations(dut):
    """Each planted violation counts once."""
    cocotb.start_soon(Clock(dut.clk, PERIOD, unit="ns").start())
    for rule, steps in VIOLATIONS + (UNKNOWN if settings()["four_states"] else []):
        errors = await play(dut, steps)
        assert errors == 1, f"{rule}: {errors} errors in {steps}"
