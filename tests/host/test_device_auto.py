"""Automatic features of an emulated device that streams, as a client sees them."""

import time

import numpy as np
import pytest

from cameras import barrel_descriptor
from devices import SIZE, device, small_lens
from ncdc_host.client import Rejected, open_device
from ncdc_host.client.lens import LensLoader
from ncdc_host.device.auto_control import AutoControl, level_of
from ncdc_model.correction import Correction
from ncdc_model.example import noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_model.images import mosaic
from ncdc_spec.colour import Colour
from ncdc_spec.interpolation import DIRECTIONAL, GRADIENT
from ncdc_spec.protocols.auto_control import BAND, CONTINUOUS, TARGET, sample_positions
from ncdc_spec.protocols.gvcp import CORRECTOR_BASE
from ncdc_spec.registers.register_map import CTRL_COMMIT, registers

FRAMES = 60
LENS = barrel_descriptor(SIZE, SIZE, strength=0.6)      # its corners are blank


def tinted():
    """A raw frame of much detail in which red is weak, and blue weaker."""
    picture = noise_picture(*SIZE)
    picture = picture if picture.ndim == 3 else np.repeat(picture[..., None], 3, axis=2)
    return mosaic((picture * (0.4, 0.7, 0.25)).astype(np.uint8), LENS.geometry.bayer)


def until(frames, done):
    """The first frame of the stream at which ``done()``."""
    for _ in range(FRAMES):
        frame = frames.next()
        if done():
            return frame
    raise AssertionError(f"not within {FRAMES} frames")


@pytest.fixture
def one():
    with device([LENS], tinted(), fps=50.0) as served:
        yield served


def test_the_colours_of_pictures_have_equal_means(one):
    seen = ~Correction(LENS).blank
    assert not seen.all()
    with open_device(f"gige://{one.options.address}") as client, client.stream() as frames:
        means = frames.next().picture()[seen].mean(axis=0)
        assert means.max() > 2 * means.min()
        client.set("BalanceWhiteAuto", "Once")
        until(frames, lambda: client.get("BalanceWhiteAuto") == "Off")
        ratios = []
        for colour in ("Red", "Green", "Blue"):
            client.set("BalanceRatioSelector", colour)
            ratios.append(client.get("BalanceRatio"))
        assert min(ratios) == 1
        frame = until(frames, lambda: True)
    means = frame.picture()[seen].mean(axis=0)
    assert means.max() < 1.02 * means.min()


def test_a_dark_scene_gets_the_longest_exposure_and_then_gain(one):
    with open_device(f"gige://{one.options.address}") as client, client.stream() as frames:
        client.set("AcquisitionFrameRate", 100.0)
        client.set("ExposureTime", 2000.0)
        client.set("ExposureAuto", "Continuous")
        with pytest.raises(Rejected):
            client.set("ExposureTime", 3000.0)
        client.set("GainAuto", "Continuous")
        state = {"last": None, "same": 0}

        def at_rest():
            now = client.get("ExposureTime"), client.get("Gain")
            state["same"] = state["same"] + 1 if now == state["last"] else 0
            state["last"] = now
            return state["same"] > 8
        until(frames, at_rest)
        exposure, gain = state["last"]
        line_us = client.get("LineTime") / 1000
        assert 1e6 / 100 - line_us < exposure <= 1e6 / 100 and gain > 1
    settings = one.registers.settings
    level = level_of(one.camera.raw(settings, 0, 0))
    assert abs(level - TARGET) <= BAND


def test_a_frame_of_other_settings_is_not_used(one):
    registers, control = one.registers, AutoControl(one.registers)
    registers.auto["ExposureAuto"] = CONTINUOUS
    registers.set_exposure(100, 8)
    frame = one.camera.newest()
    registers.set_exposure(200, 8)
    control.observe(frame)
    assert registers.lines == 200
    control.observe(one.camera.newest())
    assert registers.lines != 200


def test_samples_lie_all_over_the_frame():
    for size in (2, 8, 48, 1944, 2592):
        found = sample_positions(size)
        assert all(k % 2 == 0 and 0 <= k < size - 1 for k in found)
        assert found == sorted(found) and found[0] <= size / 16 and found[-1] >= size * 14 / 16 - 2
    raw = np.zeros((48, 64), np.uint8)
    raw[:, :32] = 200
    assert level_of(raw) == 16 * 100


AT = {one.name: CORRECTOR_BASE + 4 * one.address for one in registers(
    LENS.hidden_neurons, LENS.formats, LENS.nodes, colour=True)}


def word(client, name):
    return int.from_bytes(client.read_memory(AT[name], 4), "big")


def commit(client, **values):
    """Write registers of the corrector, and wait until they are active."""
    for name, value in {**values, "CTRL": CTRL_COMMIT}.items():
        client.write_memory(AT[name], value.to_bytes(4, "big"))
    end = time.monotonic() + 20
    while word(client, "STATUS") and time.monotonic() < end:
        time.sleep(0.05)


@pytest.mark.parametrize("interpolation,written,active", [
    (DIRECTIONAL, 1, 1), (DIRECTIONAL, 3, 2), (GRADIENT, 1, 0)])
def test_a_crest_that_a_client_commits_is_in_the_pictures(interpolation, written, active):
    lens = small_lens(interpolation=interpolation)
    with device([lens], tinted()) as served, \
            open_device(f"gige://{served.options.address}") as client:
        before = served.camera.newest().data
        commit(client, CREST=written)
        assert word(client, "CREST") == active
        after = served.camera.newest().data
    assert (bytes(before) == bytes(after)) == (not active)
    raw = tinted()
    np.testing.assert_array_equal(Correction(lens)(raw, crest=active).picture,
                                  correct(lens, raw, crest=active).picture)


def test_gains_that_a_client_commits_are_not_the_ratios():
    """Those are after interpolation, the ratios before; a lens changes neither."""
    with device([small_lens()]) as served, \
            open_device(f"gige://{served.options.address}") as client:
        client.write_memory(AT["GAIN_GREEN"], (400).to_bytes(4, "big"))
        client.set("BalanceRatioSelector", "Green")
        client.set("BalanceRatio", 2)
        assert word(client, "GAIN_GREEN") == 400        # of the shadow still
        assert served.registers.settings.colour == Colour(raw_gains=(256, 512, 256))
        commit(client)
        LensLoader(client).load(small_lens(seed=3))
        assert client.get("BalanceRatio") == 2 and word(client, "GAIN_GREEN") == 400
        assert served.registers.settings.colour == Colour((256, 400, 256),
                                                          raw_gains=(256, 512, 256))
        served.camera.newest()
        for name, value in served.camera.sums.registers.items():
            assert word(client, name) == value > 0
