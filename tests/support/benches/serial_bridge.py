"""Registers over a serial line: the line's other end is of cocotbext-uart."""

import random

import cocotb
from cocotb.triggers import ClockCycles, RisingEdge
from cocotbext.uart import UartSink, UartSource

from benches.common import PERIOD, settings, start
from ncdc_spec.protocols.serial_link import BAD, crc8, read_request, write_request

__all__ = ["noise_and_wrong_checks", "words_come_and_go"]


async def agent(dut, words, rng):
    """Answers accesses out of ``words``, after some clocks."""
    while True:
        await RisingEdge(dut.clk)
        dut.access__done.value = 0
        if dut.access__valid.value and not dut.access__done.value:
            await ClockCycles(dut.clk, rng.randrange(1, 20))
            address = int(dut.access__address.value)
            if dut.access__write.value:
                words[address] = int(dut.access__word.value)
            dut.access__answer.value = words.get(address, address * 0x10001 ^ 0xA5A5A5A5)
            dut.access__done.value = 1
            await RisingEdge(dut.clk)
            dut.access__done.value = 0
            await RisingEdge(dut.clk)


async def begin(dut):
    """Both ends of the line, and the registers at the bridge."""
    await start(dut)
    rate = round(1e9 / (PERIOD * settings()["divisor"]) * (1 + settings().get("off", 0)))
    source, sink = UartSource(dut.receive, baud=rate), UartSink(dut.send, baud=rate)
    words = {}
    cocotb.start_soon(agent(dut, words, random.Random(1)))
    return source, sink, words


async def ask(dut, source, sink, request, size):
    """Send bytes; so many bytes of an answer."""
    await source.write(request)
    byte = 10 * settings()["divisor"]       # clocks
    for _ in range(len(request) + size + 20):
        if sink.count() >= size:
            break
        await ClockCycles(dut.clk, byte)
    return bytes(sink.read_nowait(size))


@cocotb.test()
async def words_come_and_go(dut):
    source, sink, words = await begin(dut)
    rng, written = random.Random(2), {}
    for _ in range(12):
        address, word = rng.randrange(1 << 15), rng.randrange(1 << 32)
        written[address] = word
        answer = await ask(dut, source, sink, write_request(address, word), 2)
        assert answer == b"w" + bytes([crc8(b"w")])
        address = rng.choice(list(written))
        answer = await ask(dut, source, sink, read_request(address), 6)
        assert answer[:5] == b"r" + written[address].to_bytes(4, "big")
        assert answer[5] == crc8(answer[:5])
    assert words == written


@cocotb.test()
async def noise_and_wrong_checks(dut):
    source, sink, words = await begin(dut)
    request = bytearray(write_request(0x123, 0xDEADBEEF))
    for k in range(1, len(request)):
        wrong = bytearray(request)
        wrong[k] ^= 1 << k % 8
        answer = await ask(dut, source, sink, bytes(wrong), 2)
        assert answer == bytes([BAD, crc8(bytes([BAD]))])
    assert not words
    # Bytes that begin no request are dropped, and a request that stops is forgotten.
    await source.write(b"\0\xff?rw")
    await source.write(bytes(request[:4]))
    await ClockCycles(dut.clk, 110 * 10 * settings()["divisor"])
    assert await ask(dut, source, sink, bytes(request), 2) == b"w" + bytes([crc8(b"w")])
    assert words == {0x123: 0xDEADBEEF} and sink.empty()
