"""Table I and II and registers over a stream of bytes, with registers and memory in Python."""

import random

import cocotb
import numpy as np
from cocotb.triggers import FallingEdge, ReadOnly

from benches.avalon import read_memory
from benches.common import clocks, settings, start, unpack
from ncdc_hdl.link.layouts import BEAT
from ncdc_spec.protocols.serial_link import crc8, read_request, write_request
from ncdc_spec.protocols.table_one import MRAW, READ, REQUEST, RESERVED, UNKNOWN, WRITE
from ncdc_spec.protocols.table_two import HEADER_BYTES, MrawHeader

__all__ = ["no_frame", "pictures", "registers", "requests_that_stop", "system_page", "the_sensor"]

PITCH, NUMBER, TIME = 24, 77, 0x1_2345_6789     # of a raw row; of the frame, in clocks
BUFFER, BASE = 2, 0x140
HELD = 0x100


class Device:
    """A host's side of the commands, and the registers and memory that they access."""

    def __init__(self, dut):
        self.dut, self.at = dut, settings()["addresses"]
        self.width, self.height = settings()["raw"]
        rng = np.random.default_rng(3)
        self.content = rng.integers(0, 256, 4096, np.uint8).tobytes()
        self.got, self.last = bytearray(), 0
        self.log = []               # (word address, word) written
        self.frame, self.sensor = True, {0x30: 0x1234}
        self.words = {self.at["WINDOW_WIDTH"]: self.width, self.at["RAW_PITCH"]: PITCH,
                      self.at["WINDOW_HEIGHT"]: self.height, self.at["WINDOW_LEFT"]: 1,
                      self.at["WINDOW_TOP"]: 0, self.at["SENT_WIDTH"]: 640}
        for store in ("RAW", "CORRECTED"):
            base = self.at[f"{store}0_BASE"] + 4 * BUFFER
            self.words |= {base: BASE, base + 1: NUMBER, base + 2: TIME & 0xFFFFFFFF,
                           base + 3: TIME >> 32}
        self.i2c = []               # bytes of the transfer so far
        self.absent = False         # no target answers on the I2C bus

    async def begin(self):
        """Reset, and start registers and memory."""
        await start(self.dut)
        for k in range(3):
            cocotb.start_soon(self.serve(k))
        cocotb.start_soon(read_memory(self.dut, "bus_", self.content, wait=.3, latency=(1, 9)))
        cocotb.start_soon(self.receive())

    async def serve(self, number):
        """Registers, after some clocks."""
        port = {name: getattr(self.dut, f"accesses__{number}__{name}") for name in (
            "valid", "write", "address", "word", "done", "answer")}
        rng = random.Random(number)
        while True:
            await ReadOnly()
            asked = bool(port["valid"].value)
            await FallingEdge(self.dut.clk)
            if asked:
                await clocks(self.dut, rng.randrange(4))
                address = int(port["address"].value)
                answer = 0
                if port["write"].value:
                    self.written(address, int(port["word"].value))
                else:
                    answer = self.read(address)
                port["answer"].value, port["done"].value = answer, 1
                await FallingEdge(self.dut.clk)
                port["done"].value, port["answer"].value = 0, rng.getrandbits(32)

    def written(self, address, word):
        self.log.append((address, word))
        if address == self.at["I2C_COMMAND"]:
            self.command(word)
        else:
            self.words[address] = word

    def command(self, word):
        """An I2C command to a sensor of 8 bits of address and 16 of value."""
        if word & 0x100:
            self.i2c = self.i2c if word & 1 else []
            self.part = 0
        result = 0x200 if self.absent and word & 0x200 else 0
        if word & 0x200 and not word & 0x100:
            self.i2c.append(word & 0xFF)
            if len(self.i2c) == 3:
                self.sensor[self.i2c[0]] = self.i2c[1] << 8 | self.i2c[2]
        if word & 0x400:
            value = self.sensor.get(self.i2c[0] if self.i2c else 0, 0)
            result |= value >> 8 if self.part == 0 else value & 0xFF
            self.part += 1
        self.words[self.at["I2C_RESULT"]] = result

    def read(self, address):
        if address == self.at["READER1"]:
            claimed = self.words.get(address, 0)
            held = self.frame and claimed in (1, 2)
            return (HELD if held else 0) | BUFFER << 11
        return self.words.get(address, 0)

    async def receive(self):
        """Take beats, now and then."""
        dut, rng, held = self.dut, random.Random(9), None
        while True:
            ready = rng.random() >= settings()["stall"]
            dut.o__ready.value = int(ready)
            await ReadOnly()
            beat = int(dut.o__payload.value) if dut.o__valid.value else None
            assert held in (None, beat), "a beat changed while it waited"
            held = beat if not ready else None
            await FallingEdge(dut.clk)
            if ready and beat is not None:
                one = unpack(BEAT, beat)
                self.got += int(one.data).to_bytes(4, "little")[:4 - one.empty]
                self.last += one.last

    async def send(self, data):
        """Bytes, with pauses."""
        dut, rng = self.dut, random.Random(len(data))
        for byte in data:
            while rng.random() < .2:
                dut.i__valid.value = 0
                await FallingEdge(dut.clk)
            dut.i__valid.value, dut.i__payload.value = 1, byte
            taken = False
            while not taken:
                await ReadOnly()
                taken = bool(dut.i__ready.value)
                await FallingEdge(dut.clk)
        dut.i__valid.value = 0

    async def ask(self, data, size, limit=20_000):
        """Send a request; its answer, which has so many bytes and no more."""
        before, ends = len(self.got), self.last
        await self.send(data)
        for _ in range(limit):
            if len(self.got) - before >= size:
                break
            await FallingEdge(self.dut.clk)
        await clocks(self.dut, 20)
        assert self.last == ends + (size != 0)
        return bytes(self.got[before:])


async def begun(dut):
    device = Device(dut)
    await device.begin()
    return device


@cocotb.test()
async def registers(dut):
    device = await begun(dut)
    assert await device.ask(write_request(0x123, 0xDEADBEEF), 2) == b"w" + bytes([crc8(b"w")])
    answer = await device.ask(read_request(0x123), 6)
    assert answer[:5] == b"r\xde\xad\xbe\xef" and crc8(answer) == 0
    wrong = bytearray(read_request(0x123))
    wrong[1] ^= 1
    assert (await device.ask(bytes(wrong), 2))[:1] == b"?"


@cocotb.test()
async def the_sensor(dut):
    device = await begun(dut)
    assert await device.ask(REQUEST.pack(READ, 0x30, 99), 5) == REQUEST.pack(READ, 0x30, 0x1234)
    assert await device.ask(REQUEST.pack(WRITE, 9, 0x567), 5) == REQUEST.pack(WRITE, 9, 0x567)
    assert device.sensor[9] == 0x567
    device.absent = True
    assert await device.ask(REQUEST.pack(READ, 0x30, 0), 5) == REQUEST.pack(READ, 0x30, 0xFFFF)
    # The bus is left free: a target that still holds SDA may end its byte.
    assert device.log[-1] == (device.at["I2C_COMMAND"], 0x1C00)


@cocotb.test()
async def system_page(dut):
    device = await begun(dut)
    for address, value in ((0xF000, 0), (0xF001, device.width), (0xF00A, 640), (0xF003, 0),
                           (0xF005, 0)):
        assert await device.ask(REQUEST.pack(READ, address, 5), 5) == REQUEST.pack(
            READ, address, value)
    # What cannot be written reads back as it was.
    assert await device.ask(REQUEST.pack(WRITE, 0xF001, 5), 5) == REQUEST.pack(
        WRITE, 0xF001, device.width)
    assert await device.ask(REQUEST.pack(WRITE, 0xF000, 1), 5) == REQUEST.pack(WRITE, 0xF000, 1)
    width, _ = settings()["corrected"]
    assert await device.ask(REQUEST.pack(READ, 0xF001, 0), 5) == REQUEST.pack(READ, 0xF001, width)
    assert await device.ask(REQUEST.pack(READ, 0xF003, 0), 5) == REQUEST.pack(READ, 0xF003, 0x11)


@cocotb.test()
async def pictures(dut):
    device = await begun(dut)
    width, height = device.width, device.height
    for _ in range(2):
        answer = await device.ask(bytes([MRAW]), HEADER_BYTES + width * height)
        header = MrawHeader.unpack(answer[:HEADER_BYTES])
        # An odd column begins the window: the colour filter's phase is the next one.
        assert (header.width, header.height, header.pixel_format.mraw) == (width, height, 1)
        assert header.time_us == TIME // 100 & 0xFFFFFFFF
        rows = [device.content[BASE + PITCH * y:][:width] for y in range(height)]
        assert answer[HEADER_BYTES:] == b"".join(rows)
        assert device.log[-1] == (device.at["READER1"], 4)
        assert await device.ask(REQUEST.pack(READ, 0xF013, 0), 5) == REQUEST.pack(
            READ, 0xF013, NUMBER)
    await device.ask(REQUEST.pack(WRITE, 0xF000, 1), 5)
    width, height = settings()["corrected"]
    answer = await device.ask(bytes([MRAW]), HEADER_BYTES + 4 * width * height)
    header = MrawHeader.unpack(answer[:HEADER_BYTES])
    assert (header.width, header.height, header.pixel_format.mraw) == (width, height, 0x11)
    assert answer[HEADER_BYTES:] == device.content[BASE:BASE + 4 * width * height]


@cocotb.test()
async def no_frame(dut):
    """A picture is waited for; whoever asks for something else gives it up."""
    device = await begun(dut)
    device.frame = False
    size = HEADER_BYTES + device.width * device.height
    assert await device.ask(bytes([MRAW]), 0, limit=0) == b""
    await clocks(dut, 3000)
    assert not device.got
    assert await device.ask(REQUEST.pack(READ, 0xF00A, 0), 5) == REQUEST.pack(READ, 0xF00A, 640)
    await device.send(bytes([MRAW]))
    await clocks(dut, 2000)
    device.frame = True
    before = device.last
    while device.last == before:
        await FallingEdge(dut.clk)
    assert len(device.got) == 5 + size


@cocotb.test()
async def requests_that_stop(dut):
    device = await begun(dut)
    assert await device.ask(b"\x11", 2) == bytes([UNKNOWN, 0x11])
    assert await device.ask(bytes([RESERVED]), 0) == b""
    for begun_request in (REQUEST.pack(WRITE, 0xF000, 1)[:3], write_request(0, 0)[:5]):
        await device.send(begun_request)
        await clocks(dut, settings()["gap"] + 50)
        assert await device.ask(REQUEST.pack(READ, 0xF00A, 0), 5) == REQUEST.pack(
            READ, 0xF00A, 640)
