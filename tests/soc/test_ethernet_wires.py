"""RGMII, GMII and MII: LiteEth's MAC with our interfaces, at cocotbext-eth's PHYs."""

import random

import pytest
from migen import passive, run_simulation

from cocotb_run import run_cocotb
from ethernet import DEVICES, PAIRED, mac_design, packets_design
from ncdc_sim.tools import SimulationError
from ncdc_soc.phy import nibbles as blocks
from ncdc_soc.phy.nibbles import Receiver, Sender

CASES = [("rgmii", 1000), ("rgmii", 100), ("rgmii", 10), ("gmii", 1000), ("mii", 100), ("mii", 10)]
DAILY = {("altera", "rgmii", 1000), ("altera", "rgmii", 10), ("altera", "mii", 100)}


def simulate(design, interface, speed, frames, **options):
    run_cocotb(design, "ethernet", "verilator",
               **{"interface": interface, "speed": speed, "frames": frames, "seed": 5,
                  "pause": .05, "bad": .2, "longest": 1514, **options})


@pytest.mark.longer
@pytest.mark.parametrize("device,interface,speed", [
    pytest.param(device, *case, marks=() if (device, *case) in DAILY else pytest.mark.regress)
    for device in DEVICES for case in CASES])
def test_frames(device, interface, speed):
    simulate(mac_design(device, interface), interface, speed, 12, longest=200)


@pytest.mark.regress
@pytest.mark.parametrize("device,interface,speed", [(d, *case) for d in DEVICES for case in CASES])
def test_thousand_frames(device, interface, speed):
    simulate(mac_design(device, interface), interface, speed, 1000,
             longest=1514 if speed == 1000 else 200, seed=8)


@pytest.mark.regress
@pytest.mark.parametrize("speed,frames", [(1000, 1000), (100, 12), (10, 12)])
def test_frames_of_words(speed, frames):
    """As on a slow device: preamble, padding and check sequence at the system's clock."""
    simulate(mac_design("ecp5", "rgmii", in_words=True), "rgmii", speed, frames,
             longest=1514 if speed == 1000 else 200)


@pytest.mark.regress
@pytest.mark.parametrize("device", DEVICES)
def test_clock_made_late_by_the_device(device):
    simulate(mac_design(device, "rgmii", late=True), "rgmii", 1000, 50)


@pytest.mark.regress
@pytest.mark.parametrize("device", DEVICES)
def test_halves_of_two_clocks_are_seen(device):
    with pytest.raises(SimulationError, match="received"):
        simulate(mac_design(device, "rgmii", paired=not PAIRED[device]), "rgmii", 1000, 12)


@pytest.mark.regress
def test_gap_that_is_too_short_is_seen(monkeypatch):
    monkeypatch.setattr(blocks, "eth_interpacket_gap", 11)
    mac_design.cache_clear()
    with pytest.raises(SimulationError, match="96 are the minimum"):
        simulate(mac_design("altera", "mii"), "mii", 100, 12, longest=200)
    mac_design.cache_clear()


def picture(width, height, payload, capacity, min_rate, device="altera"):
    """A raw picture through packetiser, MAC and RGMII; memory answers after 60 clocks."""
    run_cocotb(packets_design(device, capacity), "ethernet_packets", "verilator",
               width=width, height=height, payload=payload, bytes=width * height, min_rate=min_rate,
               seed=3, wait=0, stall=0, latency=[60, 60], rate=[])


def test_small_picture_leaves():
    picture(64, 48, 256, 3840, min_rate=80)


@pytest.mark.regress
@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("payload,capacity,min_rate", ((1456, 3840, 118), (8960, 18176, 122.7)))
def test_whole_picture_fills_the_line(device, payload, capacity, min_rate):
    picture(1280, 1024, payload, capacity, min_rate, device)


def sent(frames, whole, clocks, ready=lambda k: True):
    """Each step's nibbles, enable and error while a :class:`Sender` is given ``frames``.

    ``ready(k)``: whether the k-th byte of all is there when it is asked for, or a step later.
    """
    sender, steps = Sender(), []
    data = [(byte, k == len(frame) - 1) for frame in frames for k, byte in enumerate(frame)]

    def feed():
        yield sender.whole.eq(whole)
        yield sender.clocks.eq(clocks - 1)
        for _ in range(4 * clocks):
            yield
        for k, (byte, last) in enumerate(data):
            if not ready(k):
                yield sender.sink.valid.eq(0)
                yield
                while not (yield sender.sink.ready):
                    yield
            yield sender.sink.data.eq(byte)
            yield sender.sink.last.eq(last)
            yield sender.sink.valid.eq(1)
            yield
            while not (yield sender.sink.ready):
                yield
        yield sender.sink.valid.eq(0)
        for _ in range(40 * clocks):
            yield

    @passive
    def watch():
        while True:
            steps.append(((yield sender.low), (yield sender.high), (yield sender.enable),
                          (yield sender.error)))
            yield

    run_simulation(sender, [feed(), watch()])
    return steps


@pytest.mark.parametrize("whole,clocks", ((1, 1), (0, 1), (0, 5), (0, 50)))
def test_sender(whole, clocks):
    frames = [random.Random(k).randbytes(9 + k) for k in range(3)]
    steps = sent(frames, whole, clocks)
    got, nibbles = [], []
    for low, high, enable, error in steps:
        assert not error
        if enable:
            nibbles += [low, high] if whole else [low]
            if not whole:
                assert low == high
        elif nibbles:
            assert len(nibbles) % (1 if whole else clocks) == 0
            one = nibbles if whole else nibbles[::clocks]
            got.append(bytes(a | b << 4 for a, b in zip(one[::2], one[1::2], strict=True)))
            nibbles = []
    assert got == frames
    gaps = "".join(str(step[2]) for step in steps).strip("0").split("1")
    shortest = min(len(gap) for gap in gaps if gap)
    assert shortest >= 12 * clocks * (1 if whole else 2), "the gap is shorter than 96 bits"


def test_starved_frame_is_one_bad_frame():
    """A byte that is late is an error within its frame, no end of it."""
    frame = bytes(range(1, 21))
    steps = sent([frame], 1, 1, ready=lambda k: k != 7)
    enables = "".join(str(step[2]) for step in steps).strip("0")
    assert enables == "1" * 21 and sum(step[3] for step in steps) == 1
    assert next(k for k, step in enumerate(s for s in steps if s[2]) if step[3]) == 7


def received(nibbles):
    """Frames of a :class:`Receiver` at a nibble a clock; None: idle."""
    receiver, frames, data = Receiver(), [], bytearray()

    def feed():
        yield receiver.whole.eq(0)
        for nibble in [*nibbles, *[None] * 4]:
            yield receiver.valid.eq(nibble is not None)
            yield receiver.low.eq(nibble or 0)
            yield

    @passive
    def watch():
        nonlocal data
        while True:
            if (yield receiver.source.valid):
                data.append((yield receiver.source.data))
                if (yield receiver.source.last):
                    frames.append(bytes(data))
                    data = bytearray()
            yield

    run_simulation(receiver, [feed(), watch()])
    return frames


@pytest.mark.parametrize("lost", range(15))
def test_preamble_may_lose_nibbles(lost):
    """As long as its last nibble but one is there."""
    frame = bytes(range(40, 60))
    wire = [5] * 15 + [13] + [n for byte in frame for n in (byte & 15, byte >> 4)]
    idle = [None] * 3
    got = received([*idle, *wire[lost:], *idle, *wire, *idle])
    assert [one[one.index(b"\xd5") + 1:] for one in got] == [frame, frame]
