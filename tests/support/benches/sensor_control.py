"""Our I2C controller sets up the Verilog model of a sensor, one that answers and one that does not.
"""

import cocotb
from cocotb.triggers import ReadOnly, RisingEdge, with_timeout

from benches.common import clocks, settings, start
from benches.i2c import command, write
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.sensor import Settings

__all__ = ["set_up"]

QUARTER = 8             # clocks of a quarter of a bit


def bytes_of(sensor, register, value=None):
    """A register's address, and its value, as they are sent."""
    data = register.to_bytes(sensor.pointer_bits // 8, "big")
    return data if value is None else data + value.to_bytes(sensor.value_bits // 8, "big")


async def read(dut, sensor, register):
    """The value of a register, by a repeated START."""
    for k, byte in enumerate([sensor.i2c_address << 1, *bytes_of(sensor, register)]):
        result = await command(dut, data=byte, write=1, start=k == 0)
        assert (result.nack, result.lost, result.timeout) == (0, 0, 0)
    await command(dut, data=sensor.i2c_address << 1 | 1, write=1, start=1)
    value, size = 0, sensor.value_bits // 8
    for k in range(size):
        last = k == size - 1
        value = value << 8 | (await command(dut, read=1, nack=last, stop=last)).data
    return value


async def failed_start(dut, sensor, kind):
    """The START of the fault: the controller reports what is wrong, and the bus works again."""
    address = sensor.i2c_address << 1
    if kind == "nack":
        result = await command(dut, data=address, write=1, start=1, stop=1)
        assert (result.nack, result.lost, result.timeout) == (1, 0, 0)
        return
    result = await command(dut, data=address, write=1, start=1)
    assert (result.nack, result.lost) == (0, 0)
    result = await command(dut, data=0xFF, write=1, stop=1)
    assert result.lost == 1, "SDA is stuck, and this is not reported"
    result = await command(dut, data=address, write=1, start=1, stop=1)
    assert result.lost == 1
    # Nine clocks free the target.
    await command(dut, read=1, nack=1, stop=1)
    await clocks(dut, 4 * QUARTER)
    await ReadOnly()
    assert dut.sda.value == 1
    await clocks(dut, 1)


@cocotb.test()
async def set_up(dut):
    """Every register of the configuration reads back as it was written last; then frames come."""
    given = settings()
    sensor = sensor_named(given["sensor"])
    plan = setup(sensor, Settings(**given["asked"]))
    await start(dut, quarter=QUARTER, limit=2000, i__valid=0)
    await clocks(dut, 20)
    for register, value in sensor.chip_id:
        assert await read(dut, sensor, register) == value
    if given["fault"]:
        await failed_start(dut, sensor, given["fault"])
    written = {}
    for k, (register, value) in enumerate(plan.pairs):
        assert dut.frame_valid.value == 0 or k < len(plan.pairs) - 1
        await write(dut, sensor.i2c_address, bytes_of(sensor, register, value))
        # After a write to a page register others are at the same addresses.
        written = {} if register == 0xF0 else written
        written[register] = value
    limit = 2 * plan.timing.frame_clocks * 10
    await with_timeout(RisingEdge(dut.frame_valid), limit, "ns")
    await clocks(dut, 1)
    for register, value in written.items():
        assert await read(dut, sensor, register) == value, hex(register)
