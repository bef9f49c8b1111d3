"""The I2C controller on a bus with targets of cocotbext-i2c, with one that holds a line, and with
another controller."""

import random

import cocotb
from cocotb.triggers import FallingEdge, ReadOnly, Timer
from cocotbext.i2c import I2cDevice, I2cMemory

from benches.common import PERIOD, clocks, pack, settings, start, unpack
from ncdc_hdl.camera.i2c import COMMAND, RESULT

__all__ = ["a_held_clock", "a_stuck_target", "arbitration", "memory", "no_target", "stretching"]

TARGET, ABSENT = 0x50, 0x21
LIMIT = 1500


class Line:
    """One participant's output to a line: 0 pulls it low."""
    def __init__(self):
        self.value = 1

    def setimmediatevalue(self, value):
        """The value, as of a simulator's handle."""
        self.value = value


class Bus:
    """Both lines, each low if anybody pulls it low; watches what the controller does to them.

    The lines change after a falling edge of the controller's clock, or with the setting ``wander``
    at any time until the next one. ``shortest`` are the fewest clocks for which SCL was low, and
    high, after its first edge.
    """
    def __init__(self, dut, *targets):
        self.dut, self.scl, self.sda = dut, [Line()], [Line()]
        self.targets = [target(dut, self) for target in targets]
        self.shortest = [LIMIT, LIMIT]
        cocotb.start_soon(self._join())
        cocotb.start_soon(self._watch())

    def lines(self):
        """A line of each kind for one more participant."""
        self.scl.append(Line())
        self.sda.append(Line())
        return {"scl": self.dut.scl, "scl_o": self.scl[-1], "sda": self.dut.sda,
                "sda_o": self.sda[-1]}

    async def _join(self):
        dut, rng, wander = self.dut, random.Random(4), settings().get("wander", False)
        while True:
            if wander:
                await Timer(rng.randrange(1, 1000 * PERIOD), "ps")
            dut.scl.value = int(not dut.scl_low.value and all(int(one.value) for one in self.scl))
            dut.sda.value = int(not dut.sda_low.value and all(int(one.value) for one in self.sda))
            await FallingEdge(dut.clk)

    async def _watch(self):
        lasted, before = None, 1
        while True:
            await ReadOnly()
            scl = int(self.dut.scl.value)
            if scl != before:
                if lasted is not None:
                    self.shortest[before] = min(self.shortest[before], lasted)
                lasted = 0
            lasted = None if lasted is None else lasted + 1
            before = scl
            await FallingEdge(self.dut.clk)


async def begin(dut, *targets):
    """Reset, and let both lines go high."""
    await start(dut, quarter=settings()["quarter"], limit=LIMIT, i__valid=0, scl=1, sda=1)
    bus = Bus(dut, *targets)
    await clocks(dut, 20)
    return bus


async def command(dut, **fields):
    """The RESULT of one command."""
    item = {"data": 0, "start": 0, "write": 0, "read": 0, "nack": 0, "stop": 0, **fields}
    dut.i__payload.value, dut.i__valid.value = pack(COMMAND, item), 1
    await ReadOnly()
    assert dut.i__ready.value == 1
    await FallingEdge(dut.clk)
    dut.i__valid.value = 0
    for _ in range(100_000):
        await ReadOnly()
        if dut.done.value == 1:
            result = unpack(RESULT, dut.result.value)
            await FallingEdge(dut.clk)
            return result
        await FallingEdge(dut.clk)
    raise AssertionError("the command is never over")


async def write(dut, address, data):
    """Write bytes after a START; every one must be acknowledged."""
    for k, byte in enumerate([address << 1, *data]):
        result = await command(dut, data=byte, write=1, start=k == 0, stop=k == len(data))
        assert (result.nack, result.lost, result.timeout) == (0, 0, 0), k


async def read(dut, address, pointer, count):
    """Read bytes from ``pointer`` on, with a repeated START."""
    await command(dut, data=address << 1, write=1, start=1)
    await command(dut, data=pointer, write=1)
    result = await command(dut, data=address << 1 | 1, write=1, start=1)
    assert (result.nack, result.lost, result.timeout) == (0, 0, 0)
    found = []
    for k in range(count):
        result = await command(dut, read=1, nack=k == count - 1, stop=k == count - 1)
        assert (result.lost, result.timeout) == (0, 0)
        found.append(result.data)
    return bytes(found)


def memory_target(dut, bus):
    """256 bytes, as of an EEPROM."""
    return I2cMemory(**bus.lines(), addr=TARGET, size=256)


def lets_go(dut):
    return dut.scl_low.value == 0 and dut.sda_low.value == 0


@cocotb.test()
async def memory(dut):
    """Random bytes, written and read back; the bits are no shorter than they may be."""
    bus, rng, expected = await begin(dut, memory_target), random.Random(3), bytearray(256)
    for _ in range(4):
        at, count = rng.randrange(200), rng.randrange(1, 6)
        expected[at:at + count] = data = rng.randbytes(count)
        await write(dut, TARGET, [at, *data])
        at, count = rng.randrange(200), rng.randrange(1, 6)
        assert await read(dut, TARGET, at, count) == expected[at:at + count]
        assert lets_go(dut)
    assert bus.targets[0].read_mem(0, 256) == expected
    # A line that changes at any time may be seen a clock later when it falls.
    minimum = 2 * settings()["quarter"] - settings().get("wander", False)
    assert min(bus.shortest) >= minimum, bus.shortest


@cocotb.test()
async def no_target(dut):
    """A missing acknowledge is reported, and the bus works afterwards."""
    await begin(dut, memory_target)
    result = await command(dut, data=ABSENT << 1, write=1, start=1, stop=1)
    assert (result.nack, result.lost, result.timeout) == (1, 0, 0) and lets_go(dut)
    await write(dut, TARGET, [7, 0x5A])
    assert await read(dut, TARGET, 7, 1) == b"\x5a"


class Slow(I2cDevice):
    """Holds SCL before each byte that it sends."""
    addr = TARGET

    async def handle_read(self):
        """A byte, after a while."""
        # The package would hold SCL in the middle of the acknowledge, where it is high.
        self._set_scl(1)
        if self.scl.value == 1:
            await FallingEdge(self.scl)
        self._set_scl(0)
        await Timer(LIMIT // 2 * PERIOD, "ns")
        return 0xC3


@cocotb.test()
async def stretching(dut):
    """A target that holds SCL is waited for."""
    await begin(dut, lambda dut, bus: Slow(**bus.lines()))
    await command(dut, data=TARGET << 1 | 1, write=1, start=1)
    for last in (0, 1):
        result = await command(dut, read=1, nack=last, stop=last)
        assert (result.data, result.lost, result.timeout) == (0xC3, 0, 0)


@cocotb.test()
async def a_held_clock(dut):
    """SCL held for ever ends the command; the bus works when it is let go."""
    bus = await begin(dut, memory_target)
    held = bus.lines()["scl_o"]
    held.value = 0
    result = await command(dut, data=TARGET << 1, write=1, start=1, stop=1)
    assert (result.lost, result.timeout) == (0, 1) and lets_go(dut)
    held.value = 1
    await clocks(dut, 20)
    await write(dut, TARGET, [9, 0xA5])
    assert await read(dut, TARGET, 9, 1) == b"\xa5"


@cocotb.test()
async def a_stuck_target(dut):
    """A controller that is reset in mid-byte leaves SDA held; nine clocks free it."""
    await begin(dut, memory_target)
    await write(dut, TARGET, [0, 0, 0])
    await command(dut, data=TARGET << 1, write=1, start=1)
    await command(dut, data=0, write=1)
    await command(dut, data=TARGET << 1 | 1, write=1, start=1)
    dut.i__payload.value, dut.i__valid.value = pack(COMMAND, {
        "data": 0, "start": 0, "write": 0, "read": 1, "nack": 0, "stop": 0}), 1
    await clocks(dut, 10 * settings()["quarter"])
    dut.rst.value, dut.i__valid.value = 1, 0
    await clocks(dut, 3)
    dut.rst.value = 0
    await clocks(dut, 20)
    assert lets_go(dut) and dut.sda.value == 0
    result = await command(dut, data=TARGET << 1, write=1, start=1, stop=1)
    assert result.lost == 1
    result = await command(dut, read=1, nack=1, stop=1)
    assert result.lost == 0 and dut.sda.value == 1
    await write(dut, TARGET, [9, 0xA5])
    assert await read(dut, TARGET, 9, 1) == b"\xa5"


@cocotb.test()
async def arbitration(dut):
    """Another controller sends a zero where this one sends a one: this one lets go at once."""
    bus = await begin(dut, memory_target)
    other = bus.lines()["sda_o"]
    task = cocotb.start_soon(command(dut, data=0xFF, write=1, start=1, stop=1))
    await clocks(dut, 9 * settings()["quarter"])        # in the second bit, SCL low
    other.value = 0
    await clocks(dut, 4 * settings()["quarter"] + 8)    # a bit, and the filter
    assert task.done(), "what another controller sends is not looked at"
    result = task.result()
    assert (result.lost, result.timeout) == (1, 0) and lets_go(dut)
