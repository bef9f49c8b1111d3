"""The I2C controller, briefly: bytes, arbitration that is lost, and spikes on the lines."""

import pytest
from amaranth.sim import Simulator

from ncdc_hdl.camera.i2c import I2cController

QUARTER = 8
BIT = 4 * QUARTER


class Bus:
    """Both lines, each low if a side pulls it low; a target that acknowledges and sends a byte.

    ``log`` has "S", "P" and the bits that SCL's rising edges show. ``sends``: the target's bits
    from the given rising edge on, None: let go.
    """

    def __init__(self, sends=None, hold=None, spikes=0):
        self.controller = I2cController()
        self.sends, self.hold, self.spikes = sends or {}, hold, spikes
        self.log, self.rises, self.clock = [], 0, 0
        self.scl, self.sda, self.results = 1, 1, []

    def run(self, *commands):
        """(byte seen, nack, lost, timeout) of each command, a dict of its flags and ``data``."""
        simulator = Simulator(self.controller)
        simulator.add_clock(1e-6)

        async def commanded(ctx):
            await self._commands(ctx, commands)

        simulator.add_testbench(commanded)
        simulator.add_testbench(self._lines, background=True)
        simulator.run()
        return self.results

    async def _commands(self, ctx, commands):
        controller = self.controller
        ctx.set(controller.quarter, QUARTER)
        ctx.set(controller.limit, 1000)
        for command in commands:
            ctx.set(controller.i.payload, {"data": 0, "start": 0, "write": 0, "read": 0, "nack": 0,
                                           "stop": 0} | command)
            ctx.set(controller.i.valid, 1)
            await ctx.tick().until(controller.i.ready)
            ctx.set(controller.i.valid, 0)
            await ctx.tick().until(controller.done)
            result = ctx.get(controller.result)
            self.results.append((result.data, result.nack, result.lost, result.timeout))
        await ctx.tick().repeat(BIT)

    async def _lines(self, ctx):
        controller = self.controller
        while True:
            low = self.sends.get(self.rises) == 0 or (
                self.hold is not None and self.hold(self))
            scl = not ctx.get(controller.scl_low)
            sda = not (ctx.get(controller.sda_low) or low)
            if scl and self.scl and sda != self.sda:
                self.log.append("P" if sda else "S")
            if scl and not self.scl:
                self.log.append(int(sda))
            if not scl and self.scl:
                self.rises = sum(item in (0, 1) for item in self.log)
            self.scl, self.sda = scl, sda
            # A spike: the line is seen as it is not, for so many clocks of every seven.
            wrong = self.clock % 7 < self.spikes
            ctx.set(controller.scl, scl != wrong)
            ctx.set(controller.sda, sda != wrong)
            self.clock += 1
            await ctx.tick()


def bits(byte):
    return [byte >> k & 1 for k in reversed(range(8))]


WRITE = {"data": 0xA6, "start": 1, "write": 1}
LAST = {"data": 0x35, "write": 1, "stop": 1}
ACKNOWLEDGED = {8: 0, 17: 0}


@pytest.mark.parametrize("spikes", [0, 1, 2])
def test_bytes_go_out_and_are_acknowledged(spikes):
    """Spikes of up to two clocks, on both lines all the time, change nothing."""
    bus = Bus(ACKNOWLEDGED, spikes=spikes)
    assert bus.run(WRITE, LAST) == [(0xA6, 0, 0, 0), (0x35, 0, 0, 0)]
    assert bus.log == ["S", *bits(0xA6), 0, *bits(0x35), 0, 0, "P"]


def test_no_target():
    assert Bus().run(WRITE | {"stop": 1}) == [(0xA6, 1, 0, 0)]


def test_a_byte_comes_in():
    sent = dict(enumerate(bits(0x5C), 9))
    bus = Bus(ACKNOWLEDGED | sent | {17: None})
    results = bus.run({"data": 0xA7, "start": 1, "write": 1}, {"read": 1, "nack": 1, "stop": 1})
    assert results == [(0xA7, 0, 0, 0), (0x5C, 0, 0, 0)]
    assert bus.log[-2:] == [0, "P"] and bus.log[-3] == 1


@pytest.mark.parametrize("step", ["start", "bit", "acknowledge", "stop"])
def test_whoever_pulls_sda_low_has_the_bus(step):
    """The command ends at once, with both lines let go."""
    rises = {"start": 0, "bit": 0, "acknowledge": 17, "stop": 18}[step]

    def hold(bus):
        if step == "start":
            return True
        # At STOP SDA is low until the last quarter; before, SCL is low too.
        return bus.rises >= rises and bus.log.count("S") == 1

    sends = dict.fromkeys([8, 17], 0) | dict.fromkeys(range(9, 17))
    last = {"read": 1, "nack": 1, "stop": 1} if step == "acknowledge" else LAST
    bus = Bus(sends if step != "acknowledge" else {8: 0}, hold=hold)
    results = bus.run(WRITE, last) if step in ("acknowledge", "stop") else bus.run(WRITE)
    assert results[-1][1:] == (0, 1, 0)
    assert [result[2] for result in results[:-1]] == [0] * (len(results) - 1)
    assert "P" not in bus.log and bus.scl
