"""A board's own SDRAM between a sensor and a gigabit line: every picture right, and how often."""

import struct
import zlib
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_boards.camera_board.design import hardware_for
from ncdc_boards.catalogue import board
from ncdc_sim.board import network
from ncdc_sim.board.network import NetworkModel
from ncdc_sim.board.pictures import GAP_CLOCKS, line_frames, pictures_of, steady
from ncdc_sim.board.rates import corrected_rates, replayed_rates
from ncdc_sim.board.sender import Claimed, PictureSender
from ncdc_sim.tools import SimulationError
from ncdc_spec.pixel_formats import format_of_name
from ncdc_spec.protocols.link_headers import Endpoint, gvsp_headers

SIZE = 160, 120
RELEASE = 4
_ALL = 0xFFFFFFFF
_HERE = Endpoint(bytes(6), bytes(4), 1)


def golden(count, shape=(4, 8, 3)):
    return list(np.random.default_rng(2).integers(0, 256, (count, *shape), dtype=np.uint8))


def packets(block, picture):
    """Ethernet frames of a picture of GVSP, without check sequence, filled up."""
    height, width, _ = picture.shape
    headers = gvsp_headers(_HERE, _HERE, (format_of_name("BGR8"), width, height), block, 0, 32)
    at, size = headers.field
    data = picture.tobytes()

    def numbered(header, number):
        return header[:at] + number.to_bytes(size, "big") + header[at + size:]

    parts = [numbered(headers.payload if k < headers.packets - 1 else headers.last, k + 1)
             + data[32 * k:32 * k + 32] for k in range(headers.packets)]
    trailer = numbered(headers.trailer, headers.packets + 1)
    return [one.ljust(60, b"\0") for one in (headers.leader, *parts, trailer)]


def record(frames, near=(), wrong=(), corrupted=()):
    """A record of ``hdl/network_bench.v``; ``near``: frames that come too soon after the one
    before, ``wrong``: those that were made so, ``corrupted``: those with another check
    sequence."""
    made, now = b"", 100
    for k, frame in enumerate(frames):
        check = zlib.crc32(frame) ^ (k in corrupted)
        data = bytes([0x55] * 7 + [0xD5]) + frame + check.to_bytes(4, "little")
        made += struct.pack(">IIHH", now, now + len(data), len(data), k in wrong) + data
        now += len(data) + GAP_CLOCKS - (k + 1 in near)
    return made


@pytest.fixture
def stream():
    """Three pictures, and the frames that carry them."""
    pictures = golden(3)
    return pictures, [frame for k, one in enumerate(pictures) for frame in packets(k + 1, one)]


def test_pictures_that_come_whole(stream):
    pictures, frames = stream
    found = pictures_of(line_frames(record(frames)))
    result = steady(found, pictures, line_hz=1000, settle=1)
    assert (result.frames, result.pixels_different) == (2, 0)
    # Each has as many bytes on the line, gaps included.
    clocks = sum(8 + len(frame) + 4 + GAP_CLOCKS for frame in frames[:len(frames) // 3])
    assert result.frames_per_second == pytest.approx(1000 / clocks)
    assert result.slowest == pytest.approx(1000 / clocks)
    assert result.megabytes_per_second == pytest.approx(1e-3 * 4 * 8 * 3 / clocks)


@pytest.mark.parametrize("fault", [
    {"near": {2}}, {"wrong": {2}}, {"corrupted": {2}}])
def test_a_frame_that_breaks_is_reported(stream, fault):
    pictures, frames = stream
    seen = line_frames(record(frames, **fault))
    assert [k for k, frame in enumerate(seen) if not frame.whole] == [2]
    assert pictures_of(seen)[0].data is None
    assert steady(pictures_of(seen), pictures, 1000, 1).pixels_different == 4 * 8


@pytest.mark.parametrize("spoil", [
    lambda frames: frames.pop(2), lambda frames: frames.insert(2, frames[1]),
    lambda frames: frames.insert(2, frames.pop(1))])
def test_packets_that_are_lost_doubled_or_swapped_are_found(stream, spoil):
    pictures, frames = stream
    spoil(frames)
    found = pictures_of(line_frames(record(frames)))
    assert steady(found, pictures, 1000, 1).pixels_different == 4 * 8


def test_a_pixel_that_differs_is_counted(stream):
    pictures, frames = stream
    pictures[1][2, 3, 1] ^= 1
    assert steady(pictures_of(line_frames(record(frames))), pictures, 1000,
                  1).pixels_different == 1


def test_too_few_pictures_are_no_rate(stream):
    pictures, frames = stream
    with pytest.raises(SimulationError, match="3 pictures came, 3 were sent, 4 are needed"):
        steady(pictures_of(line_frames(record(frames))), pictures, 1000, 2)


@cache
def model():
    """A board with its network that corrects small pictures in strips."""
    device = board("de2-115")
    return NetworkModel(device, barrel_descriptor(SIZE, SIZE, hidden_neurons=2),
                        hardware=replace(hardware_for(device), strip=64), optimise="-O1")


class Hasty(PictureSender):
    """Sends a frame that the corrector has only begun."""

    def _next(self, event, store):
        run = self.run
        number = run.read("CORRECTED_BEGUN") + 1
        run.until("CORRECTED_BEGUN", _ALL, number)
        for k in range(run.model.design.system.stores.corrected):
            if run.read(f"CORRECTED{k}_NUMBER") == number:
                return Claimed(run.read(f"CORRECTED{k}_BASE"), number, 0)
        raise AssertionError("no buffer is written")


class Careless(PictureSender):
    """Sends a frame that it has released, when others have come."""

    def _next(self, event, store):
        frame, run = super()._next(event, store), self.run
        for reader in ("READER1", "READER2"):
            run.write(reader, RELEASE)
        run.until("CORRECTED_BEGUN", _ALL, run.read("CORRECTED_BEGUN") + 7)
        return frame


@pytest.mark.regress
@pytest.mark.parametrize("screen", [False, True])
def test_small_pictures_from_the_sensor(screen):
    rates = corrected_rates(model(), 4, settle=1, screen=screen)
    assert rates.steady.pixels_different == rates.underruns == rates.lost == rates.dropped == 0
    assert rates.steady.frames_per_second == pytest.approx(
        model().setup.timing.frames_per_second, rel=.01)
    assert rates.screen_underruns == 0
    assert 0 < rates.refresh_most <= 781                # clocks of 7.8125 us


@pytest.mark.regress
def test_small_pictures_from_memory():
    rates = replayed_rates(model(), 5)
    assert rates.steady.pixels_different == rates.underruns == rates.lost == 0
    assert rates.format == "BayerRG8" and rates.steady.frames == 4


@pytest.mark.regress
@pytest.mark.parametrize("sender", [Hasty, Careless])
def test_a_frame_that_is_not_complete_or_no_longer_held_is_seen(sender):
    rates = corrected_rates(model(), 3, settle=1, sender=sender)
    assert rates.steady.pixels_different > 1000 and rates.underruns == 0


@pytest.mark.regress
def test_packets_that_starve_are_seen(monkeypatch):
    """A line that takes more bytes than the core's clock gives: they break in their midst."""
    monkeypatch.setattr(network, "LINE_HZ", 600_000_000)
    with pytest.raises(SimulationError, match="3 pictures were sent, .*, where .* packets broke"):
        corrected_rates(model(), 3, settle=1)
