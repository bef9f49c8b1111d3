"""The Verilog model of an EEPROM, and cocotbext-i2c's controller: chips of four sizes on a bus."""

import random

import cocotb
from cocotb.triggers import ReadOnly
from cocotbext.i2c import I2cMaster

from benches.common import clocks, settings, start

__all__ = ["absent", "pages", "reads", "several_at_once", "without_stop"]

_HZ = 10e6              # of the bus: 20 clocks a bit


class Chip:
    """One chip of the bus, what it should hold, and the controller's accesses to it."""
    def __init__(self, dut, master, pins, size, page, content):
        self.dut, self.master, self.size, self.page = dut, master, size, page
        self.wide, self.i2c = size > 2048, 0x50 | pins
        self.content = bytearray(bytes(content).ljust(size, b"\xff"))

    async def point(self, address):
        """START, and an address in the chip; whether it answers."""
        upper = 0 if self.wide else address >> 8
        await self.master.send_start()
        if await self.master.send_byte((self.i2c | upper) << 1):
            await self.master.send_stop()
            return False
        if self.wide:
            assert not await self.master.send_byte(address >> 8)
        assert not await self.master.send_byte(address & 0xFF)
        return True

    async def read(self, address, count):
        """Bytes from an address on, None: from where the last access has ended."""
        if address is not None:
            assert await self.point(address)
        data = await self.master.read(self.i2c, count)
        await self.master.send_stop()
        return bytes(data)

    async def write(self, address, data, stop=True):
        """Data of a page; what the chip should hold then."""
        assert await self.point(address)
        for k, byte in enumerate(data):
            assert not await self.master.send_byte(byte)
            if stop:
                self.content[address - address % self.page + (address + k) % self.page] = byte
        if stop:
            await self.master.send_stop()

    async def ready(self):
        """Poll until the chip answers, as it does not while it writes; how often it did not."""
        count = 0
        while not await self.point(0):
            count += 1
            assert count < 100, "the write never ends"
        await self.master.send_stop()
        return count

    def expected(self, address, count):
        """What a read finds."""
        return bytes(self.content[(address + k) % self.size] for k in range(count))


async def begin(dut):
    """The chips, with what the settings say."""
    await start(dut, scl_o=1, sda_o=1)
    master = I2cMaster(sda=dut.sda, sda_o=dut.sda_o, scl=dut.scl, scl_o=dut.scl_o, speed=_HZ)
    await clocks(dut, 20)
    return [Chip(dut, master, *one[:3], bytes.fromhex(one[3])) for one in settings()["chips"]]


@cocotb.test()
async def reads(dut):
    """Anywhere, beyond the end, and on from there; what its file does not have is ones."""
    rng = random.Random(1)
    for chip in await begin(dut):
        for address in (0, rng.randrange(chip.size), chip.size - 3):
            assert await chip.read(address, 7) == chip.expected(address, 7)
        assert await chip.read(None, 4) == chip.expected(4, 4)


@cocotb.test()
async def pages(dut):
    """Data beyond the end of a page go to its beginning; the chip is busy for a while."""
    for chip in await begin(dut):
        at = chip.size // 2 + chip.page - 3
        await chip.write(at, bytes(range(1, 7)))
        assert await chip.ready() > 0
        base = at - at % chip.page
        assert await chip.read(base - 2, chip.page + 4) == chip.expected(base - 2, chip.page + 4)


@cocotb.test()
async def without_stop(dut):
    """Data that a START follows are not written."""
    for chip in await begin(dut):
        await chip.write(5, b"\x12\x34", stop=False)
        assert await chip.read(4, 5) == chip.expected(4, 5)
        assert await chip.ready() == 0


@cocotb.test()
async def several_at_once(dut):
    """While one writes the others answer, and keep what they have."""
    chips = await begin(dut)
    await chips[0].write(0, b"\x77")
    for chip in chips[1:]:
        assert await chip.read(0, 4) == chip.expected(0, 4)
    assert await chips[0].ready() >= 0
    assert await chips[0].read(0, 4) == chips[0].expected(0, 4)


@cocotb.test()
async def absent(dut):
    """No chip has the address; and none without a file, which pulls nothing low."""
    chips = await begin(dut)
    master = chips[0].master
    for address in (0x50, 0x57, 0x2A):
        await master.send_start()
        assert await master.send_byte(address << 1), hex(address)
        await master.send_stop()
    await ReadOnly()
    assert dut.sda.value == 1
