"""Frames at the lanes of a CSI-2 receiver: whole ones, each fault planted, corrupted packets."""

from itertools import combinations, product

import numpy as np

from ncdc_hdl.camera.csi2.receiver import Receiver
from ncdc_sim.csi2.lanes import MIN_GAP, Lanes
from ncdc_sim.csi2.packets import frame_packets, long_packet, short_packet
from ncdc_sim.csi2.run import receive
from ncdc_spec.sensors.csi2 import MAX_SKEW, SAMPLE_BITS_OF, DataType

__all__ = ["FAULTS", "check_corrupted", "check_faulty", "check_reset", "check_statuses",
           "check_whole", "corrupted_frames", "faulty_frames", "header_frames", "long_frames",
           "odd_frames", "received", "reset_frames", "residue_frames", "whole_frames"]

CHANNEL = 2
GROUPS = {DataType.RAW8: 1, DataType.RAW10: 4, DataType.RAW12: 2}      # samples of a group
GROUP_BYTES = {DataType.RAW8: 1, DataType.RAW10: 5, DataType.RAW12: 3}
SKEW = 8 * MAX_SKEW         # bits by which lanes may differ
_HEIGHT = 5                 # rows of the frames that are corrupted


def resting(lanes, rng):
    """Lanes that rest at first: a burst under way at the start is ignored."""
    wire = Lanes(lanes, rng)
    wire.rest(3)
    return wire


def received(wire, kind, **options):
    """What a receiver of the own channel makes of the lanes."""
    return receive(wire.lanes, *wire.clocks, channel=CHANNEL, kind=kind, **options)


def random_frame(rng, kind, groups, height):
    """Random samples, in rows of so many groups."""
    return rng.integers(0, 1 << SAMPLE_BITS_OF[kind], (height, groups * GROUPS[kind]))


def same(frame, sent, kind):
    """Whether a received frame has the rows that were sent, its samples in the upper bits."""
    shift = 12 - SAMPLE_BITS_OF[kind]
    return (len(frame.rows) == len(sent)
            and all(np.array_equal(got, row << shift) for got, row in zip(frame.rows, sent)))


def flip(packet, *bits):
    """A packet with some bits inverted, the lowest bit of its first byte being 0."""
    value = int.from_bytes(packet, "little")
    for bit in bits:
        value ^= 1 << bit
    return value.to_bytes(len(packet), "little")


def row(packets, other, **how):
    """The third of the packets of a frame, which is its second row, sent otherwise."""
    return [*packets[:2], (other(packets[2]), how), *packets[3:]]


def no_sync(lane, bits):
    """Bits of a burst of which lane 0 has no sync byte."""
    return bits * (lane != 0)


def no_lane_has_sync(lane, bits):
    return bits * 0


def as_it_is(packet):
    return packet


def payload_of(packet):
    return packet[4:-2]


def long_row(packet):
    return long_packet(CHANNEL, DataType.RAW10, payload_of(packet) + b"\x5A")


def empty_row(packet):
    return long_packet(CHANNEL, DataType.RAW10, b"")


# What happens to the packets of a frame of three rows: how they are sent, the faults, and what
# becomes of the frame (None: it has no end).
GOOD, BAD = False, True
FAULTS = {
    "one bit of a header": (lambda p: row(p, lambda one: flip(one, 9)), {"corrected": 1}, GOOD),
    "one bit of a code": (lambda p: [flip(p[0], 29), *p[1:]], {"corrected": 1}, GOOD),
    "two bits of a header": (lambda p: row(p, lambda one: flip(one, 9, 27)), {"header": 1}, BAD),
    "two bits of an end": (lambda p: [*p[:-1], flip(p[-1], 0, 1)], {"header": 1, "order": 1}, BAD),
    "one bit of a row": (lambda p: row(p, lambda one: flip(one, 40)), {"checksum": 1}, BAD),
    "one bit of a checksum": (lambda p: row(p, lambda one: flip(one, 8 * len(one) - 1)),
                              {"checksum": 1}, BAD),
    "a row is cut": (lambda p: row(p, lambda one: one[:-12], cut=True), {"cut": 1}, BAD),
    "a checksum is cut": (lambda p: row(p, lambda one: one[:-2], cut=True), {"cut": 1}, BAD),
    "a header is cut": (lambda p: row(p, lambda one: one[:2], cut=True, skew=(0,) * 4),
                        {"cut": 1}, BAD),
    "no sync byte on a lane": (lambda p: row(p, as_it_is, change=no_sync), {"unaligned": 1}, BAD),
    "no sync byte at all": (lambda p: row(p, as_it_is, change=no_lane_has_sync),
                            {"unaligned": 1}, BAD),
    "too much skew": (lambda p: row(p, as_it_is, skew=(0, SKEW + 8, 0, 0)), {"unaligned": 1}, BAD),
    "a byte too many": (lambda p: row(p, long_row), {"length": 1}, BAD),
    "an empty row": (lambda p: row(p, empty_row), {"length": 1}, BAD),
    "a frame without an end": (lambda p: p[:-1], {"order": 1}, BAD),
    "a frame without a start": (lambda p: p[1:], {"order": 4}, None),
    "an end without a start": (lambda p: [*p, p[-1]], {"order": 1}, GOOD),
    "a frame without rows": (lambda p: [p[0], p[-1]], {"order": 1}, None),
    "bytes after a packet": (lambda p: row(p, lambda one: one + bytes(one)), {}, GOOD),
}


def send(wire, lanes, packets):
    for packet in packets:
        packet, how = packet if isinstance(packet, tuple) else (packet, {})
        wire.burst(packet, **{name: value[:lanes] if name == "skew" else value
                              for name, value in how.items()})


def flips(rng, packet):
    """Up to four bits of one lane, sync byte included."""
    def change(lane, bits):
        if lane == 0:
            bits[rng.integers(0, len(bits), rng.integers(1, 5))] ^= 1
        return bits
    return packet, {"change": change}


def error_burst(rng, packet):
    """Up to 16 bits in a row."""
    begin = int(rng.integers(0, 8 * len(packet) - 15))
    return flip(packet, *(begin + k for k in range(16) if rng.integers(2))), {}


def cut(rng, packet):
    """Lanes that stop too early, with a trail or not."""
    return packet[:rng.integers(1, len(packet))], {"cut": bool(rng.integers(2))}


def garbage(rng, packet):
    """Random bytes after the sync byte."""
    return rng.bytes(int(rng.integers(1, 2 * len(packet)))), {}


def other_count(rng, packet):
    """A right header of a wrong length."""
    return long_packet(CHANNEL, DataType.RAW10, bytes(rng.integers(0, 40)))[:4] + packet[4:], {}


def apart(rng, packet):
    """Lanes with too much skew, or without a sync byte."""
    if rng.integers(2):
        return packet, {"change": no_lane_has_sync}
    return packet, {"skew": (0, *(SKEW + 8 + int(rng.integers(0, 30)) for _ in range(3)))}


def stray(rng, packet):
    """A right packet of any kind."""
    return short_packet(CHANNEL, int(rng.integers(0, 16)), int(rng.integers(0, 1 << 16))), {}


CORRUPTIONS = [flips, flips, flips, error_burst, cut, garbage, other_count, apart, stray]


def corrupted_run(rng, lanes, count, frame_of):
    """Frames, about half of them with corrupted packets, until there are ``count`` of these.

    Returns (lanes, frames, whether each frame is untouched).
    """
    wire, frames, untouched, corrupted = resting(lanes, rng), [], [], 0
    while corrupted < count or not untouched[-1]:
        frames.append(frame_of(rng))
        rate = 0.3 * rng.integers(2)
        packets, before = frame_packets(frames[-1], DataType.RAW10, CHANNEL), corrupted
        for packet in packets:
            if rng.random() < rate:
                change = CORRUPTIONS[rng.integers(len(CORRUPTIONS))]
                packet = change(rng, packet)
                corrupted += 1
            send(wire, lanes, [packet])
        untouched.append(corrupted == before)
    return wire, frames, untouched


def whole_frames(lanes, kind, count):
    """A wire with ``count`` frames, rows of every length modulo the lanes; the frames.

    Clocks stop between packets, or do not.
    """
    rng = np.random.default_rng([lanes, kind])
    wire, frames = resting(lanes, rng), []
    for number in range(count):
        frames.append(random_frame(rng, kind, 1 + number % 17, 4 + number % 3))
        packets = frame_packets(frames[-1], kind, CHANNEL, number, embedded=number % 3,
                                line_packets=number % 2)
        for packet in packets:
            wire.burst(packet, gap=MIN_GAP if number % 4 < 2 else int(rng.integers(8, 60)),
                       skew=rng.integers(0, SKEW + 1, lanes) if number % 3 else None,
                       zeros=int(rng.integers(0, 40)))
            other = long_packet((CHANNEL + 1) % 4, kind, bytes(5))
            wire.burst(other if rng.integers(2) else short_packet(0, DataType.FRAME_END))
    return wire, frames


def check_whole(result, frames, kind):
    """All frames came, without a fault."""
    assert not any(result.faults.values()), result.faults
    assert [frame.bad for frame in result.frames] == [False] * len(frames)
    assert all(same(*pair, kind) for pair in zip(result.frames, frames))


def faulty_frames(lanes, fault):
    """A wire with three frames, the second with one of :data:`FAULTS`; the frames."""
    rng = np.random.default_rng(lanes)
    wire, kind = resting(lanes, rng), DataType.RAW10
    frames = [random_frame(rng, kind, 8, 3) for _ in range(3)]
    for number, frame in enumerate(frames):
        packets = frame_packets(frame, kind, CHANNEL, number)
        send(wire, lanes, FAULTS[fault][0](packets) if number == 1 else packets)
    return wire, frames


def check_faulty(result, fault, frames):
    """The fault is counted, and nothing else; the next frame is right."""
    _, faults, bad = FAULTS[fault]
    assert {name: count for name, count in result.faults.items() if count} == faults
    sent = frames if bad is not None else [frames[0], frames[2]]
    statuses = [GOOD, GOOD] if bad is None else [GOOD, bad, GOOD]
    assert [frame.bad for frame in result.frames] == statuses
    assert all(same(got, one, DataType.RAW10) for got, one in zip(result.frames, sent)
               if not got.bad)


def header_frames(lanes):
    """A wire with frames, each single bit and each pair of bits of a row's header wrong in one.

    Returns (wire, whether each frame is bad, faults).
    """
    rng, kind = np.random.default_rng(lanes), DataType.RAW10
    wire = resting(lanes, rng)
    wrong = [*combinations(range(32), 1), *combinations(range(32), 2)]
    for bits in wrong:
        packets = frame_packets(random_frame(rng, kind, 1, 2), kind, CHANNEL)
        send(wire, lanes, row(packets, lambda one, bits=bits: flip(one, *bits)))
    bad = [len(bits) == 2 for bits in wrong]
    return wire, bad, {"corrected": bad.count(False), "header": bad.count(True)}


def odd_frames(lanes, kind):
    """A wire with frames, of which the second row has 1, 2, 3, .. bytes, whole groups or not.

    Returns as :func:`header_frames`.
    """
    rng, size = np.random.default_rng(lanes), GROUP_BYTES[kind]
    wire, sizes = resting(lanes, rng), range(1, 3 * lanes * size + 2)
    for count in sizes:
        packets = frame_packets(random_frame(rng, kind, 3, 3), kind, CHANNEL)
        packets[2] = long_packet(CHANNEL, kind, rng.bytes(count))
        send(wire, lanes, packets)
    bad = [count % size != 0 for count in sizes]
    return wire, bad, {"length": sum(bad)} if any(bad) else {}


def residue_frames(lanes):
    """A wire with frames, the checksum of a row wrong so that one bit of its remainder is not 0.

    Each of the 16 bits is that one in a row of an odd number of bytes, and of an even one. Returns
    as :func:`header_frames`.
    """
    rng, kind = np.random.default_rng(lanes), DataType.RAW8
    wire = resting(lanes, rng)
    for size, bit in product((7, 8), range(16)):
        wrong = 1 << bit
        for _ in range(16):         # back through the bits of the checksum
            wrong = (wrong ^ 0x8408) << 1 | 1 if wrong >> 15 else wrong << 1
        bits = [8 * (4 + size) + k for k in range(16) if wrong >> k & 1]
        packets = frame_packets(random_frame(rng, kind, size, 3), kind, CHANNEL)
        send(wire, lanes, row(packets, lambda one, bits=bits: flip(one, *bits)))
    return wire, [True] * 32, {"checksum": 32}


def check_statuses(result, bad, faults):
    """Each frame came, bad or not, and those faults were counted."""
    assert [frame.bad for frame in result.frames] == bad
    assert {name: count for name, count in result.faults.items() if count} == faults


def long_frames(lanes):
    """A wire with a frame of samples of 8 bits whose rows are as long as a packet may be, or set
    one upper bit each of its length; the frame."""
    rng, kind = np.random.default_rng(lanes), DataType.RAW8
    wire = resting(lanes, rng)
    rows = [random_frame(rng, kind, groups, 1)[0]
            for groups in (65_535, 200, *((1 << k) + k % 5 for k in range(6, 16)))]
    send(wire, lanes, frame_packets(rows, kind, CHANNEL))
    return wire, [rows]


def corrupted_frames(lanes, count, seed=1):
    """A wire with frames, ``count`` of their packets corrupted; the frames; which are untouched."""
    rng = np.random.default_rng([lanes, seed])
    return corrupted_run(rng, lanes, count, lambda rng: random_frame(
        rng, DataType.RAW10, 3, _HEIGHT))


def check_corrupted(result, frames, untouched):
    """No frame that is handed on is wrong, and every untouched one is handed on."""
    # The consumer checks the size, as it does for each kind of camera.
    number_of = {(frame << 2).tobytes(): number for number, frame in enumerate(frames)}
    sizes = [12] * _HEIGHT
    handed_on = [number_of[np.array(frame.rows).tobytes()] for frame in result.frames
                 if not frame.bad and [len(row) for row in frame.rows] == sizes]
    assert handed_on == sorted(set(handed_on))
    assert {number for number, clean in enumerate(untouched) if clean} <= set(handed_on)
    assert all(result.faults.values()), result.faults


def reset_frames(lanes):
    """A wire with frames; the frames; whether there is a reset in each clock; which frames are
    whole."""
    rng, kind = np.random.default_rng(lanes), DataType.RAW10
    wire, frames, begins = resting(lanes, rng), [], []
    for number in range(60):
        frames.append(random_frame(rng, kind, 3, 2))
        begins.append(len(wire.clocks[0]) if number else 0)
        send(wire, lanes, frame_packets(frames[-1], kind, CHANNEL))
    ends = len(wire.clocks[0])
    resets = [begin + int(rng.integers(0, 100)) for begin in begins[1:-1:2]]
    reset = np.zeros(ends, bool)
    reset[resets] = True
    # The end of a frame leaves while the next one begins.
    latency = Receiver(lanes).latency
    whole = [number for number, (begin, end) in enumerate(zip(begins, [*begins[1:], ends]))
             if not reset[begin:end + latency].any()]
    return wire, frames, reset, whole


def check_reset(result, frames, whole):
    """Whole frames came, and nothing that was not sent."""
    good = [frame for frame in result.frames if not frame.bad]
    assert len(good) >= len(whole) > 20
    number_of = {frame.tobytes(): number for number, frame in enumerate(frames)}
    found = [number_of[(np.array(frame.rows) >> 2).tobytes()] for frame in good
             if len(frame.rows) == 2]
    assert set(whole) <= set(found)
