"""Pictures of the emulated device: the golden model's, mirrored, cut and stored as declared."""

import time
from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from devices import SIZE, device, small_lens
from ncdc_host.client.errors import Rejected
from ncdc_host.client.lens import LensLoader
from ncdc_host.device.camera import picture_of
from ncdc_host.device.corrector_window import CorrectorWindow, descriptor_of_words
from ncdc_host.device.emulated import lens_corrections
from ncdc_host.device.light import POSITIONS, MovingScene, Photo
from ncdc_host.device.registers import Settings, View
from ncdc_host.device.sensor import Exposure, expose
from ncdc_host.device.stream import Receiver
from ncdc_model.correction import Correction
from ncdc_model.example import noise_picture
from ncdc_model.golden.colour import ColourSums, coloured
from ncdc_model.golden.corrector import correct
from ncdc_spec.colour import Colour
from ncdc_spec.errors import InputError
from ncdc_spec.formats import Formats
from ncdc_spec.geometry import BAYER_PHASE
from ncdc_spec.interpolation import FAST, GRADIENT, INTERPOLATIONS
from ncdc_spec.pixel_formats import BGR8, BGRA8, MONO8, bayer_format, packed
from ncdc_spec.protocols.gvcp import CORRECTOR_BASE
from ncdc_spec.raw_gains import sample_gains
from ncdc_spec.registers.host_values import host_values, table_words
from ncdc_spec.registers.register_map import registers
from ncdc_spec.sensors.catalogue import SENSORS
from ncdc_spec.sensors.level import levelled


def noise(size, seed=3):
    return np.random.default_rng(seed).integers(0, 256, size[::-1], np.uint8)


@pytest.mark.parametrize("bayer", BAYER_PHASE)
@pytest.mark.parametrize("corrected,distorted,strength", [
    ((48, 40), (48, 40), .25), ((90, 40), (64, 52), .6), ((40, 60), (120, 90), -.1)])
@pytest.mark.parametrize("interpolation", INTERPOLATIONS.values(), ids=INTERPOLATIONS)
def test_pictures_are_the_golden_model_s(bayer, corrected, distorted, strength, interpolation):
    lens = barrel_descriptor(corrected, distorted, strength=strength, bayer=bayer, fill=(9, 8, 7),
                             interpolation=interpolation)
    correction = Correction(lens)
    for raw in (noise(distorted), noise_picture(*distorted), np.full(distorted[::-1], 255,
                                                                     np.uint8)):
        golden = correct(lens, raw)
        assert golden.blank.any() or strength < 0
        assert np.array_equal(correction(raw).picture, golden.picture)


def test_a_frame_of_another_size_is_rejected():
    with pytest.raises(InputError, match="48x48 pixels, the descriptor is for 64x48"):
        Correction(small_lens())(np.zeros((48, 48), np.uint8))


@pytest.mark.parametrize("reverse_x", [False, True])
@pytest.mark.parametrize("reverse_y", [False, True])
def test_pictures_are_mirrored_then_cut(reverse_x, reverse_y):
    lens, raw = small_lens(), noise(SIZE)
    flips = (slice(None, None, -1 if reverse_y else 1), slice(None, None, -1 if reverse_x else 1))
    settings = Settings(View(BGR8, 4, 6, 20, 10, reverse_x, reverse_y), 0, 1, 8, 0, 1)
    golden = correct(lens, raw).picture[flips]
    assert np.array_equal(picture_of(raw, settings, Correction(lens)).data,
                          packed(golden[6:16, 4:24], BGR8))
    view = replace(settings.view, pixel_format=bayer_format("RGGB"))
    assert np.array_equal(picture_of(raw, replace(settings, view=view), None).data,
                          raw[flips][6:16, 4:24])


@pytest.mark.parametrize("form", [BGR8, BGRA8, MONO8])
def test_gains_are_those_of_the_golden_model(form):
    lens, raw = barrel_descriptor(SIZE, SIZE, strength=0.6, fill=(9, 8, 7)), noise(SIZE)
    colour = Colour((300, 256, 1023))
    golden = correct(lens, raw)
    assert golden.blank.any()
    settings = Settings(View(form, 0, 0, *SIZE), 0, 1, 8, 0, 1, colour)
    picture = picture_of(raw, settings, Correction(lens))
    assert np.array_equal(picture.data, packed(coloured(golden, colour), form))
    assert picture.sums == ColourSums.of(golden)


@pytest.mark.parametrize("bayer", BAYER_PHASE)
def test_a_mirrored_raw_frame_has_the_pattern_that_it_says(bayer):
    """Samples of a filter that passes 10, 20 and 30 show where its colours are."""
    raw = np.full(SIZE[::-1], 20, np.uint8)
    column, row = BAYER_PHASE[bayer]
    raw[row::2, column::2], raw[1 - row::2, 1 - column::2] = 10, 30
    with device([small_lens(bayer=bayer)], raw) as one:
        one.registers.write(0xF000, 0)
        for mirrors in (0x0000, 0x4000, 0x8000, 0xC000):
            one.registers.write(0x20, mirrors)
            frame = one.camera.newest()
            said_column, said_row = BAYER_PHASE[frame.pixel_format.bayer]
            got = np.frombuffer(frame.data, np.uint8).reshape(SIZE[::-1])
            assert (got[said_row::2, said_column::2] == 10).all(), hex(mirrors)
            assert (got[1 - said_row::2, 1 - said_column::2] == 30).all()
            assert one.registers.read(0xF003) == frame.pixel_format.mraw


@pytest.mark.parametrize("bayer", ["GRBG", "MONO"])
def test_capture_has_its_gains_before_samples_are_bytes(bayer):
    """Of samples between two grey levels too, as capture's golden model; and of a test pattern."""
    light, gains = noise(SIZE), (700, 256, 400)
    phase = BAYER_PHASE.get(bayer)
    found = expose(light, Exposure(.25, 1, "Off", 0, gains), bayer, 0)
    wanted = levelled(4 * light.astype(int), gains=sample_gains(SIZE, phase, gains))
    assert np.array_equal(found, wanted)
    coarse = expose(light, Exposure(.25, 1, "Off", 0), bayer, 0)
    assert len(np.unique(found)) > len(np.unique(coarse)) or phase is None
    plain, gained = (expose(light, Exposure(1, 1, "ColorBar", 0, *more), bayer, 0)
                     for more in ((), (gains,)))
    assert np.array_equal(gained, levelled(16 * plain.astype(int),
                                           gains=sample_gains(SIZE, phase, gains)))


def test_ratios_are_in_raw_frames_too():
    with device([small_lens()], np.full(SIZE[::-1], 100, np.uint8)) as one:
        one.registers.write(0xF000, 0)
        one.registers.set_ratio(0, 512)
        raw = np.frombuffer(one.camera.newest().data, np.uint8).reshape(SIZE[::-1])
    column, row = BAYER_PHASE[small_lens().geometry.bayer]
    assert (raw[row::2, column::2] == 200).all() and (raw == 100).sum() == raw.size * 3 // 4


def test_the_sensor_multiplies_and_clips():
    light = np.array([[0, 10, 100, 200]], np.uint8)
    assert expose(light, Exposure(1, 1, "Off", 0), "RGGB", 0) is light
    assert expose(light, Exposure(0.5, 2.125, "Off", 0), "RGGB", 0).tolist() == [[0, 11, 106, 213]]
    assert expose(light, Exposure(2, 1, "Off", 0), "RGGB", 0).tolist() == [[0, 20, 200, 255]]
    flat = np.full((100, 100), 100, np.uint8)
    noisy = expose(flat, Exposure(1, 4, "Off", 2.0), "RGGB", 1)
    assert 250 < noisy.mean() <= 255
    dark = expose(flat, Exposure(0.25, 4, "Off", 2.0), "RGGB", 1).astype(float)
    # Photons: 100 x 4 x 0.35 / 16; reading: (2 x 4)^2.
    assert dark.std()**2 == pytest.approx(100 * 4 * 0.35 / 16 + 64, rel=0.1)
    assert np.array_equal(noisy, expose(flat, Exposure(1, 4, "Off", 2.0), "RGGB", 1))


def test_every_test_pattern_is_another_picture():
    light = noise(SIZE)
    names = {name for sensor in SENSORS if sensor.controls for name in sensor.controls.patterns}
    pictures = [expose(light, Exposure(1, 1, name, 5.0), "RGGB", 0).tobytes() for name in names]
    assert len(names) == 7 and len(set(pictures)) == len(names)


def test_the_newest_frame_has_every_setting_written_before():
    dim = noise(SIZE) // 4
    with device(image=dim) as one:
        for k in range(20):
            one.registers.write(0x35, 8 + k)
            raw = np.floor(dim * ((8 + k) / 8) + .5).astype(np.uint8)
            frame = one.camera.newest()
            golden = correct(one.camera.corrections[0].descriptor, raw).picture
            assert np.array_equal(np.frombuffer(frame.data, np.uint8).reshape(golden.shape),
                                  golden[..., ::-1])


def test_the_frame_rate_is_met():
    with device(fps=50.0) as one:
        first = one.camera.newest()
        one.registers.write(0xF004, 100)      # 10 per second
        second = one.camera.newest()
        third = one.camera.frame(second.number + 1)
        assert second.number > first.number
        assert third.time_ns - second.time_ns == 100_000_000
        assert one.camera.now_ns() >= third.time_ns


def test_a_lens_changes_between_two_frames():
    lenses = [small_lens(), small_lens(seed=5)]
    with device(lenses) as one:
        raw = noise_picture(*SIZE)
        for lens in (1, 0, 1):
            one.registers.write(0xF005, lens)
            data = np.frombuffer(one.camera.newest().data, np.uint8).reshape(48, 64, 3)
            assert np.array_equal(data[..., ::-1], correct(lenses[lens], raw).picture)


def test_lenses_of_other_sizes_are_rejected():
    with pytest.raises(InputError, match="lens 2 has other sizes"):
        lens_corrections([small_lens(), barrel_descriptor((64, 50), SIZE)])
    with pytest.raises(InputError, match="63 pixels, an emulated device needs even sides"):
        lens_corrections([barrel_descriptor((63, 48), SIZE)])


def test_light_of_another_size_is_rejected():
    with pytest.raises(InputError, match="descriptor is for 64x48"):
        Photo(np.zeros((48, 63), np.uint8), small_lens().geometry)


def test_the_scene_moves_and_comes_back():
    scene = MovingScene(small_lens())
    pictures = {scene.raw(scene.position(number)).tobytes() for number in range(100)}
    assert len(pictures) == POSITIONS
    assert scene.position(0) == scene.position(2 * POSITIONS)


@pytest.mark.parametrize("nodes", [1, 8])
def test_a_descriptor_goes_through_the_registers(nodes):
    base, other = (replace(small_lens(seed=seed), nodes=nodes) for seed in (1, 7))
    table = {r.name: r.address for r in registers(base.hidden_neurons, Formats())}
    words = {table[name]: value & 0xFFFFFFFF for name, value in host_values(other).items()}
    words |= dict(table_words(other.valid))
    assert descriptor_of_words(base, words, {}).digest == other.digest


class Memory:
    """The corrector's window of a device, as a client reads and writes it."""

    url = "here"

    def __init__(self, one):
        self.window = CorrectorWindow(one.registers, one.camera)

    def read_memory(self, address, count):
        return self.window.read((address - CORRECTOR_BASE) // 4).to_bytes(count, "big")

    def write_memory(self, address, data):
        for k in range(0, len(data), 4):
            self.window.write((address - CORRECTOR_BASE + k) // 4,
                              int.from_bytes(data[k:k + 4], "big"))


@pytest.mark.parametrize("own,lens", [(1, 8), (8, 1)])
def test_a_lens_with_other_nodes_is_rejected(own, lens):
    one = device([replace(small_lens(), nodes=own)])
    try:
        loader = LensLoader(Memory(one))
        assert loader.limits().nodes == own
        with pytest.raises(Rejected, match=f"nodes {lens} pixels apart, the device {own}"):
            loader.load(replace(small_lens(seed=7), nodes=lens))
        loader.load(replace(small_lens(seed=7), nodes=own))
    finally:
        one.close()


@pytest.mark.parametrize("own,lens", [(FAST, GRADIENT), (GRADIENT, FAST)])
def test_a_lens_of_the_other_interpolation_is_rejected(own, lens):
    one = device([small_lens(interpolation=own)])
    try:
        loader = LensLoader(Memory(one))
        assert loader.limits().interpolation == own.name
        with pytest.raises(Rejected, match=f"the lens is for the interpolation {lens.name}, the "
                                          f"device has {own.name}"):
            loader.load(small_lens(seed=7, interpolation=lens))
        loader.load(small_lens(seed=7, interpolation=own))
    finally:
        one.close()
    with pytest.raises(InputError, match=f"lens 2 is for the interpolation {lens.name}, the "
                                         f"first one for {own.name}"):
        lens_corrections([small_lens(interpolation=each) for each in (own, lens)])


def test_an_emulated_device_has_no_grey_sensor():
    grey = small_lens(bayer="MONO", interpolation=GRADIENT)
    with pytest.raises(InputError, match="the lens is for a grey sensor .MONO."):
        lens_corrections([grey])


def test_lenses_of_a_device_have_the_same_nodes():
    with pytest.raises(InputError, match="lens 2 has nodes 8 pixels apart, the first one 1"):
        lens_corrections([small_lens(), replace(small_lens(), nodes=8)])


def test_the_next_frame_is_made_while_one_is_on_the_line(monkeypatch):
    """A stand-in for sending, which waits until the camera is asked for the frame after."""
    asked, sent = [], []
    with device(fps=100.0) as one:
        following = one.camera.following

        def noted(number, *rest):
            asked.append(number)
            return following(number, *rest)

        def send(frame, *_):
            end = time.monotonic() + 5
            while frame.number not in asked and time.monotonic() < end:
                time.sleep(.001)
            sent.append((frame.number, frame.number in asked))
        monkeypatch.setattr(one.camera, "following", noted)
        monkeypatch.setattr(one.stream, "send_frame", send)
        one.stream.start(Receiver(("127.0.0.1", 9), 1500, 0, False))
        while len(sent) < 3:
            time.sleep(.001)
        one.stream.stop()
    assert all(made for _, made in sent[:3])
    assert [number for number, _ in sent] == sorted({number for number, _ in sent})
