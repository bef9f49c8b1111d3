"""Registers over a serial line: the line's other end is of cocotbext-uart, the backend the users'."""

import importlib.util
import random
from importlib.resources import files

import cocotb
from cocotb.triggers import ClockCycles, RisingEdge
from cocotbext.uart import UartSink, UartSource

from ncdc_model.interface.serial_link import BAD, crc8, read_request, write_request
from ncdc_sim.benches.common import PERIOD, settings, start

__all__ = ["by_the_users_backend", "noise_and_wrong_checks", "words_come_and_go"]


async def agent(dut, words, chance):
    """Answers accesses out of ``words``, after some clocks."""
    while True:
        await RisingEdge(dut.clk)
        dut.access__done.value = 0
        if dut.access__valid.value and not dut.access__done.value:
            await ClockCycles(dut.clk, chance.randrange(1, 20))
            address = int(dut.access__address.value)
            if dut.access__write.value:
                words[address] = int(dut.access__word.value)
            dut.access__answer.value = words.get(address, address * 0x10001 ^ 0xA5A5A5A5)
            dut.access__done.value = 1
            await RisingEdge(dut.clk)
            dut.access__done.value = 0
            await RisingEdge(dut.clk)


async def begin(dut):
    """Both ends of the line, and the registers behind the bridge."""
    await start(dut)
    rate = round(1e9 / (PERIOD * settings()["divisor"]) * (1 + settings().get("off", 0)))
    source, sink = UartSource(dut.receive, baud=rate), UartSink(dut.send, baud=rate)
    words = {}
    cocotb.start_soon(agent(dut, words, random.Random(1)))
    return source, sink, words


async def ask(source, sink, request, size):
    """Send bytes; so many bytes of an answer."""
    await source.write(request)
    answer = b""
    while len(answer) < size:
        answer += bytes(await sink.read(1))
    return answer


@cocotb.test()
async def words_come_and_go(dut):
    source, sink, words = await begin(dut)
    chance, kept = random.Random(2), {}
    for _ in range(12):
        address, word = chance.randrange(1 << 15), chance.randrange(1 << 32)
        kept[address] = word
        answer = await ask(source, sink, write_request(address, word), 2)
        assert answer == b"w" + bytes([crc8(b"w")])
        address = chance.choice(list(kept))
        answer = await ask(source, sink, read_request(address), 6)
        assert answer[:5] == b"r" + kept[address].to_bytes(4, "big")
        assert answer[5] == crc8(answer[:5])
    assert words == kept


@cocotb.test()
async def noise_and_wrong_checks(dut):
    source, sink, words = await begin(dut)
    request = bytearray(write_request(0x123, 0xDEADBEEF))
    for k in range(1, len(request)):
        wrong = bytearray(request)
        wrong[k] ^= 1 << k % 8
        answer = await ask(source, sink, bytes(wrong), 2)
        assert answer == bytes([BAD, crc8(bytes([BAD]))])
    assert not words
    # Bytes that begin no request are dropped, and a request that stops is forgotten.
    await source.write(b"\0\xff?rw")
    await source.write(bytes(request[:4]))
    await ClockCycles(dut.clk, 110 * 10 * settings()["divisor"])
    assert await ask(source, sink, bytes(request), 2) == b"w" + bytes([crc8(b"w")])
    assert words == {0x123: 0xDEADBEEF} and sink.empty()


class Line:
    """What :class:`Serial` of ``ncdc_backends.py`` wants of a port, from a thread beside."""

    def __init__(self, dut, source, sink):
        self.dut, self.source, self.sink = dut, source, sink

    def write(self, data):
        cocotb.task.resume(self._write)(data)

    async def _write(self, data):
        await self.source.write(data)

    def read(self, size):
        return cocotb.task.resume(self._read)(size)

    async def _read(self, size):
        # As long as a port waits: 40 bytes' time without any.
        for _ in range(40 * 10):
            if self.sink.count() >= size:
                break
            await ClockCycles(self.dut.clk, settings()["divisor"])
        return bytes(self.sink.read_nowait(min(size, self.sink.count())))


@cocotb.test()
async def by_the_users_backend(dut):
    source, sink, words = await begin(dut)
    place = files("ncdc_hdl.export.registers") / "host" / "ncdc_backends.py"
    spec = importlib.util.spec_from_file_location("ncdc_backends", place)
    backends = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(backends)
    port = backends.Serial(Line(dut, source, sink), pause=0)

    def host():
        port.write(4 * 0x40, 0x01234567)
        port.write(4 * 0x7FFF, 0xFFFFFFFF)
        return port.read(4 * 0x40), port.read(4 * 0x7FFF), port.read(4 * 5)

    assert await cocotb.task.bridge(host)() == (
        0x01234567, 0xFFFFFFFF, 5 * 0x10001 ^ 0xA5A5A5A5)
    assert words == {0x40: 0x01234567, 0x7FFF: 0xFFFFFFFF}
