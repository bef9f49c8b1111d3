"""Frames through a MAC and its interface to cocotbext-eth's PHYs, both ways at once."""

import random

import cocotb
from cocotb.triggers import RisingEdge, Timer, with_timeout
from cocotbext.eth import GmiiFrame, GmiiPhy, MiiPhy, RgmiiPhy

from benches.common import settings

__all__ = ["GAP_BITS", "filled", "frames_pass"]

_SHORTEST, _LONGEST = 15, 1514      # bytes without check sequence; below 60 the MAC fills them up
GAP_BITS = 96                       # bits between two frames at least, IEEE 802.3


def _phy(dut, interface, speed):
    """The chip, and the wires as it knows them."""
    if interface == "rgmii":
        return RgmiiPhy(dut.tx_data, dut.tx_en, dut.tx_clk, dut.rx_data, dut.rx_dv,
                        dut.rx_clk, speed=speed)
    if interface == "gmii":
        return GmiiPhy(dut.tx_data, dut.tx_er, dut.tx_en, dut.mii_tx_clk, dut.tx_clk, dut.rx_data,
                       dut.rx_er, dut.rx_dv, dut.rx_clk, speed=speed)
    return MiiPhy(dut.tx_data, dut.tx_er, dut.tx_en, dut.mii_tx_clk, dut.rx_data,
                  dut.rx_er, dut.rx_dv, dut.rx_clk, speed=speed)


async def _send(dut, frames, rng, pause):
    """``frames`` as words of four bytes, with short random pauses."""
    for frame in frames:
        for start in range(0, len(frame), 4):
            while rng.random() < pause:
                await RisingEdge(dut.clk)
            word = frame[start:start + 4]
            last = start + 4 >= len(frame)
            dut.sink_valid.value = 1
            dut.sink_data.value = int.from_bytes(word, "little")
            dut.sink_last.value = int(last)
            dut.sink_last_be.value = 1 << len(word) - 1 if last else 0
            while True:
                await RisingEdge(dut.clk)
                if int(dut.sink_ready.value):
                    break
            dut.sink_valid.value = 0


async def _receive(dut, frames):
    """Each frame that leaves the MAC, and whether it is marked as bad, into ``frames``."""
    data = bytearray()
    while True:
        await RisingEdge(dut.clk)
        if not int(dut.source_valid.value):
            continue
        word = int(dut.source_data.value).to_bytes(4, "little")
        if int(dut.source_last.value):
            data += word[:int(dut.source_last_be.value).bit_length()]
            frames.append((bytes(data), bool(int(dut.source_error.value))))
            data = bytearray()
        else:
            data += word


def filled(frame):
    """A frame as it is on the wire, 60 bytes at least."""
    return frame + bytes(max(0, 60 - len(frame)))


def _damaged(frame, rng):
    """A frame on the wire that must not pass: an error signalled by the chip, or a wrong bit."""
    wire = GmiiFrame.from_payload(frame)
    at = rng.randrange(12, len(wire.data) - 1)
    if rng.random() < .5:
        wire.error = [int(k == at) for k in range(len(wire.data))]
    else:
        wire.data[at] ^= 1 << rng.randrange(8)
    return wire


@cocotb.test()
async def frames_pass(dut):
    """Random frames both ways, each once, whole, in order; bad ones marked, with full gaps."""
    s = settings()
    interface, speed = s["interface"], s["speed"]
    rng = random.Random(s["seed"])
    dut.rst.value = 1
    dut.speed.value = (10, 100, 1000).index(speed)
    for name in ("sink_valid", "rx_dv", "rx_er", "rx_data", "mii_tx_clk"):
        getattr(dut, name).value = 0
    phy = _phy(dut, interface, speed * 1e6)
    await Timer(1, "us")
    dut.rst.value = 0
    await Timer(4, "us")        # the chip's reset, 256 clocks

    if interface == "rgmii":
        await _status_is_read(dut, rng.randrange(16), speed)

    def some(count, longest):
        return [rng.randbytes(rng.choice((_SHORTEST, 60, 61, 62, 63, longest,
                                          rng.randint(_SHORTEST, longest))))
                for _ in range(count)]

    longest = min(_LONGEST, s["longest"])
    sent, coming = some(s["frames"], longest), some(s["frames"], longest)
    got = []
    cocotb.start_soon(_receive(dut, got))
    sender = cocotb.start_soon(_send(dut, sent, rng, s["pause"]))
    expected = []
    for frame in coming:
        bad = rng.random() < s["bad"]
        await phy.rx.send(_damaged(frame, rng) if bad
                          else GmiiFrame.from_payload(frame))
        expected.append((filled(frame), bad))
    await _compare_sent(phy, sent, speed)
    await sender
    await phy.rx.wait()
    await Timer(200 * 1000 // speed, "ns")
    _compare_received(got, expected)


async def _status_is_read(dut, status, speed):
    """The chip's status on its idle wires is in the register."""
    dut.rx_data.value = status
    await Timer(200 + 40_000 // speed, "ns")
    assert int(dut.status.value) == status, f"{int(dut.status.value)} is read, {status} is right"
    dut.rx_data.value = 0


async def _compare_sent(phy, sent, speed):
    end = None
    for number, frame in enumerate(sent):
        wire = await with_timeout(phy.tx.recv(), 60_000_000 // speed, "ns")
        assert wire.error is None or not any(wire.error), f"frame {number} is sent with an error"
        assert wire.check_fcs(), f"frame {number} is sent with a wrong check sequence"
        assert wire.get_payload() == filled(frame), f"frame {number} is sent wrong"
        if end is not None:
            gap = (wire.sim_time_start - end) / 1000 * speed / 1000
            assert gap >= GAP_BITS - .01, f"{gap} bits before frame {number}, 96 are the minimum"
        end = wire.sim_time_end
    assert phy.tx.empty(), "more frames are sent than were given"


def _compare_received(got, expected):
    assert len(got) == len(expected), f"{len(got)} frames of {len(expected)} were received"
    for number, ((data, marked), (frame, bad)) in enumerate(zip(got, expected, strict=True)):
        assert marked == bad, f"frame {number} is {'not ' * bad}marked as bad"
        assert bad or data == frame, f"frame {number} is received wrong"
