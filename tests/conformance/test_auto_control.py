"""Automatic exposure, gain and white balance: one rule, and devices that come to rest by it."""

import random

import numpy as np
import pytest

from devices import SIZE, device, small_lens
from firmware_wire import TcpUser, Wire
from gvcp_client import PEER, Client
from ncdc_model.images import mosaic
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.auto_control import (
    BAND,
    CONTINUOUS,
    GAIN_MIN,
    OFF,
    ONCE,
    TARGET,
    Limits,
    balanced,
    exposed,
)
from ncdc_spec.protocols.features import AUTO_FEATURES
from ncdc_spec.protocols.table_one import MRAW, WRITE
from ncdc_spec.protocols.table_two import HEADER_BYTES
from ncdc_spec.registers.register_map import registers
from ncdc_spec.registers.system_map import Stores, system_registers
from ncdc_spec.sensors import mt9p031
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY, gains_word

GAIN_MAX = 63           # of the sensor, eighths
FRAMES = 40             # within which a device settles, whatever the scene
_LENS = small_lens()
REGISTERS = {one.name: one.address for one in registers(
    _LENS.hidden_neurons, _LENS.formats, _LENS.nodes, colour=True)}
CAPTURE_GAINS, = (one.address for one in system_registers(Stores(4, 3, 1))
                  if one.name == "CAPTURE_GAINS")


class Scene:
    """A grey scene of any brightness, or the colours of a picture."""

    def __init__(self, bayer):
        self._bayer, self.light, self.colours = bayer, 0.0, (1, 1, 1)

    def position(self, number):
        """The camera caches a picture for each position."""
        return hash((self.light, self.colours))

    def raw(self, position):
        """In floats: brighter than white, too."""
        picture = np.full((*SIZE[::-1], 3), self.colours, np.float32) * np.float32(self.light)
        return mosaic(picture, self._bayer)


class Emulated:
    """An emulated device whose stream is made frame by frame, by the test."""

    def __init__(self):
        self._device = one = device([_LENS])
        self._scene = one.camera._light = Scene(_LENS.geometry.bayer)
        # No exposure is the reference, of which the camera shows the light as it is.
        one.registers.reference_ns += 1
        self._number, self._now = 1, 0
        one.camera.now_ns = lambda: self._now       # a frame is due when the test says so
        self.client = Client(lambda data: one.agent.answers(data, PEER))
        one.stream.start = lambda receiver, **_: None
        self.lines_max = one.registers.limits(True, True).lines[1]

    def set_light(self, light, colours=(1, 1, 1)):
        """A grey of ``light`` for each line and eighth of gain."""
        line_ns = self._device.registers.settings.exposure_ns // self._device.registers.lines
        self._scene.light = light * 8 * self._device.registers.reference_ns / line_ns
        self._scene.colours = colours

    def frames(self, count):
        """Let frames pass; the last one."""
        for _ in range(count):
            self._number += 1
            self._now = self._number * 10**7
            frame = self._device.camera.frame(self._number)
            if self._device.agent._acquiring:
                self._device.stream._observe(frame)
        return frame

    def level(self):
        """Mean of a frame with the present settings, 16ths."""
        return self.frames(2).level

    def table_write(self, address, value):
        """Write a word of Table I; the word as read back."""
        self._device.table.write(address, value)
        return self._device.table.read(None, address)

    def capture_gains(self):
        """The gains at capture, as in the register CAPTURE_GAINS."""
        return gains_word(self._device.registers.settings.colour.raw_gains)

    def close(self):
        self._device.close()


class Firmware:
    """The firmware on this machine."""

    def __init__(self, program):
        self.wire = Wire(program).__enter__()
        self.client = Client(lambda data: self.wire.datagram(data, PEER[1], PEER[0]))
        # The rule's limit is seen in what a black scene ends with.
        self.lines_max = None
        self._light = 0

    def set_light(self, light, colours=(1, 1, 1)):
        self._light = light
        self.wire.set_light(max(1, round(65536 * light)))
        # As the corrector would count them, at any exposure, without gains.
        for name, share in zip(("RED", "GREEN", "BLUE"), colours):
            self.wire.put(REGISTERS[f"{name}_SUM"], round(1000 * 100 * share))
        self.wire.put(REGISTERS["VALID_PIXELS"], 1000)

    def frames(self, count):
        for _ in range(count):
            self.wire.wait(5)

    def level(self):
        lines, gain = self.client.exposure()
        return 16 * min(255, int(self._light * max(1, lines) * gain))

    def table_write(self, address, value):
        user = TcpUser(self.wire, 40_000)
        assert user.connect()
        return user.ask(WRITE, address, value)

    def capture_gains(self):
        return self.wire.peek(CAPTURE_GAINS)

    def close(self):
        self.wire.__exit__()


@pytest.fixture(params=["emulated", "firmware"])
def one(request, wire_firmware):
    found = Emulated() if request.param == "emulated" else Firmware(wire_firmware)
    found.client.control()
    yield found
    found.close()


@pytest.fixture
def firmware(wire_firmware):
    found = Firmware(wire_firmware)
    found.client.control()
    yield found
    found.close()


def settled(one):
    """Exposure and gain that the device comes to rest with, within ``FRAMES`` frames."""
    one.frames(FRAMES)
    rest = one.client.exposure()
    for _ in range(10):
        one.frames(1)
        assert one.client.exposure() == rest
    return rest


# The rule itself.

def limits_of(exposure, gain, lines):
    """What the rule may change of the MT9P031 with so long a frame."""
    return Limits(exposure, gain, (1, lines), GAIN_MAX)


def cases(count, seed=7):
    rng = random.Random(seed)
    for _ in range(count):
        lines = rng.choice((1, 2, 3, 7, 50, 999, 1000, 1001, 0xFFFFF, rng.randint(1, 0xFFFFF)))
        yield (rng.choice((0, 1, TARGET - BAND, TARGET - BAND - 1, TARGET + BAND,
                           TARGET + BAND + 1, 4080, rng.randint(0, 4080))),
               lines, rng.randint(GAIN_MIN, GAIN_MAX), rng.random() < .7, rng.random() < .7,
               rng.choice((1, 2, 1000, 0xFFFFF)))


def balances(count, seed=8):
    rng = random.Random(seed)
    for _ in range(count):
        pixels = rng.choice((0, 1, 1000, 1 << 24))
        sums = [rng.choice((0, 1, rng.randint(0, 255 * pixels), 8 * pixels)) for _ in range(3)]
        near = [min(LARGEST_GAIN, max(0, gain + rng.randint(-3, 3)))
                for gain in balanced(sums, pixels, (UNITY,) * 3)]
        present = rng.choice((near, [rng.choice((0, UNITY, rng.randint(0, LARGEST_GAIN)))
                                     for _ in range(3)]))
        yield sums, pixels, present
        yield [min(s * gain >> 8, 0xFFFFFFFF) for s, gain in zip(sums, present)], pixels, present


def test_the_firmware_has_the_same_rule(wire_firmware):
    with Wire(wire_firmware) as wire:
        for level, lines, gain, *limits in cases(3000):
            assert wire.rule("e", level, lines, gain, *limits) == exposed(
                level, lines, gain, limits_of(*limits)), (level, lines, gain, limits)
        for sums, pixels, gains in balances(2000):
            assert wire.rule("w", *sums, pixels, *gains) == balanced(sums, pixels, gains)


def test_the_rule_comes_to_rest_at_any_light():
    """A sensor that is linear from black level to white never gets two settings in turn."""
    rng = random.Random(5)
    for _ in range(20_000):
        limits = limits_of(*rng.choice(((1, 1), (1, 0), (0, 1))), rng.choice((1, 2, 5, 50, 1000)))
        light, black = 10**rng.uniform(-5, 4), rng.choice((0, 0, 30, 600))
        now = rng.randint(1, 2000), rng.randint(GAIN_MIN, GAIN_MAX)
        for _ in range(FRAMES):
            level = min(4080, int(black + light * now[0] * now[1]))
            before, now = now, exposed(level, *now, limits)
            if now == before:
                break
        assert now == before, (limits, light, black)
        assert now[0] <= max(before[0], limits.lines[1]) and GAIN_MIN <= now[1] <= GAIN_MAX


def test_a_step_is_bounded():
    both = limits_of(True, True, 100_000)
    assert exposed(1, 100, 8, both) == (400, 8)
    assert exposed(4080, 100, 8, both)[0] >= 25
    assert exposed(TARGET - BAND, 100, 8, both) == (100, 8)
    assert exposed(TARGET - BAND - 1, 100, 8, both) != (100, 8)
    # The gain goes down first, and up last.
    assert exposed(2 * TARGET, 1000, 32, limits_of(True, True, 1000)) == (1000, 16)
    assert exposed(TARGET // 2, 900, 8, limits_of(True, True, 1000)) == (1000, 14)


# Devices.

def test_both_follow_the_light(one):
    one.client.set(ExposureAuto=CONTINUOUS, GainAuto=CONTINUOUS, AcquisitionStart=1)
    for light in (0.05, 0.25, 0.04, 1.0, 0.01):
        one.set_light(light)
        settled(one)
        assert abs(one.level() - TARGET) <= BAND, light


@pytest.mark.parametrize("feature_name", ["ExposureAuto", "GainAuto"])
def test_one_alone_leaves_the_other(one, feature_name):
    one.set_light(0.02)
    one.client.set(ExposureTime=200, Gain=16)
    one.client.set(**{feature_name: CONTINUOUS}, AcquisitionStart=1)
    lines, gain = settled(one)
    assert abs(one.level() - TARGET) <= BAND
    assert (lines == 200) == (feature_name == "GainAuto")
    assert (gain == 16) == (feature_name == "ExposureAuto")


def test_black_and_white_end_at_the_limits(one):
    one.client.set(ExposureAuto=CONTINUOUS, GainAuto=CONTINUOUS, AcquisitionStart=1)
    one.set_light(0.0)
    lines, gain = settled(one)
    assert gain == GAIN_MAX and lines > 40 and one.lines_max in (None, lines)
    one.set_light(1000.0)
    assert settled(one) == (1, GAIN_MIN)


def test_once_becomes_off(one):
    one.set_light(0.1)
    assert one.client.set(ExposureAuto=ONCE, GainAuto=ONCE) == [gvcp.SUCCESS] * 2
    one.client.set(AcquisitionStart=1)
    one.frames(1)
    assert one.client.get("ExposureAuto") == ONCE
    rest = settled(one)
    assert one.client.get("ExposureAuto") == one.client.get("GainAuto") == OFF
    assert abs(one.level() - TARGET) <= BAND
    one.set_light(0.9)                  # the exposure is fixed now
    assert settled(one) == rest
    assert one.client.set(ExposureTime=77, Gain=9) == [gvcp.SUCCESS] * 2


def test_nothing_happens_without_a_stream(one):
    one.set_light(0.5)
    one.client.set(ExposureTime=100, Gain=8, ExposureAuto=CONTINUOUS, GainAuto=ONCE,
                   BalanceWhiteAuto=ONCE)
    assert settled(one) == (100, 8)
    assert one.client.get("GainAuto") == one.client.get("BalanceWhiteAuto") == ONCE
    one.client.set(AcquisitionStart=1)
    assert settled(one) != (100, 8)


def test_what_is_automatic_is_locked(one):
    one.client.set(ExposureTime=100, Gain=10)
    for auto, name, value in (("ExposureAuto", "ExposureTime", 100), ("GainAuto", "Gain", 10),
                              ("BalanceWhiteAuto", "BalanceRatio", UNITY)):
        assert one.client.set(**{auto: CONTINUOUS, name: value + 1}) == [
            gvcp.SUCCESS, gvcp.ACCESS_DENIED], name
        assert one.client.get(name) == value
        assert one.client.set(**{name: value}) == [gvcp.SUCCESS]
        if auto == "GainAuto":
            assert one.table_write(mt9p031.GLOBAL_GAIN, 20) == value
            one.client.set(SensorRegisterAddress=mt9p031.GLOBAL_GAIN)
            assert one.client.set(SensorRegisterValue=20) == [gvcp.ACCESS_DENIED]
        assert one.client.set(**{auto: OFF, name: value + 1}) == [gvcp.SUCCESS] * 2
    assert one.client.set(ExposureAuto=3, BalanceRatioSelector=3, BalanceRatio=0) == [
        gvcp.INVALID_PARAMETER] * 3


def test_it_stays_when_the_controller_leaves(one):
    modes = {name: CONTINUOUS for name in AUTO_FEATURES}
    one.set_light(0.5)
    one.client.set(ExposureTime=100, Gain=8, **modes, AcquisitionStart=1)
    one.client.write(gvcp.register("ControlPrivilege").address, 0)
    assert {name: one.client.get(name) for name in modes} == modes
    # Without a controller, users of Table I write what they like.
    assert one.table_write(mt9p031.GLOBAL_GAIN, 20) == 20
    assert settled(one) == (100, 20)
    one.client.control()
    assert one.client.set(Gain=21) == [gvcp.ACCESS_DENIED]
    one.client.set(AcquisitionStart=1)
    assert settled(one) != (100, 20)


def test_the_colours_get_equal_means(one):
    one.set_light(0.03, (0.5, 1.0, 0.7))
    one.client.set(ExposureTime=400, Gain=8, BalanceWhiteAuto=ONCE, AcquisitionStart=1)
    one.frames(10)
    assert one.client.get("BalanceWhiteAuto") == OFF
    ratios = []
    for colour in range(3):
        one.client.set(BalanceRatioSelector=colour)
        ratios.append(one.client.get("BalanceRatio"))
    assert ratios == pytest.approx([512, 256, 366], abs=6)


def test_while_raw_frames_stream_no_ratio_is_estimated(one):
    one.client.set(CorrectionEnable=0)
    one.set_light(0.03, (0.5, 1.0, 0.7))
    one.client.set(ExposureTime=400, Gain=8, BalanceWhiteAuto=ONCE, AcquisitionStart=1)
    one.frames(10)
    assert one.client.get("BalanceWhiteAuto") == ONCE
    assert one.client.get("BalanceRatio") == UNITY


def test_the_ratios_are_the_gains_of_capture(one):
    """Written in any order, and not those of the corrector, which act after interpolation."""
    for colour, ratio in ((2, 300), (0, 1023), (2, 301)):
        assert one.client.set(BalanceRatioSelector=colour, BalanceRatio=ratio) == [
            gvcp.SUCCESS] * 2
    one.frames(1)
    assert one.capture_gains() == gains_word((1023, 256, 301))


def test_gains_that_are_in_the_sums_stay_balanced(one):
    """The estimate takes the present gains into account: it comes to rest, from any beginning."""
    one.set_light(0.02, (0.6, 1.0, 0.8))
    one.client.set(ExposureTime=300, Gain=8)
    for colour, ratio in enumerate((300, 700, 512)):
        one.client.set(BalanceRatioSelector=colour, BalanceRatio=ratio)
    one.client.set(BalanceWhiteAuto=CONTINUOUS, AcquisitionStart=1)
    one.frames(12)
    found = []
    for _ in range(6):
        one.frames(1)
        found.append(one.capture_gains())
    assert len(set(found)) == 1
    gains = [found[0] >> 10 * colour & 1023 for colour in range(3)]
    assert gains == pytest.approx([427, 256, 320], abs=5)


# The firmware alone: other users of the frames.

def test_exposure_waits_while_a_package_is_sent(firmware):
    user = TcpUser(firmware.wire, 41_000, takes=False)
    assert user.connect()
    user.send(bytes([MRAW]))
    firmware.set_light(0.5)
    firmware.client.set(ExposureTime=100, Gain=8, ExposureAuto=CONTINUOUS, AcquisitionStart=1)
    assert settled(firmware) == (100, 8)
    user.takes = True
    for _ in range(100):            # what was not taken is sent again after seconds
        user.wait(100)
        if len(user.data) == HEADER_BYTES + 3 * SIZE[0] * SIZE[1]:
            break
    else:
        raise AssertionError(len(user.data))
    assert settled(firmware)[0] < 100
