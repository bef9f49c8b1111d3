"""The packetiser: packets of frames in memory, packets sent again, rejected writes."""

import random
import struct
from dataclasses import replace

import cocotb
from cocotb.triggers import FallingEdge, ReadOnly

from benches.avalon import Host, read_memory
from benches.common import clocks, settings, start, unpack
from frame_packets import packet_of, packets_of, some_headers
from ncdc_hdl.link.layouts import BEAT
from ncdc_spec.pixel_formats import format_of_name
from ncdc_spec.protocols.link_headers import Endpoint, Headers, gvsp_headers, mraw_headers
from ncdc_spec.protocols.table_two import MrawHeader
from ncdc_spec.registers.link_map import (
    CONTROL_ABORT,
    CONTROL_SEND,
    LINK,
    PAYLOAD_BITS,
    RESEND_BEFORE,
    STATUS_BUSY,
    STATUS_DONE,
    STATUS_REFUSED,
    STATUS_RESENDING,
    STATUS_RESENT,
    TEMPLATE_WORDS,
    TEMPLATES,
)

__all__ = ["aborted", "again", "any_headers", "far", "gvsp", "mraw", "pauses", "rejected",
           "registers", "restarts"]

SOURCE = Endpoint(bytes.fromhex("02004e434443"), bytes([10, 77, 0, 11]), 49152)
TARGET = Endpoint(bytes.fromhex("02004e434401"), bytes([10, 77, 0, 1]), 50000)
WORDS = {register.name: register.address for register in LINK}


class Link:
    """The packetiser's host, memory and receiver."""

    def __init__(self, dut, seed):
        self.dut, self.host = dut, Host(dut, "csr")
        self.rng = random.Random(seed)
        self.content = self.rng.randbytes(settings()["bytes"])
        self.packets = []           # that have come, as bytes
        self.began, self.ended = [], []     # clocks of the first and of the last beat of each
        self.clock, self.taken = 0, 0       # now, and of the last beat
        self.ready = self.random_ready
        self.stall = settings()["stall"]

    def random_ready(self):
        """Whether a beat is taken in this clock."""
        return self.rng.random() >= self.stall

    def gigabit_ready(self):
        """A port of a byte per clock: a beat in four, and after a packet 24 bytes of check sum,
        gap and preamble."""
        wait = 4 + 24 * (self.ended[-1:] == [self.taken])
        return self.clock + 1 - self.taken >= wait

    async def receive(self):
        """Take beats, forever: none is missing within a packet, none changes while it waits."""
        dut, packet, held = self.dut, b"", None
        while True:
            ready = self.ready()
            dut.o__ready.value = int(ready)
            await ReadOnly()
            self.clock += 1
            valid = bool(dut.o__valid.value) and not bool(dut.rst.value)
            assert valid or not packet or bool(dut.rst.value), "a pause within a packet"
            beat = int(dut.o__payload.value) if valid else None
            assert held in (None, beat) or bool(dut.rst.value), "a beat changed while it waited"
            held = beat if not ready else None
            if bool(dut.rst.value):
                packet, held = b"", None
            elif valid and ready:
                self.taken = self.clock
                if not packet:
                    self.began.append(self.clock)
                beat = unpack(BEAT, beat)
                assert beat.last or not beat.empty
                packet += int(beat.data).to_bytes(4, "little")[:4 - beat.empty]
                if beat.last:
                    self.packets.append(packet)
                    self.ended.append(self.clock)
                    packet = b""
            await FallingEdge(dut.clk)

    async def put(self, **values):
        """Write registers, called without LINK_."""
        for name, value in values.items():
            await self.host.write(WORDS[f"LINK_{name}"], value)

    async def get(self, name):
        """Read one."""
        return await self.host.read(WORDS[f"LINK_{name}"])

    async def headers(self, headers):
        """Write the headers of the next frame."""
        for number, name in enumerate(("leader", "payload", "last", "trailer")):
            header = getattr(headers, name)
            at = TEMPLATES + TEMPLATE_WORDS * number
            await self.host.write(at, len(header))
            for word in range(-(-len(header) // 4)):
                # The bytes after the end are random.
                four = (header + self.rng.randbytes(4))[4 * word:4 * word + 4]
                await self.host.write(at + 1 + word, int.from_bytes(four, "little"))

    async def prepare(self, headers, base, delay=0):
        """Write all that a frame wants."""
        await self.headers(headers)
        await self.put(BASE=base, PAYLOAD=headers.payload_bytes, PACKETS=headers.packets,
                       LAST=headers.last_bytes, FIRST_NUMBER=headers.first,
                       NUMBER_FIELD=headers.field[0] | headers.field[1] << 8, DELAY=delay)

    async def settled(self, busy=STATUS_BUSY | STATUS_RESENDING):
        """Wait until nothing is sent; returns the status, and clears it."""
        for _ in range(5000):
            status = await self.get("STATUS")
            if not status & busy:
                await self.put(STATUS=status)
                return status
        raise AssertionError(f"still sending: {status:#x}")

    def packet(self, headers, base, position):
        """Packet number ``position`` of a frame, 0 for the leader; empty if there is none."""
        return packet_of(self.content, headers, base, position)

    def frame(self, headers, base):
        """All packets of a frame, in order."""
        return packets_of(self.content, headers, base)

    def take(self, expected):
        """These packets have come, and no others."""
        assert self.packets == expected, (len(self.packets), len(expected))
        self.packets, self.began, self.ended = [], [], []


async def begin(dut):
    """A link that receives."""
    s = settings()
    # A memory of the test before owes nothing.
    await start(dut, csr__read=0, csr__write=0, memory_rst=1, o__ready=0)
    dut.memory_rst.value = 0
    link = Link(dut, s["seed"])
    cocotb.start_soon(read_memory(dut, "bus", link.content, wait=s["wait"],
                                  latency=tuple(s["latency"])))
    cocotb.start_soon(link.receive())
    return link


@cocotb.test()
async def gvsp(dut):
    """Pictures over GVSP; the packets are printed, for others to judge."""
    link = await begin(dut)
    picture = (format_of_name("BayerGB8"), 40, 27)
    for block in (7, 8):
        headers = gvsp_headers(SOURCE, TARGET, picture, block, 123_456_789_012, 256)
        base = 128 * block
        await link.prepare(headers, base)
        await link.put(CONTROL=CONTROL_SEND)
        assert await link.settled() == STATUS_DONE
        for packet in link.packets:
            print("PACKET", packet.hex())
        assert await link.get("SENT") == (block - 6) * (headers.packets + 2)
        link.take(link.frame(headers, base))
    assert await link.get("RESENT") == 0


@cocotb.test()
async def mraw(dut):
    """A Table II package over UDP: no trailer, numbers of four bytes."""
    link = await begin(dut)
    package = MrawHeader(33, 21, format_of_name("BGR8"), "10.77.0.11", 4000, 99)
    headers = mraw_headers(SOURCE, TARGET, package, 512)
    await link.prepare(headers, 512)
    await link.put(CONTROL=CONTROL_SEND)
    assert await link.settled() == STATUS_DONE
    expected = link.frame(headers, 512)
    assert len(expected) == headers.packets + 1
    numbers = [struct.unpack(">I", packet[42:46])[0] for packet in link.packets]
    assert numbers == list(range(headers.packets + 1))
    image = b"".join(packet[46:] for packet in link.packets[1:])
    assert image == link.content[512:512 + package.size]
    link.take(expected)


@cocotb.test()
async def any_headers(dut):
    """Headers and payloads of any length, numbers anywhere, one frame right after the other."""
    link = await begin(dut)
    expected = []
    for _ in range(settings()["frames"]):
        headers = some_headers(link.rng, settings()["payload"])
        base = 16 * link.rng.randrange(0, 64)
        await link.prepare(headers, base)
        await link.put(CONTROL=CONTROL_SEND)
        expected += link.frame(headers, base)
        assert await link.settled() == STATUS_DONE
    link.take(expected)


@cocotb.test()
async def again(dut):
    """Ranges of a frame and of the one before, while packets are sent and after them."""
    link = await begin(dut)
    rng, before, resent = link.rng, None, 0
    for number in range(settings()["frames"]):
        headers = some_headers(rng, settings()["payload"])
        headers = replace(headers, leader=rng.randbytes(9), trailer=rng.randbytes(6),
                          payload_bytes=32, packets=4, last_bytes=17, first=1, field=(2, 3))
        base = 16 * rng.randrange(0, 64)
        await link.prepare(headers, base)
        await link.put(CONTROL=CONTROL_SEND)
        expected = link.frame(headers, base)
        for _ in range(3):
            first, last = rng.randrange(0, 9), rng.randrange(0, 9)
            of = rng.choice([(headers, base, 0)] + [before] * (before is not None))
            await link.put(RESEND_FIRST=first, RESEND_LAST=last | of[2])
            positions = range(first, min(last, 5) + 1)
            expected += [link.packet(of[0], of[1], position) for position in positions]
            resent += len(positions)
            status = await link.settled(STATUS_RESENDING)
            assert status & (STATUS_RESENT | STATUS_REFUSED) == STATUS_RESENT
        await link.settled()
        assert await link.get("RESENT") == resent
        # They come somewhere between the others.
        link.packets.sort()
        link.take(sorted(expected))
        before = (headers, base, RESEND_BEFORE)


@cocotb.test()
async def far(dut):
    """Ranges far from the beginning of a frame, of which nothing else is sent."""
    link = await begin(dut)
    for payload, packets in ((16, 500), (48, 160)):
        headers = Headers(b"", link.rng.randbytes(7), b"last", b"", (1, 3), 9, payload, packets,
                          payload - 3)
        base = 16 * link.rng.randrange(0, 20)
        await link.prepare(headers, base)
        await link.put(CONTROL=CONTROL_SEND)
        await link.put(CONTROL=CONTROL_ABORT)
        await link.settled()
        link.packets = []
        for first in (1, packets, *(link.rng.randrange(1, packets) for _ in range(6))):
            await link.put(RESEND_FIRST=first + 8, RESEND_LAST=first + 9)
            await link.settled()
            link.take([packet for position in (first, first + 1)
                       if (packet := link.packet(headers, base, position))])


@cocotb.test()
async def registers(dut):
    """Each register has its bits, and those only; what is no register reads as zero."""
    link = await begin(dut)
    for register in LINK:
        value = await link.host.read(register.address)
        assert value == (1456 if register.name == "LINK_PAYLOAD" else 0), register.name
    for register in LINK:
        if register.access != "action":
            await link.host.write(register.address, 0xFFFFFFFF)
    for register in LINK:
        expected = (1 << register.shape.width) - 1 if register.access == "rw" else 0
        if register.name == "LINK_BASE":
            expected &= -(len(dut.bus__readdata) // 8)
        assert await link.host.read(register.address) == expected, register.name
    for address in (15, 16, 24, 25, 64 + WORDS["LINK_PAYLOAD"], TEMPLATES + 4):
        assert await link.host.read(address) == 0, address


@cocotb.test()
async def pauses(dut):
    """`LINK_DELAY` clocks between two packets, and no fewer."""
    link = await begin(dut)
    headers = gvsp_headers(SOURCE, TARGET, (format_of_name("Mono8"), 32, 10), 1, 0, 64)
    await link.prepare(headers, 0, delay=77)
    await link.put(CONTROL=CONTROL_SEND)
    await link.settled()
    gaps = [begin - end - 1 for begin, end in zip(link.began[1:], link.ended)]
    assert len(gaps) == headers.packets + 1 and min(gaps) >= 77, gaps
    assert settings()["stall"] or max(gaps) <= 77 + settings()["latency"][1] + 40, gaps
    link.take(link.frame(headers, 0))


# Without rates there is nothing to measure: most runs have pauses, which this test must not.
@cocotb.test(skip=not settings()["rate"])
async def rate(dut):
    """A gigabit port with the clock of the core never has to wait."""
    link = await begin(dut)
    link.ready = link.gigabit_ready
    for payload in settings()["rate"]:
        packets = settings()["packets"]
        headers = gvsp_headers(SOURCE, TARGET, (format_of_name("Mono8"), payload, packets), 1, 0,
                               payload)
        await link.prepare(headers, 0)
        await link.put(CONTROL=CONTROL_SEND)
        while not int(dut.irq.value):
            await clocks(dut, 50)
        await link.settled()
        # From the first payload packet's end to the last one's.
        clocks_taken = link.ended[packets] - link.ended[1]
        share = (packets - 1) * payload / clocks_taken
        print(f"RATE {payload} {share:.5f} {await link.get('STALLS')}")
        assert share > 0.998 * payload / (payload + 36 + 38)
        link.take(link.frame(headers, 0))


@cocotb.test()
async def rejected(dut):
    """Writes that would corrupt packets are rejected and reported."""
    link = await begin(dut)
    headers = gvsp_headers(SOURCE, TARGET, (format_of_name("Mono8"), 64, 16), 1, 0, 128)
    await link.put(RESEND_FIRST=0, RESEND_LAST=1)
    assert await link.settled() == STATUS_REFUSED, "no frame was sent"
    await link.prepare(headers, 64, delay=50)
    large = settings()["capacity"] + 16
    for wrong in ({"PAYLOAD": 24}, {"PAYLOAD": 0}, {"PACKETS": 0}, {"LAST": 0}, {"LAST": 129},
                  *[{"PAYLOAD": large}] * (large < 1 << PAYLOAD_BITS)):
        await link.prepare(headers, 64, delay=50)
        await link.put(**wrong, CONTROL=CONTROL_SEND)
        assert await link.settled() == STATUS_REFUSED, wrong
    await link.prepare(headers, 64, delay=50)
    await link.put(CONTROL=CONTROL_SEND)
    await link.put(RESEND_LAST=1 | RESEND_BEFORE)
    await link.put(CONTROL=CONTROL_SEND)
    for name in ("PAYLOAD", "PACKETS", "LAST", "FIRST_NUMBER", "NUMBER_FIELD"):
        await link.put(STATUS=STATUS_REFUSED)
        await link.put(**{name: 3})
        assert await link.get("STATUS") == STATUS_BUSY | STATUS_REFUSED, name
    assert await link.settled() == STATUS_DONE | STATUS_REFUSED
    link.take(link.frame(headers, 64))
    # A header of the frame before, while that is sent again.
    await link.prepare(headers, 96, delay=50)
    await link.put(CONTROL=CONTROL_SEND)
    await link.settled()
    await link.put(RESEND_FIRST=0, RESEND_LAST=9 | RESEND_BEFORE)
    await link.host.write(TEMPLATES + 1, 0)
    await link.put(RESEND_LAST=9)
    assert await link.settled() == STATUS_RESENT | STATUS_REFUSED
    link.take([*link.frame(headers, 96), *link.frame(headers, 64)])


@cocotb.test()
async def aborted(dut):
    """No packet after those on their way; the next frame is right."""
    link = await begin(dut)
    headers = gvsp_headers(SOURCE, TARGET, (format_of_name("Mono8"), 64, 40), 1, 0, 64)
    await link.prepare(headers, 0)
    await link.put(CONTROL=CONTROL_SEND)
    await clocks(dut, 60)
    await link.put(CONTROL=CONTROL_ABORT)
    assert await link.settled() == STATUS_DONE
    whole = link.frame(headers, 0)
    assert 0 < len(link.packets) < len(whole)
    link.take(whole[:len(link.packets)])
    await link.put(CONTROL=CONTROL_SEND)
    await link.settled()
    # The other set of headers, which was not written.
    link.packets = []
    await link.prepare(headers, 48)
    await link.put(CONTROL=CONTROL_SEND)
    await link.settled()
    link.take(link.frame(headers, 48))


@cocotb.test()
async def restarts(dut):
    """A reset at any time: after it, packets are whole and right."""
    link = await begin(dut)
    headers = gvsp_headers(SOURCE, TARGET, (format_of_name("Mono8"), 64, 20), 1, 0, 64)
    for _ in range(settings()["frames"]):
        await link.prepare(headers, 16)
        await link.put(CONTROL=CONTROL_SEND)
        await clocks(dut, link.rng.randrange(1, 300))
        dut.rst.value = 1
        await clocks(dut, link.rng.randrange(1, 4))
        dut.rst.value = 0
        assert all(packet in link.frame(headers, 16) for packet in link.packets)
        link.packets = []
    await link.prepare(headers, 16)
    await link.put(CONTROL=CONTROL_SEND)
    assert await link.settled() == STATUS_DONE
    link.take(link.frame(headers, 16))
