"""The packetiser of 64-bit memory words, between a memory, a host and a line."""

import random
from dataclasses import replace
from functools import cache

from frame_packets import packet_of, packets_of, some_headers
from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.link.packetiser import Packetiser
from ncdc_spec.protocols.link_headers import Headers
from ncdc_spec.registers.link_map import (
    CONTROL_ABORT,
    CONTROL_SEND,
    HEADER_BYTES,
    LINK,
    LINK_SETTINGS,
    RESEND_BEFORE,
    STATUS_BUSY,
    STATUS_DONE,
    STATUS_REFUSED,
    STATUS_RESENDING,
    STATUS_RESENT,
    TEMPLATES,
)
from simulations.packets import PACKETISER, Script, simulate_packets

__all__ = ["DESIGN"]

_WIDTH, _CAPACITY = 64, 512
_DECODED = 16       # bits of an address that the memory decodes
_CONTENT = random.Random(1).randbytes(1 << _DECODED)
_BUSY = STATUS_BUSY | STATUS_RESENDING
_BUILT = 100        # clocks in which a short packet is built
_MEMORY = {"latency_min": 1, "latency_max": 40, "wait_probability": 80, "max_pending": 4,
           "clock_limit": 120_000}
# A memory that waits for long, and gives a word in some three clocks.
_SLOW = {"latency_max": 400, "wait_probability": 240, "rate": 90, "clock_limit": 300_000}


def make():
    """The packetiser, anew."""
    return Packetiser(_WIDTH, capacity=_CAPACITY)


def outcome(verilog, transcripts, script, **settings):
    """The results of a script."""
    return simulate_packets(verilog, _WIDTH, _CONTENT, script, transcripts=transcripts,
                            **_MEMORY | settings)


def anywhere(rng):
    """Base of a frame, any multiple of a word in the lower half of what the memory decodes."""
    return rng.getrandbits(32) & -_WIDTH // 8 & ~(1 << _DECODED - 1)


def near(base):
    """A base as the memory sees it."""
    return base % (1 << _DECODED)


def plain(payload, packets, **changed):
    """Headers without anything special, of a frame of so many packets."""
    rng = random.Random(payload)
    return replace(Headers(rng.randbytes(9), rng.randbytes(46), rng.randbytes(46), rng.randbytes(6),
                           (2, 3), 1, payload, packets, payload - 15), **changed)


@cache
def any_frames():
    """A script of frames of any headers, and the packets that must come."""
    rng, script, expected = random.Random(2), Script(), []
    for _ in range(14):
        headers = some_headers(rng, _CAPACITY, HEADER_BYTES + 1)
        base = anywhere(rng)
        script.prepare(rng, headers, base)
        script.put(CONTROL=CONTROL_SEND)
        script.interrupt()
        script.settled(_BUSY)
        expected += packets_of(_CONTENT, headers, near(base))
    script.get("SENT")
    script.get("RESENT")
    return script, expected


def frames(verilog, transcripts):
    """Headers and payloads of any length, numbers anywhere; a line that stalls, and one that
    does not."""
    script, expected = any_frames()
    for stall in (0, 150):
        result = outcome(verilog, transcripts, script, stall=stall)
        assert result.packets == expected
        assert result.reads == [*[STATUS_DONE] * 14, len(expected), 0]
        assert result.results["irq"] == 0


@cache
def some_ranges():
    """A script of ranges that are sent again; packets, and what is read."""
    rng, script, expected, reads, before = random.Random(3), Script(), [], [], None
    for _ in range(8):
        headers = replace(plain(32, 4), leader=rng.randbytes(9), trailer=rng.randbytes(6),
                          last_bytes=17)
        base = anywhere(rng)
        script.prepare(rng, headers, base)
        script.put(CONTROL=CONTROL_SEND)
        expected += packets_of(_CONTENT, headers, near(base))
        for _ in range(3):
            first, last = rng.randrange(0, 9), rng.randrange(0, 9)
            of = rng.choice([(headers, base, 0)] + [before] * (before is not None))
            script.put(RESEND_FIRST=first, RESEND_LAST=last | of[2])
            expected += [packet_of(_CONTENT, of[0], near(of[1]), position)
                         for position in range(first, min(last, 5) + 1)]
            script.settled(STATUS_RESENDING)
        script.settled(_BUSY)
        before = headers, base, RESEND_BEFORE
    script.get("SENT")
    script.get("RESENT")
    reads = [8 * 6, len(expected) - 8 * 6]
    return script, expected, reads


def again(verilog, transcripts):
    """Ranges of a frame and of the one before, while packets are sent and after them."""
    script, expected, reads = some_ranges()
    result = outcome(verilog, transcripts, script, stall=60, rate=110)
    # They come somewhere between the others.
    assert sorted(result.packets) == sorted(expected)
    assert result.reads[-2:] == reads
    for k in range(8):
        statuses = result.reads[4 * k:4 * k + 3]
        assert all(one & (STATUS_RESENT | STATUS_REFUSED) == STATUS_RESENT for one in statuses)


def far(verilog, transcripts):
    """Ranges far from the beginning of a frame that is aborted at once."""
    rng, script, expected = random.Random(4), Script(), []
    for payload, packets in ((16, 300), (48, 120)):
        headers = plain(payload, packets, leader=b"", trailer=b"", first=9, last_bytes=3)
        base = anywhere(rng)
        script.prepare(rng, headers, base)
        script.put(CONTROL=CONTROL_SEND)
        script.put(CONTROL=CONTROL_ABORT)
        script.settled(_BUSY)
        for first in (1, packets - 1, *(rng.randrange(1, packets) for _ in range(4))):
            script.put(RESEND_FIRST=first + 8, RESEND_LAST=first + 9)
            script.settled(_BUSY)
            expected += [packet_of(_CONTENT, headers, near(base), position)
                         for position in (first, first + 1)]
        script.get("SENT")
    result = outcome(verilog, transcripts, script)
    sent = result.reads[-1]
    assert len(result.packets) == sent + len(expected)
    assert [one for one in result.packets if one in expected] == expected or sent > 0
    assert result.packets[-12:] == expected[-12:]


@cache
def some_fuzz():
    """A script of random accesses with a frame after some of them; the packets of each frame."""
    rng, script, frames = random.Random(8), Script(), []
    for k in range(12):
        for _ in range(40):
            disturb(rng, script)
        if k % 3 == 2:
            script.reset(rng.randrange(1, 4), memory=k % 2 == 0)
        script.put(DELAY=0, CONTROL=CONTROL_ABORT)
        script.settled(_BUSY)
        headers, base = some_headers(rng, _CAPACITY, HEADER_BYTES + 1), anywhere(rng)
        script.prepare(rng, headers, base)
        script.put(CONTROL=CONTROL_SEND)
        script.interrupt()
        script.settled(_BUSY)
        for register in LINK:
            script.read(register.address)
        frames.append(packets_of(_CONTENT, headers, near(base)))
    return script, frames


def disturb(rng, script):
    """An access of any kind, or a pause."""
    kind = rng.randrange(9)
    if kind < 2:
        name, most = rng.choice((("PAYLOAD", 600), ("PACKETS", 8),
                                 ("LAST", 600), ("FIRST_NUMBER", 1 << 24), ("FIRST_NUMBER", 4),
                                 ("NUMBER_FIELD", 1 << 11), ("DELAY", 400), ("DELAY", 2)))
        script.put(**{name: rng.randrange(most)})
    elif kind == 2:
        script.put(PAYLOAD=16 * rng.randrange(1, 9), PACKETS=rng.randrange(1, 6),
                   LAST=rng.randrange(1, 17), BASE=anywhere(rng))
    elif kind == 3:
        script.put(CONTROL=rng.choice((CONTROL_SEND, CONTROL_SEND, CONTROL_ABORT,
                                       CONTROL_SEND | CONTROL_ABORT)))
    elif kind == 4:
        script.put(RESEND_FIRST=rng.randrange(8))
        script.put(RESEND_LAST=rng.randrange(8) | rng.choice((0, RESEND_BEFORE)))
    elif kind == 5:
        template = TEMPLATES + 64 * rng.randrange(4)
        script.write(template, rng.randrange(HEADER_BYTES))
        script.write(template + rng.randrange(1, 64), rng.getrandbits(32))
    elif kind == 6:
        script.put(STATUS=rng.getrandbits(5))
    elif kind == 7:
        script.read(rng.choice((rng.randrange(32), rng.randrange(1 << 10))))
    else:
        script.wait(rng.randrange(1, 400))


def fuzzed(verilog, transcripts):
    """Any accesses at any time; a frame after them is right."""
    script, frames = some_fuzz()
    for settings in ({"stall": 40}, _SLOW):
        packets = outcome(verilog, transcripts, script, **settings).packets
        for one in frames:
            if one:
                begins = [k for k in range(len(packets)) if packets[k:k + len(one)] == one]
                assert begins, "a frame is missing"
                packets = packets[begins[0] + len(one):]


def registers(verilog, transcripts):
    """Each register has its bits, and those only; what is no register reads as zero."""
    script, expected = Script(), []
    for register in LINK:
        script.read(register.address)
        expected.append(1456 if register.name == "LINK_PAYLOAD" else 0)
    for word in (0xFFFFFFFF, 0x5A5AA5A5, 0x00FF55AA):
        for register in LINK:
            if register.access == "rw":
                script.write(register.address, word)
        for register in LINK:
            script.read(register.address)
            value = word & (1 << register.shape.width) - 1 if register.access == "rw" else 0
            expected.append(value & -(_WIDTH // 8) if register.name == "LINK_BASE" else value)
    for address in (15, 16, 24, 25, TEMPLATES + 4, *(3 + (1 << k) for k in range(4, 10))):
        script.read(address)
        expected.append(0)
    assert outcome(verilog, transcripts, script).reads == expected


def rejected(verilog, transcripts):
    """Writes that would corrupt packets are rejected and reported."""
    rng, script, headers, statuses = random.Random(5), Script(), plain(128, 8), []
    expected = []

    def settled(status):
        script.settled(_BUSY)
        statuses.append(status)

    script.put(RESEND_FIRST=0, RESEND_LAST=1)
    settled(STATUS_REFUSED)
    for wrong in ({"PAYLOAD": 24}, {"PAYLOAD": 0}, {"PACKETS": 0}, {"LAST": 0}, {"LAST": 129},
                  {"PAYLOAD": _CAPACITY + 16}, *({"PAYLOAD": 1 << k} for k in range(10, 14)),
                  *({"LAST": 1 << k} for k in range(8, 14))):
        script.prepare(rng, headers, 64, delay=50)
        script.put(**wrong, CONTROL=CONTROL_SEND)
        settled(STATUS_REFUSED)
    for name in LINK_SETTINGS:
        script.prepare(rng, headers, 64, delay=50)
        script.put(CONTROL=CONTROL_SEND)
        script.put(**{name.removeprefix("LINK_"): 3})
        settled(STATUS_DONE | STATUS_REFUSED)
        expected += packets_of(_CONTENT, headers, 64)
    # A frame while one is sent, and a range while one is sent again.
    script.prepare(rng, headers, 64, delay=200)
    script.put(CONTROL=CONTROL_SEND)
    script.put(CONTROL=CONTROL_SEND)
    settled(STATUS_DONE | STATUS_REFUSED)
    script.put(RESEND_FIRST=0, RESEND_LAST=3)
    script.put(RESEND_LAST=4)
    settled(STATUS_RESENT | STATUS_REFUSED)
    whole = packets_of(_CONTENT, headers, 64)
    expected += [*whole, *whole[:4]]
    # A header of the frame before, while that is sent again.
    script.put(RESEND_FIRST=0, RESEND_LAST=9 | RESEND_BEFORE)
    script.write(TEMPLATES + 1, 0)
    script.put(RESEND_LAST=9)
    settled(STATUS_RESENT | STATUS_REFUSED)
    expected += packets_of(_CONTENT, headers, 64)
    result = outcome(verilog, transcripts, script)
    assert result.reads == statuses
    assert result.packets == expected


def pauses(verilog, transcripts):
    """`LINK_DELAY` clocks between two packets, and no fewer; not many more."""
    headers = plain(64, 5)
    for delay in (177, 600):
        script = Script()
        script.prepare(random.Random(6), headers, 0, delay=delay)
        script.put(CONTROL=CONTROL_SEND)
        script.settled(_BUSY)
        script.get("CLOCKS")
        script.get("STALLS")
        result = outcome(verilog, transcripts, script, wait_probability=0, latency_max=1)
        gaps = [begin - end - 1 for (begin, _), (_, end) in zip(result.times[1:], result.times)]
        assert len(gaps) == 6 and min(gaps) >= delay and max(gaps) <= delay + _BUILT, gaps
        assert result.packets == packets_of(_CONTENT, headers, 0)
        clocks, stalls = result.reads[-2:]
        whole = result.times[-1][1] - result.times[0][0]
        assert whole < clocks < whole + 400 and stalls < clocks


def aborted(verilog, transcripts):
    """No packet after those on their way; the next frame is right. Then resets at any time."""
    rng, script, headers = random.Random(7), Script(), plain(64, 20)
    script.prepare(rng, headers, 0)
    script.put(CONTROL=CONTROL_SEND)
    script.wait(60)
    script.put(CONTROL=CONTROL_ABORT)
    script.settled(_BUSY)
    script.get("SENT")
    script.prepare(rng, headers, 16)
    script.put(CONTROL=CONTROL_SEND)
    script.settled(_BUSY)
    result = outcome(verilog, transcripts, script)
    sent, whole = result.reads[1], packets_of(_CONTENT, headers, 0)
    assert result.reads[0] == STATUS_DONE and 0 < sent < len(whole)
    assert result.packets == [*whole[:sent], *packets_of(_CONTENT, headers, 16)]

    reset_often(verilog, transcripts, headers, 700, latency_max=300)
    # Two whole bursts are due at most resets, and long after them.
    reset_often(verilog, transcripts, plain(256, 8), 400, latency_min=600, latency_max=900,
                clock_limit=300_000)


def reset_often(verilog, transcripts, headers, longest, **settings):
    """Resets of the packetiser, or of all, in the midst of frames; the last frame is right."""
    rng, script, whole = random.Random(9), Script(), packets_of(_CONTENT, headers, 16)
    script.prepare(rng, headers, 16)
    for k in range(40):
        # After a reset the next read comes as soon as it can, while words of the last one are due.
        script.put(PAYLOAD=headers.payload_bytes, PACKETS=headers.packets, LAST=headers.last_bytes,
                   BASE=16)
        script.put(CONTROL=CONTROL_SEND)
        script.wait(rng.randrange(40, longest))
        script.reset(rng.randrange(1, 4), memory=k % 4 == 3)
    script.settled(_BUSY)
    script.prepare(rng, headers, 16)
    script.put(CONTROL=CONTROL_SEND)
    script.settled(_BUSY)
    result = outcome(verilog, transcripts, script, stall=60, **settings)
    assert result.reads == [0, STATUS_DONE] and result.packets[-len(whole):] == whole


_RUNS = {"frames": frames, "registers": registers, "packets again": again, "far packets": far,
         "rejected writes": rejected, "pauses": pauses, "aborts and resets": aborted,
         "register fuzz": fuzzed}

DESIGN = Design("packetiser", PACKETISER, make, tuple(PlayedBench(*item) for item in _RUNS.items()))
