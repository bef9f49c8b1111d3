"""The Verilog model of a sensor: its registers by the controller of cocotbext-i2c, its frames
compared with the reference model."""

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, ReadOnly, RisingEdge, Timer, with_timeout
from cocotbext.i2c import I2cMaster

from benches.common import PERIOD, settings
from ncdc_sim.sensor.reference import raw_frames
from ncdc_sim.sensor.verilog import Light
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.sensor import Settings

__all__ = ["LIGHT", "frames"]

LIGHT = "light.bin"             # file of the samples
I2C_HZ = 4_000_000              # 25 pixel clocks a bit


class Host:
    """Registers by I2C, as ``sensor`` has them."""
    def __init__(self, dut, sensor):
        self.sensor = sensor
        self.bus = I2cMaster(sda=dut.sda, sda_o=dut.sda_o, scl=dut.scl, scl_o=dut.scl_o,
                             speed=I2C_HZ)

    async def write(self, register, value):
        """Write a register."""
        sensor = self.sensor
        data = (register.to_bytes(sensor.pointer_bits // 8, "big")
                + value.to_bytes(sensor.value_bits // 8, "big"))
        await self.bus.write(sensor.i2c_address, data)
        await self.bus.send_stop()

    async def read(self, register, count=1):
        """The values of ``count`` registers, one after the other."""
        sensor, size = self.sensor, self.sensor.value_bits // 8
        await self.bus.write(sensor.i2c_address,
                             register.to_bytes(sensor.pointer_bits // 8, "big"))
        data = await self.bus.read(sensor.i2c_address, size * count)
        await self.bus.send_stop()
        return [int.from_bytes(data[k:k + size], "big") for k in range(0, len(data), size)]


async def begin(dut):
    """Clock and reset, both lines high."""
    dut.reset_n.value, dut.scl_o.value, dut.sda_o.value = 0, 1, 1
    cocotb.start_soon(Clock(dut.extclk, PERIOD, unit="ns").start())
    await Timer(10 * PERIOD, "ns")
    dut.reset_n.value = 1
    await Timer(10 * PERIOD, "ns")


async def rows_of(dut, rows):
    """Append to ``rows``, for each row, the list of its samples, until FRAME_VALID falls."""
    while True:
        await RisingEdge(dut.line_valid)
        row = []
        while True:
            await RisingEdge(dut.pixclk)
            await ReadOnly()
            if not dut.line_valid.value:
                break
            row.append(int(dut.data.value))
        rows.append(row)


async def frame_of(dut):
    """The rows of the next frame that begins, and pixel clocks from its beginning to its end."""
    await RisingEdge(dut.frame_valid)
    begun, rows = cocotb.simtime.get_sim_time("ns"), []
    task = cocotb.start_soon(rows_of(dut, rows))
    await FallingEdge(dut.frame_valid)
    await FallingEdge(dut.extclk)
    task.cancel()
    return rows, begun


def asked():
    """The configuration and the light that the bench was given."""
    given = settings()
    sensor = sensor_named(given["sensor"])
    shape, corner = given["shape"], given["corner"]
    light = Light(np.fromfile(LIGHT, "<u2").reshape(shape), *corner, given["nominal"])
    return setup(sensor, Settings(**given["asked"])), light


@cocotb.test()
async def frames(dut):
    """Written registers read back; samples are the reference model's, lines and frames take the
    configured times."""
    given, light = asked()
    await begin(dut)
    host, timing = Host(dut, given.sensor), given.timing
    for register, value in given.sensor.chip_id:
        assert await host.read(register) == [value]
    *first, last = given.pairs
    for register, value in first:
        await host.write(register, value)
    assert dut.frame_valid.value == 0
    check = first[-1]
    assert await host.read(check[0]) == [check[1]] and await host.read(check[0], 2)
    cocotb.start_soon(host.write(*last))
    expected, begins = raw_frames(given, light), []
    limit = 4 * timing.frame_clocks * PERIOD + 100_000
    for number in range(given_frames()):
        rows, begun = await with_timeout(frame_of(dut), limit, "ns")
        begins.append(begun)
        fault = settings().get("fault")
        if fault is not None and fault["frame"] == number:
            check_fault(fault, rows, timing)
            continue
        wanted = expected[number % len(expected)]
        assert np.array_equal(rows, wanted), number
    if settings().get("fault") is None:
        gaps = np.diff(begins)
        assert set(gaps) == {timing.frame_clocks * PERIOD}, (gaps, timing)


def given_frames():
    return settings()["count"]


def check_fault(fault, rows, timing):
    """The frame has the fault, and no other."""
    row, lengths = fault["row"], [len(row) for row in rows]
    usual = [timing.width] * timing.height
    half = timing.width // 2
    wanted = {
        "short_line": [*usual[:row], timing.width - 1, *usual[row + 1:]],
        "long_line": [*usual[:row], timing.width + 1, *usual[row + 1:]],
        "glitch": [*usual[:row], half, timing.width - half - 1, *usual[row + 1:]],
        "cut_frame": usual[:row],
        "clock_stop": usual,
    }[fault["kind"]]
    assert lengths == wanted, (fault, lengths)
