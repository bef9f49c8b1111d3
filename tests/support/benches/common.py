"""Common parts of the test benches: clocking, streams with pauses, free-running pipelines.

Every process does its work around the falling edge. It sets inputs there, and samples the settled
signals that the next rising edge will see. This means the same in every simulator, whichever side
of the rising edge its callbacks fall on.
"""

import json
import os
import random

import cocotb
from amaranth.hdl import Const, Shape
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, ReadOnly

__all__ = ["PERIOD", "clocks", "get", "pack", "pipeline", "put", "receive", "send", "settings",
           "signed", "start", "unpack"]

PERIOD = 10     # ns


def settings():
    """The settings that ``run_cocotb`` was given, as a dict."""
    return json.loads(os.environ["NCDC_BENCH"])


def signed(value, width):
    """The ``width`` low bits of ``value`` as a two's complement number."""
    value &= (1 << width) - 1
    return value - (1 << width) if value >> (width - 1) else value


def pack(layout, item):
    """Bits of ``item`` (int, dict or list) in an Amaranth ``layout``; ints are cut to its width."""
    if isinstance(item, int):
        return item & ((1 << Shape.cast(layout).width) - 1)
    return Const.cast(layout.const(item)).value


def unpack(layout, value):
    """Field access to the bits ``value`` of an Amaranth ``layout``."""
    return layout.from_bits(int(value))


async def start(dut, **inputs):
    """Start the clock, set ``inputs`` (zero where absent) and reset for three clocks."""
    cocotb.start_soon(Clock(dut.clk, PERIOD, unit="ns").start())
    if hasattr(dut, "rst"):
        dut.rst.value = 1
    for name, value in inputs.items():
        handle = getattr(dut, name)
        handle.value = value & ((1 << len(handle)) - 1)
    await clocks(dut, 3)
    if hasattr(dut, "rst"):
        dut.rst.value = 0


async def clocks(dut, count):
    """Wait for ``count`` falling edges."""
    for _ in range(count):
        await FallingEdge(dut.clk)


async def put(dut, name, payloads, gap=0.0, seed=1):
    """Offer the packed ``payloads`` on the stream ``name``, idling with probability ``gap``.

    Starts and ends after a falling edge. The payload is scrambled while valid is low: a
    consumer that looks at it then is found out.
    """
    valid, ready, payload = (getattr(dut, f"{name}__{part}")
                             for part in ("valid", "ready", "payload"))
    rng, width = random.Random(seed), len(payload)
    for item in payloads:
        while rng.random() < gap:
            valid.value = 0
            payload.value = rng.getrandbits(width)
            await FallingEdge(dut.clk)
        valid.value, payload.value = 1, item
        taken = False
        while not taken:
            await ReadOnly()
            taken = bool(ready.value)
            await FallingEdge(dut.clk)
    valid.value = 0
    payload.value = rng.getrandbits(width)


async def get(dut, name, count, stall=0.0, seed=2, limit=100000):
    """Take ``count`` payloads from the stream ``name`` as ints; ``stall``: how often ready is low.

    A payload that is not taken must stay valid and unchanged. ``limit``: clocks without a payload
    after which the test fails.
    """
    valid, ready, payload = (getattr(dut, f"{name}__{part}")
                             for part in ("valid", "ready", "payload"))
    rng, got, held, silent = random.Random(seed), [], None, 0
    while len(got) < count:
        take = rng.random() >= stall
        ready.value = int(take)
        await ReadOnly()
        offered = int(payload.value) if bool(valid.value) else None
        assert held is None or offered == held, f"{name}: payload {len(got)} changed in a stall"
        held = offered if not take else None
        if take and offered is not None:
            got.append(offered)
            silent = 0
        silent += 1
        assert silent < limit, f"{name}: no payload {len(got)} of {count} in {limit} clocks"
        await FallingEdge(dut.clk)
    ready.value = 0
    return got


async def send(dut, name, payloads, gap=0.0, seed=1):
    """Announce and send the packed ``payloads`` to the ``Credited`` input ``name``.

    Each comes in the clock of its issue, which idles with probability ``gap``.
    """
    space, issue, valid, payload = (getattr(dut, f"{name}__{part}")
                                    for part in ("space", "issue", "valid", "payload"))
    rng, width, waiting, allowed = random.Random(seed), len(payload), list(payloads), True
    while waiting:
        goes = allowed and rng.random() >= gap
        issue.value = valid.value = int(goes)
        payload.value = waiting.pop(0) if goes else rng.getrandbits(width)
        await ReadOnly()
        allowed = bool(space.value)
        await FallingEdge(dut.clk)
    issue.value = valid.value = 0


async def receive(dut, name, count, stall=0.0, seed=2, limit=100000):
    """Take ``count`` payloads of the ``Credited`` output ``name`` as ints.

    ``stall``: how often there is no space. ``limit``: as in :func:`get`.
    """
    space, issue, valid, payload = (getattr(dut, f"{name}__{part}")
                                    for part in ("space", "issue", "valid", "payload"))
    rng, got, allowed, silent = random.Random(seed), [], True, 0
    while len(got) < count:
        gives = rng.random() >= stall
        space.value = int(gives)
        await ReadOnly()
        assert allowed or not bool(issue.value), f"{name}: issue without space"
        allowed, silent = gives, silent + 1
        if bool(valid.value):
            got.append(int(payload.value))
            silent = 0
        assert silent < limit, f"{name}: no payload {len(got)} of {count} in {limit} clocks"
        await FallingEdge(dut.clk)
    space.value = 0
    return got


async def pipeline(dut, inputs, outputs, latency):
    """Feed a free-running pipeline one set of ``inputs`` per clock.

    ``inputs``: port name to ints; ``outputs``: port names. Returns port name to ints: output k is
    what stands there exactly ``latency`` clocks after input k.
    """
    count = len(next(iter(inputs.values())))
    ports = {name: getattr(dut, name) for name in (*inputs, *outputs)}
    masks = {name: (1 << len(ports[name])) - 1 for name in inputs}
    results = {name: [] for name in outputs}
    for k in range(count + latency):
        for name, values in inputs.items():
            ports[name].value = int(values[min(k, count - 1)]) & masks[name]
        await ReadOnly()
        if k >= latency:
            for name in outputs:
                results[name].append(int(ports[name].value))
        await FallingEdge(dut.clk)
    return results
